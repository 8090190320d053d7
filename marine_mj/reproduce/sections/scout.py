"""The Scout by itself: drag fit (4.9), added mass (4.5 to 4.7), passive responses (4.11)."""

import numpy as np
from scipy.integrate import solve_ivp

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.estimates import fit_drag, prolate_spheroid_added_mass
from marine_mj.reproduce.sections.base import Finding, Job, Outcome, compare, panels
from marine_mj.validation.scout import (
    PASSIVE,
    SCOUT_BUOYANCY,
    SCOUT_WEIGHT,
    passive_response,
    push,
    scout,
)

#: Axis FLU, largest wrench, published quadratic coefficient, units (equation 4.43, labels righted).
_DRAG = {
    "surge": (0, 192.0, 42.1, "m/s", "N", "N s²/m²"),
    "heave": (2, 68.0, 502.4, "m/s", "N", "N s²/m²"),
    "pitch": (4, 20.0, 109.5, "rad/s", "N m", "N m s²"),
}
_NAMES = ("x [m]", "z [m]", "θ [rad]", "u [m/s]", "w [m/s]", "q [rad/s]")
#: Half length and radius of the spheroid with the Scout's length and volume, m (digest 3.3).
_SPHEROID = (0.95, float(np.sqrt(3 * 0.061 / (4 * np.pi * 0.95))))
_RHO = 1025.0


def drag_fit(job: Job) -> Outcome:
    """Steady speeds of the model under constant wrenches, and the study's three fits to them."""
    figure, axes = panels(1, 3, (13, 4.2))
    findings = []
    for ax, (name, (axis, most, published, unit, force, per)) in zip(
        axes[0], _DRAG.items(), strict=True
    ):
        forces = most * np.linspace(0.1, 1.0, 8)
        speeds = []
        for value in forces:
            model, data = scout(0.01)
            righting = 0.01 * SCOUT_BUOYANCY if axis == 4 else 0.0
            net = SCOUT_BUOYANCY - SCOUT_WEIGHT
            speeds.append(push(model, data, axis, value, 8.0, net, righting)[-1, axis])
        fits = fit_drag(speeds, forces)
        grid = np.linspace(0, max(speeds), 60)
        ax.plot(speeds, forces, "ko", ms=4, label="steady speeds of the model")
        for style, (kind, label) in zip(
            ("C1--", "C0-", "C2:"),
            (("linear", "a v"), ("quadratic", "b v²"), ("both", "c v + d v²")),
            strict=True,
        ):
            ax.plot(grid, fits[kind].force(grid), style, label=f"{label}, rms {fits[kind].rms:.2g}")
        ax.set(xlabel=f"{name} speed [{unit}]", ylabel=f"control wrench [{force}]")
        ax.set_title(f"b = {fits['quadratic'].quadratic:.1f} {per}")
        ax.legend(fontsize="small")
        note = "of the model's own towing test: the study's points are not published; within 1 %"
        findings.append(
            compare(f"quadratic drag in {name}", published, fits["quadratic"].quadratic, per,
                    0.01 * published, note)
        )  # fmt: skip
    text = (
        "The free-running test of the study with the model in the Scout's place: constant wrench "
        "along one axis, buoyancy and righting moment taken away, speed after 8 s."
    )
    return Outcome(findings, [job.save(figure, "drag_fit")], text)


def passive_responses(job: Job) -> Outcome:
    """Motion from the six initial states of table 4.5, beside the study's equations."""
    figure, axes = panels(6, 6, (15, 12), sharex=True)
    findings = []
    time = np.linspace(0.0, 10.0, 201)
    for column, (start, *_) in enumerate(PASSIVE):
        ours = passive_response(start, time.tolist(), 0.005)
        theirs = _equations(start, time)
        for ax, a, b in zip(axes[:, column], ours.T, theirs.T, strict=True):
            ax.plot(time, a, "C0", lw=1.6, label="simulation")
            ax.plot(time, b, "k--", lw=0.9, label="equations")
        label = ", ".join(f"{value:.3g}" for value in start)
        axes[0, column].set_title(f"from ({label})", fontsize="small")
        axes[-1, column].set_xlabel("time [s]")
        gap = float(np.abs(ours - theirs).max())
        good = gap < 5e-3
        note = f"largest distance from solve_ivp of the study's equations: {gap:.1e} (m, rad, s)"
        findings.append(
            Finding(f"passive response from ({label})", "as expected",
                    "as expected" if good else "off the equations", "1",
                    "agrees" if good else "differs", note)
        )  # fmt: skip
    for ax, name in zip(axes[:, 0], _NAMES, strict=True):
        ax.set_ylabel(name)
    axes[1, 0].invert_yaxis()
    for ax in axes[1, 1:]:
        ax.invert_yaxis()
    axes[0, 0].legend(fontsize="small")
    text = (
        "No control, still water. Dashed: the study's equations of motion by solve_ivp, apart from "
        "the simulation. Depth grows downwards."
    )
    return Outcome(findings, [job.save(figure, "passive_responses")], text)


