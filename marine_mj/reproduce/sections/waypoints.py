"""Table 7.11: every controller steers to waypoints at rest, turned, moving and accelerating."""

from dataclasses import dataclass

import numpy as np

from marine_mj.frames import Array
from marine_mj.reproduce.sections.base import Finding, Job, Outcome, panels
from marine_mj.simulation import run_batch

_VARIANTS = {
    "manual pose": {"task.settings.gains": "manual"},
    "brute-force pose": {"task.settings.gains": "brute_force"},
    "CPV": {"task.settings.controller": "cpv", "task.settings.gains": "reference"},
    "CPVA": {"task.settings.controller": "cpva", "task.settings.gains": "reference"},
}
#: Largest speeds of the Scout in surge, heave, pitch: sqrt(limit / drag) (digest V9, V10).
_FASTEST = np.array([2.136, 0.368, 0.427])
#: Mean miss of the last seconds that counts as reached, m and rad: the study's acceptance radius.
_REACHED = np.array([0.3, 0.3, 0.1])
_LAST = 3.0
#: Share of the speed it could have with which a vehicle counts as pursuing, and when, s.
_PURSUED, _LOOK = 0.9, (10.0, 20.0)


@dataclass(frozen=True)
class Waypoint:
    """Pose x, z, theta at the start, its rate and acceleration, NED."""

    label: str
    pose: tuple[float, float, float]
    rate: tuple[float, float, float] = (0.0, 0.0, 0.0)
    acceleration: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def still(self) -> bool:
        """Whether it rests."""
        return not any((*self.rate, *self.acceleration))


def _waypoints() -> list[Waypoint]:
    """Rows of table 7.11."""
    places = [(2, 5), (-2, 5), (10, 5), (2, 8), (2, 1), (-2, 8), (10, 8)]
    found = [Waypoint(f"({x}, {z}) m", (float(x), float(z), 0.0)) for x, z in places]
    found.append(Waypoint("(-1, 5) m, θ 1.0 rad", (-1.0, 5.0, 1.0)))
    found += [Waypoint(f"(2, 5) m, θ {n / 2:g} π", (2.0, 5.0, n / 2 * np.pi)) for n in range(1, 9)]
    for i, (name, rate, unit) in enumerate(
        (("u", 1.0, "m/s"), ("w", 0.3, "m/s"), ("q", 0.5, "rad/s"))
    ):
        moving, faster = [0.0] * 3, [0.0] * 3
        moving[i], faster[i] = rate, 0.1
        found.append(Waypoint(f"{name} {rate:g} {unit}", (2.0, 5.0, 0.0), tuple(moving)))  # type: ignore[arg-type]
        found.append(
            Waypoint(f"{name} rising by 0.1 {unit}²", (2.0, 5.0, 0.0), acceleration=tuple(faster))  # type: ignore[arg-type]
        )
    return found


WAYPOINTS = _waypoints()


