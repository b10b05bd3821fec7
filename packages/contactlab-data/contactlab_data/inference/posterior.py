"""The posterior of the free numbers, as weighted samples or as a normal distribution about an optimum."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab_data.inference.free_parameters import FreeParameter

ENDS: Final = (0.05, 0.95)
"""Quantiles of the intervals, 90 %."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Weighted samples of a posterior, and the evidence: what a method makes of a problem.

    Args:
        method: "least squares" or "nested sampling".
        free: the free numbers.
        samples: all points in the order of their likelihood [SI], shape (sample, parameter).
        log_likelihood: of each, shape (sample,).
        log_weight: logarithm of each one's share in the posterior, shape (sample,).
        log_evidence, error: ln Z and its standard deviation, NaN where it is not known.
        information: of the data about the parameters [nat].
        calls: number of evaluations of the likelihood.
        points, seed: live points, 0 of least squares, and the seed of all random numbers.
    """

    method: str
    free: tuple[FreeParameter, ...]
    samples: Array
    log_likelihood: Array
    log_weight: Array
    log_evidence: float
    error: float
    information: float
    calls: int
    points: int
    seed: int

    @property
    def effective(self) -> float:
        """Number of independent draws of the same weight (Kish): 1 over the sum of squared weights."""
        return float(1.0 / np.sum(np.exp(self.log_weight) ** 2))

    def draws(self, count: int) -> NDArray[np.int64]:
        """Return indices of samples drawn by their weights, in random order, shape (count,)."""
        generator = np.random.default_rng([self.seed, 1])
        # Systematic resampling: the number of each sample is its share but for rounding.
        steps = (np.arange(count) + generator.random()) / count
        chosen = np.searchsorted(np.cumsum(np.exp(self.log_weight)), steps)
        return np.asarray(np.minimum(chosen, len(self.samples) - 1)[generator.permutation(count)])

    def quantiles(self, shares: Iterable[float]) -> Array:
        """Return the quantiles of each parameter [SI], shape (parameter, share)."""
        outcome = []
        for column in self.samples.T:
            order = np.argsort(column, kind="stable")
            reached = np.cumsum(np.exp(self.log_weight[order]))
            outcome.append(np.interp(list(shares), reached, column[order]))
        return np.array(outcome).reshape(len(self.free), -1)

    def moments(self) -> tuple[Array, Array]:
        """Return mean, shape (parameter,), and covariance [SI], shape (parameter, parameter)."""
        weights = np.exp(self.log_weight)
        mean = weights @ self.samples
        off = self.samples - mean
        return mean, np.asarray((off * weights[:, None]).T @ off)

    @property
    def interval(self) -> Array:
        """90 % interval of each parameter [SI], shape (parameter, 2)."""
        return self.quantiles(ENDS)


@final
@dataclass(frozen=True, eq=False)
class NormalPosterior(Posterior):
    """A normal distribution about an optimum, in the unit cube, with intervals of its own.

    Args:
        best: the optimum [SI], shape (parameter,).
        covariance: about it [SI], shape (parameter, parameter).
        ends: 90 % interval of each parameter [SI], shape (parameter, 2).
    """

    best: Array
    covariance: Array
    ends: Array

    def moments(self) -> tuple[Array, Array]:
        """Return optimum and covariance [SI]."""
        return self.best, self.covariance

    @property
    def interval(self) -> Array:
        """90 % interval of each parameter [SI], shape (parameter, 2)."""
        return self.ends
