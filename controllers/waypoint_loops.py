"""The decisions of `waypoints.DockingGuidance` as native loops over the leading dimensions.

A plan comes as one vector, `DockingPlan.values`, in the order of the names below. Vectors are in
world axes NWU; matrices turn into them. `course` is cos and sin of the carrier's heading and of
half of it. `size` and `sizes` stand for the size of a result only.
"""

from enum import IntEnum

import numpy as np
from numba import njit

from marine_mj.native_loops import native_loop


class Phase(IntEnum):
    """Where the vehicle is in the docking manoeuvre."""

    APPROACH = 0  # to waypoint 1, behind the dock and deep
    UNDER = 1  # to waypoint 2, under the carrier
    WAIT = 2  # to waypoint 3, below the aperture, moving with it
    ENTER = 3  # through the aperture
    CONTACT = 4  # pushed against the seat
    LATCHED = 5
    LEAVE = 6  # the latch has opened: out along the way in
    RETURN = 7  # back to waypoint 1
    AWAY = 8  # holds waypoint 1


#: Numbers of a `DockingPlan` of which there is one, in the order of `DockingPlan.values`.
SCALARS = (
    "approach_distance", "approach_depth", "under_depth", "wait_depth", "acceptance", "passing",
    "ride", "wait_speed", "wait_time", "quiet_rate", "patience", "retreat", "commit",
    "missed_depth", "push", "lift", "contact_time", "seat_speed", "leave_speed", "leave_depth",
    "axis",
)  # fmt: skip
(
    APPROACH_DISTANCE, APPROACH_DEPTH, UNDER_DEPTH, WAIT_DEPTH, ACCEPTANCE, PASSING,
    RIDE, WAIT_SPEED, WAIT_TIME, QUIET_RATE, PATIENCE, RETREAT, COMMIT,
    MISSED_DEPTH, PUSH, LIFT, CONTACT_TIME, SEAT_SPEED, LEAVE_SPEED, LEAVE_DEPTH,
    AXIS,
) = range(len(SCALARS))  # fmt: skip
#: Where those with more numbers begin, which follow.
CORRIDOR = len(SCALARS)
APERTURE = CORRIDOR + 2
CONTACT_SCALE = APERTURE + 2

_, _UNDER, _WAIT, _ENTER, _CONTACT, _LATCHED, _LEAVE, _RETURN, _ = map(int, Phase)
#: Opening of the corridor under the aperture (digest 6.8): half-angle 20 deg.
CORRIDOR_SLOPE = np.tan(np.deg2rad(20.0))
# Memory of the mean square of the dock's angular velocity, s: one and a half short waves.
_MEMORY = 4.0
# An entry is given up below the aperture when the dock turns this much faster than it may at the
# start: without it the decision would chatter.
_HYSTERESIS = 1.3


@njit(inline="always")
def _quiet(plan, turning, waited):
    allowed = plan[QUIET_RATE] * (1.0 + np.floor(waited / plan[PATIENCE]))
    return turning < allowed * allowed


@njit(inline="always")
def _inside(rotation, origin, point):
    """Coordinates of a point in a frame."""
    x, y, z = point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
        rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z,
    )


@njit(inline="always")
def _towards(axis, course):
    """Unit vector of the entry, level or upwards."""
    return (0.0, 0.0, 1.0) if axis == 2.0 else (course[0], course[1], 0.0)


@njit(inline="always")
def _distance(a, b):
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return np.sqrt(x * x + y * y + z * z)


@native_loop("void(f8[:], f8[:], f8[:], b1[:])", "(n),(),()->()")
def quiet(plan, turning, waited, out):
    """Whether the dock turns slowly enough, after waiting for so long."""
    out[0] = _quiet(plan, turning[0], waited[0])


