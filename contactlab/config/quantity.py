"""A declared number as the configuration takes it: a number in SI, or a text with a unit ('1 um').

Angles are told apart from pure numbers, which most unit libraries do not do: '20 krad/s' is no
frequency in Hz, and '2 Hz' is no angular velocity. Either would be wrong by 2 pi without a word.
"""

import re
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from math import isfinite
from numbers import Real
from types import NoneType
from typing import TYPE_CHECKING, Any, final

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from contactlab.parameter import DeclaredField, Parameter

if TYPE_CHECKING:
    import pint

FAULT = "quantity"
"""Type of the pydantic error that carries a finished sentence, all but the key."""

MISSING = "???"
"""What a configuration file writes for a value that has to be given."""

_NUMBER_AND_UNIT = re.compile(
    r"\s*(?P<number>[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)\s*(?P<unit>[^\W\d_°%][\w\s*/^().-]*|[°%])\s*"
)

_EXAMPLES = {
    "1/m": "1 um^-1",
    "1/s": "7.5 Hz",
    "C/m^2": "9.2 C/m**2",
    "F/m": "6.2 nF/m",
    "Hz": "3.2 kHz",
    "N m": "2 mN m",
    "N m s/rad": "1 uN m s/rad",
    "N/m": "20 kN/mm",
    "N/m^1.5": "1e10 N/m**1.5",
    "Pa": "210 GPa",
    "V": "100 V",
    "kg": "1.2 g",
    "kg m^2": "480 g cm**2",
    "kg/m^3": "7.85 g/cm**3",
    "m": "1 um",
    "rad": "-36 deg",
    "rad/s": "10 rpm",
    "s": "5 ms",
}


class UnitError(ValueError):
    """A text without a fitting number; the message goes on from '<key> is <text>, '."""


@final
@dataclass(frozen=True)
class Quantity:
    """Annotates a field of pydantic with what is declared of a number; replaces pydantic's own check.

    Args:
        declared: by the class that has the number.
        parameter: that of `declared`.
    """

    declared: DeclaredField
    parameter: Parameter

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Give pydantic the check of the annotated type."""
        return core_schema.no_info_plain_validator_function(self.validate)

    def validate(self, value: object) -> float | None:
        """Give the number in the SI unit.

        Raises:
            PydanticCustomError: with a sentence that lacks its subject, the key.
        """
        kinds, said = self.declared.kinds, self.parameter
        # Nearly every value is a sound float; sentences are for the others.
        if type(value) is float and float in kinds and said.holds(value):
            return value
        if value is None and NoneType in kinds:
            return None
        if value == MISSING:
            raise self._fault("missing", self._expected)
        try:
            number, shown = self._number(value)
        except UnitError as error:
            raise self._fault(f"{describe(value)}, {error}", self._expected) from None
        if not isfinite(number):
            raise self._fault(f"{number}, which is not finite", self._expected)
        if int in kinds and number != int(number):
            raise self._fault(f"{shown}, which is not a whole number", self._expected)
        if not said.admits(number):
            raise self._fault(shown, said.range)
        return int(number) if int in kinds else number

    @property
    def _expected(self) -> str:
        """What a value must be, for one that is no number at all."""
        said = self.parameter
        kind = "a whole number" if int in self.declared.kinds else "a number"
        unit = f" in {said.unit}" if said.label and not said.range else ""
        example = f", for example '{_EXAMPLES[said.unit]}'" if said.unit in _EXAMPLES else ""
        return f"{kind}{unit}{' that is ' if said.range else ''}{said.range}{example}"

    def _number(self, value: object) -> tuple[float, str]:
        """The number in SI, and the value as a sentence shows it."""
        label = self.parameter.label
        if isinstance(value, str):
            number = to_si(value, self.parameter.unit)
            return number, f"'{value}' ({number:.12g}{label})"
        if isinstance(value, bool) or not isinstance(value, Real):
            raise UnitError("which is not a number")
        try:
            return float(value), f"{float(value):.12g}{label}"
        except OverflowError:
            raise UnitError("which is too large") from None

    def _fault(self, what: str, expected: str) -> PydanticCustomError:
        sentence = f"is {what}; it must be {expected}. {self.declared.hint}".rstrip()
        # The sentence goes in as context: braces in a user's text are no placeholders.
        return PydanticCustomError(FAULT, "{sentence}", {"sentence": sentence})


def describe(value: object) -> str:
    """Write a value of a configuration as a sentence shows it."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f"'{value}'"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"the list {list(value)}"
    return str(value)


def to_si(text: str, unit: str) -> float:
    """Give the number that a text gives, in an SI unit.

    Args:
        text: a number ('1e-6') or a number with a unit ('1 um').
        unit: the SI unit of the result as configurations write it, '1' for a pure number.

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
    # Imported here: plain numbers, which most runs are given, need neither library nor registry.
    import pint

    # Decimal keeps 0.3 ms the float that 3e-4 is.
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
