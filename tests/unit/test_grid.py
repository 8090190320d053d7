"""Pictures side by side: sizes, places, text, and panels that have ended."""

from types import SimpleNamespace

import numpy as np
import pytest
from picture_scenes import SIZE, dataset, run, scene, sea

from marine_mj import video
from marine_mj.errors import RenderError
from marine_mj.grid import GAP, LINE, Caption, Grid, captioned
from marine_mj.replay import interpolate
from marine_mj.time_map import time_map


class Painter:
    """A job without OpenGL: frame i has the value `base + i` everywhere."""

    def __init__(self, base: int, count: int) -> None:
        self.base, self.count, self.size, self.rendered = base, count, (160, 90), []

    def __len__(self) -> int:
        return self.count

    def renderer(self):
        return self

    def frame(self, i: int) -> np.ndarray:
        self.rendered.append(i)
        return np.full((90, 160, 3), self.base + i, np.uint8)

    def close(self) -> None:
        self.rendered.append("closed")


@pytest.mark.parametrize(
    ("panels", "columns", "expected", "size"),
    [
        (1, None, 1, (160, 90)),
        (2, None, 2, (324, 90)),
        (4, None, 2, (324, 184)),
        (5, None, 3, (488, 184)),
        (6, None, 3, (488, 184)),
        (6, 2, 2, (324, 278)),
        (2, 5, 2, (324, 90)),
    ],
)
def test_size_of_a_grid(panels, columns, expected, size):
    grid = Grid.of([Painter(0, 1)] * panels, columns)
    assert grid.columns == expected and grid.size == size
    # The encoder needs even sizes.
    assert all(length % 2 == 0 for length in grid.size)
    parts = [grid.part(i) for i in range(panels)]
    assert all(np.empty(size[::-1])[part].shape == (90, 160) for part in parts)


def test_panels_stand_in_their_places_and_wait_for_the_longest():
    jobs = [Painter(50, 4), Painter(100, 2), Painter(150, 1)]
    grid = Grid.of(jobs, 2)
    assert len(grid) == 4
    renderer = grid.renderer()
    frames = [renderer.frame(i) for i in range(4)]
    for i, frame in enumerate(frames):
        assert frame.shape == (180 + GAP, 320 + GAP, 3)
        assert np.all(frame[:90, :160] == 50 + i)
        assert np.all(frame[:90, 160 + GAP :] == 100 + min(i, 1))
        assert np.all(frame[90 + GAP :, :160] == 150)
        assert np.all(frame[90 + GAP :, 160:] == LINE)
    # What stands still is rendered once.
    assert jobs[1].rendered == [0, 1] and jobs[2].rendered == [0]
    renderer.close()
    assert jobs[0].rendered[-1] == "closed"


def test_captions_stay_in_their_panel_and_tell_the_speed():
    grid = Grid.of([Painter(90, 3), Painter(90, 3)])
    slow = time_map(np.array([0.0, 0.1]), windows=[(0.0, 0.05)], window_speed=0.2)
    times = np.array([0.0, 0.06, 0.1])
    captions = [Caption(times, None, slow, 1.0), Caption(times, lambda t: [f"t {t}"], slow, 0.2)]
    renderer = grid.renderer()
    frames = list(captioned((renderer.frame(i) for i in range(3)), grid, captions))
    left = [frame[:, :160] for frame in frames]
    # Slow in the first frame only; the text of the speed is on the right.
    assert np.any(left[0][:, 80:] != 90) and np.all(left[0][:, :80] == 90)
    assert np.all(left[1] == 91) and np.all(left[2] == 92)
    right = [frame[:, 160 + GAP :] for frame in frames]
    assert all(np.any(part[:, :80] != 90 + i) for i, part in enumerate(right))
    # There 0.2 is the usual speed, and 1 is worth a word.
    assert np.all(right[0][:, 100:] == 90) and np.any(right[1][:, 100:] != 91)


def test_bad_settings_are_named():
    with pytest.raises(RenderError, match="1 titles for 2 logs"):
        video.render_video([None, None], "x.mp4", titles=["a"])
    with pytest.raises(RenderError, match="0 titles for 0 logs: give one for each log"):
        video.render_video([], "x.mp4")
    with pytest.raises(RenderError, match="columns is 0, allowed are whole numbers from 1"):
        video.render_video([None], "x.mp4", columns=0)


def test_workers_render_grids():
    status = video.gl_status()
    if not status:
        pytest.skip(status.reason)
    model, waves = scene(), sea()
    jobs = [
        video.make_job(model, interpolate(model, run(), times), waves, ("close",), SIZE)
        for times in ([0.0, 0.4, 0.8], [2.0])
    ]
    here, there = (list(video.job_frames(Grid.of(jobs), workers)) for workers in (0, 1))
    assert len(here) == len(there) == 3 and here[0].shape == (90, 324, 3)
    for a, b in zip(here, there, strict=True):
        # Threads of the matrix product may round a texel the other way.
        assert np.mean(a != b) < 0.01
    alone = next(video.job_frames(jobs[1], 0))
    for frame in here:
        assert np.mean(frame[:, 160 + GAP :] != alone) < 0.01


def test_video_of_two_logs(tmp_path, monkeypatch):
    status = video.gl_status()
    if not status:
        pytest.skip(status.reason)
    found = SimpleNamespace(model=scene(), environment=SimpleNamespace(waves=sea()))
    monkeypatch.setattr(video, "_scene", lambda *_: found)
    logs = [SimpleNamespace(data=dataset())] * 2
    done = []
    path = video.render_video(
        *(logs, tmp_path / "two.mp4"),
        **{"size": SIZE, "fps": 2, "start": 3.0, "contact_speed": 0.5, "titles": ["a", "b"]},
        progress=lambda *a: done.append(a),
    )
    import imageio_ffmpeg

    reader = imageio_ffmpeg.read_frames(str(path))
    assert next(reader)["size"] == (324, 90)
    # From 3 to 4 s at half speed: 2 s of video, 5 frames.
    assert done == [(i + 1, 5) for i in range(5)] and len(list(reader)) == 5
