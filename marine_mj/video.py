"""Videos of finished runs: a second pass over the log, so cameras and styles need no rerun.

Frames are rendered in worker processes (each with its own OpenGL context), drawn on with Pillow
and encoded by ffmpeg, all at the same time. Every picture is a pure function of the log and of
time: two workers give the same video as one.
"""

import contextlib
import functools
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from marine_mj.cameras import CAMERAS
from marine_mj.errors import LogError, RenderError
from marine_mj.overlay import Overlay, draw_lines, log_overlay
from marine_mj.render_jobs import JobRenderer, job_frames, make_job
from marine_mj.rendering import Frame, GlStatus, gl_status, require_gl
from marine_mj.replay import States, interpolate, states_from_log
from marine_mj.water import Waves, add_scenery

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
    return job_frames(job, workers)


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
    # the test picture takes a second in another process: meanwhile the scene compiles here
    with ThreadPoolExecutor(1) as pool:
        probe = pool.submit(require_gl)
        log = open_log(log)
        recorded = states_from_log(log.data)
        times = frame_times(recorded.time, fps, speed, start, stop)
        scene = _scene(log, size)
        probe.result()
    cameras = (camera,) if isinstance(camera, str) else tuple(camera)
    states = interpolate(scene.model, recorded, times)
    job = make_job(scene.model, states, scene.environment.waves, cameras, size, follow)
    text = log_overlay(log.data, job.waves) if overlay is True else (overlay or None)
    if workers is None:
        workers = min(os.cpu_count() or 1, 4) if len(states) >= 50 else 0
    frames = job_frames(job, workers)
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
                    output_params=[
                        "-crf",
                        str(crf),
                        "-preset",
                        "veryfast",
                        "-movflags",
                        "faststart",
                    ],
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
    times = np.asarray(time + np.arange(-50, 51) * 0.1, float)
    states = interpolate(scene.model, states_from_log(log.data), times)
    states = replace(states, time=times)
    cameras = (camera,) if isinstance(camera, str) else tuple(camera)
    job = make_job(scene.model, states, scene.environment.waves, cameras, size, **options)
    renderer = JobRenderer(job)
    try:
        return renderer.frame(50)
    finally:
        renderer.close()
