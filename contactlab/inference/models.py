"""What predicts an impact: a contact law, or the plainest things that a law has to be better than."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.impact import velocities_after
from contactlab.inference.free_parameters import Free, free_parameters, label_of, with_values
from contactlab.laws import ContactLaw, Newton, PenaltyLaw
from contactlab.measured.floors import best_impulses, with_constant_impulse
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.parameter import Parameter

TOLERANCE: Final = 1e-4
"""Of compliant laws: measurements are never known so well."""

FRICTIONLESS: Final = "frictionless"
CONSTANT_IMPULSE: Final = "constant impulse"


class Model(ABC):
    """Predicts velocities after impacts from those before, with parameters that may be fitted.

    Its label is what tables call it. A costly one is fitted on a part of the impacts.
    """

    label: str
    free: tuple[Free, ...]

    @property
    def costly(self) -> bool:
        """Whether every impact is integrated."""
        return False

    @property
    def step(self) -> float | None:
        """Of differences in the unit cube; see `contactlab.inference.least_squares.best_fit`."""
        return None

    @abstractmethod
    def after(self, values: Array, impacts: MeasuredImpacts) -> Array:
        """Give gap rate and slip after the impacts [m/s], shape (impact, 2); NaN where there is no answer.

        Args:
            values: of the free parameters [SI], shape (parameter,).
            impacts: of which nothing is used but what was there before.
        """

    def held(self) -> Mapping[str, float]:
        """Give the parameters that are not free, by name, SI."""
        return {}


@final
@dataclass(frozen=True)
class LawModel(Model):
    """A contact law of either family; a baseline is there to be better than."""

    law: ContactLaw
    free: tuple[Free, ...]
    label: str
    baseline: bool = False

    @classmethod
    def of(
        cls, law: ContactLaw, chosen: Mapping[str, tuple[float, float] | None] | None = None, label: str = ""
    ) -> "LawModel":
        """Give the model of a law; what is free is as of `free_parameters`.

        Raises:
            ValueError: a name that the law has not, or a range that it does not admit.
        """
        return cls(law, free_parameters(law, chosen), label or label_of(law))

    @property
    def costly(self) -> bool:
        """Whether every impact is integrated."""
        return isinstance(self.law, PenaltyLaw)

    @property
    def step(self) -> float | None:
        """The square root of the tolerance, where there is one."""
        return TOLERANCE**0.5 if self.costly else None

    def after(self, values: Array, impacts: MeasuredImpacts) -> Array:
        """See `Model.after`; values that the law refuses together have no answer."""
        try:
            law = with_values(self.law, self.free, values)
        except ValueError:
            return np.full_like(impacts.velocity_before, np.nan)
        tolerance = TOLERANCE if self.costly else None
        return velocities_after(law, impacts.delassus, impacts.velocity_before, tolerance)

    def held(self) -> Mapping[str, float]:
        """See `Model.held`."""
        names = {one.name for one in self.free}
        return {name: value for name, value in self.law.describe().items() if name not in names}


def frictionless() -> LawModel:
    """Give Newton's impact without friction, its restitution free."""
    law = Newton(friction_coefficient=0.0)
    return LawModel(law, free_parameters(law, {"restitution": None}), FRICTIONLESS, baseline=True)


@final
@dataclass(frozen=True)
class ConstantImpulse(Model):
    """One impulse for all impacts, its tangential part against the slip: it knows nothing of an impact."""

    free: tuple[Free, ...]
    label: str = CONSTANT_IMPULSE

    @classmethod
    def of(cls, impacts: MeasuredImpacts) -> "ConstantImpulse":
        """Give the model with ranges that hold what the largest of these impacts needs."""
        largest = np.abs(best_impulses(impacts)).max(axis=0)
        words = ("normal", "tangential")
        free = tuple(
            Free(f"{word}_impulse", low, float(high), False, Parameter(symbol, "N s", f"{word} impulse"))
            for word, symbol, low, high in zip(
                words, ("p_n", "p_t"), (0.0, -float(largest[1])), largest, strict=True
            )
        )
        return cls(free)

    def after(self, values: Array, impacts: MeasuredImpacts) -> Array:
        """See `Model.after`."""
        return with_constant_impulse(impacts, values)
