"""Code of other packages: which it is, a digest of its sources, and the values compiled into it."""

import ast
import pickle
import sys
from collections.abc import Callable, Iterator
from hashlib import sha256
from importlib.util import resolve_name
from inspect import getclosurevars
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, Final

_PACKAGE: Final = __name__.partition(".")[0]
_LIBRARIES: Final = {
    _PACKAGE,
    *sys.stdlib_module_names,
    *("hydra", "llvmlite", "matplotlib", "numba", "numpy", "omegaconf", "pandas", "scipy", "xarray"),
}
"""Top-level names of modules whose version is recorded elsewhere, or that make no law's numbers."""


def is_own(owner: Any) -> bool:
    """Return whether a function or class is defined in this package."""
    return str(getattr(owner, "__module__", "")).partition(".")[0] == _PACKAGE


def digest_of_sources(*owners: type | Callable[..., Any]) -> str:
    """Return a digest of the sources that define classes and functions of other packages, empty without any.

    It covers all files of a class's package, and of the modules that these import, to the end, libraries
    left out. An import in a function counts once its module is loaded.
    """
    contents: dict[Path, bytes] = {}
    waiting = [sys.modules.get(owner.__module__) for owner in owners if not is_own(owner)]
    while waiting:
        module = waiting.pop()
        # A module may be typed in, without a file.
        file = Path(getattr(module, "__file__", None) or "")
        if module is None or file in contents or file.suffix != ".py" or _top(module) in _LIBRARIES:
            continue
        contents[file] = file.read_bytes()
        waiting += [sys.modules.get(name) for name in (*_imports(module, contents[file]), _top(module))]
        if file.name == "__init__.py":
            every = (path for path in file.parent.rglob("*.py") if "__pycache__" not in path.parts)
            contents |= {path: path.read_bytes() for path in every if path not in contents}
    digests = sorted(sha256(content).hexdigest() for content in contents.values())
    return sha256("".join(digests).encode()).hexdigest() if digests else ""


def compiled_constants(function: Any) -> tuple[tuple[bytes, ...], list[Any]]:
    """Return the global and captured values that a function's machine code holds, pickled, and its callees.

    The callees are the compiled functions of other packages that it calls, each after those that it calls.
    """
    values: list[bytes] = []
    functions: list[Any] = []
    met: set[int] = set()

    def visit(each: Any) -> None:
        plain = getattr(each, "py_func", each)
        if not isinstance(plain, FunctionType) or is_own(plain) or id(each) in met:
            return
        met.add(id(each))
        named = getclosurevars(plain)
        for value in (*named.nonlocals.values(), *named.globals.values()):
            parts = [value]
            if isinstance(value, ModuleType):
                known = _top(value) in _LIBRARIES
                parts = [getattr(value, name, None) for name in plain.__code__.co_names if not known]
            for part in parts:
                if callable(part):
                    visit(part)
                elif not isinstance(part, ModuleType):
                    values.append(_pickled(part))
        functions.append(each)

    visit(function)
    return tuple(values), [each for each in functions[:-1] if hasattr(each, "py_func")]


def _pickled(value: Any) -> bytes:
    # What cannot be pickled is no constant of compiled code.
    try:
        return pickle.dumps(value)
    except Exception:
        return b""


def _imports(module: ModuleType, source: bytes) -> Iterator[str]:
    """Yield the names of modules that a module's source imports, and of what may be one."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                parts = alias.name.split(".")
                yield from (".".join(parts[: k + 1]) for k in range(len(parts)))
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (node.module or "")
            name = resolve_name(base, module.__package__) if node.level else base
            yield from (name, *(f"{name}.{alias.name}" for alias in node.names))


def _top(module: ModuleType) -> str:
    return module.__name__.partition(".")[0]
