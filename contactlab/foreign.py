"""Code of other packages: which it is, a digest of its sources, and the values compiled into it."""

import ast
import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from hashlib import sha256
from importlib.machinery import SourceFileLoader
from importlib.util import resolve_name
from inspect import getclosurevars
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, Final

_PACKAGE: Final = __name__.partition(".")[0]
_LIBRARIES: Final = {
    _PACKAGE,
    *sys.stdlib_module_names,
    *("hydra", "llvmlite", "matplotlib", "numba", "numpy", "omegaconf", "pandas", "scipy", "xarray"),
}
"""Top-level names of modules whose version is recorded elsewhere, or that make no law's numbers."""

_SITES: Final = {"site-packages", "dist-packages"}
"""Names of the folders in which distributions are installed; an editable one stays where it is."""


def is_own(owner: Any) -> bool:
    """Return whether a function or class is defined in this package."""
    return str(getattr(owner, "__module__", "")).partition(".")[0] == _PACKAGE


def is_library(module: str) -> bool:
    """Return whether a module is of this package or of a library that it is built on."""
    return module.partition(".")[0] in _LIBRARIES


def digest_of_sources(*owners: type | Callable[..., Any]) -> str:
    """Return a digest of the sources that define classes and functions of other packages, empty without any.

    It covers all files of a class's package, and of the modules that these import, to the end. What they
    import from another installed distribution counts by the digests in the record of its installation, and
    none of its sources is read. An import in a function counts once its module is loaded. A module that was
    edited after it was loaded has another digest than either text.
    """
    contents: dict[Path, bytes] = {}
    met: set[Path] = set()
    waiting = [sys.modules.get(owner.__module__) for owner in owners if not is_own(owner)]
    whole = {_top(module) for module in waiting if module}
    while waiting:
        module = waiting.pop()
        # A module may be typed in, without a file.
        file = Path(getattr(module, "__file__", None) or "")
        if module is None or file in met or file.suffix != ".py" or _top(module) in _LIBRARIES:
            continue
        met.add(file)
        site = next((folder for folder in file.parents if folder.name in _SITES), None)
        if site and _top(module) not in whole:
            contents[site / _top(module)] = _record_of(site, _top(module))
            continue
        source = file.read_bytes()
        contents[file] = _as_loaded(module, source)
        _sources[module.__name__] = sha256(contents[file]).hexdigest()
        waiting += [sys.modules.get(name) for name in (*_imports(module, source), _top(module))]
        if file.name == "__init__.py":
            every = (path for path in file.parent.rglob("*.py") if "__pycache__" not in path.parts)
            contents |= {path: path.read_bytes() for path in every if path not in contents}
    digests = sorted(sha256(content).hexdigest() for content in contents.values())
    return sha256("".join(digests).encode()).hexdigest() if digests else ""


@cache
def _record_of(site: Path, top: str) -> bytes:
    """Return what the records of installed distributions have of a top-level module: its files' digests.

    Empty where the system's packages have no records.
    """
    records = (path.read_text("utf-8") for path in site.glob("*.dist-info/RECORD"))
    lines = (line for record in records for line in record.splitlines() if not line.endswith(",,"))
    return "\n".join(sorted(line for line in lines if line.startswith((f"{top}/", f"{top}.")))).encode()


_sources: Final[dict[str, str]] = {}
"""Digests by module of the sources that `digest_of_sources` has covered."""


def covered_sources() -> dict[str, str]:
    """Return the digests by module of the sources that `digest_of_sources` has covered, but of no script."""
    return {name: digest for name, digest in _sources.items() if name != "__main__"}


def other_sources(expected: Mapping[str, str]) -> list[str]:
    """Return the modules that this process has loaded from other sources than those of these digests."""
    loaded = ((sys.modules.get(name), digest) for name, digest in expected.items())
    return [module.__name__ for module, digest in loaded if module and _source_of(module) != digest]


@cache
def _source_of(module: ModuleType) -> str:
    """Return the digest of a module's source as it is when the module is met first; of none an empty one."""
    file = getattr(module, "__file__", None)
    return sha256(_as_loaded(module, Path(file).read_bytes())).hexdigest() if file else ""


def _as_loaded(module: ModuleType, source: bytes) -> bytes:
    """Return a module's source text, marked where the module's functions are those of another text."""
    if type(getattr(module, "__loader__", None)) is not SourceFileLoader:
        return source
    codes, waiting = set[CodeType](), [compile(source, str(module.__file__), "exec", dont_inherit=True)]
    while waiting:
        code = waiting.pop()
        codes.add(code)
        waiting += [part for part in code.co_consts if isinstance(part, CodeType)]
    return source if codes.issuperset(_codes_of(module)) else source + EDITED


EDITED: Final = b"\n# edited since it was loaded"


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


def _codes_of(module: ModuleType) -> Iterator[CodeType]:
    """Yield the code of the functions that a module's file defines, in its classes too."""
    waiting = [*vars(module).values()]
    while waiting:
        value = waiting.pop()
        if isinstance(value, type):
            waiting += vars(value).values() if value.__module__ == module.__name__ else ()
            continue
        if isinstance(value, staticmethod | classmethod):
            value = value.__func__
        # Of modules that libraries load by need, an attribute would be an import.
        plain = value if isinstance(value, ModuleType) else getattr(value, "py_func", value)
        if isinstance(plain, FunctionType) and plain.__code__.co_filename == module.__file__:
            yield plain.__code__


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
