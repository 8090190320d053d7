"""What a docking mission remembers, and what of it stands in the summary of a run."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from marine_mj.contact_success import contact_success
from marine_mj.controllers import LatchState, PilotState, RigidState
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.tasks.contact_log import ContactLog
from marine_mj.tasks.docking_navigation import NavigationState
from marine_mj.tasks.docking_settings import DockingSettings
from marine_mj.weather import significant_height

#: Pose errors at capture, in the aperture frame FRD, m and rad.
CAPTURE_ERRORS = tuple(
    f"{axis}_error" for axis in ("surge", "sway", "heave", "roll", "pitch", "yaw")
)
#: What is kept of the first crossing of the aperture.
CAPTURE = ("time", *CAPTURE_ERRORS, "relative_speed", "relative_kinetic_energy")


@dataclass(frozen=True)
class DockingState:
    """Memory of a mission.

    Attributes:
        pilot: of guidance and controller.
        navigation: of what they know.
        latch: of the latch's monitor.
        wrench: (..., 6) wrench the actuators were asked for, FLU.
        target: state that the controller steers to.
        vehicle: state of the vehicle when it began to.
        start_time: (...,) time on the wave record at the start, s.
        latch_time: (...,) when the latch closed, s; inf before.
        undock_at: (...,) when it is to open, s; inf: never.
        undock_time: (...,) when it opened, s; inf before.
        clear_time: (...,) when the undocked vehicle was clear of the dock, s; inf before.
        away_time: (...,) when it was back at waypoint 1 (open loop: clear), s; inf before.
        contact: what contacts did so far.
        departure: what they did since the latch opened.
        height: (...,) height above the aperture plane at the last look, m.
        entries: (...,) int, crossings of the aperture from below.
        capture: (..., 9) values of `CAPTURE` at the first crossing; NaN before.
    """

    pilot: PilotState
    navigation: NavigationState
    latch: LatchState
    wrench: Array
    target: RigidState
    vehicle: RigidState
    start_time: Array
    latch_time: Array
    undock_at: Array
    undock_time: Array
    clear_time: Array
    away_time: Array
    contact: ContactLog
    departure: ContactLog
    height: Array
    entries: Array
    capture: Array


def docking_summary(
    scenario: Scenario,
    settings: DockingSettings,
    closed_loop: bool,
    state: DockingState,
    latched: bool,
    navigation_rmse: dict[str, Any] | None,
) -> dict[str, Any]:
    """Whether and how the vehicle of one simulation docked; times count from its start.

    Args:
        scenario: what was run.
        settings: of the task.
        closed_loop: whether guidance and controller steered.
        state: of that simulation, shape ().
        latched: whether its latch is closed.
        navigation_rmse: errors of the navigation.
    """
    values = dict(zip(CAPTURE, state.capture.tolist(), strict=True))
    capture = None if np.isnan(values["time"]) else values
    height, period = significant_height(scenario.sea)
    undocked = bool(np.isfinite(state.undock_time))

    def since(moment: Array) -> float | None:
        return float(moment - state.start_time) if np.isfinite(moment) else None

    row = {
        "docked": bool(np.isfinite(state.latch_time)),
        "sea_state": {"H_s": height, "T_p": period, "number": scenario.sea.sea_state},
        "capture": capture,
        "capture_time": capture["time"] if capture else None,
        "latch_time": since(state.latch_time),
        "latched": bool(latched),
        "undock_time": since(state.undock_time),
        "clear_time": since(state.clear_time),
        "away_time": since(state.away_time),
        "undocked": bool(np.isfinite(state.clear_time)),
        "undock_contact_force": float(state.departure.peak_force) if undocked else None,
        "undock_forbidden_contact": bool(state.departure.crashed) if undocked else None,
        "peak_contact_force": float(state.contact.peak_force),
        "contact_impulse": float(state.contact.impulse),
        "contact_energy": float(state.contact.energy),
        "contact_penetration": float(state.contact.penetration),
        "contact_duration": float(state.contact.duration),
        "forbidden_contact": bool(state.contact.crashed),
        "attempts": int(state.entries),
        "controller": settings.controller if closed_loop else None,
        "gains": settings.gain_set if closed_loop else None,
        "navigation": settings.navigation.kind if closed_loop else None,
        "navigation_rmse": navigation_rmse,
    }
    return row | {"contact_success": contact_success(row, settings.force_limit)}
