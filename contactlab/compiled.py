"""The one place that names the compiler: decorators for numeric kernels, and where their code is kept.

Numba decides by a kernel's own file whether its machine code is still good, but a kernel holds the code
of every kernel that it calls. The code is therefore kept in a folder named after a digest of all
sources of kernels, in the package or else in the user's cache. Kernels of other packages, which may call
anything, are compiled in every session: about 0.1 s a law.
"""

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, TypeVar, cast

import numba
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import LoweringPass, PassManager, register_pass
from numba.core.typed_passes import NativeLowering

from contactlab.foreign import is_own

Function = TypeVar("Function", bound=Callable[..., object])

INTERPRETED = bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]
"""Whether NUMBA_DISABLE_JIT asks for no machine code: every kernel is the Python function that it was."""

PACKAGE = Path(__file__).parent
SOURCES = ("compiled.py", "motor/geometry.py", "variables.py", "laws/**/*.py", "engine/*.py")
"""Where kernels stand, and the constants that are compiled into them."""

PREFIX = "kernels-"
OLD = 30 * 86400.0
"""Age in seconds at which the code of other sources is given up."""


@cache
def code_folder() -> Path:
    """Return the folder of the compiled code of exactly these sources."""
    digest = sha256()
    for source in sorted(path for name in SOURCES for path in PACKAGE.glob(name)):
        digest.update(source.relative_to(PACKAGE).as_posix().encode())
        digest.update(source.read_bytes())
        # Numba goes by it, and would find a folder with other dates full of code it does not take.
        digest.update(str(source.stat().st_mtime_ns).encode())
    name = f"{PREFIX}{digest.hexdigest()[:16]}"
    users = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    for parent in [Path(chosen)] if chosen else [PACKAGE / "__pycache__", users / "contactlab"]:
        try:
            (parent / name).mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=parent / name):
                _remove_old(parent, name)
                return parent / name
        except OSError:
            continue
    # Nowhere to keep it: compile for this process alone.
    return Path(tempfile.mkdtemp(prefix="contactlab-"))


def _remove_old(parent: Path, name: str) -> None:
    """Remove the code of other sources that has not been added to for a month."""
    for folder in parent.glob(f"{PREFIX}*"):
        if folder.name != name and time.time() - folder.stat().st_mtime > OLD:
            shutil.rmtree(folder, ignore_errors=True)


class _Unit:
    """Code of a kernel and of all inner kernels that it calls, which is optimised once and as a whole.

    Left to itself the compiler makes machine code of every function, with that of all functions that it calls
    in it: four times as much as the loop has. Inner kernels therefore add theirs to the unit of the kernel
    that is being compiled, and are compiled again for another one.
    """

    open: ClassVar[list["_Unit"]] = []
    """Units being compiled, outermost first: one kernel may call another."""

    def __init__(self, library: Any) -> None:
        self.library = library
        self.parts: list[tuple[Any, tuple[Any, ...]]] = []
        """Inner kernels in it, and the types of their arguments."""

    def take_parts(self) -> list[tuple[Any, tuple[Any, ...], Any]]:
        """Remove the code of the inner kernels from them, and return it with both."""
        return [(each, key, each.overloads.pop(key)) for each, key in self.parts if key in each.overloads]


class _WholeCompiler(CompilerBase):
    """Compiles a kernel as a unit."""

    def define_pipelines(self) -> list[PassManager]:
        return [_pipeline(self.state, _CloseUnit)]

    def compile_extra(self, function: Any) -> Any:
        library = self.state.targetctx.codegen().create_library(function.__qualname__)
        library.enable_object_caching()
        unit, hidden = _Unit(library), _Unit.open[-1].take_parts() if _Unit.open else []
        _Unit.open.append(unit)
        try:
            return super().compile_extra(function)  # type: ignore[no-untyped-call]
        finally:
            _Unit.open.pop()
            for _, _, code in unit.take_parts():
                self.state.targetctx.remove_user_function(code.entry_point)
            for part, key, code in hidden:
                part.overloads[key] = code