def _equations(start: tuple[float, ...], time: Array) -> Array:
    """States (n, 6) by the equations of the study in still water (digest 3.2)."""
    net = SCOUT_BUOYANCY - SCOUT_WEIGHT

    def rate(_: float, y: Array) -> list[float]:
        _, _, theta, u, w, q = y
        c, s = np.cos(theta), np.sin(theta)
        du = -61.5 * q * w - 65.1 * w * q - 42.1 * u * abs(u) + net * s
        dw = 61.5 * q * u + 5.8 * u * q - 502.4 * w * abs(w) - net * c
        dq = 59.3 * u * w - 109.5 * q * abs(q) - 0.01 * SCOUT_BUOYANCY * s
        return [c * u + s * w, -s * u + c * w, q, du / 67.3, dw / 126.6, dq / 26.12]

    span = (0.0, float(time[-1]))
    return solve_ivp(rate, span, start, t_eval=time, rtol=1e-9, atol=1e-10).y.T


def added_mass(job: Job) -> Outcome:
    """Added mass of the Scout's spheroid over the period for three meshes, beside Lamb."""
    lamb = np.diag(prolate_spheroid_added_mass(*_SPHEROID, _RHO))
    axes_of = {"surge": (0, "kg"), "heave": (2, "kg"), "pitch": (4, "kg m²")}
    figure, axes = panels(1, 3, (13, 4.2))
    for ax, (name, (i, unit)) in zip(axes[0], axes_of.items(), strict=True):
        ax.axhline(lamb[i], color="k", ls="--", lw=1, label="Lamb, deep water")
        ax.axhspan(0.95 * lamb[i], 1.05 * lamb[i], color="k", alpha=0.08, label="within 5 %")
        ax.set(xlabel="wave period [s]", ylabel=f"added mass in {name} [{unit}]", xscale="log")
        ax.set_xticks([1, 2, 5, 10, 30], ["1", "2", "5", "10", "30"])
        ax.set_xticks([], minor=True)
    periods = np.array([1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 12.0, 30.0])
    findings, note = [], "published: within 5 % on its meshes (figure only)"
    try:
        for color, (along, around) in zip(
            ("C0", "C1", "C2"), ((6, 3), (12, 5), (20, 8)), strict=True
        ):
            omega, values, size = _panel_added_mass(along, around, periods)
            for ax, (i, _) in zip(axes[0], axes_of.values(), strict=True):
                ax.plot(2 * np.pi / omega, values[:, i], color, marker="o", ms=3,
                        label=f"panels of {1000 * size:.0f} mm")  # fmt: skip
        for name, (i, _) in axes_of.items():
            ratio = float(values[np.argmin(omega), i] / lamb[i])
            spread = float(np.ptp(values[:, i]) / lamb[i])
            about = f"{note}; over the periods it varies by {100 * spread:.1f} %"
            findings.append(
                compare(
                    f"panels over Lamb, {name}, finest mesh, 30 s", 1.0, ratio, "1", 0.05, about
                )
            )
        text = (
            "Panel calculations (Capytaine) of the spheroid with the Scout's length and volume, "
            f"{2 * _SPHEROID[0]:g} x {2 * _SPHEROID[1]:.3f} m, axis 4 m under the surface; the "
            "mesh sizes are ours, coarser than the study's 10 and 20 mm. Fins make the study's own "
            "values larger: 5.8 kg, 65.1 kg, 11.9 kg m2."
        )
    except ModelError as error:
        text = f"Only Lamb's values: {error}"
    axes[0, 2].legend(fontsize="small", loc="lower right")
    return Outcome(findings, [job.save(figure, "added_mass")], text)


def _panel_added_mass(along: int, around: int, periods: Array) -> tuple[Array, Array, float]:
    """Frequencies (n,), diagonal added mass (n, 6), mean panel size of a spheroid at 4 m depth."""
    from marine_mj.hydrodynamics.bem import solve
    from marine_mj.hydrodynamics.bem.panels import surface

    a, b = _SPHEROID
    depth = 4.0

    def shape(s: Array, r: Array) -> list[Array]:
        polar, angle = 0.5 * np.pi * s, np.pi * (r - 0.5)
        across = b * np.cos(polar)
        return [a * np.sin(polar), across * np.cos(angle), across * np.sin(angle) - depth]

    # From the middle to the bow, from below over port to above: a quarter with two mirrors.
    hull = surface(shape, along, around)
    corners = hull.corners
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    outwards = np.sum(normal * (corners.mean(axis=1) - [0, 0, -depth]), axis=1)
    if outwards.sum() < 0:
        hull = type(hull)(corners[:, ::-1])
    hull = hull.mirrored(1, 0)
    area = 0.5 * np.linalg.norm(normal, axis=1).sum()
    found = solve(
        hull, omega=2 * np.pi / periods, directions=np.zeros(1), density=_RHO,
        origin=np.array([0.0, 0.0, -depth]),
    )  # fmt: skip
    diagonal = np.diagonal(found.added_mass, axis1=1, axis2=2)
    return found.omega, diagonal, float(np.sqrt(area / len(corners)))
