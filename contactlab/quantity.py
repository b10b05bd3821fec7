"""Numbers of a configuration: in SI, or a text with a unit ('1 um').

Angles are no pure numbers: taken as 2 Hz, '2 rad/s' would silently be wrong by 2 pi.
"""

import re
import reprlib
from contextlib import suppress
from decimal import Decimal
from functools import cache
from numbers import Real
from typing import TYPE_CHECKING, Any

from contactlab.parameter import BEYOND, DeclaredField, from_cf, has_magnitude

if TYPE_CHECKING:
    import pint

MISSING = "???"
"""What a configuration file writes for a value that has to be given."""

_NUMBER_AND_UNIT = re.compile(
    r"\s*(?P<number>[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)"
    r"\s*(?P<unit>((?<=\s)1\s*/\s*)?[^\W\d_°%]([\w\s*/^()-]|\.(?=\d))*|[°%])\s*"
)

_CF = re.compile(r"\s*[^\W\d_]+(-?\d+(\.\d+)?)?(\s+[^\W\d_]+(-?\d+(\.\d+)?)?)*\s*")
"""Units of the CF conventions: 'm2 s-2'."""

_FORCE_TIMES = re.compile(r"(?<![^\W\d_])([npuµμmkM]?N)((?:[uµμmck]?m)?)(s?)(?![^\W\d_])")
"""Newtons with metres or seconds as on data sheets, 'mNm' and 'Ns', which pint reads as other units."""


class UnitError(ValueError):
    """Fault of a value, as a rule without its subject."""


def number_of(field: DeclaredField, value: object) -> float | str | None:
    """Return the number in SI that a value stands for, or a choice; a UnitError with its fault, "is ..."."""
    if (value is None or isinstance(value, str)) and value in field.choices:
        return value
    declared, whole = field.parameter, int in field.kinds
    assert declared is not None
    # Nearly every value is a float that needs no closer look.
    if type(value) is float and not whole and declared.admits(value):
        return value
    try:
        if isinstance(value, bool) or not isinstance(value, str | Real):
            raise UnitError("which is not a number")
        number = to_si(value, declared.unit) if isinstance(value, str) else float(value)
    except OverflowError:
        wrong = f"{describe(value)}, which is too large"
    except UnitError as error:
        wrong = "missing" if value == MISSING else f"{describe(value)}, {error}"
    else:
        plain = f"{number:.12g}{declared.label}"
        shown = f"'{value}' ({plain})" if isinstance(value, str) else plain
        if not has_magnitude(number, declared):
            wrong = f"{shown}, {BEYOND}"
        elif whole and number != int(number):
            wrong = f"{shown}, which is not a whole number"
        elif declared.admits(number):
            return int(number) if whole else number
        else:
            raise UnitError(f"is {shown}; it must be {declared.range}. {field.hint}".rstrip())
    bounds = (
        f" that is {declared.range}" if declared.range else f" in {declared.unit}" if declared.label else ""
    )
    example = example_in(declared.unit)
    expected = f"a{' whole' if whole else ''} number{bounds}{example and ', for example ' + example}"
    expected = " or ".join([expected, *map(repr, filter(None, field.choices))])
    raise UnitError(f"is {wrong}; it must be {expected}. {field.hint}".rstrip())


def example_in(unit: str) -> str:
    """Return a text with a unit that converts to this one, in quotes; empty for a pure number."""
    if unit[0] == "1":
        return ""
    # No prefix goes before a kilogram.
    prefix = "k" if unit == "Hz" else "m"
    return f"'2 g{unit[2:]}'" if unit.startswith("kg") else f"'2 {prefix}{unit}'"


def describe(value: object) -> str:
    """Return a value of a configuration as messages show it."""
    if isinstance(value, list | tuple):
        # A list of lists may be as large as aliases in YAML make it.
        return f"the list {reprlib.repr(list(value))}"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, str):
        return f"'{value}'"
    return "null" if value is None else str(value).lower()


