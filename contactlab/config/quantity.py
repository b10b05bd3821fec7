"""A number of the configuration: its unit, its range and the way out of a fault."""

from dataclasses import dataclass
from math import isfinite
from numbers import Real
from typing import Any, final

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from contactlab.config.units import UnitError, to_si

FAULT = "quantity"
"""Type of the pydantic error that carries a finished sentence, all but the key."""

MISSING = "???"
"""What a configuration file writes for a value that has to be given."""

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


@final
@dataclass(frozen=True)
class Quantity:
    """Annotation of a number: `Annotated[float, Quantity("m", above=0.0)]`.

    Takes a number in the SI unit or a text with a unit, and gives a finite float within the range.
    Booleans are refused.

    Args:
        unit: SI unit, '1' for a pure number.
        above, below: bounds that are not admitted themselves, in the unit.
        at_least, at_most: bounds that are.
        hint: a sentence that helps someone who has run into the range.
        none: whether null is admitted; the hint says what it stands for.
        whole: whether the number must be an integer.
    """

    unit: str
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    hint: str = ""
    none: bool = False
    whole: bool = False

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Replace pydantic's own check of the annotated type."""
        return core_schema.no_info_plain_validator_function(self.validate)

    def validate(self, value: object) -> float | None:
        """The number in the SI unit.

        Raises:
            PydanticCustomError: with a sentence that lacks its subject, the key.
        """
        # Nearly every value is a sound float; sentences are for the others.
        if type(value) is float and not self.whole and self._within(value) and isfinite(value):
            return value
        if value is None and self.none:
            return None
        if value == MISSING:
            raise self._fault("missing", self._expected)
        try:
            number, shown = self._number(value)
        except UnitError as error:
            raise self._fault(f"{describe(value)}, {error}", self._expected) from None
        if not isfinite(number):
            raise self._fault(f"{number}, which is not finite", self._expected)
        if self.whole and number != int(number):
            raise self._fault(f"{shown}, which is not a whole number", self._expected)
        if not self._within(number):
            raise self._fault(shown, self.range)
        return int(number) if self.whole else number

    @property
    def label(self) -> str:
        """The unit as it follows a number, empty for a pure number."""
        return "" if self.unit == "1" else f" {self.unit}"

    @property
    def range(self) -> str:
        """The admitted range in words, empty where every finite number will do."""
        bounds = (
            ("greater than", self.above),
            ("at least", self.at_least),
            ("less than", self.below),
            ("at most", self.at_most),
        )
        return " and ".join(f"{word} {x:g}{self.label}" for word, x in bounds if x is not None)

    @property
    def _expected(self) -> str:
        """What a value must be, for one that is no number at all."""
        kind = "a whole number" if self.whole else "a number"
        unit = f" in {self.unit}" if self.unit != "1" and not self.range else ""
        example = f", for example '{_EXAMPLES[self.unit]}'" if self.unit in _EXAMPLES else ""
        return f"{kind}{unit}{' that is ' if self.range else ''}{self.range}{example}"

    def _number(self, value: object) -> tuple[float, str]:
        """The number in SI, and the value as a sentence shows it."""
        if isinstance(value, str):
            number = to_si(value, self.unit)
            return number, f"'{value}' ({number:.12g}{self.label})"
        if isinstance(value, bool) or not isinstance(value, Real):
            raise UnitError("which is not a number")
        try:
            return float(value), f"{float(value):.12g}{self.label}"
        except OverflowError:
            raise UnitError("which is too large") from None

    def _within(self, number: float) -> bool:
        return (
            (self.above is None or number > self.above)
            and (self.at_least is None or number >= self.at_least)
            and (self.below is None or number < self.below)
            and (self.at_most is None or number <= self.at_most)
        )

    def _fault(self, what: str, expected: str) -> PydanticCustomError:
        hint = f" {self.hint}" if self.hint else ""
        sentence = f"is {what}; it must be {expected}.{hint}"
        # The sentence goes in as context: braces in a user's text are no placeholders.
        return PydanticCustomError(FAULT, "{sentence}", {"sentence": sentence})


def describe(value: object) -> str:
    """A value of a configuration as a sentence shows it."""
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
