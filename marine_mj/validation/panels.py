"""Hull panels: hydrostatics, energy, Froude-Krylov forces and motion in waves."""

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import trimesh
import xarray as xr

from marine_mj.environment import Environment, WaveField, irregular_sea, regular_wave
from marine_mj.frames import Array, quaternion_from_euler
from marine_mj.hydrodynamics.floating import Pose, afloat, floating_height, floating_restoring
from marine_mj.hydrodynamics.loader import load, load_xml
from marine_mj.hydrodynamics.mesh import HullMesh, read_mesh
from marine_mj.hydrodynamics.start import start_in_waves
from marine_mj.hydrodynamics.wrenches import wrenches
from marine_mj.library import assets_folder, find_model
from marine_mj.validation.rows import Row, row

RHO, G = 1025.0, 9.81
CLOSED = "closed form"
DATABASE = assets_folder() / "dus_v5750_box.nc"
DOFS = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
HEELS = np.radians([5.0, 10, 20, 30, 40, 50, 60])


def hull_of(
    mesh: trimesh.Trimesh, offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> HullMesh:
    """Hull of a trimesh solid, moved by `offset`."""
    return HullMesh(np.asarray(mesh.vertices) + offset, np.asarray(mesh.faces, dtype=np.int64))


def floating_body(
    hull: HullMesh,
    mass: float = 1.0,
    center: tuple[float, float, float] = (0.0, 0.0, 0.0),
    inertia: tuple[float, float, float] = (1.0, 1.0, 1.0),
    environment: Environment | None = None,
    timestep: float = 0.005,
    coefficients: str = "",
) -> mujoco.MjModel:
    """Model of one free body `a` on the panels of a hull, RK4."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hull.obj"
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in hull.vertices.tolist()]
        lines += [f"f {i} {j} {k}" for i, j, k in (hull.triangles + 1).tolist()]
        file.write_text("\n".join(lines) + "\n")
        text = " ".join(map(repr, map(float, center)))
        diagonal = " ".join(map(repr, map(float, inertia)))
        return load_xml(
            f"""<mujoco><option timestep="{timestep}" integrator="RK4"/>
            <custom><numeric name="a.reference_speed" data="1 0.1"/>{coefficients}
            <text name="a.hull_mesh" data="{file}"/></custom>
            <worldbody><body name="a"><freejoint/>
            <inertial pos="{text}" mass="{float(mass)!r}" diaginertia="{diagonal}"/></body>
            </worldbody></mujoco>""",
            environment,
        )


def wrench(model: mujoco.MjModel, pose: Pose, cause: str = "restoring", time: float = 0.0) -> Array:
    """World wrench (6) on the body `a` about its origin, at rest in a pose."""
    data = mujoco.MjData(model)
    data.time = time
    data.qpos[2] = pose.height
    data.qpos[3:7] = quaternion_from_euler([pose.roll, pose.pitch, 0.0])
    mujoco.mj_forward(model, data)
    force = wrenches(model, data)["a"][cause]
    R = data.xmat[1].reshape(3, 3)
    return np.concatenate([R @ force[:3], R @ force[3:]])


def _arms(hull: HullMesh, volume: float, model: mujoco.MjModel) -> tuple[Array, float]:
    """GZ at HEELS with the CG in the origin by the kernel, and the worst error of its lift."""
    arms, worst = [], 0.0
    for heel in HEELS:
        force = wrench(model, Pose(floating_height(hull, volume, heel), heel))
        arms.append(-force[3] / force[2])
        worst = max(worst, abs(force[2] / (RHO * G * volume) - 1))
    return np.array(arms), worst


def solids() -> Iterator[tuple[str, HullMesh, float, Array, float]]:
    """Name, hull, volume, closed-form GZ at HEELS, closed-form draught upright."""
    R, d = 1.0, 0.3
    ball = trimesh.creation.icosphere(3, R)
    ball.apply_scale(np.cbrt(4 / 3 * np.pi * R**3 / ball.volume))
    h = 0.8
    yield ("sphere", hull_of(ball, (0, 0, d)), np.pi * h**2 * (3 * R - h) / 3,
           d * np.sin(HEELS), h)  # fmt: skip
    # wall-sided (Barrass & Derrett 2012): GZ = sin(phi) (GM + BM tan(phi)^2 / 2)
    L, B, H, T = 4.0, 1.0, 2.4, 1.0
    box = trimesh.creation.box((L, B, H)).subdivide().subdivide()
    keel = -0.45  # origin, here the CG, above it
    BM = B**2 / 12 / T
    GM = T / 2 + keel + BM
    yield ("box", hull_of(box, (0, 0, keel + H / 2)), L * B * T,
           np.sin(HEELS) * (GM + 0.5 * BM * np.tan(HEELS) ** 2), T)  # fmt: skip
    # prism with its apex down: the wet section stays a triangle of the same area, its sides at
    # the angles a - heel (port) and a + heel (starboard) from the vertical
    a, H, T, keel = np.radians(25.0), 4.0, 1.2, -0.9
    y = H * np.tan(a)
    corners = np.array([(x, s, z) for x in (-1.0, 1.0) for s, z in ((0, 0), (-y, H), (y, H))])
    wedge = trimesh.convex.convex_hull(corners).subdivide().subdivide()
    section = T**2 * np.tan(a)
    slope = np.cos(a + HEELS) / np.cos(a - HEELS)
    side = np.sqrt(2 * section / np.sin(2 * a))
    centroid = side * (np.sqrt(slope) * np.sin(a - HEELS) - np.sin(a + HEELS) / np.sqrt(slope)) / 3
    yield "wedge", hull_of(wedge, (0, 0, keel)), 2 * section, keel * np.sin(HEELS) - centroid, T


def shapes() -> Iterator[Row]:
    """Volume, centre of buoyancy and righting arms to 60 degrees of sphere, box and wedge."""
    for name, hull, volume, expected, draught in solids():
        arms, lift = _arms(hull, volume, floating_body(hull, mass=RHO * volume))
        worst = np.abs(arms / expected - 1).max()
        yield row(f"panels: GZ of a {name}", worst, 0, "1", CLOSED, within=0.005)
        yield row(f"panels: lift of a {name}", lift, 0, "1", "displaced volume", within=1e-9)
        height = floating_height(hull, volume)
        state = afloat(hull, Pose(height))
        yield row(f"panels: draught of a {name}", state.draught, draught, "m", CLOSED, percent=0.5)
    name, hull, volume, _, T = next(solids())
    state = afloat(hull, Pose(floating_height(hull, volume)))
    # centroid of a spherical cap, from the centre of the sphere
    depth = 3 * (2 - T) ** 2 / (4 * (3 - T))
    center = Pose(floating_height(hull, volume)).place(hull.vertices.mean(axis=0))
    measured = float(center[2] - state.center_of_buoyancy[2])
    yield row("panels: centre of buoyancy of a sphere", measured, depth, "m", CLOSED, percent=0.5)


#: The box of the USV with its CG off the middle: couples heave, roll and pitch.
CENTER = (0.1, -0.05, 0.1)


def box_hull() -> HullMesh:
    """Hull mesh of the survey USV."""
    return read_mesh(find_model("dus_v5750").parent / "assets" / "hull.obj")


def linear() -> Iterator[Row]:
    """Small motions: slope of the kernel's wrench and weight against the closed form of a box."""
    L, B, T = 5.0, 1.5, 0.3
    hull, mass = box_hull(), RHO * L * B * T
    model = floating_body(hull, mass)
    x, y, z = CENTER
    moved = HullMesh(hull.vertices - CENTER, hull.triangles)
    off = floating_body(moved, mass)
    A, V = L * B, L * B * T
    # about the origin (the CG), which lies CENTER away from the middle of the waterplane
    G_33, G_34, G_35 = A, A * -y, A * x
    G_44 = B**3 * L / 12 + A * y * y + V * (-T / 2 - z)
    G_55 = L**3 * B / 12 + A * x * x + V * (-T / 2 - z)
    G_45 = -A * x * y
    expected = {"33": G_33, "34": G_34, "35": G_35, "44": G_44, "45": G_45, "55": G_55}
    step = 1e-4
    for pair, value in expected.items():
        i, j = int(pair[0]) - 1, int(pair[1]) - 1
        ends = []
        for sign in (1, -1):
            d = np.zeros(6)
            d[j] = sign * step
            force = wrench(off, Pose(z + d[2], d[3], d[4]))
            ends.append(force[i])
        slope = -(ends[0] - ends[1]) / (2 * step)
        name = f"panels: G{pair} of a box, CG off the middle"
        yield row(name, slope, RHO * G * value, "N, m", CLOSED, percent=0.1)
    G_mesh = floating_restoring(hull, mass, (0, 0, 0), RHO, G)
    C_55 = RHO * G * (L**3 * B / 12 - V * T / 2)
    yield row("panels: C55 of the mesh", G_mesh[4, 4], C_55, "N m", CLOSED, percent=1e-6)
    lift = wrench(model, Pose())[2]
    yield row("panels: lift of the USV", lift, RHO * G * V, "N", CLOSED, percent=1e-9)


def energy_drift(added_mass: str, seconds: float, timestep: float) -> float:
    """Change of the energy of a box that heaves, rolls and pitches, over its excess at the start.

    Potential energy: weight, and `-rho g V z_B` of the displaced water (NumPy).
    """
    hull, mass = box_hull(), RHO * 2.25
    inertia = (1040.0, 5412.0, 5237.0)
    coefficients = f'<numeric name="a.added_mass_flu" data="{added_mass}"/>'
    model = floating_body(hull, mass, (0, 0, 0), inertia, None, timestep, coefficients)
    data = mujoco.MjData(model)
    M = np.diag([mass] * 3 + list(inertia)) + np.diag([float(v) for v in added_mass.split()])

    def energy() -> float:
        mujoco.mj_forward(model, data)
        R = data.xmat[1].reshape(3, 3)
        roll, pitch = np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0])
        state = afloat(hull, Pose(float(data.qpos[2]), float(roll), float(pitch)))
        depth = state.center_of_buoyancy[2]
        nu = np.concatenate([R.T @ data.qvel[:3], data.qvel[3:]])
        return float(0.5 * nu @ M @ nu + G * (mass * data.qpos[2] - RHO * state.volume * depth))

    rest = energy()
    data.qpos[2] = 0.12
    data.qpos[3:7] = quaternion_from_euler([0.25, 0.06, 0.0])
    start = energy()
    drift = 0.0
    for _ in range(20):
        mujoco.mj_step(model, data, round(seconds / timestep / 20))
        drift = max(drift, abs(energy() - start))
    return drift / (start - rest)


