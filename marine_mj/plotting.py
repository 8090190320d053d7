"""Figures of a log: one page that shows what every vehicle did and why."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from marine_mj.errors import LogError
from marine_mj.overlay import phase_label, phase_names

#: Colours told apart also with colour-blind eyes (Okabe and Ito 2008), vehicles first.
COLORS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
#: Contact below this is not worth an event, N.
TOUCH = 1.0
_STYLE: dict[str, Any] = {"linewidth": 1.3}


@dataclass(frozen=True)
class Event:
    """Something that happened: time in s and a short label."""

    time: float
    label: str


def dataset_of(log: Any) -> Any:
    """The dataset of a log, or a dataset itself.

    Raises:
        LogError: it has no `time` or no `eta_ned`.
    """
    data = log if hasattr(log, "data_vars") else getattr(log, "data", None)
    missing = [name for name in ("time", "eta_ned") if data is None or name not in data]
    if missing:
        raise LogError(f"the log has no {' and no '.join(missing)}: nothing to plot")
    return data


def events(log: Any) -> list[Event]:
    """Phase changes, first contact and latching in a log, in order of time."""
    data = dataset_of(log)
    time = np.asarray(data["time"], float)
    found = []
    if "phase" in data:
        phase, names = np.asarray(data["phase"], float), phase_names(data)
        # NaN: no phase; leaving one is no event.
        for i in np.flatnonzero((phase[1:] != phase[:-1]) & np.isfinite(phase[1:])) + 1:
            found.append(Event(float(time[i]), phase_label(phase[i], names)))
    if "latched" in data:
        latched = np.asarray(data["latched"], float) > 0.5
        for i in np.flatnonzero(latched[1:] != latched[:-1]) + 1:
            label = "latched" if latched[i] else "unlatched"
            if not any(event.time == time[i] and event.label == label for event in found):
                found.append(Event(float(time[i]), label))
    if "contact_force" in data:
        touching = np.flatnonzero(_magnitude(data["contact_force"]) > TOUCH)
        if len(touching):
            found.append(Event(float(time[touching[0]]), "first contact"))
    return sorted(found, key=lambda event: event.time)


def plot_run(log: Any) -> Figure:
    """Figure of a run: tracks, poses, errors, forces by cause and contact, events marked.

    Args:
        log: `marine_mj.simulation.Log` or its dataset (docs/architecture.md, section Log). Panels
            whose variables the log lacks are left out; any number of vehicles.

    Returns:
        A figure on an Agg canvas: `figure.savefig("run.png")`.

    Raises:
        LogError: the log has no `time` or no `eta_ned`.
    """
    data = dataset_of(log)
    panels = _panels(data)
    rows = (len(panels) + 1) // 2
    figure = Figure(figsize=(11.0, 0.7 + 2.35 * rows), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = np.atleast_1d(figure.subplots(rows, 2, squeeze=False)).ravel()
    marked = events(data)
    for axis, (draw, over_time) in zip(axes, panels, strict=False):
        draw(axis, data)
        _finish(axis, data, marked if over_time else [], first=axis in axes[:2])
    for axis in axes[len(panels) :]:
        axis.set_visible(False)
    _mark_phases(axes[: len(panels)], panels, marked)
    title = str(data.attrs.get("title", "")) or _scenario_name(data)
    if title:
        figure.suptitle(title, fontsize=11, x=0.01, ha="left", weight="bold")
    return figure


_Panel = tuple[Callable[[Axes, Any], None], bool]


def _panels(data: Any) -> list[_Panel]:
    """Drawing functions of what the log has, and whether their abscissa is time."""
    panels: list[_Panel] = [(_track, False), (_depth, True)]
    if "dock_error" in data:
        panels.append((_dock_error, True))
    panels.append((_attitude, True))
    if "nu_frd" in data:
        panels.append((_speed, True))
    if "relative_velocity" in data:
        panels.append((_relative_velocity, True))
    if "wrench" in data:
        for i in range(data["wrench"].sizes[data["wrench"].dims[1]]):
            panel = _forces_of(i)
            if np.any(_force_by_cause(data, i) > 1e-6):
                panels.append((panel, True))
    if "contact_force" in data:
        panels.append((_contact, True))
    return panels


def _vehicles(data: Any) -> list[str]:
    dimension = data["eta_ned"].dims[1]
    count = data["eta_ned"].sizes[dimension]
    if dimension in data.coords:
        return [str(name) for name in data[dimension].values]
    return [f"vehicle {i}" for i in range(count)]


def _time(data: Any) -> NDArray[np.float64]:
    return np.asarray(data["time"], float)


def _magnitude(values: Any) -> NDArray[np.float64]:
    """Absolute value (n,) of a scalar or vector series."""
    values = np.asarray(values, float)
    return (
        np.abs(values)
        if values.ndim == 1
        else np.linalg.norm(values.reshape(len(values), -1), axis=1)
    )


def _track(axis: Axes, data: Any) -> None:
    eta = np.asarray(data["eta_ned"], float)
    span = np.ptp(eta[..., :2].reshape(-1, 2), axis=0)
    # The plane of the motion: seen from the side when nobody steers to the side.
    side = span[1] < 0.15 * max(span[0], 1e-9) or span[1] < 0.5
    x, y = (0, 2) if side else (1, 0)
    for name, color, path in zip(_vehicles(data), COLORS * 3, np.moveaxis(eta, 1, 0), strict=False):
        axis.plot(path[:, x], path[:, y], color=color, label=name, **_STYLE)
        axis.plot(path[0, x], path[0, y], "o", color=color, markersize=4, fillstyle="none")
        axis.plot(path[-1, x], path[-1, y], "o", color=color, markersize=4)
    if side:
        axis.invert_yaxis()
        axis.axhline(0, color="#5fa8c9", linewidth=0.8, zorder=0)
    axis.set_xlabel("north (m)" if side else "east (m)")
    axis.set_ylabel("down (m)" if side else "north (m)")
    axis.set_title("Track from the side" if side else "Track from above")
    axis.set_aspect("equal", adjustable="datalim")
    axis.legend(title="o start   ● end", title_fontsize=7)


def _depth(axis: Axes, data: Any) -> None:
    _lines(axis, data, np.asarray(data["eta_ned"], float)[..., 2])
    axis.invert_yaxis()
    axis.axhline(0, color="#5fa8c9", linewidth=0.8, zorder=0)
    axis.set_ylabel("down (m)")
    axis.set_title("Depth")


def _attitude(axis: Axes, data: Any) -> None:
    eta = np.asarray(data["eta_ned"], float)
    styles = {"roll": (3, ":"), "pitch": (4, "-")}
    for name, color, path in zip(_vehicles(data), COLORS * 3, np.moveaxis(eta, 1, 0), strict=False):
        for angle, (index, line) in styles.items():
            values = np.rad2deg(path[:, index])
            if angle == "pitch" or np.ptp(values) > 0.05:
                axis.plot(_time(data), values, line, color=color, label=f"{name} {angle}", **_STYLE)
    axis.set_ylabel("angle (deg)")
    axis.set_title("Roll and pitch")
    axis.legend()


def _speed(axis: Axes, data: Any) -> None:
    nu = np.asarray(data["nu_frd"], float)
    _lines(axis, data, np.linalg.norm(nu[..., :3], axis=-1))
    axis.set_ylabel("speed (m/s)")
    axis.set_title("Speed over ground")


def _lines(axis: Axes, data: Any, values: NDArray) -> None:
    for name, color, line in zip(_vehicles(data), COLORS * 3, values.T, strict=False):
        axis.plot(_time(data), line, color=color, label=name, **_STYLE)
    axis.legend()


def _components(axis: Axes, data: Any, name: str, labels: tuple[str, ...]) -> None:
    """Components of a vector series, lengths on the left axis and angles (deg) on the right."""
    values = np.asarray(data[name], float).reshape(len(_time(data)), -1)
    count = values.shape[1]
    if data[name].ndim == 2 and data[name].dims[1] in data.coords:
        labels = tuple(str(label) for label in data[data[name].dims[1]].values)
    elif count == 1:
        labels = ("",)
    elif count == 3 and "pitch" in str(data[name].attrs.get("components", "")):
        labels = ("surge", "heave", "pitch")
    linear = [i for i in range(count) if not _is_angle(labels, i, count)]
    for i in linear:
        label = labels[i] if i < len(labels) else str(i)
        axis.plot(_time(data), values[:, i], color=COLORS[i % 8], label=label or None, **_STYLE)
    axis.axhline(0, color="0.7", linewidth=0.7, zorder=0)
    if len(linear) < count:
        right = axis.twinx()
        for i in set(range(count)) - set(linear):
            label = labels[i] if i < len(labels) else str(i)
            degrees = np.rad2deg(values[:, i])
            right.plot(_time(data), degrees, "--", color=COLORS[i % 8], label=label, linewidth=1.0)
        right.set_ylabel("angle (deg)" if "error" in name else "rate (deg/s)", fontsize=8)
        right.tick_params(labelsize=7)
        handles = [*axis.get_lines(), *right.get_lines()]
        handles = [line for line in handles if not str(line.get_label()).startswith("_")]
        axis.legend(handles, [str(line.get_label()) for line in handles], ncols=2)
    elif any(labels):
        axis.legend()


def _is_angle(labels: tuple[str, ...], i: int, count: int) -> bool:
    names = ("roll", "pitch", "yaw", "phi", "theta", "psi")
    return (i < len(labels) and labels[i].lower() in names) or (count == 6 and i >= 3)


_AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def _dock_error(axis: Axes, data: Any) -> None:
    _components(axis, data, "dock_error", _AXES)
    axis.set_ylabel("error (m)")
    axis.set_title("Way to the dock")


def _relative_velocity(axis: Axes, data: Any) -> None:
    _components(axis, data, "relative_velocity", _AXES)
    axis.set_ylabel("velocity (m/s)")
    axis.set_title("Velocity relative to the dock")


def _force_by_cause(data: Any, vehicle: int) -> NDArray[np.float64]:
    """Magnitude (n, cause) of the force of every cause on a vehicle, N."""
    return np.linalg.norm(np.asarray(data["wrench"], float)[:, vehicle, :, :3], axis=-1)


def _forces_of(vehicle: int) -> Callable[[Axes, Any], None]:
    def draw(axis: Axes, data: Any) -> None:
        force = _force_by_cause(data, vehicle)
        dimension = data["wrench"].dims[2]
        known = dimension in data.coords
        names = data[dimension].values if known else range(force.shape[1])
        for rank, i in enumerate(np.argsort(-force.max(axis=0))[:8]):
            if force[:, i].max() > 1e-6:
                label = str(names[i]).replace("_", " ")
                axis.plot(_time(data), force[:, i], color=COLORS[rank], label=label, **_STYLE)
        # Weight and thrust may differ by a thousand: logarithmic where linear hides the small.
        peaks = force.max(axis=0)[force.max(axis=0) > 1e-6]
        if peaks.max() > 50 * np.median(peaks):
            axis.set_yscale("symlog", linthresh=max(float(np.median(peaks)) / 10, 1e-3))
        axis.set_ylabel("force (N)")
        axis.set_title(f"Forces on {_vehicles(data)[vehicle]} by cause, magnitude")
        axis.legend(ncols=2)

    return draw


def _contact(axis: Axes, data: Any) -> None:
    force = _magnitude(data["contact_force"])
    axis.plot(_time(data), force, color=COLORS[0], **_STYLE)
    axis.fill_between(_time(data), force, color=COLORS[0], alpha=0.2, linewidth=0)
    axis.set_ylim(bottom=0)
    axis.set_ylabel("force (N)")
    axis.set_title("Contact force")


def _finish(axis: Axes, data: Any, marked: list[Event], first: bool) -> None:
    """What all panels share: grid, small type, the time axis and event lines."""
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    axis.grid(True, color="0.92", linewidth=0.7)
    axis.set_axisbelow(True)
    axis.tick_params(labelsize=7.5)
    axis.xaxis.label.set_fontsize(8)
    axis.yaxis.label.set_fontsize(8)
    axis.set_title(axis.get_title(), loc="left", fontsize=9)
    axis.set_title("", loc="center")
    legend = axis.get_legend()
    if legend is not None:
        legend.get_frame().set(edgecolor="none", alpha=0.75)
        for text in legend.get_texts():
            text.set_fontsize(7)
    if not axis.get_xlabel():
        axis.set_xlabel("time (s)")
        axis.set_xlim(_time(data)[0], max(_time(data)[-1], _time(data)[0] + 1e-9))
    for event in marked:
        axis.axvline(event.time, color="0.35", linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)


def _mark_phases(axes: NDArray, panels: list[_Panel], marked: list[Event]) -> None:
    """Labels of the events on the first panel over time, in rows so that they stay apart."""
    axis = next((a for a, (_, over_time) in zip(axes, panels, strict=True) if over_time), None)
    if axis is None or not marked:
        return
    start, stop = axis.get_xlim()
    ends = [-np.inf] * 4
    for event in marked:
        # Room in data units that a label of this length takes.
        room = 0.016 * (len(event.label) + 2) * (stop - start)
        row = next((i for i, end in enumerate(ends) if event.time > end), len(ends) - 1)
        left = event.time + room > stop
        ends[row] = event.time + (0 if left else room)
        axis.annotate(
            event.label,
            (event.time, 0.03 + 0.085 * row),
            xycoords=("data", "axes fraction"),
            xytext=(-3 if left else 3, 0),
            textcoords="offset points",
            ha="right" if left else "left",
            fontsize=7,
            color="0.25",
        )


def _scenario_name(data: Any) -> str:
    """Name in the scenario that the log carries, or nothing."""
    import tomllib

    try:
        name = tomllib.loads(str(data.attrs.get("scenario", ""))).get("name", "")
    except tomllib.TOMLDecodeError:
        return ""
    seed = data.attrs.get("seed")
    return f"{name} (seed {seed})" if name and seed is not None else str(name)
