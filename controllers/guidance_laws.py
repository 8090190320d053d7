"""Guidance laws for docking horizontally, as reviewed in the docking reference (digest app. D).

Pure functions in the horizontal plane, for any leading shape. Positions (..., 2) in m and angles in
rad, counter-clockwise from x (NWU); `axis` is the direction in which a vehicle enters the dock, the
centre line passes through the dock along it. The cross-track error is positive to the left of the
centre line. A vehicle that moves with speed U through the water keeps its course over ground in a
current only by heading into it: that is where the laws differ.
"""

import numpy as np

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array, ssa

Value = Array | float


def track_errors(position: Array, dock: Array, axis: Value) -> tuple[Array, Array]:
    """Distance (...,) still to go along the centre line, and cross-track error (...,), m."""
    offset = np.asarray(position, dtype=float) - dock
    c, s = np.cos(axis), np.sin(axis)
    along = c * offset[..., 0] + s * offset[..., 1]
    return -along, c * offset[..., 1] - s * offset[..., 0]


def line_of_sight(position: Array, target: Array) -> Array:
    """Heading (...,) towards a target, `atan2(y_t - y, x_t - x)`."""
    line = np.asarray(target, dtype=float) - position
    return np.arctan2(line[..., 1], line[..., 0])


def proportional_navigation(
    position: Array,
    velocity: Array,
    target: Array,
    target_velocity: Array | float = 0.0,
    gain: Value = 3.0,
) -> Array:
    """Heading rate (...,) in rad/s: `N` times the rate of the bearing to the target.

    Args:
        position, target: (..., 2), m.
        velocity, target_velocity: (..., 2) over ground, m/s.
        gain: N.
    """  # fmt: skip
    line = np.asarray(target, dtype=float) - position
    closing = np.asarray(target_velocity, dtype=float) - velocity
    square = np.maximum(line[..., 0] ** 2 + line[..., 1] ** 2, 1e-12)
    return gain * (line[..., 0] * closing[..., 1] - line[..., 1] * closing[..., 0]) / square


def pure_pursuit(position: Array, dock: Array, axis: Value, lookahead: Value) -> Array:
    """Heading (...,) to a point on the centre line `lookahead` m on, at most to the dock."""
    togo, _ = track_errors(position, dock, axis)
    left = np.maximum(togo - lookahead, 0.0)
    direction = np.stack(np.broadcast_arrays(np.cos(axis), np.sin(axis)), axis=-1)
    return line_of_sight(position, dock - left[..., None] * direction)


def crab_angle(course: Value, speed: Value, current: Array) -> Array:
    """Heading (...,) that makes the course over ground: `course - asin(v_cross / U)`.

    A current across the course that is faster than the vehicle leaves it heading straight into it.

    Args:
        course: wanted direction over ground.
        speed: U through the water, m/s, > 0.
        current: (..., 2) m/s.
    """
    across = np.cos(course) * current[..., 1] - np.sin(course) * current[..., 0]
    return course - np.arcsin(np.clip(across / speed, -1.0, 1.0))


def cross_track(
    error: Value,
    integral: Value,
    rate: Value,
    axis: Value,
    gains: tuple[float, float, float] = (0.3, 0.02, 0.3),
    limit: Value = 1.0,
) -> Array:
    """Heading (...,) of a PID on the cross-track error: `axis - (P e + I sum(e dt) + D e')`.

    Args:
        error: cross-track error, m.
        integral: its sum over time, m s.
        rate: its rate, m/s.
        axis: direction of the centre line.
        gains: P rad/m, I rad/(m s), D rad s/m.
        limit: largest angle to the centre line, rad.
    """  # fmt: skip
    P, I, D = gains  # noqa: E741
    return axis - np.clip(P * np.asarray(error) + I * integral + D * rate, -limit, limit)


def touchdown_alignment(heading: Value, axis: Value, togo: Value, start: Value) -> Array:
    """Heading (...,) that turns from a law's heading to the dock's axis in the last metres.

    Blended by a cosine: `axis + (heading - axis) (1 - cos(pi togo / start)) / 2`.

    Args:
        heading: of the law used until then.
        axis: direction of the dock.
        togo: distance along the centre line, m.
        start: where the alignment begins, m, > 0.
    """
    share = 0.5 * (1.0 - np.cos(np.pi * np.clip(np.asarray(togo) / start, 0.0, 1.0)))
    return axis + share * ssa(np.asarray(heading) - axis)