def energy() -> Iterator[Row]:
    """Energy of a free box without damping over 100 s, RK4."""
    for name, added in (("no", "0 0 0 0 0 0"), ("constant", "300 1300 3900 400 7300 2000")):
        drift = energy_drift(added, 100.0, 0.002)
        label = f"panels: energy drift in 100 s, {name} added mass"
        yield row(label, drift, 0, "1", "conservation", within=1e-5)


def box_froude_krylov(k: float, L: float, B: float, T: float) -> Array:
    """Complex surge, heave and pitch Froude-Krylov force per metre on a fixed box in head waves.

    Closed form of linear theory, deep water, about the middle of the waterplane: `Re(X exp(-i w
    t))` for the elevation `Re(exp(i (k x - w t)))`.
    """
    decay, half = np.exp(-k * T), 0.5 * k * L
    across = RHO * G * B
    surge = -2j * across * np.sin(half) * (1 - decay) / k
    heave = across * decay * 2 * np.sin(half) / k
    arm = 2 * (np.sin(half) / k**2 - 0.5 * L * np.cos(half) / k)
    lever = (T / k + 1 / k**2) * decay - 1 / k**2
    pitch = -1j * across * (decay * arm + 2 * np.sin(half) * lever)
    return np.array([surge, heave, pitch])


