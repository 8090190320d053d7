"""Videos of finished runs: a second pass over the log, so cameras and styles need no rerun.

Frames are rendered in worker processes (each with its own OpenGL context), drawn on with Pillow
and encoded by ffmpeg, all at the same time. Every picture is a pure function of the log and of
time: two workers give the same video as one.
"""

import contextlib
import functools
import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from marine_mj.cameras import CAMERAS, camera_poses, moving_bodies
from marine_mj.errors import LogError, RenderError
from marine_mj.overlay import Overlay, draw_lines, frame_inset, log_overlay
from marine_mj.rendering import (
    Frame,
    GlStatus,
    Pose,
    SceneRenderer,
    gl_status,
    require_gl,
)
from marine_mj.replay import States, interpolate, place, states_from_log
from marine_mj.water import Components, Waves, add_scenery, components

__all__ = [
    "CAMERAS",
    "DEMO",
    "GlStatus",
    "Overlay",
    "States",
    "gl_status",
    "interpolate",
    "render_frames",
    "render_video",
    "states_from_log",
]

#: The best picture of a docking: under water beside the dock, the sea from above as an inset.
DEMO = ("dock", "chase")
#: Width of an inset and its distance from the edges, as parts of the picture's width.
INSET, MARGIN = 0.30, 0.018


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
    """

    model: mujoco.MjModel
    states: States
    waves: Components
    poses: list[list[Pose]]
    focus: np.ndarray
    size: tuple[int, int]


def make_job(
    model: mujoco.MjModel,
    states: States,
    wave_field: Waves,
    cameras: Sequence[str] = DEMO,
    size: tuple[int, int] = (960, 540),
    follow: str | None = None,
) -> Job:
    """Camera paths and everything else that frames depend on; arguments as `render_frames`."""
    waves = components(wave_field)
    poses = [camera_poses(model, states, waves, camera, follow) for camera in cameras]
    data = mujoco.MjData(model)
    bodies = moving_bodies(model)[:2]
    focus = np.zeros((len(states), 2))
    for i in range(len(states) if bodies else 0):
        place(model, data, states, i)
        focus[i] = data.xpos[bodies[0], :2]
    return Job(model, states, waves, poses, focus, size)


class JobRenderer:
    """Renders frames of a job in this process."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self._renderer = SceneRenderer(job.model, job.waves, job.size)
        self._data = mujoco.MjData(job.model)

    def frame(self, i: int) -> Frame:
        """Frame `i` (height, width, 3): the main camera, insets stacked from the lower right corner up."""
        job = self.job
        place(job.model, self._data, job.states, i)
        time, around = float(job.states.time[i]), job.focus[i]
        main, *others = [poses[i] for poses in job.poses]
        picture = self._renderer.render(self._data, main, time, job.size, around)
        width, height = job.size
        margin = round(MARGIN * width)
        inset = (round(INSET * width), round(INSET * height))
        for slot, pose in enumerate(others):
            small = self._renderer.render(self._data, pose, time, inset, around)
            picture = np.require(picture, requirements="CW")
            top = height - (slot + 1) * (inset[1] + margin)
            frame_inset(picture, small, top, margin)
        return np.ascontiguousarray(picture)

    def close(self) -> None:
        self._renderer.close()


def render_frames(
    model: mujoco.MjModel,
    states: States,
    wave_field: Waves,
    cameras: Sequence[str] = DEMO,
    size: tuple[int, int] = (960, 540),
    follow: str | None = None,
    workers: int = 0,
) -> Iterator[Frame]:
    """Frames (height, width, 3), one per state, in order.

    Args:
        model: compiled from a spec with `marine_mj.water.add_scenery`.
        states: one per frame, see `interpolate`.
        wave_field: the sea of the run, `marine_mj.environment.WaveField`.
        cameras: the main picture's camera, then those of insets; see `marine_mj.cameras`.
        size: (width, height), pixels.
        follow: body that the cameras follow; default see `camera_poses`.
        workers: processes; 0 renders in this one.

    Raises:
        RenderError: no OpenGL, no scenery, unknown camera or body, or a worker failed.
    """
    require_gl()
    job = make_job(model, states, wave_field, cameras, size, follow)
    return _frames(job, workers)


def _frames(job: Job, workers: int) -> Iterator[Frame]:
    if workers > 0:
        yield from _worker_frames(job, workers)
        return
    renderer = JobRenderer(job)
    try:
        for i in range(len(job.states)):
            yield renderer.frame(i)
    finally:
        renderer.close()


def _worker_frames(job: Job, workers: int) -> Iterator[Frame]:
    """Frames from processes: worker w renders frames w, w + workers, ... and pipes them here."""
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
        for i in range(len(job.states)):
            frame = queues[i % workers].get()
            if frame is None:
                lines = errors[i % workers].read_text(errors="replace").strip().splitlines()
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