def to_si(text: str, unit: str) -> float:
    """Return the number of a text, '1e-6' or '1 um', in an SI unit as configurations write it, '1' for none.

        >>> to_si("0.5 um", "m"), to_si("2 mN*m", "N m")
        (5e-07, 0.002)

    Raises:
        UnitError: the text is no such number, or its unit has another dimension.
    """
    with suppress(ValueError):
        return float(text)
    parts = _NUMBER_AND_UNIT.fullmatch(text)
    if parts is None:
        raise UnitError("which is not a number")
    try:
        return float(Decimal(parts["number"]) * factor(parts["unit"], unit))
    except ArithmeticError:
        raise UnitError("which is too large") from None


def is_quantity(value: object) -> bool:
    """Return whether a value is a text of a number with a unit, '1 um'."""
    if not isinstance(value, str):
        return False
    try:
        float(value)
    except ValueError:
        return _NUMBER_AND_UNIT.fullmatch(value) is not None
    return False


def in_si(name: str, value: Any, unit: str) -> Any:
    """Return the number of a text with a unit in an SI unit, and anything else as it is.

    Raises:
        UnitError: the unit is unknown or has another dimension; the sentence begins with the name.
    """
    if not is_quantity(value):
        return value
    try:
        return to_si(value, unit)
    except UnitError as error:
        expected = "a pure number" if unit == "1" else f"in {unit}"
        raise UnitError(f"{name} is '{value}', {error}; it must be {expected}.") from error


@cache
def factor(text: str, unit: str) -> Decimal:
    """Return the factor that converts a number in a unit to an SI unit, '1' for none.

    Both may be written as configurations do, 'N/m^1.5', or as CF does, 'N m-1.5'.

    Raises:
        UnitError: the unit is unknown or has another dimension.
    """
    have, wanted = _root(text), _root(unit)
    if have is None:
        raise UnitError(f"whose unit '{text.strip()}' is unknown")
    if wanted is None:
        raise UnitError(f"which cannot be converted to the declared unit {unit}: that is unknown")
    # A damper's N m s per rad is usually written without the rad.
    without_angle = _root(unit.removesuffix("/rad")) or wanted
    if have[1] not in (wanted[1], without_angle[1]):
        expected = "a pure number" if unit == "1" else unit
        raise UnitError(f"whose unit '{text.strip()}' cannot be converted to {expected}")
    return have[0] / wanted[0]


@cache
def dimensions(unit: str) -> dict[str, float]:
    """Return the powers of the base dimensions of a unit, {"[length]": 1.0}; an angle has none."""
    powers: dict[str, Any] = dict(_registry().parse_units(_as_pint(unit)).dimensionality)
    return {name: float(power) for name, power in powers.items()}


@cache
def _registry() -> "pint.UnitRegistry[Decimal]":
    # Imported here: plain numbers need neither library nor registry.
    import pint

    # Decimal keeps 0.3 ms the float that 3e-4 is.
    return pint.UnitRegistry(non_int_type=Decimal)


@cache
def _root(unit: str) -> "tuple[Decimal, pint.Unit] | None":
    """Return factor and units in base units with angles kept, or None for an unknown unit."""
    root = _parsed(unit)
    return _parsed(from_cf(unit)) if root is None and _CF.fullmatch(unit) else root


def _as_pint(unit: str) -> str:
    """Return a unit as pint reads it."""
    return "" if unit == "1" else _FORCE_TIMES.sub(lambda word: "*".join(filter(None, word.groups())), unit)


def _parsed(unit: str) -> "tuple[Decimal, pint.Unit] | None":
    registry = _registry()
    try:
        quantity = registry.Quantity(Decimal(1), registry.parse_units(_as_pint(unit)))
        root = quantity.to_root_units()
    # pint lets the errors of its tokenizer and parser through, among them AssertionError.
    except Exception:
        return None
    return Decimal(root.magnitude), registry.Unit(root.units)