def first_order(model_of: Callable[[Environment], mujoco.MjModel], wave: WaveField) -> Array:
    """Complex force (6) per metre on a fixed body, `Re(X exp(-i omega t))`, free of even orders.

    model_of: gives the model in a sea.
    """
    amplitude, omega = float(wave.amplitude[0]), float(wave.omega[0])
    parts = []
    for shift in (0.0, np.pi):
        model = model_of(Environment(waves=replace(wave, phase=wave.phase + shift)))
        real = wrench(model, Pose(), "waves", 0.0)
        quarter = wrench(model, Pose(), "waves", 0.5 * np.pi / omega)
        parts.append(real + 1j * quarter)
    return 0.5 * (parts[0] - parts[1]) / amplitude


def froude_krylov() -> Iterator[Row]:
    """Force of small waves on the fixed box against its closed form and its wave database."""
    hull = box_hull()
    names = ("surge", "heave", "pitch")

    def model_of(environment: Environment) -> mujoco.MjModel:
        return floating_body(hull, environment=environment)

    with xr.open_dataset(DATABASE, engine="h5netcdf") as data:
        loads = data["Froude_Krylov_force"].sel(influenced_dof=DOFS)
        table = loads.transpose("complex", "omega", "wave_direction", "influenced_dof").to_numpy()
        omega, direction = data["omega"].values, data["wave_direction"].values
    for period in (6.7, 4.6, 2.6, 2.0):
        wave = regular_wave(2e-4, period)
        X = first_order(model_of, wave)[[0, 2, 4]]
        expected = box_froude_krylov(float(wave.wavenumber[0]), 5.0, 1.5, 0.3)
        for name, value, exact in zip(names, X, expected, strict=True):
            label = f"panels: Froude-Krylov {name}, T {period:g} s"
            error = abs(value - exact) / abs(exact)
            yield row(label, error, 0, "1", "closed form of a box", within=0.02)
    index, angle = int(np.argmin(np.abs(omega - 2 * np.pi / 3.5))), 3
    wave = regular_wave(2e-4, 2 * np.pi / omega[index], float(direction[angle]))
    X = first_order(model_of, wave)
    complete = table[0, index, angle] + 1j * table[1, index, angle]
    for name, value, exact in zip(DOFS, X, complete, strict=True):
        label = f"panels: Froude-Krylov {name.lower()}, T 3.5 s at 67.5 deg"
        error = abs(value - exact) / abs(exact)
        yield row(label, error, 0, "1", "dus_v5750_box.nc", within=0.02)


