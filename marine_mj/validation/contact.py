"""Contact physics: energy and momentum balances, penetration, reaction of the carrier."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from marine_mj.frames import Array
from marine_mj.hydrodynamics import start_in_waves, table
from marine_mj.hydrodynamics.loader import load_xml
from marine_mj.hydrodynamics.native import table_of
from marine_mj.hydrodynamics.wrenches import wrenches
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene, main_bodies
from marine_mj.validation.rows import Row, row

DIGEST = "docking study"
#: A neutral body without drag under a soft ceiling: every energy in it has a closed form.
CEILING = """<mujoco>
  <option timestep="{h}" integrator="implicitfast" gravity="0 0 -9.81"/>
  <custom><numeric name="a.added_mass_frd" data="5.8 65.1 65.1 0.1 11.9 11.9"/>
    <numeric name="a.displaced_volume" data="0.061"/></custom>
  <worldbody>
    <body name="a" pos="0 0 -10"><freejoint/>
      <inertial pos="0 0 0" mass="61.5" diaginertia="0.31 14.22 14.22"/>
      <site name="a.center_of_buoyancy" pos="0 0 0"/><site name="thrust"/>
      <geom type="capsule" fromto="-0.85 0 0 0.85 0 0" size="0.1" mass="0"/></body>
    <geom type="plane" size="9 9 1" pos="0 0 -9.8" euler="180 0 0" priority="1" friction="0.25"
      {contact}/>
  </worldbody>
  <actuator><motor site="thrust" gear="0 0 1 0 0 0"/></actuator>
  <sensor><user name="marine_mj/contacts" dim="4" needstage="acc"/></sensor>
</mujoco>"""
#: A bar with a quarter of added mass over a bar with a stated stiffness.
BAR = """<mujoco>
  <option timestep="{h}" integrator="implicitfast" gravity="0 0 0" cone="elliptic"/>
  <custom><numeric name="a.added_mass_frd" data="{added} {added} {added} 1 1 1"/>
    <numeric name="bar.contact_stiffness" data="1e5"/></custom>
  <worldbody>
    <body name="a"><freejoint/><inertial pos="0 0 0" mass="{dry}" diaginertia="9 9 9"/>
      <geom type="capsule" fromto="-0.85 0 0 0.85 0 0" size="0.1" mass="0"/></body>
    <geom name="bar" type="capsule" fromto="0 -0.5 -0.12 0 0.5 -0.12" size="0.02"/>
  </worldbody>
  <sensor><user name="marine_mj/contacts" dim="4" needstage="acc"/></sensor>
