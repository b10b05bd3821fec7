"""Numbers with units: the text '1 um' becomes 1e-6 in metres.

A bare number is SI already. Angles are told apart from pure numbers, which most unit libraries do
not do: '20 krad/s' is no frequency in Hz, and '2 Hz' is no angular velocity. Either would be
wrong by 2 pi without a word.
"""

import re
from decimal import Decimal
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pint

_NUMBER_AND_UNIT = re.compile(
    r"\s*(?P<number>[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)\s*(?P<unit>[^\W\d_°%][\w\s*/^().-]*|[°%])\s*"
)


_CF_POWER = re.compile(r"(?P<unit>[A-Za-z]+)(?P<power>-?\d+(\.\d+)?)")


class UnitError(ValueError):
    """A text without a fitting number; the message goes on from '<key> is <text>, '."""


def from_cf(unit: str) -> str:
    """A unit of the CF conventions, 'N m-1.5', as configurations write it: 'N/m^1.5'."""
    above: list[str] = []
    below: list[str] = []
    for factor in unit.split():
        found = _CF_POWER.fullmatch(factor)
        power = found["power"] if found else "1"
        word = found["unit"] if found else factor
        size = power.removeprefix("-")
        (below if power.startswith("-") else above).append(
            word if size == "1" else f"{word}^{size}"
        )
    return "/".join([" ".join(above) or "1", *below])


def to_cf(unit: str) -> str:
    """A unit of a configuration, 'N/m^1.5', in the words of the CF conventions: the way back."""
    above, *below = unit.split("/")
    factors = [factor.replace("^", "") for factor in above.split() if factor != "1"]
    for factor in below:
        word, _, power = factor.partition("^")
        factors.append(f"{word}-{power or 1}")
    return " ".join(factors) or "1"


def to_si(text: str, unit: str) -> float:
    """The number that a text gives, in an SI unit.

    Args:
        text: a number ('1e-6') or a number with a unit ('1 um').
        unit: the SI unit of the result as pint spells it, '1' for a pure number.

    Raises:
        UnitError: if the text is neither, or if its unit has another dimension.
    """
    try:
        return float(text)
    except ValueError:
        pass
    parts = _NUMBER_AND_UNIT.fullmatch(text)
    if parts is None:
        raise UnitError("which is not a number")
    given = _root(parts["unit"])
    if given is None:
        raise UnitError(f"whose unit '{parts['unit'].strip()}' is unknown")
    factor, units = given
    wanted = _root(unit)
    if wanted is None:
        raise UnitError(f"which cannot be converted to the declared unit {unit}: that is unknown")
    # A damper's N m s per rad is usually written without the rad.
    spelled = (wanted, _root(unit.removesuffix("/rad")))
    if units not in [found[1] for found in spelled if found]:
        expected = "a pure number" if unit == "1" else unit
        raise UnitError(f"whose unit '{parts['unit'].strip()}' cannot be converted to {expected}")
    try:
        return float(Decimal(parts["number"]) * factor / wanted[0])
    except ArithmeticError:
        raise UnitError("which is too large") from None


@cache
def _registry() -> "pint.UnitRegistry[Decimal]":
    # Imported here: pint takes longer to start than all other checks together, and most runs
    # give plain numbers. Decimal keeps 0.3 ms the float that 3e-4 is.
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


@cache
def _root(unit: str) -> "tuple[Decimal, pint.Unit] | None":
    """Factor and units in base units with angles kept, or None for an unknown unit."""
    registry = _registry()
    try:
        quantity = registry.Quantity(Decimal(1), registry.parse_units("" if unit == "1" else unit))
        root = quantity.to_root_units()
    # pint lets the errors of its tokenizer and parser through, among them AssertionError.
    except Exception:
        return None
    return Decimal(root.magnitude), registry.Unit(root.units)