def side_slip_line(axis: Value, speed: Value, current: Array, start: Value) -> Array:
    """Cross-track offset (...,) in m, upstream, of the line from which side-slip ends in the dock.

    Over the last `start` metres the vehicle heads along the dock's axis and is carried across by
    the current: it arrives on the centre line if it begins `v_cross start / v_along` upstream.

    Args:
        axis: direction of the dock.
        speed: U through the water, m/s.
        current: (..., 2) m/s; the vehicle must make way along the axis against it.
        start: where the side-slip begins, m.
    """
    c, s = np.cos(axis), np.sin(axis)
    along = speed + c * current[..., 0] + s * current[..., 1]
    across = c * current[..., 1] - s * current[..., 0]
    return -across * start / np.maximum(along, 1e-6)


def side_slip(
    position: Array,
    dock: Array,
    axis: Value,
    speed: Value,
    current: Array,
    start: Value,
    lookahead: Value = 3.0,
) -> Array:
    """Heading (...,): crab along the upstream line, then along the dock's axis (see above).

    Args:
        position, dock: (..., 2), m.
        axis, speed, current, start: as in `side_slip_line`.
        lookahead: with which the upstream line is approached, m.
    """  # fmt: skip
    togo, error = track_errors(position, dock, axis)
    missed = error - side_slip_line(axis, speed, current, start)
    course = axis - np.arctan2(missed, lookahead)
    return np.where(togo > start, crab_angle(course, speed, current), axis)


def integral_line_of_sight(
    error: Value, integral: Value, axis: Value, lookahead: Value = 3.0, share: Value = 0.3
) -> tuple[Array, Array]:
    """Heading (...,) that follows the line in an unknown current, and the rate of its integral.

    `axis - atan((e + s y) / L)`, `y' = L e / ((e + s y)^2 + L^2)` (Børhaug, Pavlov and Pettersen
    2008): the integral finds the crab angle.

    Args:
        error: cross-track error e, m.
        integral: y, m.
        axis: direction of the line.
        lookahead: L, m, > 0.
        share: s, 1/s.
    """
    seen = np.asarray(error) + share * np.asarray(integral)
    return axis - np.arctan2(seen, lookahead), lookahead * np.asarray(error) / (
        seen**2 + np.square(lookahead)
    )


def regulated_speed(error: Value, speed: Value, slowest: Value, threshold: Value) -> Array:
    """Speed (...,) that falls with the cross-track error: `slowest` at the threshold and beyond.

    Raises:
        ScenarioError: the threshold is not positive.
    """
    if not np.all(np.asarray(threshold) > 0):
        raise ScenarioError(f"speed regulation: threshold must be > 0 m, got {threshold}")
    share = np.clip(1.0 - np.abs(error) / threshold, 0.0, 1.0)
    return slowest + share * (np.asarray(speed) - slowest)


def sliding_path(
    position: Array,
    dock: Array,
    axis: Value,
    integral: Value,
    speed: Value,
    current: Array,
    begin: Value,
    slowest: Value,
    threshold: Value,
    lookahead: Value = 3.0,
) -> tuple[Array, Array, Array]:
    """Heading (...,), speed (...,) m/s and rate of the integral of the sliding path.

    Crab to a point on the centre line `begin` metres before the dock, from there integral line of
    sight along the line, slower where the cross-track error is large.

    Args:
        position, dock: (..., 2), m.
        axis: direction of the dock.
        integral: of `integral_line_of_sight`, m; it rests on the way to the point.
        speed, slowest: largest and smallest speed through the water, m/s.
        current: (..., 2) estimate for the crab angle, m/s.
        begin: distance of the point to the dock, m.
        threshold: cross-track error with the smallest speed, m.
        lookahead: of the integral line of sight, m.
    """  # fmt: skip
    togo, error = track_errors(position, dock, axis)
    direction = np.stack(np.broadcast_arrays(np.cos(axis), np.sin(axis)), axis=-1)
    point = dock - np.asarray(begin)[..., None] * direction
    far = togo > begin
    crab = crab_angle(line_of_sight(position, point), speed, current)
    follow, rate = integral_line_of_sight(error, integral, axis, lookahead)
    near = regulated_speed(error, speed, slowest, threshold)
    return np.where(far, crab, follow), np.where(far, speed, near), np.where(far, 0.0, rate)
