"""Rigid bodies with added mass: closed forms, invariants, independent integration, contact."""

from collections.abc import Iterator

import mujoco
import numpy as np
from mujoco import batch, rollout
from scipy.integrate import solve_ivp

from marine_mj.environment import Environment, irregular_sea, regular_wave, uniform_current
from marine_mj.frames import Array, quaternion_multiply, rotation_from_quaternion, skew
from marine_mj.hydrodynamics.loader import load_xml
from marine_mj.hydrodynamics.wrenches import wrenches
from marine_mj.validation.rows import Row, row

RHO, G = 1025.0, 9.81
CENTER, INERTIA, MASS = np.array([0.02, 0.01, -0.05]), np.array([1.0, 2.0, 3.0]), 10.0
BALL = '<geom type="sphere" size="0.3" mass="0" solref="0.02 {}" friction="0"/>'
PLANE = '<geom type="plane" size="5 5 .1" pos="0 0 -11" friction="0"/>'


def numbers(values: object) -> str:
    """Numbers as MJCF text without loss of digits."""
    return " ".join(repr(float(v)) for v in np.ravel(np.asarray(values)))


def one_body(
    added_mass: object,
    numerics: str = "",
    *,
    mass: float = MASS,
    center: object = CENTER,
    inertia: object = INERTIA,
    options: str = 'timestep="0.005" integrator="implicitfast"',
    gravity: float = G,
    extra: str = "",
    world: str = "",
) -> str:
    """MJCF of one free body `a` at 10 m depth, centre of buoyancy at its origin."""
    return f"""<mujoco><option gravity="0 0 {-gravity}" {options}/>
    <custom><numeric name="a.added_mass_flu" data="{numbers(added_mass)}"/>{numerics}</custom>
    <worldbody>{world}<body name="a" pos="0 0 -10"><freejoint/>
      <inertial pos="{numbers(center)}" mass="{mass!r}" diaginertia="{numbers(inertia)}"/>
      <site name="a.center_of_buoyancy"/>{extra}</body></worldbody></mujoco>"""


def volume(value: float) -> str:
    """The displaced volume, m3."""
    return f'<numeric name="a.displaced_volume" data="{value!r}"/>'


def drag(values: str) -> str:
    """Quadratic drag."""
    return f'<numeric name="a.quadratic_damping_flu" data="{values}"/>'


def coupled(seed: int, scale: float = 3.0) -> Array:
    """Random full, coupled, positive definite (6, 6)."""
    B = np.random.default_rng(seed).normal(size=(6, 6))
    return scale * B @ B.T


def rigid() -> Array:
    """Rigid inertia (6, 6) of the body about its origin."""
    S = skew(CENTER)
    corner = np.diag(INERTIA) - MASS * S @ S
    return np.block([[MASS * np.eye(3), -MASS * S], [MASS * S, corner]])


def kirchhoff(M: Array, nu: Array) -> Array:
    """Right-hand side (6) of `M nu_dot = ...` without external forces (Lamb 1932, art. 124)."""
    p, v, w = M @ nu, nu[:3], nu[3:]
    return -np.concatenate([np.cross(w, p[:3]), np.cross(w, p[3:]) + np.cross(v, p[:3])])


def acceleration() -> Iterator[Row]:
    """Acceleration with coupled added mass against Kirchhoff's equations."""
    for integrator in ("implicitfast", "RK4"):
        worst = 0.0
        for seed in range(5):
            M_A, rng = coupled(seed), np.random.default_rng(seed)
            options = f'integrator="{integrator}"'
            model = load_xml(one_body(M_A, gravity=0, options=options))
            data = mujoco.MjData(model)
            q = rng.normal(size=4)
            data.qpos[3:7] = q / np.linalg.norm(q)
            data.qvel[:] = rng.normal(size=6)
            mujoco.mj_forward(model, data)
            R = data.xmat[1].reshape(3, 3)
            v, w = R.T @ data.qvel[:3], data.qvel[3:]
            M = rigid() + M_A
            nu_dot = np.linalg.solve(M, kirchhoff(M, np.r_[v, w]))
            expected = np.r_[R @ (nu_dot[:3] + np.cross(w, v)), nu_dot[3:]]
            worst = max(worst, float(np.abs(data.qacc - expected).max()))
        name = f"coupled added mass, largest error of the acceleration, {integrator}"
        yield row(name, worst, 0, "m/s2", "Kirchhoff's equations", within=1e-12)


