"""Added mass: closed forms, equivalence of models, invariants, an independent integrator."""

import itertools

import mujoco
import numpy as np
import pytest
from conftest import kirchhoff, numbers, one_body, random_added_mass, rigid_mass
from scipy.integrate import solve_ivp

import marine_mj
from marine_mj.frames import (
    quaternion_multiply,
    rotation_from_quaternion,
)

M_RB = rigid_mass(10.0, [0.02, 0.01, -0.05], [1.0, 2.0, 3.0])


def released_sphere(ratio):
    """Model of a sphere of density `ratio` times that of water, radius 0.5 m."""
    volume = 4 / 3 * np.pi * 0.5**3
    mass = ratio * 1025 * volume
    return marine_mj.load_xml(
        one_body(
            added_mass=np.full(6, 0.5 * 1025 * volume) * [1, 1, 1, 0, 0, 0],
            numerics=f'<numeric name="a.displaced_volume" data="{volume!r}"/>',
            mass=mass,
            center="0 0 0",
            inertia=numbers(np.full(3, 0.4 * mass * 0.25)),
            extra='<site name="a.center_of_buoyancy"/>',
        )
    )


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9, 2.0, 7.8])
def test_released_sphere(ratio):
    model = released_sphere(ratio)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    expected = 9.81 * (1 - ratio) / (ratio + 0.5)
    # measured 2e-15
    assert data.qacc[2] == pytest.approx(expected, rel=1e-12)
    assert np.abs(np.delete(data.qacc, 2)).max() < 1e-12


@pytest.mark.parametrize("solver", ["Newton", "CG"])
@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast", "RK4"])
@pytest.mark.parametrize("seed", range(3))
def test_acceleration_is_kirchhoffs(integrator, solver, seed):
    M_A = random_added_mass(seed)
    model = marine_mj.load_xml(
        one_body(added_mass=M_A, integrator=integrator, gravity=0, option=f'solver="{solver}"')
    )
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    data.qpos[3:7] = q / np.linalg.norm(q)
    data.qvel[:] = rng.normal(size=6)
    data.ctrl[0] = 7
    mujoco.mj_forward(model, data)
    R = data.xmat[1].reshape(3, 3)
    v, w = R.T @ data.qvel[:3], data.qvel[3:]
    nu_dot = np.linalg.solve(
        M_RB + M_A, kirchhoff(M_RB + M_A, np.r_[v, w]) + np.array([7.0, 0, 0, 0, 0, 0])
    )
    expected = np.r_[R @ (nu_dot[:3] + np.cross(w, v)), nu_dot[3:]]
    # measured 3e-15
    np.testing.assert_allclose(data.qacc, expected, atol=1e-12)


def test_isotropic_added_mass_is_a_heavier_body():
    light = one_body(added_mass=[5, 5, 5, 1, 1, 1], mass=5, center="0 0 0", gravity=0)
    heavy = one_body(added_mass=np.zeros(6), mass=10, center="0 0 0", inertia="2 3 4", gravity=0)
    states = []
    for xml in (light, heavy):
        model = marine_mj.load_xml(xml)
        data = mujoco.MjData(model)
        data.qvel[:] = [1, 2, 3, 0.5, 0.2, 0.1]
        data.ctrl[0] = 3
        mujoco.mj_step(model, data, 400)
        states.append(np.concatenate([data.qpos, data.qvel]))
    # measured 4e-14
    np.testing.assert_allclose(states[0], states[1], atol=1e-12)


def textbook(M, t_end, nu, q, push=None):
    """Pose (7) at t_end of a body with inertia M (6, 6) by solve_ivp of Kirchhoff's equations."""

    def rate(t, y):
        R = rotation_from_quaternion(y[3:7])
        force = np.zeros(6) if push is None else push(t, y)
        nu_dot = np.linalg.solve(M, kirchhoff(M, y[7:]) + force)
        return np.concatenate(
            [R @ y[7:10], 0.5 * quaternion_multiply(y[3:7], np.r_[0, y[10:]]), nu_dot]
        )

    start = np.concatenate([np.zeros(3), q, nu])
    return solve_ivp(rate, (0, t_end), start, rtol=1e-12, atol=1e-12, method="DOP853").y[:7, -1]