def expansion() -> Iterator[Row]:
    """Force by the expanded wave field against the pressure summed at every vertex."""
    hull = box_hull()
    for state, H_s, T_p in ((4, 1.1, 5.515), (6, 2.5, 6.834)):
        worst = expansion_error(hull, H_s, T_p, seeds=5)
        label = f"panels: force by the expansion, sea state {state}"
        yield row(label, worst, 0, "1", "direct sum; of the largest force", within=0.005)


def expansion_error(hull: HullMesh, H_s: float, T_p: float, seeds: int, poses: int = 10) -> float:
    """Largest error of the waves' force over its largest value, at random poses and times."""
    error, size = np.zeros(6), np.zeros(6)
    for seed in range(seeds):
        sea = irregular_sea(H_s, T_p, components=100, seed=seed, spreading=10)
        rng = np.random.default_rng(seed)
        model = floating_body(hull, environment=Environment(waves=sea))
        for _ in range(poses):
            z = rng.normal(0, 0.25 * H_s)
            pose = Pose(z, *rng.normal(0, 0.15, 2))
            time = rng.uniform(0, 100)
            ours = wrench(model, pose, "waves", time) + wrench(model, pose, "restoring", time)
            exact = direct_wrench(hull, pose, sea, time)
            error = np.maximum(error, np.abs(ours - exact))
            size = np.maximum(size, np.abs(exact))
    return float((error / np.concatenate([[size[:3].max()] * 3, [size[3:].max()] * 3])).max())


