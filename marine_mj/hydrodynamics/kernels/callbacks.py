"""The native entry points that MuJoCo calls."""

import hashlib
from pathlib import Path

from numba import cfunc, njit, types

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.body import body_loads
from marine_mj.hydrodynamics.kernels.contacts import contact_sums
from marine_mj.hydrodynamics.kernels.equations import apply_loads
from marine_mj.hydrodynamics.kernels.low_frequency import low_frequency_rates
from marine_mj.hydrodynamics.kernels.memory import (
    advance,
    field,
    float_value,
    floats,
    ints,
    scratch,
    size_value,
)
from marine_mj.hydrodynamics.kernels.radiation import memory_rates

mj_makeM = types.ExternalFunction("mj_makeM", types.void(types.voidptr, types.voidptr))
mj_factorM = types.ExternalFunction("mj_factorM", types.void(types.voidptr, types.voidptr))

_NUMERICS = field("m", "nnumeric")
_NUMERIC_ADDRESS = field("m", "numeric_adr")
_NUMERIC_SIZE = field("m", "numeric_size")
_NUMERIC_DATA = field("m", "numeric_data")
_TIME = field("d", "time")
_ACT = field("d", "act")
_CTRL = field("d", "ctrl")
_ACT_ADDRESS = field("m", "actuator_actadr")
_DYNPRM = field("m", "actuator_dynprm")

_STAGE_ACC = 3  # mjSTAGE_ACC
_WORK = 15 + 6 * len(t_.CAUSES)
_INERTIAS = 36 * t_.INERTIAS
_WRENCHES = 6 * len(t_.CAUSES)


@njit
def _table_address(model):
    """Where the packed table lies in the model's numeric data; -1 on a model without one."""
    count = size_value(model, _NUMERICS)
    if count == 0:
        return -1
    address = ints(model, _NUMERIC_ADDRESS)[count - 1]
    size = ints(model, _NUMERIC_SIZE)[count - 1]
    if size < t_.FIXED_SIZE:
        return -1
    table = advance(floats(model, _NUMERIC_DATA), address)
    if table[t_.H_MAGIC] != t_.MAGIC or table[t_.H_VERSION] != t_.VERSION:
        return -1
    return address if table[t_.H_LENGTH] <= size else -1


def _source_digest() -> int:
    """Number that changes with any source of the kernels.

    numba keys its disk cache on the file of the outermost function only; the digest, closed over
    by that function, makes a change in any of them count.
    """
    digest = hashlib.sha256()
    for path in [*sorted(Path(__file__).parent.glob("*.py")), Path(t_.__file__)]:
        digest.update(path.read_bytes())
    digest.update(Path(__file__).parent.parent.joinpath("layout.py").read_bytes())
    return int.from_bytes(digest.digest()[:6], "big")


def _compile(source: int):
    """The entry points, from the disk cache where it has them."""

    @cfunc(types.void(types.voidptr, types.voidptr), cache=True)
    def passive(model, data):
        """mjcb_passive: hydrodynamic loads and added mass; nothing on a model without table."""
        address = _table_address(model)
        if address < 0 or source == 0:
            return
        table = advance(floats(model, _NUMERIC_DATA), address)
        mj_makeM(model, data)
        work, inertia = scratch(_WORK), scratch(_INERTIAS)
        nu, R, f = work, advance(work, 6), advance(work, 15)
        time = float_value(data, _TIME)
        place = int(table[t_.H_FIRST_BODY])
        for _ in range(int(table[t_.H_BODIES])):
            p = advance(table, place)
            body_loads(model, data, table, p, time, True, R, nu, f, inertia)
            apply_loads(model, data, p, R, nu, f, inertia)
            place += int(p[t_.B_SIZE])
        mj_factorM(model, data)

    @cfunc(types.void(types.voidptr, types.voidptr, types.CPointer(types.float64)), cache=True)
    def report(model, data, out):
        """Wrenches and inertias in the axes of the loads, into out (bodies, REPORT_SIZE)."""
        address = _table_address(model)
        if address < 0 or source == 0:
            return
        table = advance(floats(model, _NUMERIC_DATA), address)
        nu, R = scratch(6), scratch(9)
        time = float_value(data, _TIME)
        place = int(table[t_.H_FIRST_BODY])
        for number in range(int(table[t_.H_BODIES])):
            p = advance(table, place)
            row = advance(out, number * t_.REPORT_SIZE)
            inertia = advance(row, _WRENCHES)
            body_loads(model, data, table, p, time, False, R, nu, row, inertia)
            place += int(p[t_.B_SIZE])

    @cfunc(types.float64(types.voidptr, types.voidptr, types.int32), cache=True)
    def act_dyn(model, data, actuator):
        """mjcb_act_dyn: rate of the activation of a `dyntype="user"` actuator.

        dynprm: [law, ...]. Law 1 is a first-order lag with rate limits: [1, time constant, fastest
        fall, fastest rise]. Laws 2, radiation memory, and 3, low-frequency place, write their many
        rates themselves: [2 or 3, record].
        """
        if source == 0:
            return 0.0
        prm = advance(floats(model, _DYNPRM), 10 * actuator)
        if prm[0] == t_.RATE_LIMITED_LAG:
            act = floats(data, _ACT)[ints(model, _ACT_ADDRESS)[actuator]]
            rate = (floats(data, _CTRL)[actuator] - act) / prm[1]
            return min(max(rate, prm[2]), prm[3])
        if prm[0] == t_.RADIATION_MEMORY or prm[0] == t_.LOW_FREQUENCY:
            address = _table_address(model)
            if address >= 0:
                table = advance(floats(model, _NUMERIC_DATA), address)
                if prm[0] == t_.RADIATION_MEMORY:
                    memory_rates(model, data, table, int(prm[1]), float_value(data, _TIME))
                else:
                    low_frequency_rates(model, data, table, int(prm[1]))
        return 0.0

    @cfunc(types.void(types.voidptr, types.voidptr, types.int32), cache=True)
    def sensor(model, data, stage):
        """mjcb_sensor: the contact sensor of a marine scene."""
        if source == 0 or stage != _STAGE_ACC:
            return
        address = _table_address(model)
        if address >= 0:
            contact_sums(model, data, advance(floats(model, _NUMERIC_DATA), address))

    return passive, report, act_dyn, sensor


passive, report, act_dyn, sensor = _compile(_source_digest())
