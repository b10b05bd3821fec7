"""The range of a number, an option of studies: `Range("contact.clearance", "1 um", "4 um")`."""

import re
from dataclasses import dataclass
from typing import ClassVar, Self, final

from contactlab.quantity import UnitError, to_si


@final
@dataclass(frozen=True)
class Range:
    """A number of a motor from one value to another.

        >>> Range.of_text("contact.clearance=1 um..4 um").within("m")
        (1e-06, 4e-06)

    Args:
        name: of the number, as a full key.
        start, end: in SI, or texts with units.
    """

    PATTERN: ClassVar[re.Pattern[str]] = re.compile(
        r"(?P<name>[\w.]+)=(?P<start>\s*[-+]?\.?\d.*?)\.\.(?P<end>\s*[-+]?\.?\d.*)"
    )
    """Words of a command that are one: KEY=START..END. Both are numbers, which no path is: a/../b."""

    name: str
    start: float | str
    end: float | str

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Read KEY=START..END; a ValueError if it is something else."""
        if span := cls.PATTERN.fullmatch(text):
            return cls(span["name"], span["start"].strip(), span["end"].strip())
        raise ValueError("it must be KEY=START..END, as in contact.clearance=1 um..4 um")

    def __str__(self) -> str:
        return f"{self.name}={self.start}..{self.end}"

    def within(self, unit: str) -> tuple[float, float]:
        """Return start and end in SI.

        Raises:
            UnitError: one of them has another unit; a sentence that names both.
        """
        ends = []
        for side in (self.start, self.end):
            try:
                ends.append(to_si(side, unit) if isinstance(side, str) else float(side))
            except UnitError as error:
                raise UnitError(f"{self}, {error}") from error
        return ends[0], ends[1]
