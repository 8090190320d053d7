"""Rendering work that any process can do: frames of a job, here or in worker processes."""

import contextlib
import functools
import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np

from marine_mj.cameras import camera_poses, moving_bodies
from marine_mj.errors import RenderError
from marine_mj.markers import Marker, draw_markers
from marine_mj.overlay import frame_inset
from marine_mj.rendering import Frame, Pose, SceneRenderer
from marine_mj.replay import States, place
from marine_mj.water import Components, Waves, components

#: Width of an inset and its distance from the edges, as parts of the picture's width.
INSET, MARGIN = 0.30, 0.018
#: Frames that share one picture of each inset: they are small, and cost a third of the time.
SHARED = 2


@dataclass(frozen=True)
class Job:
    """All that a process needs to render any frame of a video.

    Attributes:
        model: with scenery.
        states: one per frame.
        waves: components of the sea.
        poses: for every camera (main picture first) and frame.
        focus: (n, 2) world position that needs the finest water, m.
        size: (width, height) in pixels.
        markers: drawn in every frame.
    """

    model: mujoco.MjModel
    states: States
    waves: Components
    poses: list[list[Pose]]
    focus: np.ndarray
    size: tuple[int, int]
    markers: tuple[Marker, ...] = ()

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.states)

    def renderer(self) -> "JobRenderer":
        """A renderer of its frames in this process."""
        return JobRenderer(self)


class Renderer(Protocol):
    """Renders frames in this process."""

    def frame(self, i: int) -> Frame: ...
    def close(self) -> None: ...


class Frames(Protocol):
    """What `job_frames` renders: a `Job`, or several in a `marine_mj.grid.Grid`."""

    def __len__(self) -> int: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def renderer(self) -> Renderer: ...


def make_job(
    model: mujoco.MjModel,
    states: States,
    wave_field: Waves,
    cameras: Sequence[str],
    size: tuple[int, int],
    follow: str | None = None,
    markers: Sequence[Marker] = (),
) -> Job:
    """Camera paths and everything else that frames depend on; arguments as
    `marine_mj.video.render_frames`."""
    waves = components(wave_field)
    poses = [camera_poses(model, states, waves, camera, follow) for camera in cameras]
    data = mujoco.MjData(model)
    bodies = moving_bodies(model)[:2]
    focus = np.zeros((len(states), 2))
    for i in range(len(states) if bodies else 0):
        place(model, data, states, i)
        focus[i] = data.xpos[bodies[0], :2]
    return Job(model, states, waves, poses, focus, size, tuple(markers))


class JobRenderer:
    """Renders frames of a job in this process."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self._renderer = SceneRenderer(job.model, job.waves, job.size)
        self._data = mujoco.MjData(job.model)
        self._insets: tuple[int, list[Frame]] = (-1, [])

    def frame(self, i: int) -> Frame:
        """Frame `i` (height, width, 3): insets stacked from the lower right corner up."""
        width, height = self.job.size
        margin = round(MARGIN * width)
        inset = (round(INSET * width), round(INSET * height))
        group = i - i % SHARED
        if self._insets[0] != group:
            others = range(1, len(self.job.poses))
            self._insets = (group, [self._picture(group, camera, inset) for camera in others])
        picture = np.require(self._picture(i, 0, self.job.size), requirements=["C", "W"])
        for slot, small in enumerate(self._insets[1]):
            frame_inset(picture, small, height - (slot + 1) * (inset[1] + margin), margin)
        return picture

    def _picture(self, i: int, camera: int, size: tuple[int, int]) -> Frame:
        """Frame `i` as one camera sees it."""
        job = self.job
        place(job.model, self._data, job.states, i)
        time, around = float(job.states.time[i]), job.focus[i]
        decor = functools.partial(draw_markers, markers=job.markers, i=i)
        return self._renderer.render(self._data, job.poses[camera][i], time, size, around, decor)

    def close(self) -> None:
        self._renderer.close()


def job_frames(job: Frames, workers: int) -> Iterator[Frame]:
    """All frames of a job in order; `workers` processes, 0 for this one."""
    if workers > 0:
        yield from _worker_frames(job, workers)
        return
    renderer = job.renderer()
    try:
        for i in range(len(job)):
            yield renderer.frame(i)
    finally:
        renderer.close()


def worker_of(i: int, workers: int) -> int:
    """Which worker renders frame `i`: they take turns, with frames that share insets together."""
    return i // SHARED % workers


def _worker_frames(job: Frames, workers: int) -> Iterator[Frame]:
    """Frames from processes, which pipe them here."""
    # The drivers' own threads would only fight with the other workers.
    environment = {**os.environ, "LP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        file = Path(folder) / "job.pickle"
        file.write_bytes(pickle.dumps(job))
        queues: list[queue.Queue[Frame | None]] = []
        errors = []
        stop = threading.Event()
        stack.callback(stop.set)
        for worker in range(workers):
            errors.append(Path(folder) / f"error-{worker}.txt")
            with errors[-1].open("wb") as error:
                process = subprocess.Popen(
                    [
                        *(sys.executable, "-m", "marine_mj.render_worker"),
                        *(str(file), str(worker), str(workers)),
                    ],
                    stdout=subprocess.PIPE,
                    stderr=error,
                    env=environment,
                )
            stack.callback(_end, process)
            # A few frames ahead, so that no worker waits for the encoder.
            queues.append(queue.Queue(maxsize=6))
            threading.Thread(
                target=_read_frames, args=(process, job.size, queues[-1], stop), daemon=True
            ).start()
        for i in range(len(job)):
            worker = worker_of(i, workers)
            frame = queues[worker].get()
            if frame is None:
                lines = errors[worker].read_text(errors="replace").strip().splitlines()
                detail = lines[-1] if lines else "it ended without a message"
                raise RenderError(f"a rendering process stopped at frame {i}: {detail}")
            yield frame


def _read_frames(
    process: "subprocess.Popen[bytes]",
    size: tuple[int, int],
    frames: "queue.Queue[Frame | None]",
    stop: threading.Event,
) -> None:
    """Move frames from a worker's pipe to a queue; None marks the end."""
    count = size[0] * size[1] * 3
    stream = process.stdout
    assert stream is not None
    while not stop.is_set():
        content = stream.read(count)
        whole = len(content) == count
        frame = np.frombuffer(content, np.uint8).reshape(size[1], size[0], 3) if whole else None
        while not stop.is_set():
            with contextlib.suppress(queue.Full):
                frames.put(frame, timeout=0.2)
                break
        if not whole:
            return


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.kill()
    process.wait()
