"""What contacts do to each other's vehicles, summed at every step for the scene's user sensor."""

from numba import njit, types

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.memory import (
    advance,
    contact_at,
    field,
    float_value,
    floats,
    inline_floats,
    inline_ints,
    int_value,
    ints,
    scratch,
)

mj_contactForce = types.ExternalFunction(
    "mj_contactForce",
    types.void(types.voidptr, types.voidptr, types.int32, types.CPointer(types.float64)),
)

_COUNT = field("d", "ncon")
_CONTACTS = field("d", "contact")
_SENSORDATA = field("d", "sensordata")
_QVEL = field("d", "qvel")
_QACC = field("d", "qacc")
_CDOF = field("d", "cdof")
_SUBTREE_COM = field("d", "subtree_com")
_GEOMS = field("c", "geom")
_DIST = field("c", "dist")
_POS = field("c", "pos")
_FRAME = field("c", "frame")
_SIZE = field("c", "size")
_TIMESTEP = field("m", "opt.timestep")
_GEOM_BODY = field("m", "geom_bodyid")
_ROOT = field("m", "body_rootid")
_WELD = field("m", "body_weldid")
_DOF_ADDRESS = field("m", "body_dofadr")
_DOF_NUMBER = field("m", "body_dofnum")
_DOF_PARENT = field("m", "dof_parentid")


@njit
def _add_velocity(model, data, body, x, sign, out):
    """out (6) += sign * [velocity of `body` at the point x; its angular velocity], world axes.

    In the middle of the step, v + h/2 a: then force times way is the energy that the semi-implicit
    integrators take out of the motion.
    """
    moving = ints(model, _WELD)[body]
    count = ints(model, _DOF_NUMBER)[moving]
    if count == 0:
        return
    com = advance(floats(data, _SUBTREE_COM), 3 * ints(model, _ROOT)[body])
    rx, ry, rz = x[0] - com[0], x[1] - com[1], x[2] - com[2]
    half = 0.5 * float_value(model, _TIMESTEP)
    velocity, acceleration = floats(data, _QVEL), floats(data, _QACC)
    parents = ints(model, _DOF_PARENT)
    dof = ints(model, _DOF_ADDRESS)[moving] + count - 1
    while dof >= 0:
        c = advance(floats(data, _CDOF), 6 * dof)
        rate = sign * (velocity[dof] + half * acceleration[dof])
        out[0] += rate * (c[3] + c[1] * rz - c[2] * ry)
        out[1] += rate * (c[4] + c[2] * rx - c[0] * rz)
        out[2] += rate * (c[5] + c[0] * ry - c[1] * rx)
        for i in range(3):
            out[3 + i] += rate * c[i]
        dof = parents[dof]


@njit
def _power(model, data, contact, bodies, wrench):
    """Power [W] that a contact with this wrench (6, contact frame) takes out of two bodies."""
    slip = scratch(6)
    for i in range(6):
        slip[i] = 0.0
    x, frame = inline_floats(contact, _POS), inline_floats(contact, _FRAME)
    _add_velocity(model, data, int(bodies[1]), x, 1.0, slip)
    _add_velocity(model, data, int(bodies[0]), x, -1.0, slip)
    total = 0.0
    for i in range(3):
        for j in range(3):
            total -= frame[3 * i + j] * (wrench[i] * slip[j] + wrench[3 + i] * slip[3 + j])
    return total


@njit
def contact_sums(model, data, table):
    """Fill the contact sensor; table.CONTACT_SENSOR says with what."""
    place = int(table[t_.H_SENSOR]) - 1
    if place < 0:
        return
    out = advance(floats(data, _SENSORDATA), place)
    for i in range(t_.CONTACT_VALUES):
        out[i] = 0.0
    count = int_value(data, _COUNT)
    if count == 0:
        return
    wrench, bodies = scratch(6), scratch(2)
    bed = int(table[t_.E_BED]) - 1
    body, root = ints(model, _GEOM_BODY), ints(model, _ROOT)
    forbidden = advance(table, int(table[t_.H_FORBIDDEN_DATA]))
    for number in range(count):
        contact = contact_at(data, _CONTACTS, _SIZE, number)
        geoms = inline_ints(contact, _GEOMS)
        first, second = geoms[0], geoms[1]
        if first < 0 or second < 0 or first == bed or second == bed:
            continue  # the sea bed is neither a vehicle nor a dock
        if root[body[first]] != root[body[second]]:
            mj_contactForce(model, data, number, wrench)
            bodies[0], bodies[1] = body[first], body[second]
            out[t_.S_FORCE] += abs(wrench[0])
            out[t_.S_POWER] += _power(model, data, contact, bodies, wrench)
            out[t_.S_PENETRATION] = max(out[t_.S_PENETRATION], -float_value(contact, _DIST))
        for k in range(int(table[t_.H_FORBIDDEN])):
            if forbidden[k] == first or forbidden[k] == second:
                out[t_.S_FORBIDDEN] += 1.0
