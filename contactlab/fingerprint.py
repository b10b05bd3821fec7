"""Fingerprint of a function: a digest of its code and of all that the code refers to.

Machine code holds the code of every function that is called and the value of every global that is
read, so that neither the date nor the text of one file tells whether it is still good. What tells it
is all that can be reached from the function: globals, attributes of modules, captured variables,
defaults, methods and values, through other modules to the end. In doubt more is followed than is used:
every name in the code is looked for in every module that the code names.

Code of the standard library, of this package and of the libraries below is told by name and version
and not entered; who uses a fingerprint adds the digest of this package.
"""

import sys
from array import array
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, is_dataclass
from dis import get_instructions
from enum import Enum
from functools import cached_property, partial
from hashlib import sha256
from importlib import import_module
from numbers import Number
from opcode import opmap
from pathlib import Path
from types import CodeType, FunctionType, MappingProxyType, MethodType, ModuleType, SimpleNamespace
from typing import Any, Final, final

import numpy as np

_PACKAGE: Final = __name__.partition(".")[0]
_KNOWN: Final = {_PACKAGE, "numpy", "numba", "llvmlite", "scipy", *sys.stdlib_module_names}
"""Top-level names of what is not entered."""

_Parts = tuple[tuple[Any, Callable[[Any], Iterable[Any]]], ...]

_CONSTANT: Final[_Parts] = (
    (property, lambda found: (found.fget, found.fset)),
    (staticmethod | classmethod, lambda found: (found.__func__,)),
    (cached_property, lambda found: (found.func,)),
    (MethodType, lambda found: (found.__func__, found.__self__)),
    (partial, lambda found: (found.func, found.args, found.keywords)),
    (type(len), lambda found: (found.__module__, found.__name__)),
    (np.ufunc, lambda found: (found.__name__,)),
    (np.generic, lambda found: (found.dtype.str, found.tobytes())),
    (Enum, lambda found: (type(found), found.name, found.value)),
    (frozenset, lambda found: sorted(found, key=lambda one: fingerprint(one).digest)),
)
_CHANGING: Final[_Parts] = (
    (np.ndarray, lambda found: (found.dtype.str, found.shape, _content(found))),
    (bytearray | array, lambda found: (bytes(found),)),
    (list | deque, tuple),
    (set, lambda found: (frozenset(found),)),
    (dict | MappingProxyType, lambda found: (part for item in found.items() for part in item)),
)
"""What to follow in objects whose values stay, and in those whose values can change."""

_PLAIN: Final = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))
_IMPORT: Final = opmap["IMPORT_NAME"]

_NOT_OF_A_CLASS: Final = {
    *("__dict__", "__weakref__", "__module__", "__firstlineno__", "__static_attributes__"),
    # What fields are declared to be changes no number; the source that declares them is in `sources`.
    *("__annotations__", "__annotate__", "__dataclass_fields__", "__dataclass_params__"),
}


@final
@dataclass(frozen=True)
class Fingerprint:
    """What a function, a class or a value is made of.

    Args:
        digest: 64 hexadecimal digits, the same in every process.
        kernels: compiled functions that can be reached, callers before what they call alone.
        modules: those whose code can be reached.
    """

    digest: str
    kernels: tuple[Any, ...]
    modules: tuple[ModuleType, ...]

    def sources(self) -> str:
        """Digest of the modules' files as they are now: it sees what cannot be followed, and comments too."""
        digest = sha256()
        for module in sorted(self.modules, key=lambda module: module.__name__):
            # A module may be typed in without a file.
            with suppress(OSError):
                content = Path(getattr(module, "__file__", None) or "").read_bytes()
                # Line ends differ between systems, and say nothing.
                digest.update(sha256(content.replace(b"\r\n", b"\n")).digest())
        return digest.hexdigest()


def is_own(found: Any) -> bool:
    """Whether a function or class stands in this package."""
    return _top(found) == _PACKAGE


def fingerprint(subject: object, *, identities: bool = False) -> Fingerprint:
    """The fingerprint of a function, class or value, entered wherever it comes from.

    Args:
        subject: what to follow.
        identities: whether objects that can change count as themselves and not by their values; the
            digest then holds for this process alone.
    """
    walk = _Walk(subject, identities)
    modules = {id(module): module for module in walk.modules}
    return Fingerprint(walk.digest.hexdigest(), tuple(walk.kernels), tuple(modules.values()))


@dataclass(frozen=True)
class _Mention:
    """A module in code with these names, any of which may be an attribute of it."""

    module: ModuleType
    names: tuple[str, ...]


