"""Raw memory access of the native kernels: struct members, scratch arrays, bit patterns."""

import llvmlite.ir as ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from marine_mj.hydrodynamics.layout import CONTACT_FIELDS, DATA_FIELDS, MODEL_FIELDS, SYMBOL

_FIELDS = [
    *(("m", name) for name in MODEL_FIELDS),
    *(("d", name) for name in DATA_FIELDS),
    *(("c", name) for name in CONTACT_FIELDS),
]


def field(owner: str, name: str) -> int:
    """Index of a member of mjModel (`"m"`), mjData (`"d"`) or mjContact (`"c"`) in the layout."""
    return _FIELDS.index((owner, name))


def _offset(builder, index):
    """Entry `index` of the registered layout."""
    array = ir.ArrayType(ir.IntType(64), len(_FIELDS))
    module = builder.module
    symbol = module.globals.get(SYMBOL)
    if symbol is None:
        symbol = ir.GlobalVariable(module, array, SYMBOL)
        symbol.linkage = "external"
    return builder.load(builder.gep(symbol, [ir.Constant(ir.IntType(32), 0), index]))


def _address(builder, base, index):
    """LLVM address of member `index` of the struct at `base`."""
    return builder.gep(base, [_offset(builder, index)])


def _pointer_member(numba_type, llvm_type):
    @intrinsic
    def load(typingctx, base, index):
        def codegen(context, builder, signature, args):
            address = _address(builder, args[0], args[1])
            slot = builder.bitcast(address, llvm_type.as_pointer().as_pointer())
            return builder.load(slot)

        return types.CPointer(numba_type)(types.voidptr, types.int64), codegen

    return load


def _value_member(numba_type, llvm_type):
    @intrinsic
    def load(typingctx, base, index):
        def codegen(context, builder, signature, args):
            address = _address(builder, args[0], args[1])
            return builder.load(builder.bitcast(address, llvm_type.as_pointer()))

        return numba_type(types.voidptr, types.int64), codegen

    return load


#: Pointer-valued member: array of float64 / int32.
floats = _pointer_member(types.float64, ir.DoubleType())
ints = _pointer_member(types.int32, ir.IntType(32))
#: Value member: one float64 / int64 / int32.
float_value = _value_member(types.float64, ir.DoubleType())
size_value = _value_member(types.int64, ir.IntType(64))
int_value = _value_member(types.int32, ir.IntType(32))


@intrinsic
def inline_ints(typingctx, base, index):
    """Pointer to an int32 array that lies inside the struct itself."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(_address(builder, *args), ir.IntType(32).as_pointer())

    return types.CPointer(types.int32)(types.voidptr, types.int64), codegen


@intrinsic
def contact_at(typingctx, data, contacts, size, number):
    """Pointer to contact `number`, from the layout's entries for the list and the struct size."""

    def codegen(context, builder, signature, args):
        slot = builder.bitcast(
            _address(builder, args[0], args[1]), ir.IntType(8).as_pointer().as_pointer()
        )
        stride = _offset(builder, args[2])
        return builder.gep(builder.load(slot), [builder.mul(stride, args[3])])

    return types.voidptr(types.voidptr, types.int64, types.int64, types.int64), codegen


@intrinsic
def inline_floats(typingctx, base, index):
    """Pointer to a float64 array that lies inside the struct itself."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(_address(builder, *args), ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(types.voidptr, types.int64), codegen


@intrinsic
def scratch(typingctx, size):
    """Pointer to `size` (a literal) uninitialised float64 on the stack of the caller."""
    if not isinstance(size, types.IntegerLiteral):
        return None
    number = size.literal_value

    def codegen(context, builder, signature, args):
        return cgutils.alloca_once(
            builder, ir.DoubleType(), size=ir.Constant(ir.IntType(64), number)
        )

    return types.CPointer(types.float64)(size), codegen


@intrinsic
def advance(typingctx, pointer, count):
    """Pointer `count` elements further."""

    def codegen(context, builder, signature, args):
        return builder.gep(args[0], [args[1]])

    return types.CPointer(types.float64)(types.CPointer(types.float64), types.int64), codegen


@intrinsic
def power_of_two(typingctx, exponent):
    """2**exponent for an integral float64 in [-1022, 1023]; vectorises without AVX-512."""

    def codegen(context, builder, signature, args):
        shifted = builder.fadd(args[0], ir.Constant(ir.DoubleType(), 6755399441055744.0 + 1023.0))
        bits = builder.bitcast(shifted, ir.IntType(64))
        return builder.bitcast(builder.shl(bits, ir.Constant(ir.IntType(64), 52)), ir.DoubleType())

    return types.float64(types.float64), codegen
