"""Lanes as a number type of the compiler: eight float64 in one register, LLVM's <8 x double>.

Of loops over arrays of so few numbers LLVM makes no vectors; a vector that is written stays one. Every
instruction is that of IEEE in each lane. The type is made with Numba's interface for types of one's own
(`numba.extending`); its functions are those of `contactlab.compiler.lanes`, which interpreted kernels call.
"""

import operator
from collections.abc import Callable
from functools import partial, reduce
from typing import Any, Final, final

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model

from contactlab.compiler import lanes
from contactlab.compiler.lanes import COUNT, WIDTH


@final
class LanesType(types.Type):
    """The type of lanes."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES: Final = LanesType()
NUMBERS, ROWS = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
"""Arrays of numbers, or of lanes as rows."""

_REAL, _INDEX = ir.DoubleType(), ir.IntType(32)
_REGISTER = ir.VectorType(_REAL, WIDTH)
_NOTHING = ir.Constant(_REGISTER, ir.Undefined)


@register_model(LanesType)
class _Model(models.PrimitiveModel):
    """Lanes are one register."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _REGISTER)  # type: ignore[no-untyped-call]


def _define(function: Any, result: Any, *kinds: Any) -> Callable[[Callable[..., Any]], Any]:
    """Define a function by code that emits its instructions, from a builder and the arguments' values.

    Of an array, a kind NUMBERS or ROWS, the value is the pointer to its first number.
    """

    def fits(kind: Any, argument: Any) -> bool:
        if isinstance(kind, types.Array):
            array = isinstance(argument, types.Array) and argument.dtype == types.float64
            return array and argument.ndim == kind.ndim and argument.layout == "C"
        if kind == types.float64:
            return isinstance(argument, types.Float | types.Integer)
        return isinstance(argument, types.Integer) if kind == types.intp else argument == kind

    def fit(arguments: Any) -> bool:
        return len(arguments) == len(kinds) and all(map(fits, kinds, arguments))

    def register(emit: Callable[..., Any]) -> Any:
        @infer_global(function)
        class _Template(AbstractTemplate):
            def generic(self, arguments: Any, keywords: Any) -> Any:
                if keywords or not fit(arguments):
                    return None
                taken = (
                    a if isinstance(kind, types.Array) else kind
                    for kind, a in zip(kinds, arguments, strict=True)
                )
                return signature(result, *taken)

        # The compiler finds code by the class of an array: of one or two axes the emitters tell.
        _emitters.setdefault(function, []).append((fit, emit))

        def lower(context: Any, builder: Any, made: Any, values: Any) -> Any:
            ready = [
                context.make_array(kind)(context, builder, value).data
                if isinstance(kind, types.Array)
                else value
                for kind, value in zip(made.args, values, strict=True)
            ]
            chosen = next(each for fit_, each in _emitters[function] if fit_(made.args))
            emitted = chosen(builder, *ready)
            return context.get_dummy_value() if result == types.void else emitted

        lower_builtin(function, *(types.Array if isinstance(kind, types.Array) else kind for kind in kinds))(
            lower
        )
        return emit

    return register


_emitters: dict[Any, list[tuple[Callable[..., bool], Callable[..., Any]]]] = {}
"""What emits the instructions of a function, by the arguments that it takes."""


def _shuffled(builder: Any, left: Any, right: Any, order: list[int]) -> Any:
    return builder.shuffle_vector(left, right, ir.Constant(ir.VectorType(_INDEX, len(order)), order))


@_define(lanes.fill, LANES, types.float64)
def filled(builder: Any, number: Any) -> Any:
    """Emit lanes that all are one number."""
    first = builder.insert_element(_NOTHING, number, _INDEX(0))
    return _shuffled(builder, first, _NOTHING, [0] * WIDTH)


def _define_binary(function: Any, emit: Callable[..., Any]) -> None:
    """Define a function of two lanes, or of lanes and a number."""
    _define_mixed(function, emit, (LANES, LANES), (LANES, types.float64), (types.float64, LANES))


def _define_mixed(function: Any, emit: Callable[..., Any], *signatures: tuple[Any, ...]) -> None:
    """Define a function of lanes and numbers by what it does to lanes."""

    def by_filling(builder: Any, *values: Any) -> Any:
        return emit(builder, *(v if v.type == _REGISTER else filled(builder, v) for v in values))

    for kinds in signatures:
        _define(function, LANES, *kinds)(by_filling)


def _added(builder: Any, left: Any, right: Any) -> Any:
    return builder.fadd(left, right)