def released_sphere() -> Iterator[Row]:
    """A sphere released in still water."""
    V = 4 / 3 * np.pi * 0.5**3
    for ratio in (0.5, 2.0, 7.8):
        mass = ratio * RHO * V
        M_A = np.array([0.5, 0.5, 0.5, 0, 0, 0]) * RHO * V
        xml = one_body(M_A, volume(V), mass=mass, center=[0, 0, 0], inertia=[1, 1, 1])
        model = load_xml(xml)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        expected = G * (1 - ratio) / (ratio + 0.5)
        name = f"released sphere of {ratio:g} times the density of water, acceleration"
        source = "g (1 - r) / (r + 1/2)"
        yield row(name, data.qacc[2], expected, "m/s2", source, percent=1e-10)


def ellipsoid() -> Iterator[Row]:
    """Tumbling triaxial ellipsoid against solve_ivp."""
    V = 0.523599
    k = [0.126571 * V, 0.398172 * V, 1.518061 * V, 0.0132928, 0.108441, 0.0190041]
    added, mass = RHO * np.array(k), RHO * V
    inertia = mass / 5 * np.array([0.5**2 + 0.25**2, 1 + 0.25**2, 1 + 0.5**2])
    options = 'timestep="0.01" integrator="RK4"'
    xml = one_body(added, volume(V), mass=mass, center=[0, 0, 0], inertia=inertia, options=options)
    model = load_xml(xml)
    data = mujoco.MjData(model)
    nu = np.array([0.5, 0.2, -0.1, 0.3, 0.8, 0.5])
    data.qvel[:] = nu
    mujoco.mj_step(model, data, 500)
    M = np.diag(added + np.r_[np.full(3, mass), inertia])

    def rate(t: float, y: Array) -> Array:
        R = rotation_from_quaternion(y[3:7])
        turn = 0.5 * quaternion_multiply(y[3:7], np.r_[0, y[10:]])
        return np.concatenate([R @ y[7:10], turn, np.linalg.solve(M, kirchhoff(M, y[7:]))])

    start = np.concatenate([[0, 0, -10], [1, 0, 0, 0], nu])
    end = solve_ivp(rate, (0, 5), start, rtol=1e-12, atol=1e-12, method="DOP853").y[:3, -1]
    error = np.linalg.norm(data.qpos[:3] - end)
    name = "tumbling ellipsoid, position error after 5 s, RK4 at 10 ms"
    yield row(name, error, 0, "m", "solve_ivp of Kirchhoff's equations", within=1e-4)


ARTICULATED = """<mujoco><option timestep="0.0005" gravity="0 0 0" integrator="RK4">
  <flag energy="enable"/></option><custom>{}</custom>
<worldbody><body name="a"><freejoint/>
  <inertial pos="0.02 0.01 -0.05" mass="10" diaginertia="1 2 3"/>
  <body name="b" pos=".5 0 0"><joint type="hinge" axis="0 1 0"/>
    <inertial pos="0.3 0 0" mass="2" diaginertia=".1 .2 .3"/>
    <body name="c" pos=".5 0 0"><joint type="ball"/>
      <inertial pos="0.3 0.1 0" mass="2" diaginertia=".1 .2 .3"/></body></body></body>
</worldbody></mujoco>"""


def articulated() -> Iterator[Row]:
    """Energy of a free articulated body with added mass on every link."""
    text = "".join(
        f'<numeric name="{n}.added_mass_flu" data="{numbers(coupled(i, 1.0))}"/>'
        for i, n in enumerate("abc")
    )
    model = load_xml(ARTICULATED.format(text))
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(1).normal(size=model.nv)
    mujoco.mj_forward(model, data)
    start = float(data.energy[1])
    mujoco.mj_step(model, data, 4000)
    mujoco.mj_forward(model, data)
    ratio = data.energy[1] / start
    source = "conservation of energy"
    yield row(
        "articulated body, energy after 2 s / at the start", ratio, 1, "1", source, within=2e-7
    )