def direct_wrench(hull: HullMesh, pose: Pose, sea: WaveField, time: float) -> Array:
    """World wrench (6) of the water on a hull, in NumPy: pressure summed at every vertex.

    Wet parts are cut off and integrated on their own, pressure linear over each.
    """
    x = hull.vertices @ pose.rotation.T + [0, 0, pose.height]
    zeta = sea.elevation(x[:, 0], x[:, 1], time)
    wheeler = replace(sea, stretching="wheeler")
    p = wheeler.pressure(x[:, 0], x[:, 1], x[:, 2], time, RHO) - RHO * G * x[:, 2]
    total = np.zeros(6)
    for corners in hull.triangles:
        points = [(x[i], zeta[i] - x[i, 2], p[i]) for i in corners]
        wet: list[tuple[Array, float]] = []
        for (a, s_a, p_a), (b, s_b, _) in zip(points, points[1:] + points[:1], strict=True):
            if s_a > 0:
                wet.append((a, p_a))
            if (s_a > 0) != (s_b > 0):
                wet.append((a + s_a / (s_a - s_b) * (b - a), 0.0))
        # a quadrilateral is split at its second corner behind the cut, as the kernel does
        if len(wet) == 4:
            first = next(i for i in range(4) if wet[i - 1][1] == 0 and wet[i][1] != 0)
            wet = wet[first:] + wet[:first]
        for i in range(1, len(wet) - 1):
            (a, p_a), (b, p_b), (c, p_c) = wet[0], wet[i], wet[i + 1]
            area = 0.5 * np.cross(b - a, c - a)
            middles = ((a + b) / 2, (b + c) / 2, (c + a) / 2)
            values = ((p_a + p_b) / 2, (p_b + p_c) / 2, (p_c + p_a) / 2)
            for point, value in zip(middles, values, strict=True):
                force = -value * area / 3
                total += np.concatenate([force, np.cross(point - [0, 0, pose.height], force)])
    return total


def motion_ratio(period: float, height: float) -> tuple[float, float]:
    """Heave and pitch of the USV on panels over those by restoring matrix and force RAOs."""
    sizes = []
    for kind in ("panels", "linear"):
        sea = Environment(waves=regular_wave(height, period))
        model = load("dus_v5750", sea, {"hull": {"hydrostatics": kind}})
        data = mujoco.MjData(model)
        start_in_waves(model, data)
        steps = round(period / model.opt.timestep / 40)
        mujoco.mj_step(model, data, 6 * 40 * steps)
        t, poses = [], []
        for _ in range(80):
            mujoco.mj_step(model, data, steps)
            t.append(data.time)
            poses.append([data.qpos[2], 2 * data.qpos[5]])
        w = 2 * np.pi / period * np.array(t)
        fit = np.linalg.lstsq(
            np.column_stack([np.cos(w), np.sin(w), np.ones_like(w)]), np.array(poses), rcond=None
        )[0]
        sizes.append(np.hypot(fit[0], fit[1]))
    return tuple(sizes[0] / sizes[1])


def motion() -> Iterator[Row]:
    """USV in a small regular head wave: panels against the linear model."""
    for period in (2.6, 3.5, 4.6, 6.7):
        ratios = motion_ratio(period, 0.02)
        for name, ratio in zip(("heave", "pitch"), ratios, strict=True):
            label = f"panels: {name} over linear, T {period:g} s"
            yield row(label, ratio, 1, "1", "linear model of the USV", within=0.02)


CASES = (shapes, linear, energy, froude_krylov, expansion, motion)