@native_loop("void(i8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:])", "(),(),(),(s),()->(),()")
def watch(phase, turning, waited, twist, period, turning_now, waited_now):
    """What the vehicle has seen of the dock's turning, and for how long it has waited."""
    squared = twist[3] * twist[3] + twist[4] * twist[4] + twist[5] * twist[5]
    turning_now[0] = turning[0] + period[0] / _MEMORY * (squared - turning[0])
    waited_now[0] = 0.0
    if phase[0] == _WAIT:
        waited_now[0] = waited[0] + period[0]
    elif phase[0] == _ENTER:
        waited_now[0] = waited[0]


@native_loop(
    "void(f8[:], i8[:], f8[:], f8[:], f8[:], f8[:], f8[:,:], f8[:], f8[:], f8[:], f8[:], f8[:],"
    " f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:])",
    "(n),(),(),(),(),(p),(p,p),(p),(q),(p),(p),(p),(q),(s),(p),(q),(s),(p),(q),(s)->(p),(q),(s)",
)
def target(
    plan, phase, progress, turning, waited, carrier, rotation, carrier_velocity, course,
    aperture, aperture_velocity, goal, goal_q, goal_v, seat, seat_q, seat_v, out, out_q, out_v,
    place, attitude, twist,
):  # fmt: skip
    """State to reach in a phase; `goal` and `out` are those of ENTER and LEAVE."""
    now = phase[0]
    if now == _ENTER:
        place[:], attitude[:], twist[:] = goal, goal_q, goal_v
    elif now == _LEAVE:
        place[:], attitude[:], twist[:] = out, out_q, out_v
    elif now == _CONTACT or now == _LATCHED:
        for i in range(3):
            place[i] = aperture[i] + progress[0] * (seat[i] - aperture[i])
        attitude[:], twist[:] = seat_q, seat_v
    else:
        c, s = course[0], course[1]
        ride = plan[RIDE] != 0.0
        towards = _towards(plan[AXIS], course)
        offset = _inside(rotation, carrier, aperture)
        if now == _WAIT:
            for i in range(3):
                twist[i] = carrier_velocity[i] if ride else aperture_velocity[i]
                place[i] = aperture[i]
            if ride:  # below where the aperture would be if the carrier did not roll or pitch
                place[0] = carrier[0] + (c * offset[0] - s * offset[1])
                place[1] = carrier[1] + (s * offset[0] + c * offset[1])
                place[2] = carrier[2] + offset[2]
            depth = plan[WAIT_DEPTH]
            if plan[RETREAT] > 0.0 and not _quiet(plan, turning[0], waited[0]):
                depth += plan[RETREAT]
            for i in range(3):
                place[i] -= depth * towards[i]
        else:  # under the point of the carrier above the aperture
            for i in range(3):
                twist[i] = carrier_velocity[i] if ride else 0.0
                place[i] = carrier[i] + (rotation[i, 0] * offset[0] + rotation[i, 1] * offset[1])
                if plan[AXIS] != 2.0:
                    place[i] -= plan[WAIT_DEPTH] * towards[i]
            if now == _UNDER:
                place[2] -= plan[UNDER_DEPTH]
            else:
                place[0] -= plan[APPROACH_DISTANCE] * c
                place[1] -= plan[APPROACH_DISTANCE] * s
                place[2] = (carrier[2] if ride else 0.0) - plan[APPROACH_DEPTH]
        attitude[0], attitude[1], attitude[2], attitude[3] = course[2], 0.0, 0.0, course[3]
        x, y = twist[0], twist[1]
        twist[0], twist[1] = c * x + s * y, c * y - s * x
        twist[3:] = 0.0