class _PartCompiler(CompilerBase):
    """Compiles an inner kernel into the unit that is open, or by itself where none is."""

    def define_pipelines(self) -> list[PassManager]:
        if not _Unit.open:
            return [DefaultPassBuilder.define_nopython_pipeline(self.state)]
        return [_pipeline(self.state, _JoinUnit)]


def _pipeline(state: Any, last: type[LoweringPass]) -> PassManager:
    """Return the compiler's own passes, which write into the open unit, and one that makes a way in."""
    state.library, state.flags.no_compile = _Unit.open[-1].library, True
    passes: PassManager = DefaultPassBuilder.define_nopython_pipeline(state)
    passes.add_pass_after(last, NativeLowering)
    passes.finalize()
    return passes


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
        _Unit.open[-1].parts.append((_inner[state.func_id.func], tuple(state.args)))
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


_inner: dict[Callable[..., object], Any] = {}
"""Inner kernels by the functions that they are made from."""


def kernel(function: Function, **options: Any) -> Function:
    """Compile a scalar or array function on first use and keep the code of this package's.

    Division follows IEEE (`error_model="numpy"`) and no fast-math is used, so that the same input
    gives the same bits and a NaN stays visible. Kernels allocate nothing: reference counting is off,
    which the many small calls with many arrays would otherwise spend most of their time on.
    """
    made: Any = fleeting_kernel(function, pipeline_class=_WholeCompiler, **options)
    if not INTERPRETED and is_own(function):
        _keep_in(code_folder(), made)
    return cast(Function, made)


def inner_kernel(function: Function, **options: Any) -> Function:
    """Make a kernel that only kernels call, never Python.

    It has no way in from Python, and its code is kept with that of the kernels that call it.
    """
    made = fleeting_kernel(
        function, pipeline_class=_PartCompiler, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options
    )
    _inner[function] = made
    return made


def part_kernel(function: Function) -> Function:
    """Make an inner kernel that is part of its callers: a call would cost as much as its work."""
    return inner_kernel(function, forceinline=True)


def merged_kernel(function: Function) -> Function:
    """Make an inner kernel with one caller: the optimiser makes it part of that."""
    return inner_kernel(function)


def fleeting_kernel(function: Function, **options: Any) -> Function:
    """Make a kernel while the program runs, around another."""
    njit: Any = numba.njit
    return cast(Function, njit(error_model="numpy", _nrt=False, **options)(function))


def generated_kernel(name: str, source: str) -> Any:
    """Make a kernel from a source that imports this package's kernels, and keep both beside their code."""
    path = code_folder() / "generated" / f"{name}_{sha256(source.encode()).hexdigest()[:16]}.py"
    if not path.is_file():
        path.parent.mkdir(exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False) as file:
            file.write(source)
        # The same for every process that writes it: the compiler goes by it.
        os.utime(file.name, (0, 0))
        Path(file.name).replace(path)
    # The compiler finds the code of functions of known modules again.
    module = sys.modules.setdefault(f"contactlab_{path.stem}", ModuleType(f"contactlab_{path.stem}"))
    exec(compile(source, str(path), "exec"), vars(module))
    made = fleeting_kernel(vars(module)[name])
    _keep_in(code_folder(), made)
    return made


def remade(kernel: Any) -> Any:
    """Return a kernel with another's function and options, but none of its code."""
    jit: Any = numba.jit
    return jit(**kernel.targetoptions)(kernel.py_func)


def _keep_in(folder: Path, kernel: Any) -> None:
    """Let a kernel keep its code in a folder: the compiler reads the setting once, for each."""
    settings: Any = numba.config
    before, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)
    try:
        kernel.enable_caching()
    finally:
        settings.CACHE_DIR = before
