"""What contacts do to each other's vehicles, summed at every step for the scene's user sensor."""

from numba import njit, types

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.memory import (
    advance,
    contact_at,
    field,
    floats,
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
_GEOMS = field("c", "geom")
_SIZE = field("c", "size")
_GEOM_BODY = field("m", "geom_bodyid")
_ROOT = field("m", "body_rootid")


@njit
def contact_sums(model, data, table):
    """Fill the contact sensor: sum of normal forces between vehicles, forbidden geoms touched."""
    place = int(table[t_.H_SENSOR]) - 1
    if place < 0:
        return
    out = advance(floats(data, _SENSORDATA), place)
    out[0] = 0.0
    out[1] = 0.0
    count = int_value(data, _COUNT)
    if count == 0:
        return
    wrench = scratch(6)
    body, root = ints(model, _GEOM_BODY), ints(model, _ROOT)
    forbidden = advance(table, int(table[t_.H_FORBIDDEN_DATA]))
    for number in range(count):
        geoms = inline_ints(contact_at(data, _CONTACTS, _SIZE, number), _GEOMS)
        first, second = geoms[0], geoms[1]
        if first < 0 or second < 0:
            continue
        if root[body[first]] != root[body[second]]:
            mj_contactForce(model, data, number, wrench)
            out[0] += abs(wrench[0])
        for k in range(int(table[t_.H_FORBIDDEN])):
            if forbidden[k] == first or forbidden[k] == second:
                out[1] += 1.0
