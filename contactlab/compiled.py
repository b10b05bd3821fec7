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
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
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
    """The code of a kernel and of all inner kernels that it calls, which the optimiser sees once and whole.

    By itself the compiler makes machine code of every function, with all that it calls in it: of the loop's
    code four times as much as there is. Inner kernels therefore put theirs into the unit of the kernel that is
    being compiled, and are forgotten with it.
    """

    open: ClassVar[list["_Unit"]] = []
    """Units being compiled: one kernel may call another."""

    def __init__(self) -> None:
        self.library: Any = None
        self.parts: list[tuple[Any, tuple[Any, ...]]] = []
        """Inner kernels in it, and the types of their arguments."""

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Let inner kernels be compiled anew meanwhile."""
        made = [(kernel.overloads, types, kernel.overloads.pop(types, None)) for kernel, types in self.parts]
        try:
            yield
        finally:
            for overloads, types, code in made:
                overloads[types] = code


class _Whole(CompilerBase):  # type: ignore[misc]
    """Compiles a kernel as a unit."""

    def define_pipelines(self) -> list[PassManager]:
        return [_pipeline(self.state, _Close)]

    def compile_extra(self, function: Callable[..., object]) -> Any:
        unit = _Unit()
        with ExitStack() as stack:
            if _Unit.open:
                stack.enter_context(_Unit.open[-1].hidden())
            _Unit.open.append(unit)
            stack.callback(_Unit.open.pop)
            unit.library = self.state.targetctx.codegen().create_library(function.__qualname__)
            unit.library.enable_object_caching()
            try:
                return super().compile_extra(function)
            finally:
                for kernel, types in unit.parts:
                    self.state.targetctx.remove_user_function(kernel.overloads.pop(types).entry_point)


class _Part(CompilerBase):  # type: ignore[misc]
    """Compiles an inner kernel into the unit that is open, or by itself."""

    def define_pipelines(self) -> list[PassManager]:
        return [_pipeline(self.state, _Join) if _Unit.open else DefaultPassBuilder.define_nopython_pipeline(self.state)]


def _pipeline(state: Any, last: type[LoweringPass]) -> PassManager:
    """Return the compiler's usual passes into the open unit, another one making the code callable."""
    state.library, state.flags.no_compile = _Unit.open[-1].library, True
    passes = DefaultPassBuilder.define_nopython_pipeline(state)
    passes.add_pass_after(last, NativeLowering)
    passes.finalize()
    return passes


@register_pass(mutates_CFG=False, analysis_only=False)
class _Join(LoweringPass):  # type: ignore[misc]
    """Make an inner kernel callable within its unit."""

    _name = "join_unit"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        # Python has no way in; the compiler asks for a built-in function to know the code by.
        way_in = state.cr.env.__sizeof__
        state.cr = state.cr._replace(cfunc=way_in)
        state.targetctx.insert_user_function(way_in, state.cr.fndesc)
        _Unit.open[-1].parts.append((_inner[state.func_id.func], tuple(state.args)))
        return True


@register_pass(mutates_CFG=False, analysis_only=False)
class _Close(LoweringPass):  # type: ignore[misc]
    """Make the unit's code, of which only the kernel itself is seen from outside."""

    _name = "close_unit"

    def __init__(self) -> None:
        super().__init__()

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
    made: Any = fleeting_kernel(function, pipeline_class=_Whole, **options)
    if not INTERPRETED and is_own(function):
        _keep_in(code_folder(), made)
    return cast(Function, made)


def inner_kernel(function: Function, **options: Any) -> Function:
    """Make a kernel that only kernels call, never Python.

    No way in from Python is built, which is most of its compilation: a call from there would crash.
    """
    made = fleeting_kernel(
        function, pipeline_class=_Part, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options
    )
    _inner[function] = made
    return made


def part_kernel(function: Function) -> Function:
    """Make an inner kernel that is part of its callers: a call would cost as much as its work."""
    return inner_kernel(function, forceinline=True)


def merged_kernel(function: Function) -> Function:
    """Make an inner kernel with one caller, whose code it is compiled as: each would be optimised twice."""
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
