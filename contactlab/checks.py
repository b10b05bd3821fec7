"""Checks of arguments from Python against the annotations of a class."""

import json
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import is_dataclass
from functools import cache, partial, wraps
from inspect import Parameter as Parameters, signature
from math import ceil, inf, isnan, prod
from numbers import Integral, Real
from pathlib import Path
from types import NoneType
from typing import Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np

from contactlab.arrays import Array
from contactlab.parameter import BEYOND, Parameter, annotated, declared_fields, has_magnitude, kinds_of
from contactlab.quantity import in_si

SMALLEST_STEP = 1e-12
"""Contact step over duration; below it, time no longer advances reliably in double precision."""

ON_GRID = 1e-6
"""Part of a record interval that is round-off."""

FEW_RECORDS = 10_000
"""Records for which nobody asks the system how much memory there is."""

MOST_RECORDS = 10_000_000
"""Records of one run after that of its start."""

RECORD_SIZE = 380.0
"""Memory that a record takes until its run is in a file [bytes], measured with 1e7 of them."""

NUMBER_SIZE = 24.0
"""Memory that a number beside the usual ones takes in a record until then [bytes]."""

MOST_MEMORY = MOST_RECORDS * RECORD_SIZE
"""Memory of the numbers of a run or of a file [bytes]."""

MEMORY_INFO = Path("/proc/meminfo")
"""Where Linux tells the memory that processes can have."""

Function = TypeVar("Function", bound=Callable[..., Any])
Read = TypeVar("Read")

_NAMES = {
    float: "a number",
    int: "a whole number",
    bool: "True or False",
    str: "a text",
    NoneType: "None",
    np.ndarray: "an array",
    Callable: "a function",
    Mapping: "a mapping",
    Sequence: "a list",
    list: "a list",
    tuple: "a tuple",
}
"""What values of a kind are called, or of all kinds of one origin."""

_BY_NAME = {"ContactLaw": "contactlab.law({!r})"}
"""How an object of a class is made of its name, for whom passes that."""


def checked_arguments(**units: str) -> Callable[[Function], Function]:
    """Return a decorator of a function that checks every argument against its annotation.

    Texts with units, '1 um', become numbers in SI, alone or in a list: of the arguments that are named with
    their unit, and of those annotated with a `Parameter`, whose range holds too. A list of numbers becomes an
    array where one is annotated.

    >>> @checked_arguments(height="m")
    ... def fall(height: float) -> float:
    ...     return (2.0 * height / 9.81) ** 0.5
    >>> fall("10 mm") == fall(0.01)
    True
    >>> fall(None)
    Traceback (most recent call last):
    TypeError: height is None; it must be a number.
    """

    def decorated(function: Function) -> Function:
        declared = signature(function)

        @cache
        def annotations() -> dict[str, tuple[tuple[Any, ...], Parameter | None]]:
            # Not before a call: an annotation may name what is defined below.
            hints = get_type_hints(function, include_extras=True)
            return {name: annotated(hint) for name, hint in hints.items() if name in declared.parameters}

        @wraps(function)
        def checking(*arguments: Any, **named: Any) -> Any:
            try:
                bound = declared.bind(*arguments, **named)
            except TypeError as error:
                known = ", ".join(declared.parameters)
                raise TypeError(f"{function.__name__}: {error}; its arguments are {known}.") from None
            for name, value in bound.arguments.items():
                parameter = declared.parameters[name]
                # Others are checked by whom they are passed on to.
                if name in annotations() and parameter.kind is not Parameters.VAR_KEYWORD:
                    kinds, number = annotations()[name]
                    unit = number.unit if number else units.get(name)
                    bound.arguments[name] = _argument(name, value, kinds, number, unit)
            return function(*bound.args, **bound.kwargs)

        return cast(Function, checking)

    return decorated


