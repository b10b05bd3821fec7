"""What a fit asks of measurements and a law: predictions, residuals, and how likely the measurements are."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol, final

import numpy as np

from contactlab.arrays import Array
from contactlab.inference.free_parameters import Free
from contactlab.parameter import Parameter, positive

LOWEST: Final = 1e-4
"""Smallest noise or discrepancy that is thought possible, over the size of what was measured."""

LARGEST: Final = 1.0
"""Largest of it."""

IMPOSSIBLE: Final = -1e300
"""Log likelihood of values under which a law gives no prediction."""


DEGREES_OF_FREEDOM: Final = Free(
    "degrees_of_freedom", 1.0, 100.0, True, positive("nu", "1", "degrees of freedom of the Student-t noise")
)
"""Those of the noise where they are free; at 100 the distribution is nearly normal."""


@final
@dataclass(frozen=True, eq=False)
class Measured:
    """A quantity that was measured.

    Args:
        name: of the data.
        dims: names of its dimensions.
        values: SI.
        units: in the words of the CF conventions.
    """

    name: str
    dims: tuple[str, ...]
    values: Array
    units: str


class Model(Protocol):
    """Measurements under one law with free numbers: those of law and motor, then those of the noise."""

    @property
    def law(self) -> str:
        """Name of the law."""

    @property
    def free(self) -> tuple[Free, ...]:
        """All that is free, with its prior; names are keys of the configuration, or of the noise."""

    @property
    def physical(self) -> int:
        """How many of them belong to law and motor; they stand first."""

    @property
    def data(self) -> tuple[Measured, ...]:
        """What was measured."""

    @property
    def coordinates(self) -> dict[str, Array]:
        """Coordinates of its dimensions."""

    def predicted(self, values: Array) -> dict[str, Array] | None:
        """Give what the law predicts, by name, shape as measured; None where it predicts nothing."""

    def residuals(self, values: Array) -> Array:
        """Give measured minus predicted over the noise's size, shape (any,); NaN without prediction.

        The values are those of law and motor alone.
        """

    def terms(self, predicted: Mapping[str, Array], values: Array) -> dict[str, Array]:
        """Give the log density of each datum given those before it, by name; the sum is the likelihood's."""

    def replicated(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Give data as the model draws them: prediction, discrepancy and noise."""


def log_likelihood(model: Model, values: Array) -> float:
    """Give the log likelihood; `IMPOSSIBLE` where the law predicts nothing."""
    predicted = model.predicted(values)
    if predicted is None:
        return IMPOSSIBLE
    total = sum(float(each.sum()) for each in model.terms(predicted, values).values())
    return total if total > IMPOSSIBLE else IMPOSSIBLE


def size_prior(name: str, units: str, size: float, meaning: str) -> Free:
    """Give a positive number whose logarithm is spread evenly about the size of what was measured."""
    said: Parameter = positive("", units, meaning)
    return Free(name, LOWEST * size, LARGEST * size, True, said)
