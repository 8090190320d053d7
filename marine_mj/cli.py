"""The command `marine-mj`. Heavy imports stay inside the commands, so that help is quick."""

import contextlib
import dataclasses
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from marine_mj.campaign_commands import campaign_app, replay_command
from marine_mj.compare_command import compare_command, limits_app
from marine_mj.errors import MarineMjError, ScenarioError, SimulationError
from marine_mj.hydro_command import hydro_command
from marine_mj.reproduce_command import reproduce_command
from marine_mj.toml import assignments

app = typer.Typer(
    help="Marine vehicle simulation on MuJoCo.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.add_typer(campaign_app, name="campaign")
app.add_typer(limits_app, name="limits")
app.command("replay")(replay_command)
app.command("compare")(compare_command)
console = Console()
errors = Console(stderr=True)


@app.command("run")
def run_command(
    scenario: Annotated[str, typer.Argument(help="TOML file or name of a packaged scenario.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder.")] = Path("results"),
    seed: Annotated[int | None, typer.Option(help="Instead of the scenario's seed.")] = None,
    values: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE, such as sea.sea_state=3.")
    ] = None,
    first_step: Annotated[
        bool, typer.Option("--first-step", help="Stop after one step, write nothing.")
    ] = False,
) -> None:
    """Run a scenario; writes FOLDER/NAME/log.nc and summary.json."""
    from marine_mj.scenario import Scenario

    chosen = Scenario.load(scenario).with_values(assignments(values or []))
    if seed is not None:
        chosen = chosen.with_values({"seed": seed})
    if first_step:
        from marine_mj.tasks import build_environment

        environment = build_environment(chosen, random=chosen.seed)
        environment.reset()
        environment.step(environment.task.default_action(environment.physics))
        return

    from marine_mj.demo import write_json
    from marine_mj.simulation import run

    folder = output / chosen.name
    try:
        with _progress() as report:
            log = run(chosen, progress=lambda time, end: report("simulating", time, end))
    except SimulationError as error:
        if error.log is not None:
            file = error.log.save(folder / "log.nc")
            errors.print(f"the log until then is in {file}")
        raise
    log.save(folder / "log.nc")
    write_json(folder / "summary.json", log.summary)
    _show(log.summary)
    console.print(f"wrote {folder / 'log.nc'} and {folder / 'summary.json'}")


@app.command("video")
def video_command(
    logs: Annotated[list[Path], typer.Argument(help="log.nc of a run; several: side by side.")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="MP4 file.")] = None,
    camera: Annotated[
        list[str] | None, typer.Option(help="Camera; a second one becomes an inset.")
    ] = None,
    start: Annotated[float | None, typer.Option(help="First second of the run.")] = None,
    stop: Annotated[float | None, typer.Option(help="Last second of the run.")] = None,
    speed: Annotated[float, typer.Option(help="Seconds of the run per second of video.")] = 1.0,
    contact_speed: Annotated[
        float | None, typer.Option(help="The same while in contact with the dock, such as 0.2.")
    ] = None,
    markers: Annotated[bool, typer.Option(help="Mark target and estimates of a docking.")] = True,
) -> None:
    """Make a video of a log, or of several side by side."""
    from marine_mj.demo import video
    from marine_mj.simulation import Log

    options: dict[str, Any] = {"start": start, "stop": stop, "speed": speed, "markers": markers}
    options["contact_speed"] = contact_speed
    if camera:
        options["camera"] = tuple(camera)
    loaded = [Log.load(log) for log in logs]
    if len(loaded) > 1:
        options["titles"] = [log.stem for log in logs]
    with _progress() as report:
        file = video(
            loaded,
            output or logs[0].with_name("video.mp4"),
            lambda done, total: report("video", done, total),
            **options,
        )
    console.print(f"wrote {file}")