@native_loop(
    "void(f8[:], i8[:], f8[:], f8[:], i8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:],"
    " f8[:], f8[:], f8[:,:], f8[:], b1[:], f8[:],"
    " i8[:], f8[:], f8[:], i8[:], f8[:], f8[:], b1[:])",
    "(n),(),(),(),(),(),(),(),(),(p),(p),(p),(p),(p),(p,p),(p),(),()->(),(),(),(),(),(),()",
)
def decide(
    plan, phase, height, progress, attempts, calm, waited, turning, pushed,
    vehicle, vehicle_velocity, carrier_velocity, goal, aperture, rotation, seat, latched, period,
    phase_now, height_now, progress_now, attempts_now, calm_now, pushed_now, entered,
):  # fmt: skip
    """The next phase; `waited` and `turning` are those of now, `goal` the target of `phase`."""
    was, step = phase[0], period[0]
    inside = _inside(rotation, aperture, vehicle)
    speed = _distance(vehicle_velocity, carrier_velocity)
    axis = int(plan[AXIS])
    high, first = inside[axis], 0 if axis == 2 else 1
    # Above the aperture plane the forks guide: no abort there.
    outside, within = False, True
    for i in range(2):
        across = abs(inside[first + i])
        outside |= high < 0 and across > plan[CORRIDOR + i] + CORRIDOR_SLOPE * max(-high, 0.0)
        within &= across <= plan[APERTURE + i]
    reached = _distance(goal, vehicle) < (plan[PASSING] if was < _WAIT else plan[ACCEPTANCE])
    ready = reached and was == _WAIT and _quiet(plan, turning[0], waited[0])
    ready &= speed < plan[WAIT_SPEED] and not outside
    calm_now[0] = calm[0] + step if ready else 0.0
    advance = reached and (was < _WAIT or was == _RETURN)
    advance |= was == _LEAVE and high < plan[ACCEPTANCE] - plan[LEAVE_DEPTH]
    advance |= ready and calm_now[0] > plan[WAIT_TIME]
    rough = not _quiet(plan, turning[0] / (_HYSTERESIS * _HYSTERESIS), waited[0])
    abort = was == _ENTER and (speed > plan[WAIT_SPEED] or outside or rough)
    abort &= not (within and high >= -plan[COMMIT])
    # The entry counts once waypoint 2 has been reached (digest 6.5).
    enters = (was == _WAIT or was == _ENTER) and within and height[0] < 0 and high >= 0
    pushed_now[0] = pushed[0] + step if was == _CONTACT else 0.0
    missed = high < -plan[MISSED_DEPTH] or pushed_now[0] > plan[CONTACT_TIME]

    now = was + 1 if advance else was
    if abort or (was == _CONTACT and missed):
        now = _WAIT
    if enters:
        now = _CONTACT
    if was == _LATCHED:
        now = _LEAVE
    if latched[0]:
        now = _LATCHED
    travel = max(_distance(seat, aperture), 1e-9)
    progress_now[0] = 0.0
    if now == _CONTACT:
        progress_now[0] = min(progress[0] + plan[SEAT_SPEED] * step / travel, 1.0)
    elif now == _LATCHED:  # the way out begins where the vehicle is latched
        progress_now[0] = high / travel
    elif now == _LEAVE:
        back = progress[0] - plan[LEAVE_SPEED] * step / travel
        progress_now[0] = max(back, -plan[LEAVE_DEPTH] / travel)
    phase_now[0], height_now[0], entered[0] = now, high, enters
    attempts_now[0] = attempts[0] + (1 if enters else 0)


@native_loop(
    "void(f8[:], i8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], b1[:])",
    "(n),(),(q),(p),(s)->(s),(p),(s),()",
)
def command(plan, phase, course, size, sizes, scale, push, follow, riding):
    """Factors on the pose error, push, and what of the carrier's acceleration the target has."""
    now = phase[0]
    ride = plan[RIDE] != 0.0 and (now <= _WAIT or now >= _RETURN)
    still = (now <= _UNDER or now >= _RETURN) and not ride
    linear = now == _WAIT or ride  # not what turns it
    towards = _towards(plan[AXIS], course)
    for i in range(6):
        scale[i] = 0.0 if now == _LATCHED else 1.0  # latched: what the controller sums up rests
        follow[i] = 0.0 if still or (linear and i >= 3) else 1.0
        if now == _CONTACT:
            scale[i] = plan[CONTACT_SCALE + i]
    for i in range(3):
        push[i] = plan[PUSH] * towards[i] if now == _CONTACT else 0.0
    if now == _CONTACT:
        push[2] += plan[LIFT]
    riding[0] = ride
