"""The demonstration: a docking run with log, plot, summary and, where OpenGL works, a video."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from marine_mj.errors import RenderError
from marine_mj.scenario import Scenario
from marine_mj.simulation import Log, run

#: Called with the name of the part, what is done and how much there is.
Report = Callable[[str, float, float], None]


def run_demo(
    folder: str | Path = "results/demo",
    scenario: Scenario | None = None,
    report: Report | None = None,
) -> dict[str, Any]:
    """Summary of the demonstration, written with everything else into `folder`.

    Args:
        folder: gets log.nc, plot.png, summary.json and video.mp4.
        scenario: default `docking_demo`.
        report: progress.

    Raises:
        MarineMjError: the run failed. A missing OpenGL is no error: the summary says why there is
            no video.
    """
    folder = Path(folder)
    tell = report or (lambda part, done, total: None)
    scenario = scenario or Scenario.load("docking_demo")
    log = run(scenario, progress=lambda time, end: tell("simulating", time, end))
    log.save(folder / "log.nc")
    plot(log, folder / "plot.png")
    summary = log.summary | {"video": None, "video_reason": None}
    try:
        video(log, folder / "video.mp4", lambda done, total: tell("video", done, total))
        summary["video"] = "video.mp4"
    except RenderError as error:
        (folder / "video.mp4").unlink(missing_ok=True)
        summary["video_reason"] = " ".join(str(error).split())
    write_json(folder / "summary.json", summary)
    return summary


def plot(log: Log, path: Path) -> Path:
    """Figure of a log as a picture file."""
    from marine_mj.plotting import plot_run

    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}")
    plot_run(log).savefig(temporary, format=path.suffix.lstrip(".") or "png")
    os.replace(temporary, path)
    return path


def video(
    log: Log | list[Log],
    path: Path,
    progress: Callable[[int, int], None] | None,
    **options: Any,
) -> Path:
    """Video of a log, or of several side by side; options as `marine_mj.video.render_video`."""
    from marine_mj.video import render_video

    path.parent.mkdir(parents=True, exist_ok=True)
    return render_video(log, path, progress=progress, **options)


def write_json(path: Path, value: Any) -> Path:
    """Write JSON: complete or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}")
    temporary.write_text(json.dumps(value, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    os.replace(temporary, path)
    return path