@app.command("plot")
def plot_command(
    log: Annotated[Path, typer.Argument(help="log.nc of a run.")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Picture file.")] = None,
) -> None:
    """Plot poses, errors and forces of a log."""
    from marine_mj.demo import plot
    from marine_mj.simulation import Log

    console.print(f"wrote {plot(Log.load(log), output or log.with_name('plot.png'))}")


@app.command("list")
def list_command() -> None:
    """List vehicles, docks, scenarios, campaigns and tasks."""
    from marine_mj.campaign import Campaign
    from marine_mj.library import find_model, is_dock, model_names
    from marine_mj.scenario import Scenario
    from marine_mj.suite import ALL_TASKS, BASE_TASKS

    paths = {name: find_model(name) for name in model_names()}
    docks = {name for name, path in paths.items() if is_dock(path)}
    table = Table("kind", "name", "about", box=None, pad_edge=False)
    for kind, names in (("vehicle", set(paths) - docks), ("dock", docks)):
        for name in sorted(names):
            table.add_row(kind, name, str(paths[name].parent))
    for name, path in Scenario.packaged().items():
        table.add_row("scenario", name, Scenario.load(path).description)
    for name, path in Campaign.packaged().items():
        table.add_row("campaign", name, Campaign.load(path).description)
    for domain, task in BASE_TASKS:
        table.add_row("task", f"{domain} {task}", "marine_mj.suite.load(domain, task)")
    more = [task for pair in ALL_TASKS if pair not in BASE_TASKS for task in pair[1:]]
    if more:
        about = f"{len(more)} variants of controller and sea state: marine_mj.suite.ALL_TASKS"
        table.add_row("task", f"{more[0]} ... {more[-1]}", about)
    console.print(table)


@app.command("check-model")
def check_model_command(
    model: Annotated[str, typer.Argument(help="Name or path of a vehicle.")],
) -> None:
    """Check a vehicle: mass, trim, stability, natural periods, added mass, time step."""
    from marine_mj.hydrodynamics import check_model

    _rows(check_model(model))


app.command("hydro")(hydro_command)
app.command("reproduce")(reproduce_command)


@app.command("bench")
def bench_command(
    file: Annotated[Path | None, typer.Option("--json", help="Write the rows here.")] = None,
) -> None:
    """Measure speed against its bars."""
    from marine_mj import benchmark
    from marine_mj.demo import write_json

    console.print(benchmark.machine(), highlight=False)
    rows = benchmark.run()
    if file is not None:
        write_json(file, rows)
    _rows(rows)


@app.command("validate")
def validate_command(
    results: Annotated[Path, typer.Option(help="Folder of validation.json.")] = Path("results"),
    page: Annotated[Path, typer.Option(help="The table as a page.")] = Path("docs/validation.md"),
) -> None:
    """Compare with closed forms, independent solutions and the literature."""
    from marine_mj import validation

    with _progress() as report:
        rows = validation.run(lambda done, total, name: report("validation", done, total))
    validation.write(rows, results)
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text(validation.markdown(rows), encoding="utf-8")
    _rows([row.as_dict() for row in rows])


@app.command("tune")
def tune_command(
    task: Annotated[str, typer.Argument(help="What is tuned: docking.")] = "docking",
    scenario: Annotated[str, typer.Option(help="Scenario that keeps station.")] = "docking_tuning",
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder.")] = Path(
        "results/tuning"
    ),
    threads: Annotated[int, typer.Option(help="Native threads.")] = 1,
    thin: Annotated[int, typer.Option(help="Use every how many-th value of the grid.")] = 1,
) -> None:
    """Tune the docking pose PID by brute force; writes FOLDER/docking.csv and best.json."""
    import numpy as np

    from marine_mj import tuning
    from marine_mj.demo import write_json

    if task != "docking":
        raise ScenarioError(f"cannot tune {task!r}; available: docking")
    if thin < 1:
        raise ScenarioError(f"--thin {thin}: allowed are whole numbers >= 1")
    grid = [values[::thin] for values in (tuning.GRID_P, tuning.GRID_I, tuning.GRID_D)]
    with _progress() as report:
        result = tuning.tune_docking(
            scenario,
            *grid,
            threads=threads,
            progress=lambda done, total: report("tuning", done, total),
        )
    best = result.best()
    values = tuning.gain_values(*(np.asarray(v) for v in (best.P, best.I, best.D)))
    ours = {"task.settings.gains": None, "task.settings.gain_values": values}
    sets = {"best": ours} | {
        name: {"task.settings.gains": name} for name in ("manual", "brute_force")
    }
    controller = {"task.settings.controller": "pose_pid"}
    changes = [controller | change for change in sets.values()]
    errors = tuning.station_errors(scenario, changes)
    rows = [
        {"gains": name, **dict(zip(tuning.AXES, row.sum(axis=0).tolist(), strict=True)),
         "sum": float(row.sum())}
        for name, row in zip(sets, errors, strict=True)
    ]  # fmt: skip
    table = result.write(output / "docking.csv")
    file = output / "best.json"
    write_json(file, {"gain_values": values, "scores": rows})
    _rows(rows)
    console.print(f"wrote {table} and {file}")