</mujoco>"""
SOFT = 'margin="0.02" solref="0.05 1" solimp="0.3 0.97 0.03 0.5 2"'
HARD = 'solref="0.03 1" solimp="0.9 0.95 0.002 0.5 2"'


@dataclass(frozen=True)
class Impact:
    """What an impact did.

    Attributes:
        contacts: (steps, 4) contact sensor.
        timestep: s.
        change: (vehicles, 6) M nu at the end minus at the start with added mass, level axes FLU.
        water: (vehicles, 6) impulse of all forces but contact and added mass, body axes.
        velocity: (vehicles, 6) qvel of the main bodies at the end.
    """

    contacts: Array
    timestep: float
    change: Array
    water: Array
    velocity: Array

    @property
    def impulse(self) -> float:
        """Time integral of the sum of normal forces, N s."""
        return float(self.contacts[:, table.S_FORCE].sum() * self.timestep)

    @property
    def peak(self) -> float:
        """Largest sum of normal forces, N."""
        return float(self.contacts[:, table.S_FORCE].max())

    @property
    def energy(self) -> float:
        """Energy that the contacts took out of the motion, J."""
        return float(self.contacts[:, table.S_POWER].sum() * self.timestep)

    @property
    def overlap(self) -> float:
        """Deepest overlap of the geoms, m."""
        return float(self.contacts[:, table.S_PENETRATION].max())


def impact(
    position: tuple[float, float, float],
    velocity: tuple[float, float, float],
    steps: int,
    changes: dict[str, Any] | None = None,
    start: float = 0.0,
) -> Impact:
    """A free Scout without thrust against the dock of a USV, at the scene's time step of 5 ms.

    Args:
        position: of the Scout, parallel to the USV, in the USV's axes, m, FLU.
        velocity: of the Scout, m/s, NWU.
        steps: number of physics steps.
        changes: of the scenario `docking_demo` in calm water.
        start: time on the wave record, s.
    """
    calm = {"sea.spectrum": "none", "sea.sea_state": None, "sea.spreading": None}
    scene = compile_scene(
        Scenario.load("docking_demo").with_values(calm | (changes or {})), visual=False
    )
    model, data = scene.model, mujoco.MjData(scene.model)
    bodies = main_bodies(model)
    usv, auv = (int(model.body_dofadr[bodies[name]]) for name in ("usv", "auv"))
    address = int(model.jnt_qposadr[model.body_jntadr[bodies["auv"]]])
    data.time = start
    start_in_waves(model, data)
    mujoco.mj_kinematics(model, data)
    R = data.xmat[bodies["usv"]].reshape(3, 3)
    data.qpos[address : address + 3] = data.xpos[bodies["usv"]] + R @ np.array(position)
    data.qpos[address + 3 : address + 7] = data.xquat[bodies["usv"]]
    data.qvel[auv : auv + 3] = velocity
    sensor = int(model.sensor(table.CONTACT_SENSOR).adr[0])
    contacts, water = [], np.zeros((2, 6))
    dofs = np.array([np.arange(usv, usv + 6), np.arange(auv, auv + 6)])
    mujoco.mj_forward(model, data)
    before = _momentum(model, data)
    names = [model.body(bodies[name]).name for name in ("usv", "auv")]
    for _ in range(steps):
        mujoco.mj_forward(model, data)
        causes = wrenches(model, data)
        for i, name in enumerate(names):
            for cause in ("damping", "radiation", "restoring", "waves", "gravity"):
                water[i] += model.opt.timestep * causes[name][cause]
        mujoco.mj_step(model, data)
        contacts.append(data.sensordata[sensor : sensor + table.CONTACT_VALUES].copy())
    mujoco.mj_forward(model, data)
    change = (_momentum(model, data) - before)[dofs]
    return Impact(np.array(contacts), model.opt.timestep, change, water, data.qvel[dofs].copy())


def _momentum(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Generalized momentum M qvel (nv,), with added mass."""
    out = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, out, data.qvel)
    return out


def energy_balance() -> Iterator[Row]:
    """V34: kinetic energy, thrust, buoyancy and what contacts dissipate, oblique impact."""
    M = np.diag([61.5] * 3 + [0.31, 14.22, 14.22])
    M += np.diag([5.8, 65.1, 65.1, 0.1, 11.9, 11.9])
    for name, contact, h in (
        ("soft pad, 5 ms", SOFT, 0.005),
        ("bar, 5 ms", HARD, 0.005),
        ("bar, 1 ms", HARD, 0.001),
    ):
        model = load_xml(CEILING.format(h=h, contact=contact))
        data = mujoco.MjData(model)
        density = float(table_of(model)[table.E_DENSITY])
        net = 9.81 * (density * 0.061 - 61.5)
        data.ctrl[0] = 30.0
        tilt = 0.05
        data.qpos[2:7] = -10.12, np.cos(tilt), 0.0, np.sin(tilt), 0.0
        data.qvel[:] = 0.4, 0.1, 1.0, 0.0, 0.1, 0.0
        sensor = int(model.sensor(table.CONTACT_SENSOR).adr[0])
        mujoco.mj_forward(model, data)
        kinetic, height = [_kinetic(data, M)], data.qpos[2]
        thrust = lost = 0.0
        for _ in range(round(0.6 / h)):
            before = data.qvel[:3].copy()
            up = data.xmat[1].reshape(3, 3)[:, 2].copy()
            mujoco.mj_step(model, data)
            thrust += 30.0 * h * up @ (0.5 * (before + data.qvel[:3]))
            lost += h * data.sensordata[sensor + table.S_POWER]
        mujoco.mj_forward(model, data)
        kinetic.append(_kinetic(data, M))
        spent = kinetic[0] - kinetic[1] + thrust + net * (data.qpos[2] - height)
        source = f"{DIGEST} V34: closed-form energies"
        yield row(f"V34 energy taken by contact, {name}", lost, spent, "J", source, percent=2)


def _kinetic(data: mujoco.MjData, M: Array) -> float:
    """Kinetic energy 0.5 nu^T M nu of the first body, J."""
    R = data.xmat[1].reshape(3, 3)
    nu = np.concatenate([R.T @ data.qvel[:3], data.qvel[3:6]])
    return float(0.5 * nu @ M @ nu)