def contact() -> Iterator[Row]:
    """Impulse and bounce of a body with added mass."""
    options = 'timestep="0.001" integrator="implicitfast"'
    xml = one_body(
        [7, 7, 7, 1, 1, 1],
        center=[0, 0, 0],
        gravity=0,
        options=options,
        extra=BALL.format(1),
        world=PLANE,
    )
    model = load_xml(xml)
    data = mujoco.MjData(model)
    data.qpos[2], data.qvel[2] = -10.69, -0.5
    impulse = 0.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
        impulse += 0.001 * float(data.qfrc_constraint[2])
    expected = 17.0 * (data.qvel[2] + 0.5)
    yield row("impulse of an impact", impulse, expected, "N s", "(M_RB + M_A) dv", percent=1e-4)
    speeds = []
    for wet in (True, False):
        added, mass, inertia = (15, 5.0, [1, 2, 3]) if wet else (0, 20.0, [4, 5, 6])
        xml = one_body(
            [added] * 3 + [3 if wet else 0] * 3,
            mass=mass,
            inertia=inertia,
            center=[0, 0, 0],
            gravity=0,
            options=options,
            extra=BALL.format(0.3),
            world=PLANE,
        )
        model = load_xml(xml)
        data = mujoco.MjData(model)
        data.qpos[2], data.qvel[2] = -10.6, -1.0
        mujoco.mj_step(model, data, 2000)
        speeds.append(float(data.qvel[2]))
    source = "natively heavier body"
    name = "exit speed of a bounce, 3/4 added mass"
    yield row(name, speeds[0], speeds[1], "m/s", source, percent=1e-7)


def moving_water() -> Iterator[Row]:
    """Current, still water, orbit of a small neutrally buoyant body."""
    velocity = np.array([0.7, -0.4, 0.0])
    neutral = volume(MASS / RHO) + drag("30 60 60 5 5 5")
    model = load_xml(
        one_body(coupled(0), neutral, center=[0, 0, 0]),
        Environment(current=uniform_current(velocity)),
    )
    data = mujoco.MjData(model)
    data.qvel[:3] = velocity
    mujoco.mj_step(model, data, 2000)
    error = np.abs(data.qvel - [*velocity, 0, 0, 0]).max()
    yield row("drift with a current, change of speed", error, 0, "m/s", "Galilei", within=1e-12)
    model = load_xml(one_body(coupled(0), neutral, center=[0, 0, 0]))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 20000)
    error = np.abs(data.qvel).max()
    yield row("100 s in calm water, speed", error, 0, "m/s", "rest", within=1e-9)
    sea, radius = regular_wave(1.0, 5.0), 0.05
    V = 4 / 3 * np.pi * radius**3
    xml = one_body(
        np.array([0.5, 0.5, 0.5, 0, 0, 0]) * RHO * V,
        volume(V),
        mass=RHO * V,
        center=[0, 0, 0],
        inertia=np.full(3, 0.4 * RHO * V * radius**2),
        options='timestep="0.005" integrator="RK4"',
    )
    model = load_xml(xml, Environment(waves=sea))
    data = mujoco.MjData(model)
    data.qpos[2] = -3
    data.qvel[:3] = sea.velocity(0, 0, -3, 0)
    mujoco.mj_step(model, data, 4000)
    path = solve_ivp(
        lambda t, x: sea.velocity(x[0], x[1], x[2], t),
        (0, data.time),
        [0, 0, -3],
        rtol=1e-10,
        atol=1e-12,
    )
    error = np.linalg.norm(data.qpos[:3] - path.y[:, -1])
    name = "small neutral sphere in waves, distance from the water particle after 4 periods"
    yield row(name, error, 0, "m", "solve_ivp of the water particle", within=1e-4)