@app.command("new-vehicle")
def new_vehicle_command(
    name: Annotated[str, typer.Argument(help="Name of the vehicle and of its folder.")],
    folder: Annotated[Path, typer.Option(help="Where the folder is made.")] = Path("models"),
    mass: Annotated[float | None, typer.Option(help="kg")] = None,
    inertia: Annotated[str | None, typer.Option(help="'Ix Iy Iz', kg m2")] = None,
    center_of_gravity: Annotated[
        str | None, typer.Option(help="'x y z' from the origin, FRD, m")
    ] = None,
    buoyancy: Annotated[float | None, typer.Option(help="Submerged, N")] = None,
    added_mass: Annotated[str | None, typer.Option(help="6 values, FRD, positive")] = None,
    linear_damping: Annotated[str | None, typer.Option(help="6 values, FRD, positive")] = None,
    quadratic_damping: Annotated[str | None, typer.Option(help="6 values, FRD, positive")] = None,
) -> None:
    """Make the folder of a new vehicle from the template."""
    from marine_mj.new_vehicle import new_vehicle

    given = {
        "added_mass_frd": added_mass,
        "linear_damping_frd": linear_damping,
        "quadratic_damping_frd": quadratic_damping,
    }
    made = new_vehicle(
        name,
        folder,
        mass=mass,
        inertia=None if inertia is None else _numbers("--inertia", inertia),
        center_of_gravity=None
        if center_of_gravity is None
        else _numbers("--center-of-gravity", center_of_gravity),
        buoyancy=buoyancy,
        coefficients={
            key: _numbers(f"--{key[:-4].replace('_', '-')}", text)
            for key, text in given.items()
            if text is not None
        },
    )
    console.print(f"made {made}; next: marine-mj check-model {made}")


@app.command("demo")
def demo_command(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder.")] = Path("results/demo"),
    seed: Annotated[int | None, typer.Option(help="Instead of the scenario's seed.")] = None,
) -> None:
    """Dock an AUV to a USV in waves: log, plot, summary and video."""
    from marine_mj.demo import run_demo
    from marine_mj.scenario import Scenario

    scenario = Scenario.load("docking_demo")
    if seed is not None:
        scenario = scenario.with_values({"seed": seed})
    with _progress() as report:
        summary = run_demo(output, scenario, report)
    _show(summary)
    if summary["video"] is None:
        console.print(f"no video: {summary['video_reason']}", soft_wrap=True, markup=False)
    console.print(f"wrote {output}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: one clear message and exit code 1 for every error raised on purpose."""
    try:
        app(arguments, standalone_mode=True)
    except MarineMjError as error:
        errors.print(f"error: {error}", style="red", markup=False, soft_wrap=True, highlight=False)
        sys.exit(1)


@contextlib.contextmanager
def _progress() -> Iterator[Callable[[str, float, float], None]]:
    """A function that shows how much of a part is done, with the time that remains."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f}%"),
        TimeElapsedColumn(),
        TextColumn("ETA"),
        TimeRemainingColumn(),
    )
    quiet = not errors.is_terminal
    with Progress(*columns, console=errors, transient=True, disable=quiet) as bar:
        parts: dict[str, Any] = {}

        def report(part: str, done: float, total: float) -> None:
            if part not in parts:
                parts[part] = bar.add_task(part, total=total)
            bar.update(parts[part], completed=done, total=total)

        yield report


def _numbers(option: str, text: str) -> list[float]:
    """Numbers of a text, separated by blanks or commas."""
    try:
        return [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a list of numbers", param_hint=option) from None


def _dictionary(row: Any) -> dict[str, Any]:
    """A row as a dictionary."""
    return dataclasses.asdict(row) if dataclasses.is_dataclass(row) else dict(row)  # type: ignore[arg-type]


def _rows(rows: Sequence[Any]) -> None:
    """Print rows as a table; exit with 1 if one of them is not ok."""
    listed = [_dictionary(row) for row in rows]
    table = Table(*(listed[0] if listed else ()), box=None, pad_edge=False)
    marks = {True: "[green]pass[/]", False: "[red]FAIL[/]", None: ""}
    for row in listed:
        cells = [marks[v] if k == "ok" else _cell(v) for k, v in row.items()]
        table.add_row(*cells, end_section=False)
    console.print(table)
    failed = sum(row.get("ok") is False for row in listed)
    if failed:
        errors.print(f"{failed} of {len(listed)} rows failed", style="red")
        raise typer.Exit(1)


def _cell(value: Any) -> str:
    """Text of one value."""
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _show(summary: dict[str, Any]) -> None:
    """Print a summary."""
    for key, value in summary.items():
        if key != "versions" and value is not None:
            text = json.dumps(value) if isinstance(value, dict) else _cell(value)
            console.print(f"{key:>20}  {text}", highlight=False, markup=False, soft_wrap=True)


if __name__ == "__main__":
    main()