def _argument(
    name: str, value: Any, kinds: tuple[Any, ...], number: Parameter | None, unit: str | None
) -> Any:
    """Return the value of an argument as its function takes it, or refuse it."""
    # A number of an array is one.
    if getattr(value, "ndim", -1) == 0 and hasattr(value, "item"):
        value = value.item()
    if unit is not None:
        value = numbers_in_si(name, value, unit)
    if isinstance(value, list | tuple) and np.ndarray in [get_origin(kind) for kind in kinds]:
        value = as_array(name, value)
    if not any(is_kind(value, kind) for kind in kinds):
        # Another text than those admitted is of their kind.
        text = isinstance(value, str) and any(get_origin(kind) is Literal for kind in kinds)
        raise (ValueError if text else TypeError)(_other_kind(name, value, kinds))
    if isinstance(value, float | int) and isnan(value):
        raise ValueError(f"{name} is {value}; it must be a number.")
    if isinstance(value, float | int) and number and not number.admits(value):
        wrong = f"; it must be {number.range}" if has_magnitude(value, number) else f", {BEYOND}"
        raise ValueError(f"{name} is {value}{number.label}{wrong}.")
    return value


def numbers_in_si(name: str, value: Any, unit: str) -> Any:
    """Return a number, or numbers in lists, with texts with units, '1 um', in SI; all else as it is.

    Raises:
        UnitError: a unit is unknown or has another dimension; the sentence begins with the name.
    """
    if isinstance(value, list | tuple):
        return type(value)(numbers_in_si(name, each, unit) for each in value)
    if isinstance(value, np.ndarray) and value.dtype.kind == "U":
        return np.array(numbers_in_si(name, value.tolist(), unit))
    return in_si(name, value, unit)


def as_array(name: str, value: Any, unit: str = "1") -> Array:
    """Return a number, or numbers in lists or an array, as an array in SI; texts with units are converted.

    Raises:
        TypeError: it has something else than numbers.
        ValueError: its rows are of several lengths, or a unit is another one.
    """
    numbers = numbers_in_si(name, value, unit)
    try:
        array = np.asarray(numbers)
    except ValueError:
        raise ValueError(f"{name} is {shown(value)}; its rows must be of one length.") from None
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} is {shown(value)}; it must be an array of numbers.")
    return array.astype(np.float64)


def check_fields(owner: Any, title: str = "") -> None:
    """Refuse an object of a dataclass by the fields that are not as annotated and declared.

    Texts with units, '1 um', are converted. Sentences begin with the title, or the name of the class.

    Raises:
        TypeError: with a sentence for each field that is of another kind.
        ValueError: with a sentence for each number that is not finite or out of its range.
    """
    owner_class: type = type(owner)
    title = title or owner_class.__name__
    kinds, ranges = [], []
    for name, field in declared_fields(owner_class).items():
        value, parameter = getattr(owner, name), field.parameter
        # Nearly every value is a number in its range, or of the very class.
        if type(value) in field.kinds and (
            parameter.admits(value) if parameter and type(value) is float else not isinstance(value, Real)
        ):
            continue
        if field.is_number and isinstance(value, str) and str not in field.kinds:
            assert parameter is not None
            value = in_si(f"{title}: {name}", value, parameter.unit)
            object.__setattr__(owner, name, value)
        is_number = isinstance(value, Real)
        if not any(is_kind(value, kind) for kind in field.kinds):
            kinds.append(_other_kind(f"{title}: {name}", value, field.kinds))
        elif is_number and not has_magnitude(value, parameter):
            ranges.append(f"{title}: {name} is {value}, {BEYOND}.")
        elif is_number and parameter and not parameter.admits(value):
            sentence = f"{title}: {name} is {value}{parameter.label}; it must be {parameter.range}."
            ranges.append(f"{sentence} {field.hint}".rstrip())
    if kinds:
        raise TypeError(" ".join(kinds))
    if ranges:
        raise ValueError(" ".join(ranges))


class Checked:
    """Checks every object of a dataclass that derives from it by `check_fields`."""

    def __post_init__(self) -> None:
        check_fields(self)


def check_kind(name: str, value: object, kind: Any) -> None:
    """Refuse what is of another kind by a TypeError: `check_kind("The duration", duration, float)`.

    float and int stand for every number and whole number, `Motor | Setup` for either.
    """
    # Nearly every value is of the very class.
    if type(value) is kind:
        return
    kinds = kinds_of(kind)
    if not any(is_kind(value, each) for each in kinds):
        raise TypeError(_other_kind(name, value, kinds))


