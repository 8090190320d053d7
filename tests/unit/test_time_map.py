"""Slow motion: every frame shows the right instant."""

import numpy as np
import pytest
from picture_scenes import dataset

from marine_mj.cameras import smooth
from marine_mj.errors import RenderError
from marine_mj.replay import States
from marine_mj.time_map import contact_windows, time_map

TIME = np.linspace(0, 30, 751)


def test_a_map_is_exact_at_its_ends_and_at_changes_of_speed():
    mapped = time_map(TIME, 1.0, windows=[(10.0, 12.0)], window_speed=0.2)
    # 10 s, five times 2 s, 18 s.
    assert mapped.duration == pytest.approx(38.0, abs=1e-12)
    marks = mapped.run_time([0.0, 10.0, 15.0, 20.0, 38.0, 99.0])
    np.testing.assert_allclose(marks, [0, 10, 11, 12, 30, 30], atol=1e-12)
    assert mapped.run_time(0.0) == 0.0 and mapped.run_time(mapped.duration) == 30.0
    assert [mapped.speed_at(t) for t in (0.0, 9.99, 10.0, 11.9, 12.0, 30.0)] == [
        *(1.0, 1.0, 0.2, 0.2, 1.0, 1.0)
    ]


def test_frames_ascend_with_the_speed_of_their_part():
    mapped = time_map(TIME, 2.0, windows=[(10.0, 12.0), (20.0, 20.5)], window_speed=0.2)
    times = mapped.frame_times(25)
    steps = np.diff(times)
    assert times[0] == 0 and times[-1] == pytest.approx(30.0, abs=2.0 / 25)
    assert np.all(steps > 0)
    inside = (times[:-1] >= 10) & (times[1:] <= 12)
    assert np.count_nonzero(inside) >= 249
    np.testing.assert_allclose(steps[inside], 0.2 / 25, atol=1e-12)
    np.testing.assert_allclose(steps[times[1:] <= 10], 2.0 / 25, atol=1e-12)


@pytest.mark.parametrize("windows", [[(-3, 5)], [(28, 40)], [(-5, 99)], [(40, 50)], [(5, 5)]])
def test_windows_beyond_the_part_are_cut(windows):
    mapped = time_map(TIME, 1.0, 2.0, 29.0, windows, 0.5)
    assert mapped.knots[0] == 2 and mapped.knots[-1] == 29
    assert np.all(np.diff(mapped.knots) > 0) and len(mapped.speeds) == len(mapped.knots) - 1


def test_a_run_of_one_sample_has_one_frame():
    np.testing.assert_array_equal(time_map(np.array([4.0])).frame_times(25), [4.0])


def test_speeds_must_be_positive():
    with pytest.raises(RenderError, match=r"speed is 1.0 and speed in contact 0.0, both must be"):
        time_map(TIME, 1.0, window_speed=0.0)


def test_contact_phases_reach_from_before_the_touch_to_the_latch():
    # Touch from 3.3 s on, latched at 3.7 s: half a second before, 0.3 s after.
    np.testing.assert_allclose(contact_windows(dataset()), [(2.8, 4.0)])
    assert contact_windows(dataset(docking=False)) == []
    data = dataset()
    force = np.zeros(len(data.time))
    force[[5, 8, 30, 31]] = 10.0
    # Two phases; what comes after the latch is no contact phase.
    data["contact_force"] = (("time",), force)
    data["latched"] = (("time",), np.zeros(len(force)))
    np.testing.assert_allclose(contact_windows(data), [(0.0, 1.1), (2.5, 3.4)])
    data["latched"] = (("time",), (data.time.values > 1.05).astype(float))
    np.testing.assert_allclose(contact_windows(data), [(0.0, 1.4)])


def test_cameras_are_as_smooth_in_slow_motion():
    mapped = time_map(TIME, windows=[(10.0, 12.0)])
    slow, even = mapped.frame_times(25), time_map(TIME).frame_times(25)

    def path(times):
        empty = np.zeros((len(times), 0))
        return smooth(np.sin(times)[:, None], States(times, empty, empty, empty), 0.5)[:, 0]

    # A Gaussian of 0.5 s damps sin t by exp(-0.125) away from the ends: 1e-4 by its cut at 4 sigma.
    for times in (slow, even):
        middle = (times > 4) & (times < 26)
        expected = np.exp(-0.125) * np.sin(times[middle])
        np.testing.assert_allclose(path(times)[middle], expected, atol=1e-3)
