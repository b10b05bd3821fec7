"""Measured impacts under one law: what it answers to each approach, compared with what was measured."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import final

import numpy as np

from contactlab.arrays import Array
from contactlab.impact import Impacts
from contactlab.inference.free_parameters import Free, with_values
from contactlab.inference.likelihood import approach_scale, impact_terms, student_factor
from contactlab.inference.problem import DEGREES_OF_FREEDOM, LARGEST, LOWEST, Measured
from contactlab.laws import ContactLaw
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.parameter import positive

SPREAD = "discrepancy"
"""Name of the error of the law, which is also the noise where none is stated."""


@final
@dataclass(frozen=True, eq=False)
class ImpactModel:
    """See `contactlab.inference.problem.Model`.

    Args:
        measured: the impacts.
        start: the law, with what is not free.
        fields: what of the law is free, named by its fields.
        keys: the same, named by the keys of a configuration.
        spread: whether the law may be wrong, or the noise unknown.
        degrees_of_freedom: of the Student-t distribution of the residuals; infinite is the normal one, None
            is free.
    """

    measured: MeasuredImpacts
    start: ContactLaw
    fields: tuple[Free, ...]
    keys: tuple[Free, ...]
    spread: bool
    degrees_of_freedom: float | None = inf
    free: tuple[Free, ...] = field(init=False)
    scale: Array = field(init=False)
    covariance: Array = field(init=False)
    asked: Impacts = field(init=False)

    def __post_init__(self) -> None:
        said = positive("s", "1", "error in the norm of the kinetic energy, over the approach")
        own = (Free(SPREAD, LOWEST, LARGEST, True, said),) if self.spread else ()
        tails = (DEGREES_OF_FREEDOM,) if self.degrees_of_freedom is None else ()
        stated, delassus = self.measured.covariance, self.measured.delassus
        object.__setattr__(self, "free", (*self.keys, *own, *tails))
        object.__setattr__(self, "asked", Impacts(delassus, self.measured.velocity_before))
        object.__setattr__(self, "scale", approach_scale(delassus, self.measured.velocity_before))
        object.__setattr__(self, "covariance", np.zeros_like(delassus) if stated is None else stated)

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.start.name

    @property
    def physical(self) -> int:
        """How many of what is free belong to the law."""
        return len(self.keys)

    @property
    def data(self) -> tuple[Measured, ...]:
        """The velocities after the impacts."""
        return (Measured("velocity_after", ("impact", "direction"), self.measured.velocity_after, "m s-1"),)

    @property
    def coordinates(self) -> dict[str, Array]:
        """The impacts' numbers in their file."""
        return {"impact": self.measured.number.astype(np.float64)}

    def predicted(self, values: Array) -> dict[str, Array] | None:
        """Give gap rate and slip after each impact [m/s]; None where the law answers with no number."""
        try:
            law = with_values(self.start, self.fields, values[: len(self.fields)])
        # Values that are sound one by one need not be so together.
        except ValueError:
            return None
        found = self.asked.velocities_after(law)
        return {"velocity_after": found} if np.isfinite(found).all() else None

    def residuals(self, values: Array) -> Array:
        """Give the errors in the norm of the kinetic energy, or over the stated ones; shape (2 impacts,)."""
        found = self.predicted(values)
        missed = np.full_like(self.measured.velocity_after, np.nan)
        if found is not None:
            missed = self.measured.velocity_after - found["velocity_after"]
        size = self.scale[:, None, None] * self.measured.delassus
        if self.measured.covariance is not None:
            size = self.covariance + LOWEST**2 * size
        return np.linalg.solve(np.linalg.cholesky(size), missed[..., None]).ravel()

    def terms(self, predicted: Mapping[str, Array], values: Array) -> dict[str, Array]:
        """Give the log density of each impact."""
        missed = self.measured.velocity_after - predicted["velocity_after"]
        spread, tails = self._noise(values)
        terms = impact_terms(missed, self.covariance, self.measured.delassus, self.scale, spread, tails)
        return {"velocity_after": terms}

    def replicated(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Give velocities after the impacts with error and noise, as drawn."""
        spread, tails = self._noise(values)
        size = self.covariance + spread**2 * self.scale[:, None, None] * self.measured.delassus
        noise = np.linalg.cholesky(size) @ draws.standard_normal((len(self.measured), 2, 1))
        factor = student_factor(draws, tails, len(self.measured))[:, None]
        return {"velocity_after": predicted["velocity_after"] + factor * noise[..., 0]}

    def _noise(self, values: Array) -> tuple[float, float]:
        """Return the error of the law, 0 for none, and the degrees of freedom of the residuals."""
        given = dict(zip((one.name for one in self.free), map(float, values), strict=True))
        free = given.get(DEGREES_OF_FREEDOM.name, inf)
        return given.get(SPREAD, 0.0), free if self.degrees_of_freedom is None else self.degrees_of_freedom