class _Walk:
    """Goes through what refers to what, depth first, and enters nothing twice."""

    def __init__(self, subject: object, identities: bool) -> None:
        self.digest = sha256()
        self.kernels: list[Any] = []
        self.modules: list[ModuleType] = []
        self._identities = identities
        self._entered = (subject, getattr(subject, "py_func", subject))
        # Objects are held, because the identity of one that is gone is given to another.
        met: dict[object, tuple[int, object]] = {}
        waiting = [subject]
        while waiting:
            found = waiting.pop()
            key = found if isinstance(found, _Mention) else id(found)
            # Equal constants may be one object or two.
            if key in met and not isinstance(found, (*_PLAIN, tuple, frozenset)):
                self._say("again", met[key][0])
                continue
            met[key] = len(met), found
            # An object may fail in any way when it is looked at; its kind is said by then.
            with suppress(Exception):
                waiting += reversed([*self._children(found)])

    def _say(self, *words: object) -> None:
        self.digest.update(repr(words).encode("utf-8", "surrogatepass"))

    def _children(self, found: object) -> Iterator[Any]:
        """Say what an object is; gives what it refers to."""
        kind = type(found)
        self._say(kind.__name__)
        if isinstance(found, _Mention):
            yield from self._of_module(found)
        elif kind is bytes:
            self._say(len(found))  # type: ignore[arg-type]
            self.digest.update(found)  # type: ignore[arg-type]
        elif kind in _PLAIN or isinstance(found, Number | np.dtype):
            self._say(repr(found))
        elif isinstance(found, tuple):
            self._say(len(found))
            yield from (kind, *found) if kind is not tuple else found
        elif isinstance(found, CodeType):
            self._say(*found.co_names, "", *found.co_freevars, "", *found.co_varnames)
            self._say(found.co_code.hex(), found.co_flags, found.co_argcount)
            yield from found.co_consts
        elif isinstance(found, FunctionType):
            yield from self._of_function(found)
        elif hasattr(found, "py_func") and hasattr(found, "targetoptions"):
            yield from self._of_kernel(found)
        elif isinstance(found, type):
            yield from self._of_class(found)
        elif isinstance(found, ModuleType):
            yield _Mention(found, ())
        else:
            yield from self._of_object(found)

    def _of_function(self, function: FunctionType) -> Iterator[Any]:
        # A closure of this package may hold anything.
        closed = function.__closure__ and is_own(function)
        if self._known(function) and not closed:
            return
        code, names = function.__code__, tuple(sorted(set(_names(function.__code__))))
        yield code
        yield function.__defaults__
        yield function.__kwdefaults__
        for cell in function.__closure__ or ():
            # A variable that is not set yet.
            with suppress(ValueError):
                yield _mentioned(cell.cell_contents, names)
        for name in names:
            if name in function.__globals__:
                self._say(name)
                yield _mentioned(function.__globals__[name], names)
        for module in _imported(code, function.__globals__.get("__package__") or ""):
            yield _Mention(module, names)

    def _of_kernel(self, kernel: Any) -> Iterator[Any]:
        function = kernel.py_func
        if not is_own(function) or function.__closure__:
            self.kernels.append(kernel)
        self._say(*sorted(f"{key}={value}" for key, value in kernel.targetoptions.items()))
        yield function

    def _of_class(self, found: type) -> Iterator[Any]:
        if self._known(found):
            return
        yield from found.__bases__
        for name, value in sorted(vars(found).items()):
            if name not in _NOT_OF_A_CLASS:
                self._say(name)
                yield value

    def _of_module(self, mention: _Mention) -> Iterator[Any]:
        module = mention.module
        self._say(module.__name__)
        if module.__name__.partition(".")[0] in _KNOWN:
            self._say(getattr(module, "__version__", ""))
            return
        self.modules.append(module)
        for name in mention.names:
            # A module that makes its attributes when they are asked for may fail in any way.
            with suppress(Exception):
                value = getattr(module, name)
                self._say(name)
                yield _mentioned(value, mention.names)

    def _of_object(self, found: Any) -> Iterator[Any]:
        """What holds values, and the instances of classes."""
        for kinds, parts in _CONSTANT:
            if isinstance(found, kinds):
                yield from parts(found)
                return
        if self._identities and not _is_frozen(found):
            self._say(id(found))
            return
        for kinds, parts in _CHANGING:
            if isinstance(found, kinds):
                yield from parts(found)
                return
        yield getattr(found, "__wrapped__", None)
        yield (kind := type(found))
        # What an object of a library holds inside is no value of the law's.
        if _is_frozen(found) or kind is SimpleNamespace or _top(kind) not in _KNOWN:
            slots = [name for base in kind.__mro__ for name in _slots(base)]
            yield {name: getattr(found, name) for name in slots if hasattr(found, name)}
            yield getattr(found, "__dict__", None)

    def _known(self, found: Any) -> bool:
        """Say where code comes from; whether that is all there is to say."""
        self._say(found.__module__, found.__qualname__)
        top = _top(found)
        module: Any = sys.modules.get(found.__module__ or "")
        if top in _KNOWN and not any(found is one for one in self._entered):
            self._say(getattr(sys.modules.get(top), "__version__", ""))
            return True
        if module is not None and top not in _KNOWN:
            self.modules.append(module)
        return False


def _top(found: Any) -> str:
    return str(getattr(found, "__module__", "")).partition(".")[0]


def _is_frozen(found: object) -> bool:
    return is_dataclass(found) and bool(getattr(found, "__dataclass_params__").frozen)  # noqa: B009


def _content(values: Any) -> object:
    return values.tolist() if values.dtype.hasobject else values.tobytes()


def _slots(kind: type) -> tuple[str, ...]:
    slots = vars(kind).get("__slots__", ())
    return (slots,) if isinstance(slots, str) else tuple(slots)


def _mentioned(value: object, names: tuple[str, ...]) -> object:
    return _Mention(value, names) if isinstance(value, ModuleType) else value


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        yield from _names(constant) if isinstance(constant, CodeType) else ()


def _imported(code: CodeType, package: str) -> Iterator[ModuleType]:
    for constant in code.co_consts:
        yield from _imported(constant, package) if isinstance(constant, CodeType) else ()
    # Reading instructions takes far longer than looking whether there is such a one.
    steps = get_instructions(code) if _IMPORT in code.co_code[::2] else ()
    for name in [step.argval for step in steps if step.opcode == _IMPORT]:
        # `import package.module` gives the package a name.
        for full in (name, name.partition(".")[0], f"{package}.{name}"):
            # What is wrong with it is seen when it is run.
            with suppress(Exception):
                yield import_module(full)
