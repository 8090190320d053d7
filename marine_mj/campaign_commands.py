"""The commands `marine-mj campaign ...` and `marine-mj replay`."""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from marine_mj.errors import CampaignError

campaign_app = typer.Typer(
    help="Monte Carlo studies and sweeps.", no_args_is_help=True, add_completion=False
)
console = Console()
errors = Console(stderr=True)

File = Annotated[str, typer.Argument(help="TOML file, name of a packaged campaign, or its folder.")]
Out = Annotated[Path | None, typer.Option("--out", help="Folder; default results/campaigns/NAME.")]
Workers = Annotated[int | None, typer.Option(help="Processes; default: one per processor.")]
Cluster = Annotated[
    str | None, typer.Option(help="'local', or a Dask scheduler, such as tcp://10.0.0.1:8786.")
]


@campaign_app.command("run")
def run_command(
    file: File, out: Out = None, workers: Workers = None, cluster: Cluster = None
) -> None:
    """Start a campaign; its folder survives being killed."""
    _run(file, out, workers, cluster)


@campaign_app.command("resume")
def resume_command(
    file: File,
    out: Out = None,
    workers: Workers = None,
    cluster: Cluster = None,
    extend: Annotated[bool, typer.Option("--extend", help="Add runs: `runs` grew.")] = False,
) -> None:
    """Go on with a campaign: only what is missing is computed."""
    _run(file, out, workers, cluster, resume=True, extend=extend)


@campaign_app.command("status")
def status_command(file: File, out: Out = None) -> None:
    """Say how far a campaign is."""
    from marine_mj.campaign.status import status

    folder = _folder(file, out)
    found = status(folder)
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_row("campaign", found.name)
    table.add_row("folder", str(folder))
    table.add_row("state", found.state)
    of = f" of {found.progress.total}" if found.progress.total else ""
    table.add_row("finished", f"{found.progress.done}{of} runs")
    table.add_row("errors", str(found.progress.errors))
    if found.progress.total:
        low, high = found.interval
        table.add_row("success", f"{found.progress.successes} (95 % {low:.3f} to {high:.3f})")
    console.print(table)
    if found.searches:
        levels = Table("cell", "repetition", "level", "metric", "probability beyond", box=None)
        for s in found.searches:
            for i, (metric, p) in enumerate(zip(s.metrics, s.probabilities, strict=True)):
                names = (str(s.cell), str(s.repetition), str(i + 1))
                levels.add_row(*names, f"{metric:.6g}", f"{p:.3g}")
        console.print(levels)


@campaign_app.command("report")
def report_command(file: File, out: Out = None) -> None:
    """Make tables and figures of what is finished -> FOLDER/report."""
    from marine_mj.campaign.report import report

    folder = _folder(file, out)
    found = report(folder)
    if "event" in found:
        console.print(_rare_table(found))
        console.print(f"wrote {folder / 'report'}", soft_wrap=True)
        return
    table = Table("cell", "factors", "runs", "success", "95 % interval", box=None, pad_edge=False)
    for cell in found["cells"]:
        factors = ", ".join(f"{k} {v}" for k, v in cell["factors"].items())
        interval = f"{cell['low']:.3f} to {cell['high']:.3f}"
        share = f"{cell['successes']} ({cell['probability']:.3f})"
        table.add_row(str(cell["cell"]), factors, str(cell["n"]), share, interval)
    console.print(table)
    console.print(f"wrote {folder / 'report'}", soft_wrap=True)


def _rare_table(found: dict[str, Any]) -> Table:
    """Probabilities of a rare event and the runs to look at."""
    table = Table("cell", "factors", "runs", found["event"], "cov", "95 % interval", "worst runs")
    table.box, table.pad_edge = None, False
    for cell in found["cells"]:
        factors = ", ".join(f"{k} {v}" for k, v in cell["factors"].items())
        p, cov, interval = f"not reached, below about {cell['at_most']:.2g}", "", ""
        if cell["probability"] is not None:
            p, cov = f"{cell['probability']:.3g}", f"{cell['cov']:.2f}"
            interval = f"{cell['low']:.2g} to {cell['high']:.2g}"
        worst = " ".join(str(w["run"]) for w in cell["worst"][:3])
        table.add_row(str(cell["cell"]), factors, str(cell["runs"]), p, cov, interval, worst)
    return table


