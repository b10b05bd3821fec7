"""Machine code of a kernel and of all inner kernels that it calls, optimised once and as a whole.

Left to itself the compiler makes machine code of every function, with that of all functions that it calls in
it: four times as much as the engine's loop has. Here inner kernels add theirs to the unit of the kernel
that is being compiled, and are compiled again for another one.

It is written with Numba's interface for compilers of one's own (`pipeline_class` of `numba.jit`, passes) and,
beyond what that documents, with the libraries of code that passes write into.
`contactlab.compiler.kernels.units` therefore tries it with `around`, and does without where it fails.
"""

from collections.abc import Callable
from hashlib import sha256
from typing import Any, ClassVar, cast

from numba import njit
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import LoweringPass, PassManager, register_pass
from numba.core.funcdesc import default_mangler
from numba.core.typed_passes import (
    InlineOverloads,
    IRLegalization,
    NativeLowering,
    NoPythonBackend,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.types import unliteral
from numba.core.untyped_passes import (
    DeadBranchPrune,
    FixupArgs,
    GenericRewrites,
    IRProcessing,
    ReconstructSSA,
    RewriteSemanticConstants,
    TranslateByteCode,
)

inner: dict[Callable[..., object], Any] = {}
"""Inner kernels by the functions that they are made from."""


def ignore_literals(kernel: Any) -> None:
    """Let an inner kernel be compiled once for all values of a number, not again for each literal."""
    template = kernel.get_call_template
    kernel.get_call_template = lambda arguments, named: template(tuple(map(unliteral, arguments)), named)


class Unit:
    """Code of a kernel and of the inner kernels that it calls."""

    open: ClassVar[list["Unit"]] = []
    """Units being compiled, outermost first: one kernel may call another."""

    def __init__(self, library: Any) -> None:
        self.library = library
        self.parts: list[tuple[Any, tuple[Any, ...]]] = []
        """Inner kernels in it, and the types of their arguments."""

    def take_parts(self) -> list[tuple[Any, tuple[Any, ...], Any]]:
        """Remove the code of the inner kernels from them, and return it with both."""
        return [(each, key, each.overloads.pop(key)) for each, key in self.parts if key in each.overloads]


class _Flags(Flags):
    """Options of the compiler, compared by those that are set: they are in every key of its own caches."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Flags) and self._values == other._values

    __hash__ = Flags.__hash__


class _Compiler(CompilerBase):
    """Compiles with names of the types and with options that are soon compared."""

    def compile_extra(self, function: Any) -> Any:
        """Compile a function."""
        self.state.targetctx.mangler = short_name
        self.state.flags = _Flags(self.state.flags)  # type: ignore[no-untyped-call]
        return super().compile_extra(function)  # type: ignore[no-untyped-call]


class WholeCompiler(_Compiler):
    """Compiles a kernel as a unit."""

    def define_pipelines(self) -> list[PassManager]:
        """Return the only one."""
        return [_pipeline(self.state, _CloseUnit)]

    def compile_extra(self, function: Any) -> Any:
        """Compile a function into a unit of its own."""
        library = self.state.targetctx.codegen().create_library(function.__qualname__)
        library.enable_object_caching()
        unit, hidden = Unit(library), Unit.open[-1].take_parts() if Unit.open else []
        Unit.open.append(unit)
        try:
            return super().compile_extra(function)
        finally:
            Unit.open.pop()
            for _, _, code in unit.take_parts():
                self.state.targetctx.remove_user_function(code.entry_point)
            for part, key, code in hidden:
                part.overloads[key] = code


class PartCompiler(_Compiler):
    """Compiles an inner kernel into the unit that is open, or by itself where none is."""

    def define_pipelines(self) -> list[PassManager]:
        """Return the only one."""
        if not Unit.open:
            return [DefaultPassBuilder.define_nopython_pipeline(self.state)]
        return [_pipeline(self.state, _JoinUnit)]


def short_name(name: str, types: Any, **rest: Any) -> str:
    """Return a name with a digest of the arguments' types, which are records of hundreds of fields.

    The compiler itself numbers functions and records, anew in every process: code of other types that another
    process has made may then have the same name, and what is loaded first is called for both.
    """
    digest = sha256(repr(types).encode()).hexdigest()[:16]
    return cast(str, default_mangler(f"{name}_{digest}", (), **rest))


def _pipeline(state: Any, last: type[LoweringPass]) -> PassManager:
    """Return the compiler's own passes, which write into the open unit, and one that makes a way in.

    Those for closures, `with` statements, array expressions and parallel loops are left out: kernels have
    none.
    """
    state.library, state.flags.no_compile = Unit.open[-1].library, True
    passes: Any = PassManager("unit")
    for each in (
        *(TranslateByteCode, FixupArgs, IRProcessing, RewriteSemanticConstants, DeadBranchPrune),
        *(GenericRewrites, ReconstructSSA, NopythonTypeInference, PreLowerStripPhis, InlineOverloads),
        *(IRLegalization, NativeLowering, last, NoPythonBackend),
    ):
        passes.add_pass(each, each.__name__)
    passes.finalize()
    return cast(PassManager, passes)


@register_pass(mutates_CFG=False, analysis_only=False)
class _JoinUnit(LoweringPass):
    """Lets other functions of the unit call an inner kernel."""

    _name = "join_unit"

    def __init__(self) -> None:
        super().__init__()  # type: ignore[no-untyped-call]

    def run_pass(self, state: Any) -> bool:
        # There is no way in from Python; the compiler knows the code by any built-in function of its own.
        way_in = state.cr.env.__sizeof__
        state.targetctx.insert_user_function(way_in, state.cr.fndesc)
        state.cr = state.cr._replace(cfunc=way_in)
        Unit.open[-1].parts.append((inner[state.func_id.func], tuple(state.args)))
        return True


@register_pass(mutates_CFG=False, analysis_only=False)
class _CloseUnit(LoweringPass):
    """Makes the unit's machine code, of which only the kernel can be called from outside."""

    _name = "close_unit"

    def __init__(self) -> None:
        super().__init__()  # type: ignore[no-untyped-call]

    def run_pass(self, state: Any) -> bool:
        made, library = state.cr.fndesc, state.library
        seen = made.llvm_func_name, made.llvm_cpython_wrapper_name, made.llvm_cfunc_wrapper_name
        for function in library.get_defined_functions():
            if function.name not in seen:
                function.linkage = "internal"
        way_in = state.targetctx.get_executable(library, made, state.cr.env)
        state.targetctx.insert_user_function(way_in, made, [library])
        state.cr = state.cr._replace(cfunc=way_in)
        return True


def _by(compiler: type[CompilerBase], **options: Any) -> Callable[[Callable[[float], float]], Any]:
    jit: Any = njit
    return cast(Callable[..., Any], jit(pipeline_class=compiler, **options))


@_by(PartCompiler, no_cpython_wrapper=True, no_cfunc_wrapper=True)
def _third(x: float) -> float:
    return x / 3.0


@_by(WholeCompiler)
def _within(x: float) -> Any:
    return _third(x) + 1.0


@_by(WholeCompiler)
def around(x: float) -> Any:
    """Compute 2 x/3 + 1 by a kernel that calls an inner kernel and another kernel, which shares it."""
    return _third(x) + _within(x)


inner[_third.py_func] = _third
