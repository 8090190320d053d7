"""What docking is about, computed from states of any leading shape: one run or a thousand."""

from dataclasses import dataclass, field
from functools import cached_property

import mujoco
import numpy as np

from marine_mj import frames
from marine_mj.controllers import DockFrames, RigidState, pose_error, relative_velocity
from marine_mj.controllers.kinematics import rotate, unrotate
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.scene import at_origin, main_bodies
from marine_mj.tasks.dock_reader import DockReader
from marine_mj.tasks.reader import BodyReader


@dataclass(frozen=True)
class DockingGeometry:
    """Who docks where in a scene; the pair comes from the latch's weld.

    Attributes:
        weld: index of the latch's equality constraint.
        vehicle, carrier: instance names.
        vehicle_reader: reader of the vehicle's state.
        carrier_reader: reader of the body that bears the dock's frames: the carrier, or the dock
            body itself where joints of its own let it move (a suspended dock).
        frames: aperture and seat in that body's axes.
        axis: axis of the aperture frame along which the seat lies: 2 (above) or 0 (ahead).
        weld_position: (3,) dock body in the axes FLU of the body that bears the frames, m.
        weld_quaternion: (4,) attitude of the dock body relative to it, wxyz.
        mass: dry mass of the vehicle, kg.
        center: (3,) its centre of gravity from the body origin, FLU, m.
        inertia: (3, 3) about its centre of gravity, FLU, kg m2.
    """

    weld: int
    vehicle: str
    carrier: str
    vehicle_reader: BodyReader
    carrier_reader: BodyReader | DockReader
    frames: DockFrames
    axis: int = field(metadata={"stack": "same"})
    weld_position: Array
    weld_quaternion: Array
    mass: float
    center: Array
    inertia: Array

    @classmethod
    def of(cls, model: mujoco.MjModel) -> "DockingGeometry":
        """Geometry of a compiled scene.

        Raises:
            ModelError: the scene has no latch, or its dock lacks a site, has them at odds, or
                hangs on its carrier by other joints than slides and hinges.
        """
        welds = [i for i in range(model.neq) if "/latch/" in model.equality(i).name]
        if not welds:
            raise ModelError("the scene has no latch: a vehicle needs dock = NAME")
        weld = welds[0]
        carrier, _, vehicle = model.equality(weld).name.split("/")
        data = at_origin(model)
        body, reader = _bearer(model, model.eq_obj1id[weld], main_bodies(model)[carrier])
        places = []
        for name in ("aperture", "seat"):
            site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, f"{carrier}/dock/{name}")
            if site < 0:
                raise ModelError(f"the dock of {carrier!r} has no site {name!r}")
            places += _relative(data, body, data.site_xpos[site], data.site_xmat[site])
        dock = model.eq_obj1id[weld]
        dock_frames = DockFrames(*places)
        mount = _relative(data, body, data.xpos[dock], data.xmat[dock])
        own = main_bodies(model)[vehicle]
        turn = frames.rotation_from_quaternion(model.body_iquat[own])
        return cls(
            weld=weld,
            vehicle=vehicle,
            carrier=carrier,
            vehicle_reader=BodyReader.of(model, own),
            carrier_reader=reader,
            frames=dock_frames,
            axis=_entry(carrier, dock_frames),
            weld_position=mount[0],
            weld_quaternion=mount[1],
            mass=float(model.body_mass[own]),
            center=model.body_ipos[own].copy(),
            inertia=turn @ np.diag(model.body_inertia[own]) @ turn.T,
        )


def _bearer(model: mujoco.MjModel, dock: int, carrier: int) -> tuple[int, BodyReader | DockReader]:
    """Body that bears the frames of a dock, and the reader of its state."""
    if model.body_dofnum[dock] == 0:
        return carrier, BodyReader.of(model, carrier)
    return dock, DockReader.of(model, dock, carrier)