def replay_command(
    campaign: Annotated[str, typer.Argument(help="Folder or file of the campaign.")],
    run: Annotated[int, typer.Argument(help="Number of the run.")],
    out: Out = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder.")] = None,
    video: Annotated[bool, typer.Option("--video", help="Make a video too.")] = False,
) -> None:
    """Do one run of a campaign again: log, summary, and a video if wanted."""
    from marine_mj.campaign.replay import replay
    from marine_mj.demo import write_json
    from marine_mj.simulation import Log

    found = replay(_folder(campaign, out), run, output)
    write_json(found.log.with_name("summary.json"), found.summary)
    if found.error is not None:
        console.print(f"the run ended early: {found.error}", markup=False, soft_wrap=True)
    if found.differences:
        names = ", ".join(found.differences)
        errors.print(f"differs from the campaign in: {names}", style="yellow", soft_wrap=True)
    else:
        console.print("the same results as in the campaign")
    console.print(f"wrote {found.log}", soft_wrap=True)
    if video:
        from marine_mj.demo import video as make_video

        console.print(
            f"wrote {make_video(Log.load(found.log), found.log.with_name('video.mp4'), None)}"
        )


def _run(
    file: str,
    out: Path | None,
    workers: int | None,
    cluster: str | None,
    resume: bool = False,
    extend: bool = False,
) -> None:
    """Run or go on, with progress."""
    from marine_mj.campaign import Plan, load_plan, run_campaign
    from marine_mj.campaign.pools import cores

    if workers is not None and cluster in (None, "local") and workers > cores():
        raise CampaignError(
            f"--workers {workers}: this machine has {cores()} processors; more processes than "
            "that only slow each other down"
        )
    folder = _folder(file, out)
    plan = load_plan(file) if Path(file).is_dir() else Plan.load(file)
    try:
        with _progress(plan.total) as tell:
            done = run_campaign(
                plan,
                folder,
                resume=resume,
                extend=extend,
                workers=workers,
                cluster=cluster,
                progress=tell,
            )
    except KeyboardInterrupt:
        errors.print(
            f"interrupted; finished chunks are in {folder}. Go on with: marine-mj campaign resume "
            f"{file} --out {folder}",
            soft_wrap=True,
        )
        raise typer.Exit(1) from None
    console.print(
        f"{done.done} of {done.total or done.done} runs, {done.successes} successes, "
        f"{done.errors} errors; wrote {folder}. Next: marine-mj campaign report {folder}",
        soft_wrap=True,
        highlight=False,
    )


def _folder(file: str, out: Path | None) -> Path:
    """The campaign's folder: --out, the argument itself, or the default for its name."""
    from marine_mj.campaign import Campaign

    if out is not None:
        return out
    if Path(file).is_dir():
        return Path(file)
    return Path("results") / "campaigns" / Campaign.load(file).name


@contextlib.contextmanager
def _progress(total: int) -> Iterator[Callable[[Any], None]]:
    """A function that shows how far the campaign is."""
    columns = (
        TextColumn("runs"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[failures]} without success, {task.fields[errors]} errors"),
        TextColumn("{task.fields[note]}"),
        TimeElapsedColumn(),
        TextColumn("ETA"),
        TimeRemainingColumn(),
    )
    quiet = not errors.is_terminal
    with Progress(
        *columns, console=errors, transient=True, disable=quiet, speed_estimate_period=3600
    ) as bar:
        task = bar.add_task("runs", total=total or None, failures=0, errors=0, note="")

        def tell(now: Any) -> None:
            failures = now.done - now.successes
            bar.update(
                task, completed=now.done, failures=failures, errors=now.errors, note=now.note
            )

        yield tell
