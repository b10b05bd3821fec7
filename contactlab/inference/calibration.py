"""Laws brought to one datum, so that a difference between them is not one of default numbers."""

import re
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar, Final, Literal, Self, final

import numpy as np

from contactlab.arrays import Array
from contactlab.impacts import impact
from contactlab.inference.free_parameters import FreeParameter, free_parameters, with_values
from contactlab.laws import ContactLaw

EXPECTED: Final = (
    "it must be restitution=VALUE@SPEED, greater than 0 and at most 1, or contact_time=VALUE@SPEED in s, "
    "greater than 0; the speed in m/s, greater than 0"
)


@final
@dataclass(frozen=True)
class Datum:
    """What every law must have in a normal impact.

    >>> Datum.of_text("restitution=0.6@0.1")
    Datum(quantity='restitution', value=0.6, speed=0.1)

    Args:
        quantity: 'restitution', speed of separation over that of approach [1], or 'contact_time' [s].
        value: of it, SI.
        speed: of the approach [m/s].
    """

    PATTERN: ClassVar[re.Pattern[str]] = re.compile(r"(restitution|contact_time)=([-+.\deE]+)@([-+.\deE]+)")
    """Words of a command that are one: QUANTITY=VALUE@SPEED."""

    quantity: Literal["restitution", "contact_time"]
    value: float
    speed: float

    def __post_init__(self) -> None:
        highest = {"restitution": 1.0, "contact_time": inf}.get(self.quantity, 0.0)
        if not (0.0 < self.value <= highest and 0.0 < self.speed < inf):
            raise ValueError(f"calibrate is {self}; {EXPECTED}.")

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Read QUANTITY=VALUE@SPEED; a ValueError if it is something else."""
        if not (word := cls.PATTERN.fullmatch(text.replace(" ", ""))):
            raise ValueError(EXPECTED)
        quantity: Any = word[1]
        return cls(quantity, float(word[2]), float(word[3]))

    def __str__(self) -> str:
        return f"{self.quantity}={self.value}@{self.speed}"

    def measured(self, law: ContactLaw, delassus: Array) -> float:
        """Return the quantity of a law's normal impact; NaN where the bodies do not part."""
        outcome = impact(law, delassus, [-self.speed, 0.0])
        if not outcome["released"].item():
            return float("nan")
        if self.quantity == "contact_time":
            return float(outcome["duration"].item())
        return float(outcome["velocity_after"].sel(direction="normal").item()) / self.speed


def calibrated(law: ContactLaw, datum: Datum, delassus: Array) -> tuple[FreeParameter, float] | None:
    """Return the number of a law by which it meets a datum, and its value, by Brent's method.

    The first number, in the order of the law's fields, whose range reaches the datum.

    Args:
        law: any.
        datum: of a normal impact.
        delassus: D of the bodies [1/kg], shape (2, 2).

    Returns:
        None where no single number brings the law to the datum, as restitution under a law without loss.
    """
    # Imported here: a run needs no scipy.optimize.
    from scipy.optimize import brentq

    for free in free_parameters(law):

        def off(share: float, free: FreeParameter = free) -> float:
            try:
                changed = with_values(law, [free], [free.from_unit(share)])
            except ValueError:
                return float("nan")
            return datum.measured(changed, delassus) - datum.value

        # Near an end of a wide range bodies may not part.
        shares = np.linspace(0.0, 1.0, 9)
        values = np.array([off(float(share)) for share in shares])
        for i in np.flatnonzero(values[:-1] * values[1:] <= 0.0):
            if values[i] != values[i + 1]:
                return free, free.from_unit(float(brentq(off, shares[i], shares[i + 1], xtol=1e-12)))
    return None