def impulse() -> Iterator[Row]:
    """Impact on the cradle's pads at 1 m/s: both sides of the impulse, penetration."""
    done = impact((0.0, 0.0, -0.53), (0.0, 0.0, 1.0), 30)
    source = "(M_RB + M_A) dv"
    yield row(
        "Scout on the pads, contact impulse",
        done.impulse,
        -(done.change[1, 2] - done.water[1, 2]),
        "N s",
        source,
        percent=1,
    )
    yield row(
        "USV under that impact, contact impulse",
        done.impulse,
        done.change[0, 2] - done.water[0, 2],
        "N s",
        source,
        percent=1,
    )
    fixed = impact((0.0, 0.0, -0.53), (0.0, 0.0, 1.0), 30, {"vehicles.usv.motion": "rao"})
    moved = float(np.abs(fixed.velocity[0]).max())
    name = "prescribed USV, speed after the impact"
    yield row(name, moved, 0, "m/s", "prescribed motion", within=1e-5)


def penetration() -> Iterator[Row]:
    """Scout at 1 m/s against pads, forks and surge guide: the overlap at 5 ms and at 1 ms."""
    for name, position, velocity in (
        ("pads", (0.0, 0.0, -0.53), (0.0, 0.0, 1.0)),
        ("posts", (0.0, 0.0, -0.55), (0.0, 1.0, 0.0)),
        ("forks", (0.0, 0.25, -0.98), (0.0, 0.0, 1.0)),
        ("surge guide", (0.30, 0.0, -0.85), (0.0, 0.0, 1.0)),
    ):
        coarse = impact(position, velocity, 80)
        fine = impact(position, velocity, 400, {"timestep": 0.001})
        title = f"overlap at 1 m/s, {name}, 5 ms"
        yield row(title, coarse.overlap, fine.overlap, "m", "the same at 1 ms", percent=10)


def stated_stiffness() -> Iterator[Row]:
    """Peak force on light and heavy bodies that meet a bar of 100 kN/m at 0.5 m/s."""
    for mass in (30.0, 2000.0):
        for h in (0.005, 0.001):
            model = load_xml(BAR.format(h=h, dry=0.75 * mass, added=0.25 * mass))
            data, peak = mujoco.MjData(model), 0.0
            data.qpos[2], data.qvel[2] = 1e-6, -0.5
            sensor = int(model.sensor(table.CONTACT_SENSOR).adr[0])
            for _ in range(round(0.5 / h)):
                mujoco.mj_step(model, data)
                peak = max(peak, float(data.sensordata[sensor + table.S_FORCE]))
            name = f"bar on bar, {mass:g} kg wet, {1000 * h:g} ms, peak force"
            yield row(name, peak, 0.5 * np.sqrt(1e5 * mass), "N", "v sqrt(k m)", percent=5)


def moving_dock() -> Iterator[Row]:
    """A USV that plays back its motion hits a resting Scout as hard as the other way round."""
    usv = {"vehicles.usv.motion": "rao", "vehicles.usv.position_ned": [0.0, 0.0, 0.0]}
    sea = {"sea.spectrum": "regular", "sea.height": 3.0, "sea.period": 12.0}
    # the crest passes at t = 0; the USV sinks fastest a quarter period later
    place, rest = (0.0, 0.0, -0.515), (0.0, 0.0, 0.0)
    falling = impact(place, rest, 8, sea | usv, start=3.0)
    speed = -float(falling.velocity[0, 2])
    rising = impact(place, (0.0, 0.0, speed), 8, usv)
    name = "sinking dock on a resting Scout, peak force"
    yield row(name, falling.peak, rising.peak, "N", "Scout rising as fast", percent=5)
    after = impact(place, rest, 30, sea | usv, start=3.0)
    bounced = impact(place, (0.0, 0.0, speed), 30, usv)
    leaving = after.velocity[0, 2] - after.velocity[1, 2]
    name = "Scout after that impact, speed away from the dock"
    yield row(name, leaving, -bounced.velocity[1, 2], "m/s", "Scout rising as fast", percent=25)


CASES: tuple[Callable[[], Iterator[Row]], ...] = (
    energy_balance,
    impulse,
    penetration,
    stated_stiffness,
    moving_dock,
)
