"""Several data sets under one law as an inference problem: impacts, loops and series with shared numbers."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.problem import Problem


def named(label: str, name: str) -> str:
    """Return the name of what one data set has of its own."""
    return f"{label}.{name}"


@final
@dataclass(frozen=True, eq=False)
class JointProblem(Problem):
    """Problems whose numbers of law and motor are the same by name; see `Problem`.

    Their data are independent, so that log likelihoods add. What each has of its own is named LABEL.NAME:
    data, predictions, noise, discrepancy, and numbers that are not shared.

    Args:
        parts: the problems by label.
        own: names of numbers of law and motor that are not shared.
    """

    parts: Mapping[str, Problem]
    own: Collection[str] = ()

    @property
    def law(self) -> str:
        """Name of the law."""
        return next(iter(self.parts.values())).law

    @cached_property
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The free numbers of law and motor, each shared one once."""
        every = [self._renamed(label, item) for label, part in self.parts.items() for item in part.parameters]
        return tuple({item.name: item for item in every}.values())

    @cached_property
    def nuisances(self) -> tuple[FreeParameter, ...]:
        """The free numbers of noise and discrepancy of each part."""
        return tuple(
            replace(item, name=named(label, item.name))
            for label, part in self.parts.items()
            for item in part.nuisances
        )

    @cached_property
    def data(self) -> xarray.Dataset:
        """The measurements of all parts."""
        every = []
        for label, part in self.parts.items():
            names = dict.fromkeys([*part.data.variables, *part.data.dims])
            every.append(part.data.rename({name: named(label, str(name)) for name in names}))
        return xarray.merge(every)

    @property
    def step(self) -> float | None:
        """The longest of the parts' steps."""
        return max((part.step for part in self.parts.values() if part.step is not None), default=None)

    def _renamed(self, label: str, item: FreeParameter) -> FreeParameter:
        return replace(item, name=named(label, item.name)) if item.name in self.own else item

    def _values(self, label: str, values: Array) -> Array:
        """Return the values of one part, as many as there are: those of law and motor, or of all."""
        part, known = self.parts[label], {item.name: x for item, x in zip(self.free, values, strict=False)}
        names = [self._renamed(label, item).name for item in part.parameters]
        names += [named(label, item.name) for item in part.nuisances]
        return np.array([known[name] for name in names if name in known])

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the predictions of all parts; None if one has none."""
        result: dict[str, Array] = {}
        for label, part in self.parts.items():
            predicted = part.predict(self._values(label, values))
            if predicted is None:
                return None
            result |= {named(label, name): x for name, x in predicted.items()}
        return result

    def following(self, values: Array | None = None) -> Problem:
        """Return the problem of parts whose steady states follow those found before."""
        each = {
            label: part.following(None if values is None else self._values(label, values))
            for label, part in self.parts.items()
        }
        return replace(self, parts=each)

    def residuals(self, values: Array) -> Array:
        """Return the residuals of all parts."""
        return np.concatenate(
            [part.residuals(self._values(label, values)) for label, part in self.parts.items()]
        )

    def spread(self, values: Array) -> float:
        """Return the largest range of a part's misfit over motors that are one."""
        return max(part.spread(self._values(label, values)) for label, part in self.parts.items())

    def log_densities(
        self, predicted: Mapping[str, Array], values: Array, observed: Mapping[str, Array] | None = None
    ) -> dict[str, Array]:
        """Return the log densities of all parts."""
        result: dict[str, Array] = {}
        for label, part in self.parts.items():
            seen = None if observed is None else _of(label, observed)
            terms = part.log_densities(_of(label, predicted), self._values(label, values), seen)
            result |= {named(label, name): x for name, x in terms.items()}
        return result

    def replicate(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Draw data of all parts."""
        result: dict[str, Array] = {}
        for label, part in self.parts.items():
            made = part.replicate(_of(label, predicted), self._values(label, values), draws)
            result |= {named(label, name): x for name, x in made.items()}
        return result


def _of(label: str, every: Mapping[str, Array]) -> dict[str, Array]:
    """Return what is of one part, by its names there."""
    start = named(label, "")
    return {name.removeprefix(start): x for name, x in every.items() if name.startswith(start)}
