"""Sensors of the carrier, seen from the vehicle: acoustic positioning and a camera.

The conventions are those of `sensors.py`.
"""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.kinematics import RigidState, rotate, unrotate
from marine_mj.controllers.navigation.sensors import UP, Timing, Vector

from marine_mj import frames
from marine_mj.frames import Array


@dataclass(frozen=True)
class Spherical:
    """Noise of a measured direction and distance.

    Attributes:
        distance: (3,) `a, b, c` of the standard deviation of the distance, m.
        squared: it is `sqrt(a^2 + (b r)^2 + (c r^2)^2)`; otherwise `a + b r + c r^2`.
        polar: angle from the sensor's axis, rad.
        azimuth: angle across it, rad.
    """

    distance: Vector
    squared: bool
    polar: float
    azimuth: float

    def factor(self, vector: Array, axis: Vector) -> Array:
        """Matrix B (..., 3, 3) of the noise `B n` of a vector (..., 3) seen along `axis`."""
        r = np.linalg.norm(vector, axis=-1)[..., None]
        u = vector / np.maximum(r, 1e-9)
        across = frames.cross(np.asarray(axis, dtype=float), u)
        size = np.linalg.norm(across, axis=-1)[..., None]
        # On the axis any direction across will do.
        other = frames.cross(u, np.array([1.0, 0.0, 0.0]))
        other = other / np.maximum(np.linalg.norm(other, axis=-1)[..., None], 1e-9)
        across = np.where(size > 1e-6, across / np.maximum(size, 1e-9), other)
        terms = np.asarray(self.distance) * np.concatenate([np.ones_like(r), r, r * r], axis=-1)
        if self.squared:
            along = np.sqrt(np.sum(terms**2, axis=-1))[..., None]
        else:
            along = np.sum(terms, axis=-1)[..., None]
        polar = np.asarray(self.polar)[..., None] * r
        azimuth = np.asarray(self.azimuth)[..., None] * r
        columns = [along * u, polar * frames.cross(u, across), azimuth * across]
        return np.stack(columns, axis=-1)


@dataclass(frozen=True)
class Usbl:
    """Acoustic positioning: head on the vehicle, transponder on the carrier.

    Attributes:
        timing: of the samples; the delay is that of sound and processing.
        transponder: (3,) on the carrier, FLU, m.
        mount: (3,) of the head on the vehicle, FLU, m.
        noise: of distance and direction (table 8.3; the exponent in its distance is uncertain).
        reach: largest distance, m.
    """

    timing: Timing
    transponder: Vector = (1.0, 0.0, -0.5)
    mount: Vector = (0.3, 0.0, 0.1)
    noise: Spherical = Spherical((0.66, 0.01, 0.0), True, 0.174, 0.087)
    reach: float = 500.0

    def measure(self, body: RigidState, carrier: RigidState, noise: Array) -> tuple[Array, Array]:
        """Vector (..., 3) from head to transponder, FLU, and whether (...,) it is in reach."""
        vector = relative_position(body, carrier, self.transponder, self.mount)
        seen = np.linalg.norm(vector, axis=-1) <= self.reach
        return vector + rotate(self.noise.factor(vector, UP), noise), seen


@dataclass(frozen=True)
class Camera:
    """Camera on the vehicle that finds the pose of a light marker on the carrier.

    Attributes:
        timing: of the pictures; the delay is that of image processing.
        marker: (3,) on the carrier, FLU, m.
        normal: (3,) direction in which it shines, carrier axes FLU.
        mount: (3,) of the camera on the vehicle, FLU, m.
        axis: (3,) direction in which it looks, FLU.
        half_angle: of its conical field of view, rad.
        nearest, reach: smallest and largest distance, m.
        lobe: largest angle between `normal` and the line of sight, rad.
        boxes: (k, 2, 3) lower and upper corners of what may stand between, carrier FLU, m.
        noise: of distance and direction (table 8.3, vision; the reference lets the azimuth's noise
            grow away from the axis of the light, which is left out).
        attitude: standard deviation of each axis of the relative attitude, rad (ours).
    """

    timing: Timing
    marker: Vector = (0.0, 0.0, -0.1)
    normal: Vector = (0.0, 0.0, -1.0)
    mount: Vector = (0.0, 0.0, 0.1)
    axis: Vector = UP
    half_angle: float = np.deg2rad(45.0)
    nearest: float = 0.1
    reach: float = 8.0
    lobe: float = np.deg2rad(75.0)
    boxes: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))
    noise: Spherical = Spherical((0.2, 0.0046, 0.0122), False, 0.087, 0.087)
    attitude: float = 0.05

    def visible(self, body: RigidState, carrier: RigidState) -> Array:
        """Whether (...,) the marker is in the field of view, in reach, lit and not occluded."""
        vector = relative_position(body, carrier, self.marker, self.mount)
        distance = np.maximum(np.linalg.norm(vector, axis=-1), 1e-9)
        inside = np.sum(vector * np.asarray(self.axis), axis=-1) >= distance * np.cos(
            self.half_angle
        )
        # The same line in the carrier's axes, from the marker to the camera.
        line = unrotate(carrier.rotation, rotate(body.rotation, -vector))
        lit = np.sum(line * np.asarray(self.normal), axis=-1) >= distance * np.cos(self.lobe)
        near = (distance >= self.nearest) & (distance <= self.reach)
        hidden = crossed(np.asarray(self.marker), line, self.boxes)
        return np.logical_and(inside & lit & near, np.logical_not(hidden))

    def measure(
        self, body: RigidState, carrier: RigidState, noise: Array
    ) -> tuple[Array, Array, Array]:
        """Vector (..., 3) from camera to marker, FLU; attitude (..., 4) of the carrier relative to
        the vehicle, wxyz; whether (...,) the marker is seen. Takes noise (..., 6)."""
        vector = relative_position(body, carrier, self.marker, self.mount)
        error = rotate(self.noise.factor(vector, self.axis), noise[..., :3])
        turn = frames.quaternion_multiply(
            frames.quaternion_conjugate(body.quaternion), carrier.quaternion
        )
        wrong = frames.quaternion_from_rotation_vector(
            np.asarray(self.attitude)[..., None] * noise[..., 3:]
        )
        attitude = frames.quaternion_multiply(wrong, turn)
        return vector + error, attitude, self.visible(body, carrier)


def relative_position(body: RigidState, carrier: RigidState, point: Vector, mount: Vector) -> Array:
    """Vector (..., 3) from a mount on one body to a point on another, axes of the first, FLU."""
    there = carrier.position + rotate(carrier.rotation, np.asarray(point, dtype=float))
    return unrotate(body.rotation, there - body.position) - np.asarray(mount)


def crossed(start: Array, line: Array, boxes: Array) -> Array:
    """Whether (...,) the way from `start` (3,) along `line` (..., 3) meets a box (k, 2, 3)."""
    met = np.zeros(line.shape[:-1], dtype=bool)
    for low, high in boxes:
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low - start) / line, (high - start) / line
        outside = (line == 0) & ((start < low) | (start > high))
        first = np.where(line == 0, -np.inf, np.minimum(a, b)).max(axis=-1)
        last = np.where(line == 0, np.inf, np.maximum(a, b)).min(axis=-1)
        met |= (first <= last) & (last > 0) & (first < 1) & ~outside.any(axis=-1)
    return met