def _entry(carrier: str, dock: DockFrames) -> int:
    """Axis of the aperture frame that leads to the seat."""
    turn = frames.rotation_from_quaternion(dock.aperture_quaternion)
    way = turn.T @ (dock.seat - dock.aperture)
    for axis in (2, 0):
        if way[axis] > 0.99 * np.linalg.norm(way):
            return axis
    raise ModelError(
        f"in the dock of {carrier!r} the seat lies at {np.round(way, 3)} m from the aperture, in "
        "the aperture's axes; allowed is straight along z (entry from below) or along x (entry "
        "from behind): move the site or turn the aperture"
    )


def _relative(data: mujoco.MjData, body: int, position: Array, matrix: Array) -> list[Array]:
    """Position (3,) and attitude (4,) of a frame in the axes of a body."""
    rotation = data.xmat[body].reshape(3, 3)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, (rotation.T @ matrix.reshape(3, 3)).flatten())
    return [rotation.T @ (position - data.xpos[body]), quaternion]


class DockingView:
    """States and errors of docking at one moment.

    Args:
        geometry: who docks where.
        qpos: (..., nq) generalised positions of the scene.
        qvel: (..., nv) generalised velocities.
    """

    def __init__(self, geometry: DockingGeometry, qpos: Array, qvel: Array) -> None:
        self._geometry, self._qpos, self._qvel = geometry, qpos, qvel

    @cached_property
    def vehicle(self) -> RigidState:
        """State of the vehicle that docks, NWU/FLU."""
        return self._geometry.vehicle_reader.state(self._qpos, self._qvel)

    @cached_property
    def carrier(self) -> RigidState:
        """State of the body that bears the dock: the carrier or a suspended dock, NWU/FLU."""
        return self._geometry.carrier_reader.state(self._qpos, self._qvel)

    @cached_property
    def dock(self) -> tuple[RigidState, RigidState]:
        """States of the aperture frame and of the seat, NWU/FLU."""
        return self._geometry.frames.states(self.carrier)

    @cached_property
    def error(self) -> Array:
        """Seat pose minus vehicle pose (..., 6), in the vehicle's FLU axes, m and rad."""
        return pose_error(self.dock[1], self.vehicle)

    @cached_property
    def aperture_pose(self) -> Array:
        """Vehicle pose (..., 6) in the aperture frame: position m, rotation vector rad, FLU."""
        return pose_error(self.vehicle, self.dock[0])

    @cached_property
    def relative_velocity(self) -> Array:
        """Velocity (..., 6) of the vehicle relative to the seat, in the vehicle's FLU axes."""
        return relative_velocity(self.vehicle, self.dock[1])

    @cached_property
    def relative_energy(self) -> Array:
        """Kinetic energy (...,) of the relative motion with the dry mass, J.

        `0.5 dnu^T M_RB dnu` relative to the aperture frame, about the vehicle's origin
        (digest 7.0).
        """
        g = self._geometry
        nu = relative_velocity(self.vehicle, self.dock[0])
        turn = nu[..., 3:]
        at_center = nu[..., :3] + frames.cross(turn, g.center)
        linear = g.mass * np.sum(at_center**2, axis=-1)
        return 0.5 * (linear + np.sum(turn * rotate(g.inertia, turn), axis=-1))

    @cached_property
    def weld(self) -> Array:
        """First data (..., 10) of the latch's weld with which it holds the present pose.

        Anchor, relative position (m) and relative attitude of the vehicle in the dock body's axes.
        """
        g = self._geometry
        dock = self.carrier.attached(g.weld_position, g.weld_quaternion)
        vehicle = self.vehicle
        shape = vehicle.position.shape[:-1]
        held = np.zeros((*shape, 10))
        held[..., 3:6] = unrotate(dock.rotation, vehicle.position - dock.position)
        inverse = frames.quaternion_conjugate(dock.quaternion)
        held[..., 6:10] = frames.quaternion_multiply(inverse, vehicle.quaternion)
        return held