def causes() -> Iterator[Row]:
    """Reported causes against the rate of momentum."""
    numerics = volume(0.0105) + drag("20 40 40 1 2 2")
    sea = irregular_sea(1.1, 5.5, components=100, seed=3)
    environment = Environment(waves=sea, current=uniform_current([0.4, 0.1, 0]))
    model = load_xml(
        one_body(
            coupled(1),
            numerics,
            extra=BALL.format(1),
            world=PLANE,
            options='timestep="0.005" tolerance="0" ls_tolerance="1e-6" iterations="200"',
        ),
        environment,
    )
    data = mujoco.MjData(model)
    data.qpos[2] = -10.69
    data.qvel[:] = [0.5, -0.3, -0.2, 0.4, -0.6, 0.7]
    worst, M = 0.0, rigid()
    for _ in range(100):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        forces = wrenches(model, data)["a"]
        R, w = data.xmat[1].reshape(3, 3), data.qvel[3:]
        v = R.T @ data.qvel[:3]
        nu_dot = np.r_[R.T @ data.qacc[:3] - np.cross(w, v), data.qacc[3:]]
        rate = M @ nu_dot - kirchhoff(M, np.r_[v, w])
        scale = max(np.abs(f).max() for f in forces.values())
        worst = max(worst, float(np.abs(sum(forces.values()) - rate).max() / scale))
    name = "sum of the reported causes, error / largest cause"
    yield row(name, worst, 0, "1", "d/dt of the momentum", within=1e-9)


def agreement() -> Iterator[Row]:
    """Plain loop, save and restore, rollout and Batch: values that differ in any bit."""
    numerics = (
        volume(0.0105)
        + '<numeric name="a.strips" data="8 -0.9 1"/><numeric name="a.strip_drag_flu" data="9 9"/>'
    )
    sea = irregular_sea(1.1, 5.5, components=100, seed=3)
    xml = one_body(coupled(1), numerics, extra=BALL.format(1), world=PLANE)
    model = load_xml(xml, Environment(waves=sea, current=uniform_current([0.4, 0.1, 0])))
    full, steps, runs = mujoco.mjtState.mjSTATE_FULLPHYSICS, 300, 4
    size = mujoco.mj_stateSize(model, full)
    starts, states = np.zeros((runs, size)), np.zeros((runs, steps, size))
    for number in range(runs):
        data = mujoco.MjData(model)
        data.qpos[2] = -10.6
        data.qvel[:] = 0.3 * np.random.default_rng(number).normal(size=6)
        mujoco.mj_getState(model, data, starts[number], full)
        for step in range(steps):
            mujoco.mj_step(model, data)
            mujoco.mj_getState(model, data, states[number, step], full)
    threads = [mujoco.MjData(model) for _ in range(2)]
    rolled, _ = rollout.rollout(model, threads, starts, nstep=steps)
    source = "plain loop of mj_step"
    differing = int((rolled != states).sum())
    yield row("rollout on 2 threads, values that differ", differing, 0, "1", source, within=0)
    for count in (1, 2):
        simulations = batch.Batch(model, runs, nthread=count)
        for name, columns in (("time", starts[:, :1]), ("qpos", starts[:, 1:8])):
            simulations.bind(name).reshape(runs, -1)[:] = columns
        simulations.bind("qvel")[:] = starts[:, 8:14]
        got = simulations.rollout(steps, record=[full])[full]
        name = f"Batch on {count} thread{'s' if count > 1 else ''}, values that differ"
        yield row(name, int((got != states).sum()), 0, "1", source, within=0)
    everything = mujoco.mjtState.mjSTATE_INTEGRATION
    data, saved = mujoco.MjData(model), np.zeros(mujoco.mj_stateSize(model, everything))
    data.qpos[2] = -10.6
    mujoco.mj_step(model, data, 100)
    mujoco.mj_getState(model, data, saved, everything)
    mujoco.mj_step(model, data, 200)
    end = data.qpos.copy()
    mujoco.mj_setState(model, data, saved, everything)
    mujoco.mj_step(model, data, 200)
    differing = int((data.qpos != end).sum())
    name = "save and restore, values that differ"
    yield row(name, differing, 0, "1", "uninterrupted run", within=0)


CASES = (
    acceleration,
    released_sphere,
    ellipsoid,
    articulated,
    contact,
    moving_water,
    causes,
    agreement,
)