def render_video(
    log: Any,
    file: str | Path,
    camera: str | Sequence[str] = DEMO,
    size: tuple[int, int] = (960, 540),
    fps: float = 25.0,
    *,
    speed: float = 1.0,
    start: float | None = None,
    stop: float | None = None,
    follow: str | None = None,
    overlay: Overlay | bool = True,
    workers: int | None = None,
    crf: int = 20,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Video file (H.264, yuv420p) of a log.

    Args:
        log: `marine_mj.simulation.Log` or the path of one.
        file: to write, `.mp4`; it appears when it is complete.
        camera: one of `marine_mj.cameras.CAMERAS`, a camera of the scene, or several: the first
            fills the picture, the others are insets.
        size: (width, height) in pixels, both even.
        fps: frames per second of video; independent of the log's rate.
        speed: seconds of the run per second of video.
        start, stop: part of the run, s; default all.
        follow: body that the cameras follow; default see `camera_poses`.
        overlay: text lines as a function of time (s); True for those of the log, False for none.
        workers: rendering processes; default one per core, at most four,
            and none (this process) for less than 50 frames.
        crf: quality of the encoder; smaller is better and larger.
        progress: called with (frames done, frames in all).

    Returns:
        The path of the video.

    Raises:
        RenderError: no OpenGL, bad size or times, unknown camera, or the encoder failed.
        LogError: the log cannot be read.
    """
    if size[0] % 2 or size[1] % 2 or min(size) < 16:
        raise RenderError(f"size is {size}, allowed are even numbers from 16 (H.264 needs it)")
    if fps <= 0 or speed <= 0:
        raise RenderError(f"fps is {fps} and speed {speed}, both must be positive")
    require_gl()
    log = open_log(log)
    scene = _scene(log, size)
    recorded = states_from_log(log.data)
    times = frame_times(recorded.time, fps, speed, start, stop)
    cameras = (camera,) if isinstance(camera, str) else tuple(camera)
    states = interpolate(scene.model, recorded, times)
    job = make_job(scene.model, states, scene.environment.waves, cameras, size, follow)
    text = log_overlay(log.data, job.waves) if overlay is True else (overlay or None)
    if workers is None:
        workers = min(os.cpu_count() or 1, 4) if len(states) >= 50 else 0
    frames = _frames(job, workers)
    return encode(frames, file, fps, times, overlay=text, crf=crf, progress=progress)


def frame_times(
    time: np.ndarray, fps: float, speed: float, start: float | None, stop: float | None
) -> np.ndarray:
    """Instants (n,) in s of the frames; at least one."""
    first = float(time[0]) if start is None else max(start, float(time[0]))
    last = float(time[-1]) if stop is None else min(stop, float(time[-1]))
    if last < first:
        raise RenderError(
            f"the run lasts from {time[0]:.6g} to {time[-1]:.6g} s, asked for was {start} to {stop}"
        )
    return first + np.arange(int((last - first) * fps / speed + 1e-9) + 1) * speed / fps


def encode(
    frames: Iterator[Frame],
    file: str | Path,
    fps: float,
    times: np.ndarray,
    *,
    overlay: Overlay | None = None,
    crf: int = 20,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Draw the overlay on frames and encode them; the file appears when it is complete.

    Raises:
        RenderError: ffmpeg failed.
    """
    import imageio_ffmpeg

    file = Path(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(f".{file.stem}.part.mp4")
    writer: Any = None
    try:
        for i, (frame, time) in enumerate(zip(frames, times, strict=True)):
            if overlay is not None:
                frame = draw_lines(frame, tuple(overlay(float(time))))
            if writer is None:
                writer = imageio_ffmpeg.write_frames(
                    str(part),
                    (frame.shape[1], frame.shape[0]),
                    fps=fps,
                    codec="libx264",
                    pix_fmt_out="yuv420p",
                    macro_block_size=2,
                    quality=None,
                    output_params=["-crf", str(crf), "-preset", "veryfast", "-movflags", "faststart"],
                )
                writer.send(None)
            writer.send(np.ascontiguousarray(frame))
            if progress is not None:
                progress(i + 1, len(times))
        writer.close()
        writer = None
        os.replace(part, file)
    except OSError as error:
        raise RenderError(f"the video encoder failed on {file}: {error}") from error
    finally:
        if writer is not None:
            with contextlib.suppress(Exception):
                writer.close()
        part.unlink(missing_ok=True)
    return file


def open_log(log: Any) -> Any:
    """A log with `.data` from itself or from the path of its file."""
    if hasattr(log, "data") and hasattr(log.data, "attrs"):
        return log
    if isinstance(log, str | Path):
        from marine_mj.simulation.log import Log

        return Log.load(log)
    raise LogError(f"a log or its path is needed, got {type(log).__name__}")


def _scene(log: Any, size: tuple[int, int]) -> Any:
    from marine_mj.scene import scene_from_log

    return scene_from_log(log, scenery=functools.partial(add_scenery, size=size))


def still(log: Any, time: float, camera: str | Sequence[str] = DEMO, **options: Any) -> Frame:
    """One picture (height, width, 3) of a log at `time`, s; options as `render_frames`."""
    require_gl()
    log = open_log(log)
    size = options.pop("size", (960, 540))
    scene = _scene(log, size)
    # Smooth cameras look at the seconds around the instant.
    times = time + np.arange(-50, 51) * 0.1
    states = interpolate(scene.model, states_from_log(log.data), times)
    states = replace(states, time=times)
    cameras = (camera,) if isinstance(camera, str) else tuple(camera)
    job = make_job(scene.model, states, scene.environment.waves, cameras, size, **options)
    renderer = JobRenderer(job)
    try:
        return renderer.frame(50)
    finally:
        renderer.close()
