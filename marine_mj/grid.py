"""Several runs in one picture: panels side by side, each with its own scene, time and text."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from marine_mj.overlay import Overlay, write_lines
from marine_mj.render_jobs import Job
from marine_mj.rendering import Frame
from marine_mj.time_map import TimeMap

#: Width of the lines between panels, pixels, and their colour.
GAP, LINE = 4, 18


@dataclass(frozen=True)
class Grid:
    """Panels by rows; a job for `render_jobs.job_frames`. A panel that has ended stands still.

    Attributes:
        jobs: one per panel, all of the same size.
        columns: panels in a row.
    """

    jobs: tuple[Job, ...]
    columns: int

    @classmethod
    def of(cls, jobs: Sequence[Job], columns: int | None = None) -> "Grid":
        """Grid of some panels; columns default to about as many as rows, rather more."""
        return cls(tuple(jobs), min(columns or math.ceil(math.sqrt(len(jobs))), len(jobs)))

    def __len__(self) -> int:
        """Number of frames."""
        return max(len(job) for job in self.jobs)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of the whole picture, pixels."""
        rows = math.ceil(len(self.jobs) / self.columns)
        width, height = self.jobs[0].size
        return (
            self.columns * width + (self.columns - 1) * GAP,
            rows * height + (rows - 1) * GAP,
        )

    def part(self, panel: int) -> tuple[slice, slice]:
        """Rows and columns of the picture that a panel fills."""
        row, column = divmod(panel, self.columns)
        width, height = self.jobs[0].size
        top, left = row * (height + GAP), column * (width + GAP)
        return slice(top, top + height), slice(left, left + width)

    def renderer(self) -> "GridRenderer":
        """A renderer of its frames in this process."""
        return GridRenderer(self)


class GridRenderer:
    """Renders frames of a grid in this process."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self._renderers = [job.renderer() for job in grid.jobs]
        self._ended: dict[int, Frame] = {}

    def frame(self, i: int) -> Frame:
        """Frame `i` (height, width, 3)."""
        width, height = self.grid.size
        picture = np.full((height, width, 3), LINE, np.uint8)
        for panel in range(len(self._renderers)):
            picture[self.grid.part(panel)] = self._panel(panel, i)
        return picture

    def _panel(self, panel: int, i: int) -> Frame:
        """Picture of one panel; the last one is rendered once."""
        last = len(self.grid.jobs[panel]) - 1
        if i < last:
            return self._renderers[panel].frame(i)
        if panel not in self._ended:
            self._ended[panel] = self._renderers[panel].frame(last).copy()
        return self._ended[panel]

    def close(self) -> None:
        """Free the OpenGL contexts."""
        for renderer in self._renderers:
            renderer.close()


@dataclass(frozen=True)
class Caption:
    """Text of a panel: lines on the left, and the speed on the right where it is not the usual.

    Attributes:
        times: (n,) of the panel's frames, s of the run.
        lines: of text at a time; None for none.
        time_map: of the panel.
        speed: seconds of the run per second of video that need no mention.
    """

    times: np.ndarray
    lines: Overlay | None
    time_map: TimeMap
    speed: float

    def write(self, picture: Frame, i: int) -> None:
        """Write the text of frame `i` into the panel's part of the picture."""
        time = float(self.times[min(i, len(self.times) - 1)])
        if self.lines is not None:
            write_lines(picture, tuple(self.lines(time)))
        now = self.time_map.speed_at(time)
        if now != self.speed and i < len(self.times) - 1:
            write_lines(picture, (f"x{now:g}",), scale=1.8, right=True)


def captioned(frames: Iterable[Frame], grid: Grid, captions: Sequence[Caption]) -> Iterator[Frame]:
    """The frames of a grid with the captions of its panels."""
    for i, frame in enumerate(frames):
        picture = np.array(frame)
        for panel, caption in enumerate(captions):
            caption.write(picture[grid.part(panel)], i)
        yield picture