def waypoint_test(job: Job) -> Outcome:
    """Which waypoints each controller reaches or pursues."""
    figure, axes = panels(2, 2, (13, 8))
    findings = []
    for name, settings in _VARIANTS.items():
        base = {
            **settings,
            "task.settings.station": None,
            "sea": {"spectrum": "none"},
            # The USV is out of the way.
            "vehicles.usv.position_ned": [200.0, 0.0, 0.0],
            "vehicles.auv.position_ned": [0.0, 0.0, 5.0],
            "duration": 36.0,
        }
        changes = [
            {**base, "task.settings.waypoint": {"pose": list(w.pose), "rate": list(w.rate),
                                                "acceleration": list(w.acceleration)}}
            for w in WAYPOINTS
        ]  # fmt: skip
        result = run_batch("docking_tuning", changes, record=("target_error", "target_rate"))
        assert result.signals is not None
        time = result.signals["time"].values
        miss = result.signals["target_error"].values[..., [0, 2, 4]]
        closing = result.signals["target_rate"].values[..., [0, 2, 4]]
        for w, e, de in zip(WAYPOINTS, miss, closing, strict=True):
            if w.still:
                axes[0, 0 if w.pose[2] == 0 else 1].plot(
                    time[1:], np.linalg.norm(e[1:], axis=1), lw=0.6,
                    color=f"C{list(_VARIANTS).index(name)}",
                )  # fmt: skip
            else:
                i = int(np.flatnonzero(np.add(w.rate, w.acceleration))[0])
                speed = w.rate[i] + w.acceleration[i] * time[1:] - de[1:, i]
                ax = axes[1, 0 if w.rate[i] else 1]
                ax.plot(time[1:], speed / _FASTEST[i], color=f"C{list(_VARIANTS).index(name)}",
                        ls=("-", "--", ":")[i], lw=1)  # fmt: skip
            findings.append(_judge(name, w, time, e, de))
    for i, name in enumerate(_VARIANTS):
        axes[0, 0].plot([], [], f"C{i}", label=name)
    for style, name in zip(("-", "--", ":"), ("surge", "heave", "pitch"), strict=True):
        axes[1, 0].plot([], [], "k" + style, label=name)
    for ax, title in zip(
        axes.flat, ("position tests", "orientation tests", "velocity tests", "acceleration tests"),
        strict=True,
    ):  # fmt: skip
        ax.set(title=title, xlabel="time [s]")
    for ax in axes[0]:
        ax.set(ylabel="distance from the waypoint [m, rad]", yscale="log", ylim=(1e-3, 20))
    for ax in axes[1]:
        ax.set(ylabel="speed over the Scout's largest [1]", ylim=(-0.3, 1.3))
        ax.axhline(1, color="k", lw=0.8)
    axes[0, 0].legend(fontsize="small")
    axes[1, 0].legend(fontsize="small", loc="lower right")
    text = (
        "Calm water, from (0, 5) m, 36 s. At rest: reached when the mean miss of the last "
        f"{_LAST:g} s is below {_REACHED[0]:g} m, the study's acceptance radius, and "
        f"{_REACHED[2]:g} rad. Under way: pursued when the speed from {_LOOK[0]:g} to "
        f"{_LOOK[1]:g} s is at least {_PURSUED:.0%} of the waypoint's or of the Scout's largest, "
        "whichever is less. The study counts turns; here an angle counts modulo 2 π, so waypoints "
        "that turn are judged until the Scout is half a turn behind. Accelerating ones follow "
        "x + a t²/2 (the table prints x + a t²). Beyond 20 s the accelerating surge waypoint is "
        "faster than the Scout, and there the pose PID with manual gains and CPV lose their "
        "heading: the Munk moment 59 u w outgrows the 20 N m of pitch."
    )
    return Outcome(findings, [job.save(figure, "waypoints")], text)


def _judge(name: str, waypoint: Waypoint, time: Array, miss: Array, closing: Array) -> Finding:
    """Whether a run reached or pursued its waypoint."""
    last = time > time[-1] - _LAST
    if waypoint.still:
        # A mean over a turn's ends would hide a full one: lengths, not signed values.
        left = np.abs(miss[last]).mean(axis=0)
        good = bool(np.all(left < _REACHED))
        ours = "reached" if good else "missed"
        note = f"mean miss {left[0]:.3f} m, {left[1]:.3f} m, {left[2]:.3f} rad"
    else:
        i = int(np.flatnonzero(np.add(waypoint.rate, waypoint.acceleration))[0])
        wanted = waypoint.rate[i] + waypoint.acceleration[i] * time
        # Half a turn behind, the short way round changes sides.
        behind = time[np.abs(miss[:, i]) > 3.0] if i == 2 else time[:0]
        end = min(_LOOK[1], *behind, time[-1])
        seen = (time > min(_LOOK[0], 0.5 * end)) & (time < end)
        able = np.minimum(wanted[seen], _FASTEST[i])
        share = float(np.mean((wanted - closing[:, i])[seen]) / np.mean(able))
        good = share >= _PURSUED
        ours = "pursued" if good else "lost"
        note = f"{share:.2f} of the speed it could have, up to {end:.0f} s"
    published = "reached" if waypoint.still else "pursued"
    return Finding(
        f"{name}, {waypoint.label}", published, ours, "1", "agrees" if good else "differs", note
    )