def _larger(builder: Any, left: Any, right: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", right, left), right, left)


_define_binary(operator.add, _added)
_define_binary(operator.sub, lambda builder, left, right: builder.fsub(left, right))
_define_binary(operator.mul, lambda builder, left, right: builder.fmul(left, right))
_define_binary(operator.truediv, lambda builder, left, right: builder.fdiv(left, right))
_define_binary(lanes.larger, _larger)
_define_binary(
    lanes.smaller,
    lambda builder, left, right: builder.select(builder.fcmp_ordered("<", right, left), right, left),
)


_define_mixed(
    lanes.where_less,
    lambda builder, left, right, value, other: builder.select(
        builder.fcmp_ordered("<", left, right), value, other
    ),
    (LANES, LANES, LANES, LANES),
    (LANES, LANES, LANES, types.float64),
    (LANES, LANES, types.float64, LANES),
)


def _by_instruction(name: str) -> Callable[..., Any]:
    """Return what emits an instruction of LLVM's own of one number, or of each lane."""

    def emit(builder: Any, value: Any) -> Any:
        kind = value.type
        called = f"llvm.{name}.{f'v{WIDTH}f64' if kind == _REGISTER else 'f64'}"
        instruction = cgutils.get_or_insert_function(builder.module, ir.FunctionType(kind, [kind]), called)
        return builder.call(instruction, [value])

    return emit


_define(operator.neg, LANES, LANES)(lambda builder, value: builder.fneg(value))
_define(abs, LANES, LANES)(_by_instruction("fabs"))
_define(lanes.root, LANES, LANES)(_by_instruction("sqrt"))
_define(lanes.root, types.float64, types.float64)(_by_instruction("sqrt"))


@_define(operator.getitem, types.float64, LANES, types.intp)
def _lane(builder: Any, register: Any, i: Any) -> Any:
    return builder.extract_element(register, builder.trunc(i, _INDEX))


@_define(lanes.put, LANES, LANES, types.intp, types.float64)
def _changed(builder: Any, register: Any, i: Any, number: Any) -> Any:
    return builder.insert_element(register, number, builder.trunc(i, _INDEX))


@_define(lanes.load, LANES, NUMBERS)
def loaded(builder: Any, first: Any) -> Any:
    """Emit the numbers from a pointer on as lanes."""
    # Four at once and the fifth by itself, that no number behind the array is read.
    pointer = builder.bitcast(first, ir.VectorType(_REAL, 4).as_pointer())
    four, fifth = builder.load(pointer, align=8), builder.load(builder.gep(first, [_INDEX(4)]))
    rest = builder.insert_element(ir.Constant(four.type, [0.0] * 4), fifth, _INDEX(0))
    return _shuffled(builder, four, rest, [*range(WIDTH)])


@_define(lanes.load_all, LANES, NUMBERS)
def _loaded_all(builder: Any, first: Any) -> Any:
    return builder.load(builder.bitcast(first, _REGISTER.as_pointer()), align=8)


@_define(lanes.store, types.void, NUMBERS, LANES)
def stored(builder: Any, first: Any, register: Any) -> None:
    """Emit the setting of the numbers from a pointer on to lanes."""
    four = _shuffled(builder, register, _NOTHING, [0, 1, 2, 3])
    builder.store(four, builder.bitcast(first, four.type.as_pointer()), align=8)
    fifth = builder.extract_element(register, _INDEX(4))
    builder.store(fifth, builder.gep(first, [_INDEX(4)]))


@_define(lanes.entry, types.float64, NUMBERS, types.intp)
def _number(builder: Any, first: Any, m: Any) -> Any:
    return builder.load(builder.gep(first, [m]))


@_define(lanes.set_entry, types.void, NUMBERS, types.intp, types.float64)
def _set_number(builder: Any, first: Any, m: Any, value: Any) -> None:
    builder.store(value, builder.gep(first, [m]))


def _row(builder: Any, first: Any, m: Any) -> Any:
    return builder.gep(first, [builder.mul(m, ir.Constant(m.type, WIDTH))])


@_define(lanes.entry, LANES, ROWS, types.intp)
def _lanes_of_row(builder: Any, first: Any, m: Any) -> Any:
    return _loaded_all(builder, _row(builder, first, m))


@_define(lanes.set_entry, types.void, ROWS, types.intp, LANES)
def _set_row(builder: Any, first: Any, m: Any, register: Any) -> None:
    row = builder.bitcast(_row(builder, first, m), _REGISTER.as_pointer())
    builder.store(register, row, align=8)


def _define_folded(function: Any, count: int, emit: Callable[..., Any]) -> None:
    """Define a function of two numbers, taken of the first lanes one after another."""

    def fold(builder: Any, register: Any) -> Any:
        lanes_used = (builder.extract_element(register, _INDEX(i)) for i in range(count))
        return reduce(partial(emit, builder), lanes_used)

    _define(function, types.float64, LANES)(fold)


_define_folded(lanes.total_of, COUNT, _added)
_define_folded(lanes.total_of_all, WIDTH, _added)
_define_folded(lanes.largest, COUNT, _larger)
_define_folded(lanes.largest_of_all, WIDTH, _larger)