check_number = partial(check_kind, kind=float)


def check_shape(name: str, values: Any, shape: tuple[int, ...], meaning: str, kinds: str = "iuf") -> None:
    """Refuse what is no array of numbers (TypeError), or not finite or of another shape (ValueError).

    In the shape, -1 stands for any number; the kinds are those of NumPy's `dtype.kind`.
    """
    if not (isinstance(values, np.ndarray) and values.dtype.kind in kinds):
        raise TypeError(f"{name} is {shown(values)}; it must be a NumPy array of numbers.")
    sizes = zip(values.shape, shape, strict=False)
    if len(values.shape) != len(shape) or any(n != m for n, m in sizes if m >= 0):
        expected = str(shape).replace("-1", "any")
        raise ValueError(f"{name} has shape {values.shape}; it must have shape {expected}, {meaning}.")
    if not np.isfinite(values).all():
        odd = values[~np.isfinite(values)][0]
        raise ValueError(f"{name} has {odd} among its numbers; all must be finite.")


def check_records(duration: float, interval: float, name: str, numbers: int = 0, parts: int = 1) -> None:
    """Refuse more records than a run may have, or than there is memory for, by a ValueError.

    What passes here is a file that `check_declared` lets pass.

    Args:
        duration, interval: of the run and its records [s].
        name: of the interval.
        numbers: of a record beside the usual ones.
        parts: of the run, each of which has a last record of its own.
    """
    count = ceil(duration / interval - ON_GRID) + parts - 1
    if count <= FEW_RECORDS:
        return
    size = RECORD_SIZE + NUMBER_SIZE * numbers
    most = min(float(MOST_RECORDS), min(MOST_MEMORY, available_memory()) / size)
    if count > most:
        raise ValueError(
            f"{name} is {interval:.6g} s; a duration of {duration:.6g} s makes {count:.8g} records of it, "
            f"{size_of(count * size)}, and {most:.8g} are the most, {size_of(most * size)}: it "
            f"must be at least {duration / most:.3g} s. Records do not change the motion."
        )


def check_size(name: str, size: float, count: float = 0.0) -> None:
    """Refuse what is larger [bytes] than there is memory for, or has too many rows, by a ValueError."""
    most = min(MOST_MEMORY, available_memory())
    if size > most:
        raise ValueError(f"{name} takes {size_of(size)}; {size_of(most)} are the most.")
    if count > MOST_RECORDS + 1:
        raise ValueError(f"{name} has {count:.8g} rows; {MOST_RECORDS + 1} are the most.")


