"""An inference problem: measurements, a law with free numbers that predicts them, noise and priors.

One problem serves least squares, nested sampling and, for impacts, cross-validation. For data with outliers
noise may have a Student-t distribution in place of a normal one of the same scale (Lange, Little and Taylor
1989, J. Am. Stat. Assoc. 84, 881); infinite degrees of freedom are the normal distribution.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import inf, log, pi
from typing import Final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.parameter import positive
from contactlab_data.inference.free_parameters import FreeParameter

LOWEST: Final = 1e-4
LARGEST: Final = 1.0
"""Range of the size of noise and discrepancy, over the size of the data."""

LOG_TWO_PI: Final = log(2.0 * pi)

IMPOSSIBLE: Final = -1e300
"""Log likelihood of values without a prediction."""

DEGREES_OF_FREEDOM: Final = FreeParameter(
    "degrees_of_freedom", 1.0, 100.0, True, positive("nu", "1", "degrees of freedom of the Student-t noise")
)
"""Degrees of freedom of the noise where they are free; at 100 the distribution is nearly normal."""


class Problem(ABC):
    """Base class of inference problems; values of free numbers are SI, those of law and motor first.

    Attributes:
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.
    """

    degrees_of_freedom: float | None = inf

    @property
    @abstractmethod
    def law(self) -> str:
        """Name of the law."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The free numbers of law and motor."""

    @property
    @abstractmethod
    def nuisances(self) -> tuple[FreeParameter, ...]:
        """The free numbers of noise and discrepancy."""

    @property
    @abstractmethod
    def data(self) -> xarray.Dataset:
        """The measurements in SI, with the attribute `units` in the notation of the CF conventions."""

    @property
    def step(self) -> float | None:
        """Step of finite differences in the unit cube; None for predictions exact to round-off."""
        return None

    @property
    def free(self) -> tuple[FreeParameter, ...]:
        """All free numbers with their priors."""
        return (*self.parameters, *self.nuisances)

    @property
    def free_tails(self) -> tuple[FreeParameter, ...]:
        """The degrees of freedom where they are free."""
        return (DEGREES_OF_FREEDOM,) if self.degrees_of_freedom is None else ()

    def tails(self, values: Array) -> float:
        """Return the degrees of freedom of the noise."""
        fixed = inf if self.degrees_of_freedom is None else self.degrees_of_freedom
        return self.value(values, DEGREES_OF_FREEDOM.name, fixed)

    @abstractmethod
    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return predictions by name, shape as measured; None where the law has none."""

    def following(self, values: Array | None = None) -> "Problem":
        """Return the problem whose steady states follow those found before, see `KnownOrbits`.

        That is the problem itself where no steady state is predicted.

        Args:
            values: of law and motor, whose steady states alone are followed: predictions then do not depend
                on each other, as where processes share work.
        """
        del values
        return self

    @abstractmethod
    def residuals(self, values: Array) -> Array:
        """Return measured minus predicted over the size of the noise, shape (any,); NaN without prediction.

        The values are those of law and motor alone, and the noise is the stated one, else the size of the
        data; or those of all free numbers: then half the sum of squares is -ln L but for what the noise alone
        sets.
        """

    def spread(self, values: Array) -> float:
        """Return the range of the misfit over motors that are one, over its size [1].

        The motors are those of `repeats.REPEATS` that the data admit; the impact of two bodies has none.
        """
        del values
        return 0.0

    @abstractmethod
    def log_densities(
        self, predicted: Mapping[str, Array], values: Array, observed: Mapping[str, Array] | None = None
    ) -> dict[str, Array]:
        """Return the log density of each datum given those before it, by name.

        Args:
            predicted: without noise and discrepancy, by name.
            values: of all free numbers.
            observed: data in place of the measurements, by name.
        """

    @abstractmethod
    def replicate(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Draw data: prediction, discrepancy and noise."""

    def deviance(self, predicted: Mapping[str, Array], values: Array, observed: Mapping[str, Array]) -> float:
        """Return twice the log likelihood of the prediction as data, less that of the data.

        With normal noise it is the sum of squared standardised residuals, chi-square.
        """
        densities = (self.log_densities(predicted, values, data) for data in (predicted, observed))
        at_best, at_data = (sum(float(each.sum()) for each in every.values()) for every in densities)
        return 2.0 * (at_best - at_data)

    def log_likelihood(self, values: Array) -> float:
        """Return the log likelihood; `IMPOSSIBLE` without a prediction."""
        predicted = self.predict(values)
        if predicted is None:
            return IMPOSSIBLE
        total = sum(float(each.sum()) for each in self.log_densities(predicted, values).values())
        return total if total > IMPOSSIBLE else IMPOSSIBLE

    def value(self, values: Array, name: str, default: float) -> float:
        """Return the value of a free number by name, or the default if it is not free or has no value."""
        return next(
            (float(x) for item, x in zip(self.free, values, strict=False) if item.name == name), default
        )


def size_prior(name: str, units: str, size: float, meaning: str) -> FreeParameter:
    """Return a positive number that is log-uniform below the size of the data."""
    return FreeParameter(name, LOWEST * size, LARGEST * size, True, positive("", units, meaning))


def student_shrinkage(square: Array, degrees_of_freedom: float, size: int) -> Array:
    """Return the factor of standardised residuals by which half their squares are -ln L of Student-t noise.

    Args:
        square: of the residuals of `size` directions, any shape.
    """
    if degrees_of_freedom == inf:
        return np.ones_like(square)
    square = np.maximum(square, np.finfo(float).tiny)
    deviance = (degrees_of_freedom + size) * np.log1p(square / degrees_of_freedom)
    return np.asarray(np.sqrt(deviance / square))


def student_factor(draws: np.random.Generator, degrees_of_freedom: float, count: int) -> Array:
    """Draw the factors that turn normal numbers into Student-t ones, shape (count,)."""
    if degrees_of_freedom == inf:
        return np.ones(count)
    return np.asarray(np.sqrt(degrees_of_freedom / draws.chisquare(degrees_of_freedom, count)))
