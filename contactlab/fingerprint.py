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
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from dis import get_instructions
from hashlib import sha256
from importlib import import_module
from opcode import opmap
from pathlib import Path
from types import CodeType, FunctionType, MappingProxyType, ModuleType
from typing import Any, Final, NamedTuple, final

_PACKAGE: Final = __name__.partition(".")[0]
_KNOWN: Final = {_PACKAGE, "numpy", "numba", "llvmlite", "scipy", *sys.stdlib_module_names}
"""Top-level names of what is not entered."""

_PLAIN: Final = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))
_IMPORT: Final = opmap["IMPORT_NAME"]

_PARTS: Final[tuple[tuple[Any, Callable[[Any], Iterable[Any]]], ...]] = (
    (property, lambda found: (found.fget, found.fset)),
    (staticmethod | classmethod, lambda found: (found.__func__,)),
    (MappingProxyType, lambda found: (dict(found),)),
    (set | frozenset, lambda found: sorted(found, key=lambda one: fingerprint(one).digest)),
)
"""What to follow in what cannot be pickled, or has another order in every process."""

_NOT_OF_A_CLASS: Final = {
    *("__dict__", "__weakref__", "__module__", "__firstlineno__", "__static_attributes__"),
    # What fields are declared to be changes no number; the source that declares them is in `sources`.
    *("__annotations__", "__annotate__", "__dataclass_fields__", "__dataclass_params__"),
}


@final
@dataclass(frozen=True)
class Fingerprint:
    """What a function, a class or a value is made of; the digest tells one from another.

    Args:
        digest: 64 hexadecimal digits, the same in every process.
        subject: what was followed.
        kernels: compiled functions that can be reached, callers before what they call alone.
        modules: those whose code can be reached.
    """

    digest: str
    subject: object = field(compare=False)
    kernels: tuple[Any, ...] = field(compare=False)
    modules: tuple[ModuleType, ...] = field(compare=False)

    def sources(self) -> str:
        """Give a digest of the modules' files now: it sees what cannot be followed, and comments too."""
        digest = sha256()
        for module in sorted(self.modules, key=lambda module: module.__name__):
            # A module may be typed in without a file.
            with suppress(OSError):
                content = Path(getattr(module, "__file__", None) or "").read_bytes()
                # Line ends differ between systems, and say nothing.
                digest.update(sha256(content.replace(b"\r\n", b"\n")).digest())
        return digest.hexdigest()


def is_own(found: Any) -> bool:
    """Tell whether a function or class stands in this package."""
    return _top(found) == _PACKAGE


def fingerprint(subject: object) -> Fingerprint:
    """Give the fingerprint of a function, class or value, entered wherever it comes from."""
    walk = _Walk(subject)
    modules = {id(module): module for module in walk.modules}
    return Fingerprint(
        walk.digest.hexdigest(), subject, tuple(walk.kernels), tuple(modules.values())
    )


class _Mention(NamedTuple):
    """A module in code with these names, any of which may be an attribute of it."""

    module: ModuleType
    names: tuple[str, ...]


class _Walk:
    """Goes through what refers to what, depth first, and enters nothing twice."""

    def __init__(self, subject: object) -> None:
        self.digest = sha256()
        self.kernels: list[Any] = []
        self.modules: list[ModuleType] = []
        self._entered = (subject, getattr(subject, "py_func", subject))
        # Objects are held, because the identity of one that is gone is given to another.
        met: dict[object, tuple[int, object]] = {}
        waiting = [subject]
        while waiting:
            found = waiting.pop()
            mention = isinstance(found, _Mention)
            key = found if mention else id(found)
            # Equal constants may be one object or two.
            if key in met and (mention or not isinstance(found, (*_PLAIN, tuple, frozenset))):
                self._say("again", met[key][0])
                continue
            met[key] = len(met), found
            # An object may fail in any way when it is looked at; its kind is said by then.
            with suppress(Exception):
                waiting += reversed([*self._children(found)])

    def _say(self, *words: object) -> None:
        self.digest.update(repr(words).encode("utf-8", "surrogatepass"))

    def _children(self, found: Any) -> Iterator[Any]:
        """Say what an object is; give what it refers to."""
        kind = type(found)
        self._say(kind.__name__)
        if kind in _PLAIN:
            self._say(repr(found))
        elif isinstance(found, ModuleType | _Mention):
            yield from self._of_module(*found if kind is _Mention else (found, ()))
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
            if not is_own(found.py_func) or found.py_func.__closure__:
                self.kernels.append(found)
            self._say(*sorted(f"{key}={value}" for key, value in found.targetoptions.items()))
            yield found.py_func
        elif isinstance(found, type):
            yield from self._of_class(found)
        else:
            yield from self._of_object(found)

    def _of_function(self, function: FunctionType) -> Iterator[Any]:
        # A closure of this package may hold anything.
        closed = function.__closure__ and is_own(function)
        if self._known(function) and not closed:
            return
        codes = list(_codes(function.__code__))
        names = tuple(sorted({name for code in codes for name in code.co_names}))
        yield function.__code__
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
        for module in _imported(codes, function.__globals__.get("__package__") or ""):
            yield _Mention(module, names)

    def _of_class(self, found: type) -> Iterator[Any]:
        if self._known(found):
            return
        yield from found.__bases__
        for name in sorted(vars(found).keys() - _NOT_OF_A_CLASS):
            self._say(name)
            yield vars(found)[name]

    def _of_module(self, module: ModuleType, names: tuple[str, ...]) -> Iterator[Any]:
        self._say(module.__name__)
        if module.__name__.partition(".")[0] in _KNOWN:
            self._say(getattr(module, "__version__", ""))
            return
        self.modules.append(module)
        for name in names:
            # A module that makes its attributes when they are asked for may fail in any way.
            with suppress(Exception):
                value = getattr(module, name)
                self._say(name)
                yield _mentioned(value, names)

    def _of_object(self, found: Any) -> Iterator[Any]:
        """Give what an object holds: what it would be made again from."""
        for kinds, parts in _PARTS:
            if isinstance(found, kinds):
                yield from parts(found)
                return
        yield getattr(found, "__wrapped__", None)
        yield type(found)
        with suppress(Exception):
            made = found.__reduce_ex__(4)
            if isinstance(made, str):
                self._say(getattr(found, "__module__", ""), made)
            else:
                maker, given, state, items, pairs = (*made, None, None, None)[:5]
                yield from (maker, given, state, tuple(items or ()), tuple(pairs or ()))

    def _known(self, found: Any) -> bool:
        """Say where code comes from; tell whether that is all there is to say."""
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


def _mentioned(value: object, names: tuple[str, ...]) -> object:
    return _Mention(value, names) if isinstance(value, ModuleType) else value


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Give a code and those inside of it."""
    yield code
    for constant in code.co_consts:
        yield from _codes(constant) if isinstance(constant, CodeType) else ()


def _imported(codes: list[CodeType], package: str) -> Iterator[ModuleType]:
    # Reading instructions takes far longer than looking whether there is such a one.
    for code in [code for code in codes if _IMPORT in code.co_code[::2]]:
        for name in [step.argval for step in get_instructions(code) if step.opcode == _IMPORT]:
            # `import package.module` gives the package a name.
            for full in (name, name.partition(".")[0], f"{package}.{name}"):
                # What is wrong with it is seen when it is run.
                with suppress(Exception):
                    yield import_module(full)
