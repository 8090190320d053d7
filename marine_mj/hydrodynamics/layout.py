"""Offsets of the MuJoCo struct members that the native kernels read and write.

MuJoCo publishes its C structs through `mujoco.introspect`; the offsets follow from the C layout
rules. They are checked against the arrays of a tiny model and handed to the kernels through a
linker symbol, so that a kernel compiled and cached under one MuJoCo version never works with the
offsets of another.
"""

import ctypes
import glob
import os
import re
from typing import Any

import llvmlite.binding as llvm
import mujoco
import numpy as np
from mujoco.introspect import structs

from marine_mj.errors import MarineMjError

#: Members in the order in which the kernels index them (`memory.member`).
MODEL_FIELDS = (
    "nnumeric",
    "numeric_adr",
    "numeric_size",
    "numeric_data",
    "dof_parentid",
    "dof_bodyid",
    "dof_jntid",
    "jnt_type",
    "jnt_dofadr",
    "M_rowadr",
    "M_rownnz",
    "actuator_actadr",
    "actuator_dynprm",
    "opt.timestep",
    "opt.integrator",
    "opt.gravity",
    "nbody",
    "geom_bodyid",
    "body_rootid",
    "body_weldid",
    "body_dofadr",
    "body_dofnum",
)
DATA_FIELDS = (
    "time",
    "qpos",
    "qvel",
    "qacc",
    "act",
    "ctrl",
    "xpos",
    "xmat",
    "xquat",
    "subtree_com",
    "cdof",
    "cdof_dot",
    "cvel",
    "M",
    "qfrc_passive",
    "ncon",
    "contact",
    "sensordata",
    "act_dot",
)
#: Members of a contact, behind those of the data; the last number is the size of the struct.
CONTACT_FIELDS = ("geom", "dist", "pos", "frame", "size")
#: Name of the linker symbol that holds the offsets (an array of int64).
SYMBOL = "marine_mj_struct_layout"

_SCALARS = {
    "int": ctypes.c_int,
    "unsigned int": ctypes.c_uint,
    "mjtSize": ctypes.c_int64,
    "size_t": ctypes.c_size_t,
    "uintptr_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
    "mjtBool": ctypes.c_bool,
    "mjtByte": ctypes.c_ubyte,
    "char": ctypes.c_char,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
    "mjtNum": ctypes.c_double,
}
_layout = None  # keeps the memory behind SYMBOL alive


def _ctype(text: str) -> type:
    """ctypes type of a C type as the introspection prints it."""
    array = re.match(r"(.+?)\s*((?:\[\d+\])+)$", text)
    if array:
        ctype: Any = _ctype(array[1])
        for size in reversed(re.findall(r"\d+", array[2])):
            ctype = ctype * int(size)
        return ctype
    if text.endswith("*"):
        return ctypes.c_void_p
    text = text.removeprefix("const ").removeprefix("struct ").strip()
    if text in _SCALARS:
        return _SCALARS[text]
    if text in structs.STRUCTS:
        return _struct(text, structs.STRUCTS[text].fields)
    if text.startswith("mjt"):
        return ctypes.c_int  # an enum
    raise MarineMjError(
        f"MuJoCo {mujoco.__version__} has a struct member of the unknown C type {text!r}; "
        "marine_mj supports mujoco >=3.17,<4"
    )


def _struct(name: str, declarations: tuple) -> type[ctypes.Structure]:
    """ctypes structure of a MuJoCo struct (or of an anonymous one inside it)."""
    fields = []
    for number, field in enumerate(declarations):
        label = getattr(field, "name", None) or f"anonymous_{number}"
        inner = getattr(field.type, "fields", None)
        fields.append((label, _struct(label, inner) if inner else _ctype(str(field.type))))
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _offset(struct: type[ctypes.Structure], path: str) -> int:
    """Byte offset of a member such as `qvel` or `opt.timestep`."""
    offset, names = 0, path.split(".")
    for number, name in enumerate(names):
        offset += getattr(struct, name).offset
        if number < len(names) - 1:
            struct = dict(struct._fields_)[name]  # type: ignore[misc, assignment, arg-type]
    return offset


