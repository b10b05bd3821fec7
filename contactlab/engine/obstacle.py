"""Why a function cannot be compiled, in a line: where, the statement, and the cause."""

import re
from collections.abc import Iterator
from dis import get_instructions
from linecache import getline
from pathlib import Path
from typing import Any, Final

import numba

_COMPILER: Final = str(Path(numba.__file__).parent)
_PLACES: Final = re.compile(r"(?:During: .* at|Raised from) (\S.*) \((\d+)\)")
_NOISE: Final = re.compile(r"Failed in |During: |>>> |File \"|- |\* |\s*$|\^|raised from ")
_UNKNOWN: Final = r"Untyped global name '(.+)': Cannot determine Numba type of "
_NO_FUNCTION: Final = r"The decorated object is not a function \(got type "

ALLOCATES: Final = "it makes an array, a list, a dict or a text, and a kernel must not ask for memory"
_CAUSES: Final = {
    r"NRT required but not enabled|Only accept returning of array": ALLOCATES,
    "Cannot modify readonly array": ("it writes to an array that is read-only, as the parameters are"),
    _UNKNOWN + "<class 'function'>": (
        r"\1 is a Python function; decorate it with contactlab.compiled.kernel"
    ),
    _UNKNOWN + r"<class '(?:.*\.)?(\w+)'>": (
        r"\1 is a Python object (\2), where only numbers, arrays, tuples and kernels can be used"
    ),
    r"Signature mismatch: (\d+) argument types given, but function takes (\d+) arguments": (
        r"it is called with \1 arguments and names \2"
    ),
    _NO_FUNCTION + "<class 'method'>": ("it is a method of an object; decorate it with @staticmethod"),
    _NO_FUNCTION + r"<class '(?:.*\.)?(\w+)'>": r"it is a \1 and no function of its own",
    r"(name '.+' is not defined)": r"\1",
    r"Unknown attribute '(.+)' of type Module\(<module '([\w.]+)'": r"\2.\1 has no compiled form",
    r"Use of unsupported opcode \(IMPORT_NAME\)": "it imports a module",
    r">>> (.+)": r"\1 has no compiled form",
}
"""What the compiler says, and what it means."""


def obstacle(error: Exception, function: Any, signature: Any) -> str:
    """Say what keeps a callable from being compiled for a signature, from what the compiler raised."""
    text, statement = str(error), ""
    place = next(_places(error, text, getattr(function, "py_func", function)), None)
    if place is not None and (line := getline(*place).strip()):
        statement = f"{Path(place[0]).name}, line {place[1]}, `{line}`: "
    return statement + _cause(error, text, signature)


def _places(error: Exception, text: str, function: Any) -> Iterator[tuple[str, int]]:
    """Files and lines outside of the compiler, innermost first."""
    if unknown := re.search(r"name '(.+)' is not defined", text):
        # The compiler says nothing of where a name stands that it does not know.
        code: Any = getattr(function, "__code__", None)
        for step in get_instructions(code) if code else ():
            if step.argval == unknown[1] and step.positions and step.positions.lineno:
                yield code.co_filename, step.positions.lineno
    for file, line in _PLACES.findall(text):
        if not file.startswith(_COMPILER):
            yield file, int(line)
    if (location := getattr(error, "loc", None)) is not None:
        yield location.filename, location.line


def _cause(error: Exception, text: str, signature: Any) -> str:
    if given := re.search(r"No conversion from (.+) to (.+) for '\$\w*return_(?:value|const)", text):
        return f"it gives {_words(given[1])} and not {_words(str(signature.return_type))}"
    for pattern, words in _CAUSES.items():
        if found := re.search(pattern, text):
            return found.expand(words)
    lines = [line.strip() for line in text.splitlines() if not _NOISE.match(line.strip())]
    said = lines[0].partition(" Raised from ")[0].rstrip(".") if lines else ""
    if type(error).__module__.startswith("numba."):
        return said
    return f"the compiler itself fails with {type(error).__name__}: {said}".rstrip(": ")


def _words(kind: str) -> str:
    """Give a type in words."""
    if several := re.fullmatch(r"UniTuple\((?:float|int)64 x (\d+)\)", kind):
        return f"{several[1]} numbers"
    if kind == "none":
        return "nothing where it ends"
    if kind in ("float64", "int64"):
        return "1 number"
    kind = re.sub(r"<iv=.*?>", "", re.sub(r"Literal\[str\]\((.*?)\)", "text", kind))
    return re.sub(r"\b(float|int|complex)(64|128)\b", r"\1", kind).replace("Tuple(", "(")