#: Lamb's coefficients of the triaxial ellipsoid 1 x 0.5 x 0.25 m (semi-axes), neutrally buoyant.
ELLIPSOID_VOLUME = 0.523599
ELLIPSOID_ADDED = 1025 * np.array(
    [
        0.126571 * ELLIPSOID_VOLUME,
        0.398172 * ELLIPSOID_VOLUME,
        1.518061 * ELLIPSOID_VOLUME,
        0.0132928,
        0.108441,
        0.0190041,
    ]
)
ELLIPSOID_MASS = 1025 * ELLIPSOID_VOLUME
ELLIPSOID_INERTIA = ELLIPSOID_MASS / 5 * np.array([0.5**2 + 0.25**2, 1 + 0.25**2, 1 + 0.5**2])


def ellipsoid(integrator, timestep):
    """Neutrally buoyant triaxial ellipsoid in ideal fluid."""
    return marine_mj.load_xml(
        one_body(
            added_mass=ELLIPSOID_ADDED,
            numerics=f'<numeric name="a.displaced_volume" data="{ELLIPSOID_VOLUME}"/>',
            mass=ELLIPSOID_MASS,
            center="0 0 0",
            inertia=numbers(ELLIPSOID_INERTIA),
            extra='<site name="a.center_of_buoyancy"/>',
            integrator=integrator,
            timestep=timestep,
            pos="0 0 0",
        )
    )


def tumble(integrator, timestep, t_end=5.0):
    """Position error [m] of the tumbling ellipsoid after t_end against solve_ivp."""
    model = ellipsoid(integrator, timestep)
    data = mujoco.MjData(model)
    data.qpos[2] = -50
    nu = np.array([0.5, 0.2, -0.1, 0.3, 0.8, 0.5])
    data.qvel[:] = nu
    mujoco.mj_step(model, data, round(t_end / timestep))
    M = np.diag(ELLIPSOID_ADDED + np.r_[np.full(3, ELLIPSOID_MASS), ELLIPSOID_INERTIA])
    expected = textbook(M, t_end, nu, np.array([1.0, 0, 0, 0]))
    return np.linalg.norm(data.qpos[:3] - [0, 0, -50] - expected[:3])


def test_tumbling_ellipsoid_against_solve_ivp():
    error = tumble("RK4", 0.010)
    # measured 1.6e-5 m
    assert error < 1e-4


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_order_of_convergence(integrator):
    errors = [tumble(integrator, h) for h in (0.02, 0.01, 0.005)]
    # measured ratios: 2.0 for the semi-implicit ones, 4.0 for RK4 (MuJoCo 3.17: second order)
    order = 2.0 if integrator == "RK4" else 1.0
    for coarse, fine in itertools.pairwise(errors):
        assert coarse / fine > 0.85 * 2**order


ARTICULATED = """<mujoco><option timestep="0.0005" gravity="0 0 0" integrator="RK4">
  <flag energy="enable"/></option>
<custom>{}</custom>
<worldbody><body name="a"><freejoint/>
  <inertial pos="0.02 0.01 -0.05" mass="10" diaginertia="1 2 3"/>
  <body name="b" pos=".5 0 0"><joint type="hinge" axis="0 1 0"/>
    <inertial pos="0.3 0 0" mass="2" diaginertia=".1 .2 .3"/>
    <body name="c" pos=".5 0 0"><joint type="ball"/>
      <inertial pos="0.3 0.1 0" mass="2" diaginertia=".1 .2 .3"/></body></body></body>
  <body name="d" pos="5 0 0"><joint type="slide" axis="1 1 0"/><joint type="hinge" axis="0 0 1"/>
    <inertial pos="0.1 0 0" mass="3" diaginertia=".1 .2 .3"/></body>
</worldbody></mujoco>"""