def _check(model_offsets: dict[str, int], data_offsets: dict[str, int]) -> None:
    """Raise if a computed offset does not lead to the array that the bindings show."""
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option timestep="0.0123"/><custom><numeric name="n" data="1 2"/></custom>
        <worldbody><body><freejoint name="j"/><geom size=".1"/></body></worldbody>
        <actuator><general joint="j" dyntype="integrator"/></actuator>
        <sensor><clock/></sensor></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.time = 12.345
    wrong = []
    for owner, offsets in ((model, model_offsets), (data, data_offsets)):
        for name, offset in offsets.items():
            if name == "contact":
                continue  # the bindings show no address; `_check_contacts` looks at its content
            value = owner
            for part in name.split("."):
                value = getattr(value, part)
            address = owner._address + offset
            if isinstance(value, np.ndarray):
                inline = name == "opt.gravity"
                found = address if inline else ctypes.c_size_t.from_address(address).value
                ok = found == value.__array_interface__["data"][0]
            elif isinstance(value, float):
                ok = ctypes.c_double.from_address(address).value == value
            else:
                small = name.startswith("opt.") or name == "ncon"
                kind = ctypes.c_int if small else ctypes.c_int64
                ok = kind.from_address(address).value == int(value)
            if not ok:
                wrong.append(f"{type(owner).__name__}.{name}")
    if wrong:
        raise MarineMjError(
            f"the struct layout of MuJoCo {mujoco.__version__} differs from what its introspection "
            f"says for {', '.join(wrong)}; marine_mj supports mujoco >=3.17,<4: install one"
        )


def _check_contacts(data_offsets: dict[str, int], contact: dict[str, int]) -> None:
    """Raise if two touching geoms are not found where the layout of a contact says."""
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body pos="0 0 .05"><freejoint/>
        <geom size=".1"/></body><body pos=".5 0 .05"><freejoint/><geom size=".1"/></body>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    count = ctypes.c_int.from_address(data._address + data_offsets["ncon"]).value
    first = ctypes.c_size_t.from_address(data._address + data_offsets["contact"]).value
    kinds: dict[str, Any] = {"geom": ctypes.c_int * 2, "dist": ctypes.c_double * 1}
    kinds |= {"pos": ctypes.c_double * 3, "frame": ctypes.c_double * 9}
    found = [
        [list(kind.from_address(first + i * contact["size"] + contact[name])) for i in range(2)]
        for name, kind in kinds.items()
    ]
    shown = [np.reshape(getattr(data.contact, name), (2, -1)).tolist() for name in kinds]
    if count != 2 or found != shown:
        raise MarineMjError(
            f"the contacts of MuJoCo {mujoco.__version__} are not where its introspection says; "
            "marine_mj supports mujoco >=3.17,<4: install one"
        )


def register() -> None:
    """Make libmujoco's functions and the struct offsets known to the native compiler.

    Raises:
        MarineMjError: the installed MuJoCo has no shared library or another struct layout.
    """
    global _layout
    if _layout is not None:
        return
    folder = os.path.dirname(mujoco.__file__)
    libraries = sorted(glob.glob(os.path.join(folder, "libmujoco*")))
    if not libraries:
        raise MarineMjError(
            f"no libmujoco found in the mujoco {mujoco.__version__} package; reinstall mujoco"
        )
    llvm.load_library_permanently(libraries[0])
    model_struct, data_struct, contact_struct = (
        _struct(name, structs.STRUCTS[name].fields) for name in ("mjModel", "mjData", "mjContact")
    )
    model = {name: _offset(model_struct, name) for name in MODEL_FIELDS}
    data = {name: _offset(data_struct, name) for name in DATA_FIELDS}
    contact = {name: _offset(contact_struct, name) for name in CONTACT_FIELDS if name != "size"} | {
        "size": ctypes.sizeof(contact_struct)
    }
    _check(model, data)
    _check_contacts(data, contact)
    offsets = [*model.values(), *data.values(), *contact.values()]
    _layout = (ctypes.c_int64 * len(offsets))(*offsets)
    llvm.add_symbol(SYMBOL, ctypes.cast(_layout, ctypes.c_void_p).value)