def available_memory() -> float:
    """Return the memory that this process can have [bytes]; infinite where the system does not tell."""
    try:
        fields = dict(line.split(":", 1) for line in MEMORY_INFO.read_text().splitlines())
        return 1024.0 * float(fields["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        return inf


def size_of(count: float) -> str:
    """Write a number of bytes as a sentence shows it.

    >>> size_of(3.8e9)
    '3.8 GB'
    """
    return f"{count / 1e9:.3g} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB"


def shown(value: object) -> str:
    """Write a value as a sentence shows it."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    text = repr(value)
    return text if len(text) <= 60 else f"of the type {type(value).__name__}"


def is_kind(value: object, kind: Any) -> bool:
    """Return whether a value is of an annotated kind: a class, a number, a `Literal`, a list, a mapping.

    What only a type checker can tell apart is admitted.
    """
    if type(value) is kind:
        return True
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return isinstance(value, str) and value in arguments
    if origin in (list, Sequence):
        return isinstance(value, list | tuple) and all(
            any(is_kind(each, kind) for kind in kinds_of(arguments[0])) for each in value
        )
    if origin is tuple:
        fits = isinstance(value, tuple) and len(value) == len(arguments)
        return fits and all(map(is_kind, cast("tuple[Any, ...]", value), arguments))
    if origin is Mapping:
        return isinstance(value, Mapping) and all(is_kind(key, arguments[0]) for key in value)
    if origin is Callable:
        return callable(value)
    if kind in (float, int):
        number = Real if kind is float else Integral
        return isinstance(value, number) and not isinstance(value, bool)
    checked = origin or kind
    if kind is Any or not isinstance(checked, type) or getattr(checked, "_is_protocol", False):
        return True
    return isinstance(value, checked)


def read_json(text: str | bytes, kind: type[Read]) -> Read:
    """Return a dataclass that was written as JSON, each value checked against the annotation of its field.

    Fields of other names are passed over.

    Raises:
        ValueError: it is no JSON, a field is missing, or a value is of another kind.
        RecursionError: its lists are nested too deeply.
    """
    return cast(Read, _as_kind(kind.__name__, json.loads(text), kind))


def _as_kind(name: str, value: Any, kind: Any) -> Any:
    """Return a value of JSON as an annotated kind: a mapping as a dataclass, a list as a tuple."""
    origin, inner = get_origin(kind), get_args(kind)
    if is_dataclass(kind) and isinstance(value, dict):
        hints = get_type_hints(kind)
        known = {key: _as_kind(key, value[key], hints[key]) for key in hints.keys() & value.keys()}
        try:
            return cast(type, kind)(**known)
        except TypeError as error:
            raise ValueError(f"{name} is not whole: {error}.") from error
    if origin is tuple and isinstance(value, list):
        # Many plain values are looked over at once.
        plain = {*map(type, value)} <= {*kinds_of(inner[0])}
        return tuple(value if plain else (_as_kind(name, each, inner[0]) for each in value))
    if origin is Mapping and isinstance(value, dict):
        return {key: _as_kind(f"{name}.{key}", each, inner[1]) for key, each in value.items()}
    if not any(is_kind(value, each) for each in kinds_of(kind)):
        raise ValueError(_other_kind(name, value, kinds_of(kind)))
    return value


def _other_kind(name: str, value: object, kinds: tuple[Any, ...]) -> str:
    expected = " or ".join(dict.fromkeys(map(_called, kinds)))
    return f"{name} is {shown(value)}; it must be {expected}.{_way_out(value, kinds)}"


def _way_out(value: object, kinds: tuple[Any, ...]) -> str:
    """Return how what is of another kind becomes one of these: a class by a call, a name by its function."""
    if isinstance(value, type):
        return f" Call it: {value.__name__}(...)."
    if isinstance(value, list | tuple):
        # What is wrong with a list is the first of its items that no list admits.
        listed = [kinds_of(get_args(kind)[0]) for kind in kinds if get_origin(kind) in (list, Sequence)]
        odd = (x for x in value for inner in listed if not any(is_kind(x, kind) for kind in inner))
        return next((text for x in odd for inner in listed if (text := _way_out(x, inner))), "")
    if isinstance(value, str):
        names = {each for kind in kinds for each in _classes_in(kind)}
        return "".join(f" Make it: {way.format(value)}." for each, way in _BY_NAME.items() if each in names)
    return ""


def _classes_in(kind: Any) -> list[str]:
    """Return the names of the classes of which a kind is, or has as items."""
    inner = [name for each in get_args(kind) for part in kinds_of(each) for name in _classes_in(part)]
    return [getattr(kind, "__name__", ""), *inner]


def _called(kind: Any) -> str:
    """Return what a value of a kind is called."""
    origin = get_origin(kind)
    if origin is Literal:
        return " or ".join(map(repr, get_args(kind)))
    if text := _NAMES.get(origin or kind):
        return text
    return f"{'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}"


def check_declared(source: Path | bytes) -> None:
    """Refuse a file, or its content, whose variables do not fit into memory; a small one may declare many.

    Raises:
        OSError: it cannot be opened.
        ValueError: too many bytes or rows; a sentence.
    """
    import netCDF4

    opened = (
        netCDF4.Dataset("content", memory=source) if isinstance(source, bytes) else netCDF4.Dataset(source)
    )
    with opened as file:
        groups = deque([file])
        size = longest = 0.0
        while groups:
            group = groups.popleft()
            groups += group.groups.values()
            for variable in group.variables.values():
                # Texts have no size of their own.
                each = getattr(variable.dtype, "itemsize", 8)
                size += float(prod(map(float, variable.shape))) * each
                longest = max(longest, *map(float, variable.shape), 0.0)
    check_size("Its content", size, longest)
