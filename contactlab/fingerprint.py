"""Fingerprint of a function: a digest of its code and of all that the code refers to.

Machine code holds the code of every function that is called and the value of every global that is
read. What tells whether it is still good is all that can be reached from the function: globals,
attributes of modules, captured variables, defaults, methods and values, through other modules to the end.
In doubt more is followed than is used: every name in the code is looked for in every module that it names.

Code of the standard library, of this package and of the libraries below is told by name and version
and not entered; who uses a fingerprint adds the digest of this package.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dis import get_instructions
from functools import partial
from hashlib import sha256
from importlib import import_module
from inspect import getsource
from opcode import opmap
from types import CodeType, FunctionType, MappingProxyType, ModuleType
from typing import Any, Final, NamedTuple, final

_PACKAGE: Final = __name__.partition(".")[0]
_KNOWN: Final = {_PACKAGE, "numpy", "numba", "llvmlite", "scipy", *sys.stdlib_module_names}
"""Top-level names of what is not entered."""

_PLAIN: Final = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))

_NOT_OF_A_CLASS: Final = {
    "__dict__",
    "__weakref__",
    "__module__",
    "__firstlineno__",
    "__static_attributes__",
    # What fields are declared to be changes no number; the source that declares them is in `sources`.
    "__annotations__",
    "__annotate__",
    "__dataclass_fields__",
    "__dataclass_params__",
}


class _Mention(NamedTuple):
    """A module in code with these names, any of which may be an attribute of it."""

    module: ModuleType
    names: tuple[str, ...]


@final
class Fingerprint:
    """What a function, class or value is made of, entered wherever it comes from.

    `digest` has 64 hexadecimal digits, the same in every process; `kernels` are the compiled functions
    that can be reached, callers before what they call alone, and `modules` those whose code can be.
    """

    def __init__(self, subject: object) -> None:
        self.subject = subject
        self.kernels: list[Any] = []
        self.modules: dict[str, ModuleType] = {}
        self._said = sha256()
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
            children: list[object] = []
            # An object may fail in any way when it is looked at; its kind is said by then.
            with suppress(Exception):
                children.extend(self._children(found))
            waiting += reversed(children)
        self.digest = self._said.hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Fingerprint) and other.digest == self.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def sources(self) -> str:
        """Give a digest of the modules' files now: it sees what cannot be followed, and comments too."""
        digest = sha256()
        for name in sorted(self.modules):
            # A module may be typed in without a file.
            with suppress(OSError, TypeError):
                digest.update(getsource(self.modules[name]).encode())
        return digest.hexdigest()

    def _say(self, *words: object) -> None:
        self._said.update(repr(words).encode("utf-8", "surrogatepass"))

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
        elif isinstance(found, FunctionType | type):
            # A closure of this package may hold anything.
            if not self._is_known(found) or (is_own(found) and getattr(found, "__closure__", None)):
                yield from self._of_code(found)
        elif hasattr(found, "py_func") and hasattr(found, "targetoptions"):
            if not is_own(found.py_func) or found.py_func.__closure__:
                self.kernels.append(found)
            self._say(*sorted(f"{key}={value}" for key, value in found.targetoptions.items()))
            yield found.py_func
        else:
            yield from self._of_object(found)

    def _of_code(self, function: Any) -> Iterator[Any]:
        """Give what a function refers to, or a class."""
        if isinstance(function, type):
            names = tuple(sorted(vars(function).keys() - _NOT_OF_A_CLASS))
            yield from function.__bases__
            yield from self._of_names(names, vars(function).__getitem__)
            return
        codes = list(_codes(function.__code__))
        names = tuple(sorted({name for code in codes for name in code.co_names}))
        yield from (function.__code__, function.__defaults__, function.__kwdefaults__)
        for cell in function.__closure__ or ():
            # A variable that is not set yet.
            with suppress(ValueError):
                yield _mentioned(cell.cell_contents, names)
        yield from self._of_names(names, function.__globals__.__getitem__)
        for module in _imported(codes, function.__globals__.get("__package__") or ""):
            yield _Mention(module, names)

    def _of_module(self, module: ModuleType, names: tuple[str, ...]) -> Iterator[Any]:
        self._say(module.__name__)
        if module.__name__.partition(".")[0] in _KNOWN:
            self._say(getattr(module, "__version__", ""))
            return
        self.modules[module.__name__] = module
        yield from self._of_names(names, partial(getattr, module))

    def _of_names(self, names: tuple[str, ...], look: Callable[[str], Any]) -> Iterator[Any]:
        for name in names:
            # A module that makes its attributes when they are asked for may fail in any way.
            with suppress(Exception):
                value = look(name)
                self._say(name)
                yield _mentioned(value, names)

    def _of_object(self, found: Any) -> Iterator[Any]:
        """Give what an object would be made again from; some cannot be pickled, or only in any order."""
        if isinstance(found, property):
            yield from (found.fget, found.fset)
        elif isinstance(found, staticmethod | classmethod):
            yield found.__func__
        elif isinstance(found, MappingProxyType):
            yield dict(found)
        elif isinstance(found, set | frozenset):
            yield from sorted(found, key=lambda one: Fingerprint(one).digest)
        else:
            yield getattr(found, "__wrapped__", None)
            yield type(found)
            made = found.__reduce_ex__(4)
            if isinstance(made, str):
                self._say(getattr(found, "__module__", ""), made)
            else:
                yield from (tuple(each) if hasattr(each, "__next__") else each for each in made)

    def _is_known(self, found: Any) -> bool:
        """Say where code comes from; tell whether that is all there is to say."""
        self._say(found.__module__, found.__qualname__)
        top, module = _top(found), sys.modules.get(found.__module__ or "")
        if top in _KNOWN:
            self._say(getattr(sys.modules.get(top), "__version__", ""))
            return found is not self.subject and found is not getattr(self.subject, "py_func", None)
        if module is not None:
            self.modules[module.__name__] = module
        return False


def is_own(found: Any) -> bool:
    """Tell whether a function or class stands in this package."""
    return _top(found) == _PACKAGE


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
    wanted = opmap["IMPORT_NAME"]
    for code in [code for code in codes if wanted in code.co_code[::2]]:
        for name in [step.argval for step in get_instructions(code) if step.opcode == wanted]:
            # `import package.module` gives the package a name.
            for full in (name, name.partition(".")[0], f"{package}.{name}"):
                # What is wrong with it is seen when it is run.
                with suppress(Exception):
                    yield import_module(full)
