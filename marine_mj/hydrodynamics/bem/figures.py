"""Pictures of a wave database: motion RAOs, wave forces, added mass and damping."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.raos import DOFS
from marine_mj.plotting import COLORS

if TYPE_CHECKING:
    import xarray as xr

#: Headings drawn by default: following, quartering, beam, bow and head seas.
HEADINGS = (0.0, 45.0, 90.0, 135.0, 180.0)


def plot_raos(data: "xr.Dataset", response: str = "RAO", headings=HEADINGS) -> Figure:
    """Figure of magnitude and phase of all six degrees of freedom over the wave period.

    Rotations of the motion RAO are per wave slope k a. Phases are left out where the magnitude is
    below 1 % of its largest: they mean nothing there.

    Args:
        data: wave database.
        response: "RAO" or "excitation_force".
        headings: directions of travel, deg; the nearest ones in the database are drawn.

    Raises:
        ModelError: the database has no such response (unbounded fluid).
    """
    if response not in data:
        raise ModelError(f"the database has no {response}: it was made without waves")
    dims = [d for d in data[response].dims if str(d).endswith("_dof")]
    values = data[response].sel({dims[0]: DOFS}).transpose("complex", "omega", ..., dims[0]).values
    phasor = values[0] + 1j * values[1]
    period = 2 * np.pi / data["omega"].values
    slope = response == "RAO"
    if slope:
        phasor = phasor / np.where(np.arange(6) < 3, 1.0, data["wavenumber"].values[:, None, None])
    beta = np.degrees(data["wave_direction"].values)
    chosen = sorted({int(np.abs((beta - h + 180) % 360 - 180).argmin()) for h in headings})
    figure = _figure(12.5, 9.6)
    axes = figure.subplots(6, 2, sharex=True, gridspec_kw={"width_ratios": (1.5, 1)})
    units = ["m/m"] * 3 + ["rad / (k a)"] * 3 if slope else ["N/m"] * 3 + ["N m/m"] * 3
    largest = np.abs(phasor[:, chosen]).max(axis=(0, 1))
    # What should be zero by symmetry is drawn as zero.
    floor = 1e-3 * np.repeat([largest[:3].max(), largest[3:].max()], 3)
    for dof, (left, right) in enumerate(axes):
        for color, i in zip(COLORS, chosen, strict=False):
            size = np.abs(phasor[:, i, dof])
            label = f"{beta[i]:.0f}°"
            left.plot(period, size, color=color, label=label, linewidth=1.4)
            seen = size > max(0.01 * largest[dof], floor[dof])
            angle = np.where(seen, np.degrees(np.angle(phasor[:, i, dof])), np.nan)
            right.plot(period, angle, ".", color=color, markersize=4)
            right.plot(period, _unjumped(angle), color=color, linewidth=0.8, alpha=0.6)
        left.set_ylabel(f"{DOFS[dof].lower()}\n{units[dof]}", fontsize=8)
        left.set_ylim(0, 1.06 * max(largest[dof], 5 * floor[dof], 1e-12))
        right.set_ylim(-185, 185)
        right.set_yticks([-180, -90, 0, 90, 180])
    for axis in axes[-1]:
        axis.set_xlabel("wave period (s)", fontsize=8)
    axes[0, 0].set_title("magnitude", loc="left", fontsize=9)
    axes[0, 1].set_title("phase after the crest at the origin (deg)", loc="left", fontsize=9)
    for axis in axes.ravel():
        _finish(axis)
        # Long waves say little: the axis ends where the body follows them.
        axis.set_xscale("log")
        axis.set_xlim(period.min(), period.max())
        ticks = [t for t in (0.5, 1, 2, 3, 5, 7, 10, 15, 20, 30) if period.min() <= t]
        axis.set_xticks([t for t in ticks if t <= period.max()], minor=False)
        axis.set_xticks([], minor=True)
        axis.xaxis.set_major_formatter("{x:g}")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        title="direction of travel (0° following, 180° head seas)",
        loc="outside lower center",
        ncols=len(labels),
        fontsize=8,
        title_fontsize=8,
        frameon=False,
    )
    name = "Motion RAOs" if slope else "Wave excitation per metre of amplitude"
    _title(figure, f"{name}: {_short(data)}")
    return figure


def plot_radiation(data: "xr.Dataset") -> Figure:
    """Figure of A(omega) and B(omega) on the diagonal, with A(0) and A(inf) and the couplings.

    Raises:
        ModelError: the database has no frequencies (unbounded fluid).
    """
    if "added_mass" not in data:
        raise ModelError("the database has no added_mass(omega): it was made without waves")
    omega = data["omega"].values
    A, B = (
        data[name].sel(radiating_dof=DOFS, influenced_dof=DOFS).transpose("omega", ...).values
        for name in ("added_mass", "radiation_damping")
    )
    limits = {"A(∞)": ("infinite_added_mass", ":"), "A(0)": ("zero_frequency_added_mass", "--")}
    figure = _figure(12.5, 7.4)
    axes = figure.subplots(3, 4)
    for dof in range(6):
        row, column = dof % 3, 2 * (dof // 3)
        left, right = axes[row, column], axes[row, column + 1]
        left.plot(omega, A[:, dof, dof], color=COLORS[1], linewidth=1.4)
        right.plot(omega, B[:, dof, dof], color=COLORS[0], linewidth=1.4)
        for label, (name, line) in limits.items():
            if name in data:
                value = float(data[name].values[dof, dof])
                left.axhline(value, color="0.35", linestyle=line, linewidth=0.9, label=label)
        left.set_title(f"added mass {dof + 1}{dof + 1}, {DOFS[dof].lower()}", loc="left")
        right.set_title(f"damping {dof + 1}{dof + 1}", loc="left")
        left.set_ylabel("kg" if dof < 3 else "kg m²", fontsize=8)
        right.set_ylabel("kg/s" if dof < 3 else "kg m²/s", fontsize=8)
        left.set_ylim(bottom=min(0.0, float(A[:, dof, dof].min()) * 1.1))
        right.axhline(0, color="0.8", linewidth=0.8, zorder=0)
    axes[0, 0].legend(fontsize=7, frameon=False)
    for axis in axes.ravel():
        _finish(axis)
        axis.set_title(axis.get_title(loc="left"), loc="left", fontsize=8.5)
        axis.set_xlim(0, omega.max())
        axis.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4))
        axis.yaxis.get_offset_text().set_fontsize(7)
    for axis in axes[-1]:
        axis.set_xlabel("ω (rad/s)", fontsize=8)
    _title(figure, f"Radiation: {_short(data)}")
    return figure


def plot_convergence(sizes: NDArray, values: dict[str, NDArray], title: str) -> Figure:
    """Figure of coefficients over the panel size, each divided by its limit.

    Args:
        sizes: (n,) panel sizes, m.
        values: (n,) ratios to the limit (extrapolated or finest value), by name.
        title: of the picture.
    """
    figure = _figure(7.5, 4.4)
    axis = figure.subplots()
    for i, (name, ratio) in enumerate(values.items()):
        style = ("-", "--", ":")[i // len(COLORS) % 3]
        color = COLORS[i % len(COLORS)]
        axis.plot(sizes, 100 * (ratio - 1), f"o{style}", color=color, label=name, markersize=4)
    axis.axhline(0, color="0.35", linewidth=0.8)
    axis.set_xlim(left=0)
    axis.set_xlabel("mean panel size (m)", fontsize=8)
    axis.set_ylabel("difference from the limit (%)", fontsize=8)
    axis.legend(fontsize=7, frameon=False, ncols=2)
    _finish(axis)
    _title(figure, title)
    return figure


def _figure(width: float, height: float) -> Figure:
    """Empty figure on an Agg canvas."""
    figure = Figure(figsize=(width, height), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _title(figure: Figure, text: str) -> None:
    """Title of the page, left."""
    figure.suptitle(text, fontsize=11, x=0.01, ha="left", weight="bold")


def _short(data: "xr.Dataset") -> str:
    """Name and water of a database."""
    title = str(data.attrs.get("title", "")).removeprefix("Linear wave response of ")
    return f"{title}, {data.attrs.get('water', '')}"


def _unjumped(angle: NDArray) -> NDArray:
    """Angles in degrees with gaps where they jump from 180 to -180."""
    out = np.array(angle)
    out[1:][np.abs(np.diff(angle)) > 180] = np.nan
    return out


def _finish(axis: Axes) -> None:
    """Grid and small type."""
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    axis.grid(True, color="0.92", linewidth=0.7)
    axis.set_axisbelow(True)
    axis.tick_params(labelsize=7.5)
