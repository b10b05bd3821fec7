"""What a number of a motor or a law may be, stated by its key and a distribution."""

import re
from dataclasses import dataclass
from typing import Any, ClassVar, Final, Self, final

from contactlab.estimate import Estimate

Distribution = float | str | Estimate | tuple[float | str, float | str]
"""What a number may be: within a share of its value, of which 0 is exact; normal, by mean and deviation; or
uniform between two ends, in SI or texts with units, or in the logarithm: 'log(2e-6..2e-5)'."""

LOG: Final = re.compile(r"log\((.+)\.\.(.+)\)")

FORMS: Final = "LOW..HIGH", "log(LOW..HIGH)", "MEAN+-DEVIATION", "+-SHARE"
"""A distribution as it is written in a command."""


@final
@dataclass(frozen=True)
class Prior:
    """What a number of a motor or a law may be.

    >>> Prior.of_text("rotor.inertia=+-0.1"), str(Prior("drive.phase", Estimate(-0.6, 0.05)))
    (Prior(name='rotor.inertia', value=0.1), 'drive.phase=-0.6+-0.05')

    Args:
        name: of the number, as a full key.
        value: its distribution.
    """

    PATTERN: ClassVar[re.Pattern[str]] = re.compile(
        r"(?!(?:law|law/\w+)=)(?P<name>[\w.]+)="
        rf"(?:(?P<log>{LOG.pattern})"
        r"|(?P<first>(?:\s*[-+]?\.?\d[^,\[(]*?)?)(?P<sign>(?<!/)\.\.|\+-)(?P<second>\s*[-+]?\.?\d.*))"
    )
    """Words of a command that are one: KEY= and one of `FORMS`, of numbers, which no path has: a=b/../c."""

    name: str
    value: Distribution

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Read a word; a ValueError if it is something else."""
        if not (word := cls.PATTERN.fullmatch(text)):
            raise ValueError(f"it must be KEY={' or KEY='.join(FORMS)}")
        if word["log"]:
            return cls(word["name"], word["log"])
        ends: Any = [number_in(word["first"]), number_in(word["second"])]
        if word["sign"] == "..":
            return cls(word["name"], tuple(ends))
        return cls(word["name"], Estimate(*ends) if word["first"] else ends[1])

    def __str__(self) -> str:
        match self.value:
            case Estimate(mean, deviation):
                return f"{self.name}={mean}+-{deviation}"
            case (low, high):
                return f"{self.name}={low}..{high}"
            case str(text) if LOG.fullmatch(text):
                return f"{self.name}={text}"
        return f"{self.name}=+-{self.value}"


def number_in(text: str) -> float | str:
    """Return the number that a text is, or the text, stripped: a number with a unit."""
    try:
        return float(text)
    except ValueError:
        return text.strip()
