"""Installing the native callbacks, and the self-test that guards them."""

import ctypes
from typing import Any

import mujoco
import numpy as np

from marine_mj.errors import MarineMjError, ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import layout
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernel_cache import compile_kernels


def _refuse_python_callbacks() -> None:
    """Raise if a Python function is installed: with one, MuJoCo compiles no model any more."""
    for name in ("mjcb_passive", "mjcb_act_dyn", "mjcb_sensor"):
        present = getattr(mujoco, f"get_{name}")()
        if present is not None and _address(present) is None:
            _refuse(name, present)


def _refuse(name: str, present: object) -> None:
    """Raise because of somebody else's callback."""
    raise MarineMjError(
        f"MuJoCo's {name} is already set to {present!r} and MuJoCo has room for one only: remove "
        f"it with mujoco.set_{name}(None) before importing marine_mj or loading a marine model"
    )


#: Base class of ctypes function pointers.
_NATIVE: Any = ctypes.CFUNCTYPE(None).__mro__[1]


def _address(callback: Any) -> int | None:
    """Address of a native callback as MuJoCo returns it, None for no or a Python callback."""
    if callback is None or not isinstance(callback, _NATIVE):
        return None
    return ctypes.cast(callback, ctypes.c_void_p).value


_refuse_python_callbacks()
layout.register()  # before the kernels compile
compile_kernels()

from marine_mj.hydrodynamics.kernels import callbacks

_REPORT = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(
    callbacks.report.address
)


def install() -> None:
    """Install our callbacks; called on import and by every marine load.

    Raises:
        MarineMjError: another library has installed a callback of its own.
    """
    for name, get, set_, ours in (
        ("mjcb_passive", mujoco.get_mjcb_passive, mujoco.set_mjcb_passive, callbacks.passive),
        ("mjcb_act_dyn", mujoco.get_mjcb_act_dyn, mujoco.set_mjcb_act_dyn, callbacks.act_dyn),
        ("mjcb_sensor", mujoco.get_mjcb_sensor, mujoco.set_mjcb_sensor, callbacks.sensor),
    ):
        present = get()
        if present is not None and _address(present) != ours.address:
            _refuse(name, present)
        set_(ours.ctypes)


def table_slice(model: mujoco.MjModel) -> slice | None:
    """Where the packed table lies in `model.numeric_data`; None for a plain model."""
    if model.nnumeric == 0:
        return None
    start, size = int(model.numeric_adr[-1]), int(model.numeric_size[-1])
    marked = size >= t_.FIXED_SIZE and model.numeric_data[start + t_.H_MAGIC] == t_.MAGIC
    return slice(start, start + size) if marked else None


def table_of(model: mujoco.MjModel) -> Array:
    """The packed table, a view into the model.

    Raises:
        ModelError: the model has none.
    """
    place = table_slice(model)
    if place is None:
        raise ModelError(
            "this model has no hydrodynamics table: make it with marine_mj.load, "
            "marine_mj.load_xml or marine_mj.hydrodynamics.compile_spec"
        )
    table = model.numeric_data[place]
    if table[t_.H_VERSION] != t_.VERSION:
        raise ModelError(
            f"the hydrodynamics table of this model has the layout version "
            f"{table[t_.H_VERSION]:g}, this marine_mj reads {t_.VERSION:g}: load the model again "
            "from its MJCF"
        )
    if table[t_.H_LENGTH] > len(table):
        raise ModelError(
            f"the hydrodynamics table of this model is damaged: it names a length of "
            f"{table[t_.H_LENGTH]:g} but has {len(table)} numbers: load the model again"
        )
    return table


def records(table: Array) -> list[Array]:
    """Views of the body records in a packed table, in its order."""
    place, found = int(table[t_.H_FIRST_BODY]), []
    for _ in range(int(table[t_.H_BODIES])):
        size = int(table[place + t_.B_SIZE])
        found.append(table[place : place + size])
        place += size
    return found


def report(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Raw report (bodies, REPORT_SIZE) of the kernel for the state in `data` (mj_forward first)."""
    table = table_of(model)
    out = np.zeros((int(table[t_.H_BODIES]), t_.REPORT_SIZE))
    _REPORT(model._address, data._address, out.ctypes.data)
    return out


def self_test() -> None:
    """One forward pass with a known answer, before any user model is touched.

    A sphere of 1000 kg in water that displaces 2000 kg, with the added mass of 1000 kg of a sphere,
    released from rest: `a = (2000 - 1000) g / (1000 + 1000)`.

    Raises:
        MarineMjError: the native kernel gives another acceleration.
    """
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="b", pos=[0, 0, -50], mass=1000, inertia=[9, 9, 9])
    body.explicitinertial = True
    body.simple = False
    body.add_freejoint()
    record = np.zeros(t_.B_FIXED_SIZE)
    record[[t_.B_SIZE, t_.B_BODY, t_.B_ROOT, t_.B_LAST_DOF]] = t_.B_FIXED_SIZE, 1, 1, 5
    record[[t_.B_CHAIN, t_.B_FREE, t_.B_VOLUME]] = 6, 1, 2
    record[t_.B_ADDED_MASS + np.array([0, 7, 14])] = 1000
    fixed = np.zeros(t_.FIXED_SIZE)
    fixed[[t_.H_MAGIC, t_.H_VERSION, t_.H_BODIES]] = t_.MAGIC, t_.VERSION, 1
    fixed[[t_.H_FIRST_BODY, t_.H_LENGTH]] = t_.FIXED_SIZE, t_.FIXED_SIZE + t_.B_FIXED_SIZE
    fixed[[t_.E_DENSITY, t_.E_GRAVITY]] = 1000, 9.81
    values = np.concatenate([fixed, record])
    spec.add_numeric(name=t_.NAME, data=values, size=len(values))
    model = spec.compile()
    model.opt.gravity[:] = 0, 0, -9.81
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    expected = np.array([0, 0, 4.905, 0, 0, 0])
    if not np.allclose(data.qacc, expected, atol=1e-9):
        raise MarineMjError(
            f"the native kernel gives the acceleration {data.qacc} in its self-test, expected is "
            f"{expected}: MuJoCo {mujoco.__version__} is not one that marine_mj works with "
            "(>=3.17,<4), or the kernel cache is damaged: delete the __pycache__ folders of "
            "marine_mj and ~/.cache/numba"
        )
