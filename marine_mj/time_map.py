"""Which instant of a run each frame of its video shows: slow motion where it matters."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj.errors import RenderError

Array = NDArray[np.float64]

#: Slow motion begins this long before a contact and ends this long after it, s.
LEAD, TAIL = 0.5, 0.3
#: Contacts less than this apart are one contact phase, s.
PAUSE = 1.5


@dataclass(frozen=True)
class TimeMap:
    """Time of the run as a piecewise linear, increasing function of time in the video.

    Attributes:
        knots: (k,) times of the run where the speed changes, with start and end, s, ascending.
        speeds: (k - 1,) seconds of the run per second of video between them.
    """

    knots: Array
    speeds: Array

    @property
    def duration(self) -> float:
        """Length of the video, s."""
        return float(np.sum(np.diff(self.knots) / self.speeds))

    def run_time(self, video_time: ArrayLike) -> Array:
        """Times (...,) of the run at times of the video, s; the ends are held outside."""
        marks = np.concatenate([[0.0], np.cumsum(np.diff(self.knots) / self.speeds)])
        return np.interp(np.asarray(video_time, float), marks, self.knots)

    def speed_at(self, time: float) -> float:
        """Speed at a time of the run, s; at a change that of the part which begins."""
        part = np.searchsorted(self.knots, time + 1e-9, side="right") - 1
        return float(self.speeds[np.clip(part, 0, len(self.speeds) - 1)])

    def frame_times(self, fps: float) -> Array:
        """Times (n,) of the run of the frames, s; at least one."""
        return self.run_time(np.arange(int(self.duration * fps + 1e-9) + 1) / fps)


def time_map(
    time: Array,
    speed: float = 1.0,
    start: float | None = None,
    stop: float | None = None,
    windows: Sequence[tuple[float, float]] = (),
    window_speed: float = 0.2,
) -> TimeMap:
    """Time map of a run or a part of it.

    Args:
        time: (n,) of the log, s.
        speed: seconds of the run per second of video.
        start, stop: part of the run, s; default all.
        windows: parts that have a speed of their own, ascending, s; see `contact_windows`.
        window_speed: that speed.

    Raises:
        RenderError: a speed is not positive, or nothing of the run is between start and stop.
    """
    if not (speed > 0 and window_speed > 0):
        raise RenderError(
            f"speed is {speed} and speed in contact {window_speed}, both must be positive"
        )
    first = float(time[0]) if start is None else max(start, float(time[0]))
    last = float(time[-1]) if stop is None else min(stop, float(time[-1]))
    if last < first:
        raise RenderError(
            f"the run lasts from {time[0]:.6g} to {time[-1]:.6g} s, asked for was {start} to {stop}"
        )
    knots, speeds = [first], []
    for begin, end in windows:
        begin, end = np.clip([begin, end], knots[-1], last).tolist()
        if end > begin:
            if begin > knots[-1]:
                knots.append(begin)
                speeds.append(speed)
            knots.append(end)
            speeds.append(window_speed)
    if last > knots[-1] or not speeds:
        knots.append(last)
        speeds.append(speed)
    return TimeMap(np.array(knots), np.array(speeds))


def contact_windows(data: Any) -> list[tuple[float, float]]:
    """Contact phases of a docking log, s: from just before a first touch until the latch is closed.

    Touches less than `PAUSE` apart are one phase; one that does not end in the latch ends after
    its last touch. Nothing for a log without `contact_force`.

    Args:
        data: dataset of the log. One with a `log_period` of the control period misses no touch.
    """
    if "contact_force" not in data:
        return []
    time = np.asarray(data["time"], float)
    force = np.asarray(data["contact_force"], float)
    latched = np.asarray(data["latched"], float) > 0.5 if "latched" in data else force < 0
    closing = float(time[np.argmax(latched)]) if latched.any() else np.inf
    touches = time[(force > 0) & (time <= closing)]
    if len(touches) == 0:
        return []
    splits = np.flatnonzero(np.diff(touches) > PAUSE) + 1
    groups = [(float(part[0]), float(part[-1])) for part in np.split(touches, splits)]
    if closing - groups[-1][1] <= PAUSE:
        groups[-1] = (groups[-1][0], closing)
    return [(begin - LEAD, end + TAIL) for begin, end in groups]
