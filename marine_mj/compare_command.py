"""The commands `marine-mj compare` and `marine-mj limits`: controllers side by side."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from marine_mj import toml
from marine_mj.errors import ScenarioError

if TYPE_CHECKING:
    from marine_mj.compare import Variant

limits_app = typer.Typer(
    help="Limit sea states of the docking controllers.", no_args_is_help=True, add_completion=False
)

Slow = Annotated[
    float, typer.Option(help="Seconds of the run per second of video while in contact.")
]
Speed = Annotated[float, typer.Option(help="Seconds of the run per second of video.")]


def compare_command(
    scenario: Annotated[str, typer.Argument(help="TOML file or name of a packaged scenario.")],
    vary: Annotated[
        list[str],
        typer.Option(help="KEY=VALUE,VALUE,...; several: all combinations."),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="MP4 file.")] = Path(
        "results/compare.mp4"
    ),
    sea_state: Annotated[int | None, typer.Option(help="Short for --set sea.sea_state=N.")] = None,
    seed: Annotated[int | None, typer.Option(help="Of all runs.")] = None,
    values: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE of all runs.")
    ] = None,
    logs: Annotated[Path | None, typer.Option(help="Folder that gets the logs too.")] = None,
    columns: Annotated[int | None, typer.Option(help="Panels in a row.")] = None,
    camera: Annotated[
        list[str] | None, typer.Option(help="Camera; a second one becomes an inset.")
    ] = None,
    speed: Speed = 1.0,
    contact_speed: Slow = 0.2,
) -> None:
    """Run a scenario with other values in the same sea; a video with a panel for each."""
    from marine_mj.compare import variants
    from marine_mj.scenario import Scenario
    from marine_mj.toml import assignments

    changes = assignments(values or [])
    if sea_state is not None:
        changes["sea.sea_state"] = sea_state
    if seed is not None:
        changes["seed"] = seed
    varied = {key: found for key, found in (varied_values(text) for text in vary)}
    chosen = variants(Scenario.load(scenario).with_values(changes), varied)
    options: dict[str, Any] = {"speed": speed, "contact_speed": contact_speed, "columns": columns}
    if camera:
        options["camera"] = tuple(camera)
    _film(chosen, output, logs, options)


@limits_app.command("measure")
def measure_command(
    scenario: Annotated[str, typer.Argument(help="Docking scenario.")] = "docking_demo",
    output: Annotated[Path, typer.Option("-o", "--output", help="JSON file.")] = Path(
        "results/limits/limits.json"
    ),
    controllers: Annotated[
        str, typer.Option(help="Their names.")
    ] = "pose_pid,cpv,cpva,lqr,sliding,mpc",
    sea_states: Annotated[str, typer.Option(help="From the easiest on.")] = "4,5,6,7,8,9,10,11,12",
    runs: Annotated[int, typer.Option(help="Seeds per sea state.", min=1)] = 10,
    first_seed: Annotated[int, typer.Option(help="Of these seeds.", min=0)] = 11,
    duration: Annotated[float, typer.Option(help="Longest time of a run, s.")] = 90.0,
    workers: Annotated[
        int | None, typer.Option(help="Processes; default: one per processor.", min=1)
    ] = None,
) -> None:
    """Measure up to which sea state each controller docks in 9 of 10 runs."""
    from marine_mj.cli import _numbers, _progress, console
    from marine_mj.demo import write_json
    from marine_mj.limits import measure_limits

    with _progress() as report:
        table = measure_limits(
            scenario,
            controllers.split(","),
            [int(number) for number in _numbers("--sea-states", sea_states)],
            range(first_seed, first_seed + runs),
            duration=duration,
            workers=workers,
            progress=lambda done, total: report("controllers", done, total),
        )
    rows = Table("controller", *map(str, table.sea_states), "limit", box=None, pad_edge=False)
    for name in table.success:
        counts = [f"{sum(docked)}/{runs}" for docked in table.success[name]]
        counts += [""] * (len(table.sea_states) - len(counts))
        rows.add_row(name, *counts, str(table.limit(name)))
    console.print(rows)
    console.print(f"wrote {write_json(output, table.model_dump())}")


@limits_app.command("video")
def video_command(
    table: Annotated[
        Path | None, typer.Option(help="From `limits measure`; default: packaged.")
    ] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder.")] = Path(
        "results/limits"
    ),
    logs: Annotated[Path | None, typer.Option(help="Folder that gets the logs too.")] = None,
    speed: Speed = 1.0,
    contact_speed: Slow = 0.2,
) -> None:
    """Film one docking per controller: all in the sea of the lowest limit, and each at its own."""
    from marine_mj.compare import variants_at_limit
    from marine_mj.limits import LimitTable

    loaded = LimitTable.load(table)
    options = {"speed": speed, "contact_speed": contact_speed}
    for shared, name in ((True, "same_sea"), (False, "own_limit")):
        chosen = variants_at_limit(loaded, shared)
        _film(chosen, output / f"{name}.mp4", logs and logs / name, options)


def varied_values(text: str) -> tuple[str, list[Any]]:
    """Key and values of KEY=VALUE,VALUE,... or KEY=[VALUE, ...] in TOML.

    Raises:
        ScenarioError: it is not of this form.
    """
    key, separator, listed = text.partition("=")
    if not (key.strip() and separator and listed.strip()):
        raise ScenarioError(
            f"--vary {text!r} is not KEY=VALUE,VALUE,..., such as task.settings.controller=cpv,mpc"
        )
    if listed.strip().startswith("["):
        return key.strip(), list(toml.value(listed.strip()))
    return key.strip(), [toml.value(value.strip()) for value in listed.split(",")]


def _film(
    chosen: "Sequence[Variant]", output: Path, logs: Path | None, options: dict[str, Any]
) -> None:
    """Run variants, show their results and make the video."""
    from marine_mj.cli import _progress, console
    from marine_mj.demo import video
    from marine_mj.video import require_gl

    require_gl()
    table = Table("run", "docked", "latch, s", "largest contact force, N", box=None, pad_edge=False)
    done = []
    with _progress() as report:
        for variant in chosen:
            log = variant.run(report)
            done.append(log)
            if logs is not None:
                log.save(logs / f"{variant.title.replace(', ', '_').replace(' ', '_')}.nc")
            values = (log.summary.get(k) for k in ("docked", "latch_time", "peak_contact_force"))
            table.add_row(variant.title, *("" if value is None else f"{value}" for value in values))
        console.print(table)
        titles = [variant.title for variant in chosen]
        video(done, output, lambda n, of: report("video", n, of), titles=titles, **options)
    console.print(f"wrote {output}")
