"""The horizontal guidance laws as guidance of the docking pilot."""

import numpy as np
import pytest
from marine_mj.controllers import (
    CRUISE_LAWS,
    CruiseGuidance,
    DockingPlan,
    Phase,
    RigidState,
    guidance_laws,
)
from marine_mj.controllers.kinematics import heading_quaternion

from marine_mj.errors import ScenarioError
from marine_mj.tasks.docking_settings import DockingSettings, Guidance

PERIOD = 0.05
PLAN = DockingPlan(axis=0, approach_depth=1.05)


def at(x, y, heading=0.0, speed=0.0):
    heading = np.asarray(heading, dtype=float)
    position = np.stack(np.broadcast_arrays(x, y, -1.05), axis=-1).astype(float)
    velocity = np.zeros((*np.shape(x), 6))
    velocity[..., 0] = speed
    quaternion = np.broadcast_to(heading_quaternion(heading), (*np.shape(x), 4))
    return RigidState(position, quaternion, velocity)


def dock(shape=()):
    carrier = at(np.full(shape, 10.0), np.zeros(shape))
    return carrier, carrier.attached([-1.5, 0, 0]), carrier.attached([-0.66, 0, 0])


def fly(law, y=1.5, lag=1.0):
    """Kinematic vehicle whose heading follows the command with a lag, until it enters."""
    guidance, frames = CruiseGuidance(law, 0.7, PLAN), dock()
    x, heading, state, speed = 0.0, 0.0, guidance.initial(), 0.0
    for _ in range(1000):
        vehicle = at(x, y, heading, speed)
        command, state = guidance.update(state, vehicle, *frames, np.asarray(False), PERIOD)
        if command.entered:
            return y, heading
        assert command.target.position[2] == -1.05
        wanted = command.target.heading
        heading += PERIOD / lag * np.arctan2(np.sin(wanted - heading), np.cos(wanted - heading))
        speed = float(command.target.velocity[0])
        x += PERIOD * speed * np.cos(heading)
        y += PERIOD * speed * np.sin(heading)
    raise AssertionError("never entered")


@pytest.mark.parametrize("law", CRUISE_LAWS)
def test_laws_enter_the_dock_in_calm_water(law):
    y, _ = fly(law)
    # measured: at most 0.20 m (proportional navigation, cross-track); the nose may be 0.35 m off
    assert abs(y) < 0.35


def test_laws_that_align_arrive_along_the_axis():
    compared = ("side_slip", "touchdown_alignment", "line_of_sight")
    headings = {law: abs(fly(law)[1]) for law in compared}
    # measured: side-slip 0.06 deg, touchdown alignment 1.6 deg, line of sight 9.9 deg
    assert headings["side_slip"] < np.deg2rad(0.5)
    assert headings["touchdown_alignment"] < np.deg2rad(3.0) < headings["line_of_sight"]


def test_target_is_that_of_the_law():
    frames = dock()
    guidance = CruiseGuidance("line_of_sight", 0.8, PLAN)
    vehicle = at(2.0, 1.0, 0.1, 0.5)
    command, state = guidance.update(
        guidance.initial(), vehicle, *frames, np.asarray(False), PERIOD
    )
    seat = frames[2].position[:2]
    expected = guidance_laws.line_of_sight(vehicle.position[:2], seat)
    assert command.target.heading == pytest.approx(float(expected), abs=1e-12)
    np.testing.assert_array_equal(command.target.velocity, [0.8, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(command.target.position, vehicle.position)
    assert state.phase == Phase.ENTER
    # Entered: the docking guidance takes over, towards the seat.
    inside = at(8.6, 0.0, 0.0, 0.5)
    command, state = guidance.update(state, inside, *frames, np.asarray(False), PERIOD)
    assert command.entered and state.phase == Phase.CONTACT
    np.testing.assert_allclose(command.push, [20.0, 0, 0])


def test_crab_angle_stands_against_the_known_current():
    current = np.array([0.0, 0.2])
    guidance = CruiseGuidance("crab_angle", 0.7, PLAN, current)
    command, _ = guidance.update(
        guidance.initial(), at(0.0, 0.0), *dock(), np.asarray(False), PERIOD
    )
    assert command.target.heading == pytest.approx(-np.arcsin(0.2 / 0.7), abs=1e-12)


@pytest.mark.parametrize("law", CRUISE_LAWS)
def test_batch_is_row_by_row(law):
    guidance, frames = CruiseGuidance(law, 0.7, PLAN), dock()
    many, singles = guidance.initial((3,)), [guidance.initial() for _ in range(3)]
    rng = np.random.default_rng(1)
    for _ in range(20):
        x, y, heading = rng.uniform([0, -2, -0.5], [8, 2, 0.5], (3, 3)).T
        batch = at(x, y, heading, 0.6)
        command, many = guidance.update(many, batch, *dock((3,)), np.zeros(3, bool), PERIOD)
        for i in range(3):
            alone = at(x[i], y[i], heading[i], 0.6)
            one, singles[i] = guidance.update(singles[i], alone, *frames, np.asarray(False), PERIOD)
            assert (one.target.quaternion == command.target.quaternion[i]).all()
            assert (one.target.velocity == command.target.velocity[i]).all()
            assert singles[i].integral == many.integral[i]


def test_refusals():
    with pytest.raises(ScenarioError, match="'fuzzy' does not exist; available: line_of_sight"):
        CruiseGuidance("fuzzy")
    with pytest.raises(ScenarioError, match="this one is entered from below"):
        CruiseGuidance("side_slip", plan=DockingPlan())
    for other, message in (
        ({"prediction": {}}, "flown without prediction"),
        ({"station": 1.0}, "flown without station"),
        ({"controller": "mpc"}, "no target ahead of time"),
    ):
        with pytest.raises(ScenarioError, match=message):
            DockingSettings.parse({"guidance": "side_slip", **other})


def test_every_law_is_a_setting():
    assert set(Guidance.__args__) == {"target_state", *CRUISE_LAWS}
