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
from marine_mj.grid import Caption, Grid, captioned
from marine_mj.markers import docking_markers
from marine_mj.overlay import Overlay, log_overlay
from marine_mj.render_jobs import JobRenderer, job_frames, make_job
from marine_mj.rendering import Frame, GlStatus, gl_status, require_gl
from marine_mj.replay import States, interpolate, states_from_log
from marine_mj.time_map import contact_windows, time_map
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
    "require_gl",
    "states_from_log",
]

#: The best picture of a docking: under water beside the dock, the sea from above as an inset.
DEMO = ("dock", "chase")
#: Size of a video of one log, and of a panel of several, pixels.
SIZE, PANEL = (960, 540), (640, 360)


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
    camera: str | Sequence[str] | None = None,
    size: tuple[int, int] | None = None,
    fps: float = 25.0,
    *,
    speed: float = 1.0,
    contact_speed: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    follow: str | None = None,
    overlay: Overlay | bool = True,
    titles: Sequence[str] = (),
    markers: bool = True,
    columns: int | None = None,
    workers: int | None = None,
    crf: int = 20,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Video file (H.264, yuv420p) of a log, or of several side by side.

    Args:
        log: `marine_mj.simulation.Log` or the path of one, or a list of these: a panel for each.
            A panel whose run is over stands still until all are.
        file: to write, `.mp4`; it appears when it is complete.
        camera: one of `marine_mj.cameras.CAMERAS`, a camera of the scene, or several: the first
            fills the picture, the others are insets. Default: `DEMO`, and `close` for several logs.
        size: (width, height) in pixels, both even, of a panel; default 960x540, and 640x360 for
            several logs.
        fps: frames per second of video; independent of the log's rate.
        speed: seconds of the run per second of video.
        contact_speed: the same from just before a contact with the dock until the latch is closed
            (`marine_mj.time_map.contact_windows`): 0.2 is five times slower; default `speed`.
        start, stop: part of the run, s; default all.
        follow: body that the cameras follow; default see `camera_poses`.
        overlay: text lines as a function of time (s); True for those of the log, False for none.
        titles: first line of the text of each log.
        markers: draw those of `marine_mj.markers.docking_markers`.
        columns: panels in a row; default about as many as rows.
        workers: rendering processes; default one per core, at most four,
            and none (this process) for less than 50 frames.
        crf: quality of the encoder; smaller is better and larger.
        progress: called with (frames done, frames in all).

    Returns:
        The path of the video.

    Raises:
        RenderError: no OpenGL, bad size, times, titles or columns, unknown camera, no log, or the
            encoder failed.
        LogError: a log cannot be read.
    """
    logs = list(log) if isinstance(log, list | tuple) else [log]
    single = len(logs) == 1
    size = size or (SIZE if single else PANEL)
    if size[0] % 2 or size[1] % 2 or min(size) < 16:
        raise RenderError(f"size is {size}, allowed are even numbers from 16 (H.264 needs it)")
    if fps <= 0 or speed <= 0:
        raise RenderError(f"fps is {fps} and speed {speed}, both must be positive")
    if not logs or (titles and len(titles) != len(logs)):
        raise RenderError(f"{len(titles)} titles for {len(logs)} logs: give one for each log")
    if columns is not None and columns < 1:
        raise RenderError(f"columns is {columns}, allowed are whole numbers from 1")
    camera = camera or (DEMO if single else "close")
    cameras = (camera,) if isinstance(camera, str) else tuple(camera)
    jobs, captions = [], []
    # the test picture takes a second in another process: meanwhile the scenes compile here
    with ThreadPoolExecutor(1) as pool:
        probe = pool.submit(require_gl)
        for title, one in zip(titles or [""] * len(logs), logs, strict=True):
            one = open_log(one)
            recorded = states_from_log(one.data)
            windows = [] if contact_speed is None else contact_windows(one.data)
            mapped = time_map(recorded.time, speed, start, stop, windows, contact_speed or speed)
            times = mapped.frame_times(fps)
            scene = _scene(one, size)
            states = interpolate(scene.model, recorded, times)
            marked = docking_markers(scene.model, one.data, times) if markers else ()
            waves = scene.environment.waves
            jobs.append(make_job(scene.model, states, waves, cameras, size, follow, marked))
            text = log_overlay(one.data, jobs[-1].waves, title) if overlay is True else overlay
            captions.append(Caption(times, text or None, mapped, speed))
        probe.result()
    grid = Grid.of(jobs, columns)
    if workers is None:
        workers = min(os.cpu_count() or 1, 4) if len(grid) >= 50 else 0
    frames = captioned(job_frames(grid, workers), grid, captions)
    return encode(frames, file, fps, len(grid), crf=crf, progress=progress)


def encode(
    frames: Iterator[Frame],
    file: str | Path,
    fps: float,
    count: int,
    *,
    crf: int = 20,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Encode `count` frames; the file appears when it is complete.

    Raises:
        RenderError: ffmpeg failed.
    """
    import imageio_ffmpeg

    file = Path(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(f".{file.stem}.part.mp4")
    writer: Any = None
    try:
        for i, frame in enumerate(frames):
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
                progress(i + 1, count)
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
    markers = options.pop("markers", True)
    # Smooth cameras look at the seconds around the instant.
    times = np.asarray(time + np.arange(-50, 51) * 0.1, float)
    states = interpolate(scene.model, states_from_log(log.data), times)
    states = replace(states, time=times)
    cameras = (camera,) if isinstance(camera, str) else tuple(camera)
    options["markers"] = docking_markers(scene.model, log.data, times) if markers else ()
    job = make_job(scene.model, states, scene.environment.waves, cameras, size, **options)
    renderer = JobRenderer(job)
    try:
        return renderer.frame(50)
    finally:
        renderer.close()