def test_articulated_body_keeps_its_energy():
    added = {name: random_added_mass(i, 1.0) for i, name in enumerate("abcd")}
    text = "".join(
        f'<numeric name="{n}.added_mass_flu" data="{numbers(A)}"/>' for n, A in added.items()
    )
    model = marine_mj.load_xml(ARTICULATED.format(text))
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(1).normal(size=model.nv)

    def energy():
        mujoco.mj_forward(model, data)
        total = 0.0
        for name, A in added.items():
            body = model.body(name).id
            J = np.zeros((6, model.nv))
            mujoco.mj_jac(model, data, J[:3], J[3:], data.xpos[body], body)
            R = data.xmat[body].reshape(3, 3)
            nu = np.r_[R.T @ J[:3] @ data.qvel, R.T @ J[3:] @ data.qvel]
            M = rigid_mass(model.body_mass[body], model.body_ipos[body], model.body_inertia[body])
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, model.body_iquat[body])
            T = turn.reshape(3, 3)
            M[3:, 3:] += T @ np.diag(model.body_inertia[body]) @ T.T - np.diag(
                model.body_inertia[body]
            )
            total += 0.5 * nu @ (M + A) @ nu
        return total

    start = energy()
    # MuJoCo's own kinetic energy contains the added mass: measured 2e-14
    assert data.energy[1] == pytest.approx(start, rel=1e-12)
    mujoco.mj_step(model, data, 4000)
    # measured 3e-8 after 2 s
    assert energy() / start == pytest.approx(1, abs=2e-7)


def test_model_without_coefficients_is_plain_mujoco():
    xml = one_body()
    ours, plain = marine_mj.load_xml(xml), mujoco.MjModel.from_xml_string(xml)
    states = []
    for model in (ours, plain):
        data = mujoco.MjData(model)
        data.qvel[:] = [1, 2, 3, 0.5, 0.2, 0.1]
        mujoco.mj_step(model, data, 200)
        states.append(np.concatenate([data.qpos, data.qvel]))
    assert (states[0] == states[1]).all()
    mujoco.set_mjcb_passive(None)
    try:
        data = mujoco.MjData(plain)
        data.qvel[:] = [1, 2, 3, 0.5, 0.2, 0.1]
        mujoco.mj_step(plain, data, 200)
    finally:
        from marine_mj.hydrodynamics.native import install

        install()
    assert (states[0] == np.concatenate([data.qpos, data.qvel])).all()


def test_transition_matrices_do_not_count_added_mass_twice():
    model = marine_mj.load_xml(one_body(added_mass=random_added_mass(), gravity=0))
    data = mujoco.MjData(model)
    data.qvel[:] = [0.4, 0.2, -0.3, 0.5, -0.7, 0.9]
    mujoco.mj_forward(model, data)
    B = np.zeros((2 * model.nv, model.nu))
    mujoco.mjd_transitionFD(model, data, 1e-6, True, None, B, None, None)
    M = M_RB + random_added_mass()
    expected = np.linalg.solve(M, [1, 0, 0, 0, 0, 0]) * model.opt.timestep
    # measured 1e-9
    np.testing.assert_allclose(B[model.nv :, 0], expected, atol=1e-7)


def test_six_times_the_dry_mass_stays_stable():
    model = marine_mj.load_xml(
        one_body(
            added_mass=np.r_[60.0, 60, 60, 6, 12, 18],
            center="0 0 0",
            numerics='<numeric name="a.quadratic_damping_flu" data="20 50 50 1 1 1"/>',
            gravity=0,
            timestep=0.01,
        )
    )
    data = mujoco.MjData(model)
    data.qvel[:] = [0.5, 1, 1, 1, 0, 0]
    data.ctrl[0] = 20
    fastest = 0.0
    for _ in range(6000):
        mujoco.mj_step(model, data)
        fastest = max(fastest, np.abs(data.qvel).max())
    marine_mj.check_state(model, data)
    # 1 m/s is the terminal speed of 20 N; a lagged acceleration feedback diverges here
    assert fastest < 2.0
    # it stays within its terminal speed although the Munk moment turns it
    nu = data.xmat[1].reshape(3, 3).T @ data.qvel[:3]
    assert 0 < nu[0] < 1.05
