"""The one place that names the compiler: decorators for numeric kernels, and where their code is kept.

Numba decides by a kernel's own file whether its machine code is still good, but a kernel holds the code
of every kernel that it calls. The code is therefore kept in a folder named after a digest of all
sources of kernels, see `contactlab.compiler.folders`. Kernels of other packages, which may call
anything, are compiled in every session: about 0.1 s a law. The compiler itself is imported when the first
kernel is called: listings, help and configurations need none.
"""

import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache, cached_property, update_wrapper
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast, final

from contactlab.compiler.folders import code_folder, read_only_folder, shipped_folder
from contactlab.foreign import is_own

Function = TypeVar("Function", bound=Callable[..., object])

INTERPRETED = bool(int(os.environ.get("NUMBA_DISABLE_JIT") or 0))
"""Whether NUMBA_DISABLE_JIT asks for no machine code: every kernel is the Python function that it was."""

OPTIONS = {"error_model": "numpy", "_nrt": False, "nogil": True}
"""Of every kernel, see `kernel`."""


@cache
def units() -> Any:
    """Return the module that compiles kernels as units; none where this Numba cannot, with the same bits."""
    try:
        from contactlab.compiler import units

        _keep_in(code_folder(), units.around)
        return units if units.around(6.0) == 5.0 else None
    # Units go beyond the compiler's documented interface: another version may fail in any way.
    except Exception:
        return None


@final
class Kernel:
    """A function that is compiled when it is first called, by another kernel or, if not inner, from Python.

    Any other attribute is that of the compiler's own object, by whose type kernels call each other.
    """

    def __init__(self, function: Callable[..., object], options: dict[str, Any], inner: bool) -> None:
        update_wrapper(self, function)
        self.py_func, self.targetoptions, self._inner = function, OPTIONS | options, inner

    @cached_property
    def compiled(self) -> Any:
        """The compiler's own object."""
        pipeline: dict[str, Any] = {}
        if whole := units():
            pipeline["pipeline_class"] = whole.PartCompiler if self._inner else whole.WholeCompiler
        made: Any = fleeting_kernel(self.py_func, **pipeline, **self.targetoptions)
        if self._inner and whole:
            whole.inner[self.py_func] = made
            whole.ignore_literals(made)
        elif not self._inner and is_own(self.py_func):
            _keep_in(code_folder(), made)
        return made

    def __call__(self, *arguments: Any) -> Any:
        """Evaluate the function; an inner kernel, which has no entry from Python, as the Python function."""
        return self.py_func(*arguments) if self._inner else self.compiled(*arguments)

    def __getattr__(self, name: str) -> Any:
        # Whoever looks for a method of Python's own needs no compiler.
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.compiled, name)


def kernel(function: Function, **options: Any) -> Function:
    """Compile a scalar or array function on first use and keep the code of this package's.

    Division follows IEEE (`error_model="numpy"`) and no fast-math is used, so that the same input
    gives the same bits and a NaN stays visible. Kernels allocate nothing: reference counting is off,
    which the many small calls with many arrays would otherwise spend most of their time on. Other threads
    run meanwhile, so that one can end the process where a law's code does not return.
    """
    return function if INTERPRETED else cast(Function, Kernel(function, options, inner=False))


def unit_kernel(function: Function) -> Function:
    """Make a kernel that kernels alone call, by its address, see `contactlab.compiler.ahead`."""
    return kernel(function, no_cpython_wrapper=True)


def inner_kernel(function: Function, **options: Any) -> Function:
    """Make a kernel whose machine code only kernels call, with whose code it is kept.

    It has no entry from Python: a call from there evaluates the Python function.
    """
    options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return function if INTERPRETED else cast(Function, Kernel(function, options, inner=True))


def part_kernel(function: Function) -> Function:
    """Make an inner kernel that is part of its callers: a call would cost as much as its work."""
    return inner_kernel(function, forceinline=True)


def fleeting_kernel(function: Function, **options: Any) -> Function:
    """Make a kernel while the program runs, around another."""
    import numba

    from contactlab.compiler import registers  # noqa: F401 - from then on lanes are a type

    njit: Any = numba.njit
    return cast(Function, njit(**OPTIONS | options)(function))


def generated_kernel(name: str, source: str) -> Any:
    """Make a kernel from a source that imports this package's kernels, and keep both beside their code."""
    file_name = f"generated/{name}_{sha256(source.encode()).hexdigest()[:16]}.py"
    path = (read_only_folder() or code_folder()) / file_name
    if not _holds(path, source):
        path = code_folder() / file_name
    if not _holds(path, source):
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


def _holds(path: Path, source: str) -> bool:
    """Return whether a file holds a source, whole."""
    try:
        return path.read_text() == source
    except (OSError, UnicodeDecodeError):
        return False


def remade(kernel: Any) -> Any:
    """Return a kernel with another's function and options, but none of its code."""
    from numba import jit

    return jit(**kernel.targetoptions)(kernel.py_func)


def _keep_in(folder: Path, kernel: Any) -> None:
    """Let a kernel keep its code in a folder: the compiler reads the setting once, for each."""
    from numba import config

    settings: Any = config
    before, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)
    try:
        kernel.enable_caching()
    finally:
        settings.CACHE_DIR = before
    others: list[Any] = []
    if read_only_folder() or shipped_folder():
        from contactlab.compiler.shipped import ReadOnly, Shipped

        kinds = (ReadOnly, read_only_folder()), (Shipped, shipped_folder())
        others = [kind(kernel.py_func) for kind, there in kinds if there]
    kernel._cache = _Kept(kernel._cache, others)


@final
class _Kept:
    """A kernel's code that this machine keeps, before others of the compiler's caches, which are read alone.

    Any other attribute is that of the first. A file of it that cannot be read, such as one that was cut as it
    was written, is made anew.
    """

    def __init__(self, first: Any, others: list[Any]) -> None:
        self._first, self._others = first, others

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the code for a signature, None where there is none."""
        for each in (self._first, *self._others):
            try:
                code = each.load_overload(signature, target)
            # What a cut file leads to depends on where it is cut.
            except Exception:
                code = None
                if each is self._first:
                    each.flush()
            if code is not None:
                return code
        return None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._first, name)
