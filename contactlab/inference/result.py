"""What a fit of one law found: optimum, posterior and predictions, as a table and in ArviZ's layout."""

import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, NamedTuple, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.inference.evidence import Evidence
from contactlab.inference.least_squares import Fit
from contactlab.inference.nested_sampling import Posterior
from contactlab.inference.problem import Measured, Model
from contactlab.results.files import whole_netcdf
from contactlab.results.provenance import checkout_state, versions

DRAWS: Final = 1000
"""Posterior samples of equal weight that are kept."""

PREDICTED: Final = 250
"""Those of them whose predictions are kept."""

ENDS: Final = (0.05, 0.95)
"""Of the intervals, 90 %."""

MIDDLE: Final = (0.25, 0.75)
"""Of the intervals by which outliers are noticed, 50 %."""

ERRORS: Final = 3.0
"""Binomial errors by which the share of the data inside an interval may be off."""

SAMPLED: Final = ("chain", "draw")

UNINFORMED: Final = 0.95
"""Part of the prior's interval from which a posterior is said to be the prior."""

AT_END: Final = 2e-3
"""Share of a range by which an interval must keep off its ends."""


@final
class Row(NamedTuple):
    """A parameter in the table of a posterior, in its unit; the truth is NaN where it is not known."""

    name: str
    unit: str
    best: float
    mean: float
    deviation: float
    low: float
    high: float
    truth: float

    @property
    def covered(self) -> bool | None:
        """Whether the truth lies in the interval; None where it is not known."""
        return None if np.isnan(self.truth) else self.low <= self.truth <= self.high


@final
@dataclass(frozen=True, eq=False)
class Answer:
    """What was found of one law.

    Args:
        label: of the law, and of the discrepancy where both are asked.
        model: what was asked.
        best: least squares, of law and motor alone; None where nothing of them is free.
        posterior: by nested sampling.
        truth: of made data, by name.
        origin: what made it: data, digest, configuration, likelihood; notes on the data.
        numbers: which numbers of the law are free, fixed or absent, a sentence.
        draws: of equal weight, shape (draw, parameter).
        predictions, replicas: of the first draws, by name, shape (draw, ...); the second with noise.
        terms: log density of each datum under them.
    """

    label: str
    model: Model
    best: Fit | None
    posterior: Posterior
    truth: Mapping[str, float]
    origin: Mapping[str, str]
    numbers: str = ""
    draws: Array = field(init=False)
    predictions: dict[str, Array] = field(init=False)
    replicas: dict[str, Array] = field(init=False)
    terms: dict[str, Array] = field(init=False)

    def __post_init__(self) -> None:
        draws = self.posterior.draws(DRAWS)
        object.__setattr__(self, "draws", draws)
        generator = np.random.default_rng([self.posterior.seed, 2])
        kept: dict[str, dict[str, list[Array]]] = {"predictions": {}, "replicas": {}, "terms": {}}
        for values in draws[:PREDICTED]:
            predicted = self.model.predicted(values)
            # It is one that had a likelihood.
            assert predicted is not None
            replica = self.model.replicated(predicted, values, generator)
            found = predicted, replica, self.model.terms(predicted, values)
            for part, given in zip(kept.values(), found, strict=True):
                for name, numbers in given.items():
                    part.setdefault(name, []).append(numbers)
        for name, part in kept.items():
            object.__setattr__(self, name, {key: np.array(numbers) for key, numbers in part.items()})

    @property
    def evidence(self) -> Evidence:
        """The logarithm of the evidence and its error."""
        found = self.posterior
        return Evidence(self.label, found.log_evidence, found.error, self.covers, self.predictive_share())

    @property
    def file(self) -> str:
        """A part of the names of its files."""
        return self.label.replace(" + ", "_").replace(" ", "_")

    def rows(self) -> list[Row]:
        """Give the table of the posterior."""
        mean, covariance = self.posterior.moments()
        interval = self.posterior.quantiles(ENDS)
        best = dict(zip((one.name for one in self.model.free), self._best(), strict=False))
        return [
            Row(
                one.name,
                one.parameter.unit,
                best.get(one.name, np.nan),
                float(mean[k]),
                float(np.sqrt(covariance[k, k])),
                float(interval[k, 0]),
                float(interval[k, 1]),
                float(self.truth.get(one.name, np.nan)),
            )
            for k, one in enumerate(self.model.free)
        ]

    @property
    def covers(self) -> bool:
        """Whether the 90 % intervals contain 90 % of the data within `ERRORS` binomial errors."""
        return abs(self.predictive_share() - (ENDS[1] - ENDS[0])) <= ERRORS * self._binomial_error(ENDS)

    def _binomial_error(self, ends: tuple[float, float]) -> float:
        """Return the standard deviation of the share; both directions of an impact count once."""
        level, count = ends[1] - ends[0], sum(len(one.values) for one in self.model.data)
        return float(np.sqrt(level * (1.0 - level) / count))

    def predictive_share(self, ends: tuple[float, float] = ENDS) -> float:
        """Return the share of the data between two quantiles of their replicas, 90 % intervals as default."""
        inside = []
        for one in self.model.data:
            low, high = np.quantile(self.replicas[one.name], ends, axis=0)
            inside.append(((low <= one.values) & (one.values <= high)).ravel())
        return float(np.mean(np.concatenate(inside)))

    def correlation(self) -> Array:
        """Give the posterior's correlation, shape (parameter, parameter)."""
        _, covariance = self.posterior.moments()
        size = np.sqrt(np.diag(covariance))
        return np.asarray(covariance / np.multiply.outer(size, size))

    def sentences(self) -> list[str]:
        """Say what the search and the posterior found, and what they cannot tell."""
        said = [self.numbers] if self.numbers else []
        if self.best is not None:
            count = self.best.costs.size
            said.append(f"Least squares: {self.best.hits} of {count} starts found the optimum.")
            said += [f"Least squares: {words}." for words in self.best.warnings()]
        found = self.posterior
        said.append(
            f"ln Z = {found.log_evidence:.2f} +- {found.error:.2f}, {found.information:.1f} nat of "
            f"information, {found.calls} evaluations, {found.effective:.0f} effective samples."
        )
        said.append(
            f"{self.predictive_share():.1%} of the data lie in the 90 % intervals of what is predicted of "
            "them, noise included."
        )
        said += self._misfit()
        for one, row in zip(self.model.free, self.rows(), strict=True):
            share = [one.to_unit(row.low), one.to_unit(row.high)]
            if share[1] - share[0] > UNINFORMED * (ENDS[1] - ENDS[0]):
                said.append(f"{one.name}: the data say next to nothing of it; its posterior is its prior.")
            elif min(share[0], 1.0 - share[1]) < AT_END:
                end = one.low if share[0] < 1.0 - share[1] else one.high
                said.append(f"{one.name} leans on an end of its range, {end:.4g}; the truth may lie beyond.")
        if known := [row for row in self.rows() if row.covered is not None]:
            inside = sum(bool(row.covered) for row in known)
            said.append(
                f"Truth: {inside} of {len(known)} numbers that are known lie in their 90 % intervals."
            )
        return said

    def _misfit(self) -> list[str]:
        """Warn where the residuals are not those of the assumed noise."""
        share, half = self.predictive_share(), self.predictive_share(MIDDLE)
        error = self._binomial_error(ENDS)
        if share < ENDS[1] - ENDS[0] - ERRORS * error:
            return [
                f"Warning: 90 % +- {error:.1%} of the data should lie there. The noise is understated or the "
                "law does not explain the data, and the intervals of the numbers are too narrow. Try --noise "
                "free, --discrepancy on or --student free."
            ]
        if not self.covers or half > 0.5 + ERRORS * self._binomial_error(MIDDLE):
            return [
                f"Warning: the 50 % intervals contain {half:.1%} of the data: the noise is overstated, or "
                "outliers have widened it for all. Try --student free, whose tails hold outliers."
            ]
        return []

    def save(self, path: Path) -> None:
        """Write the posterior in ArviZ's layout, netCDF, whole or not at all.

        Raises:
            OSError: the folder cannot be written to.
        """
        with whole_netcdf(path) as partial:
            self.to_xarray().to_netcdf(partial, engine="netcdf4")

    def to_inference(self) -> Any:
        """Give the posterior as ArviZ's `InferenceData`, with that package."""
        with warnings.catch_warnings():
            # It tells of its next version.
            warnings.simplefilter("ignore", FutureWarning)
            from arviz import InferenceData
        made: Any = InferenceData
        return made.from_datatree(self.to_xarray())

    def to_xarray(self) -> xarray.DataTree:
        """Give the posterior in ArviZ's layout: a group each for draws, predictions, densities and data."""
        data = {one.name: one for one in self.model.data}
        units = {one.name: one.parameter.units for one in self.model.free}
        draws = {
            name: (SAMPLED, column[None], {"units": units[name]})
            for name, column in zip(units, self.draws.T, strict=True)
        }
        coordinates = {**self.model.coordinates, "direction": ["normal", "tangential"]}

        def over(numbers: Array, one: Measured, words: dict[str, str]) -> xarray.Variable:
            """Give what there is of every draw; of both directions of an impact there is one density."""
            return xarray.Variable((*SAMPLED, *one.dims[: numbers.ndim - 1]), numbers[None], words)

        predicted = {
            name: over(x, data[name], {"units": data[name].units}) for name, x in self.replicas.items()
        }
        for name, x in self.predictions.items():
            words = {"units": data[name].units, "long_name": f"{name} without noise and discrepancy"}
            predicted[f"{name}_predicted"] = over(x, data[name], words)
        groups: dict[str, dict[str, Any]] = {
            "posterior": draws,
            "posterior_predictive": predicted,
            "log_likelihood": {name: over(x, data[name], {}) for name, x in self.terms.items()},
            "sample_stats": {"lp": (SAMPLED, self._likelihoods()[None])},
            "observed_data": {
                name: (one.dims, one.values, {"units": one.units}) for name, one in data.items()
            },
        }
        tree = xarray.DataTree(xarray.Dataset(attrs=self._attributes()))
        for group, columns in groups.items():
            made = xarray.Dataset(columns)
            known: dict[Any, Any] = {
                name: np.arange(size) for name, size in made.sizes.items() if name in SAMPLED
            }
            known |= {name: values for name, values in coordinates.items() if name in made.dims}
            tree[group] = xarray.DataTree(made.assign_coords(known))
        tree["posterior"].attrs |= self._attributes()
        return tree

    def _attributes(self) -> dict[str, Any]:
        found, (revision, dirty) = self.posterior, checkout_state()
        priors = {
            one.name: {"low": one.low, "high": one.high, "logarithmic": one.logarithmic}
            for one in self.model.free
        }
        best = {} if self.best is None else {row.name: row.best for row in self.rows()[: self.model.physical]}
        return {
            "title": f"Posterior of {self.label}",
            "law": self.model.law,
            "log_evidence": found.log_evidence,
            "log_evidence_error": found.error,
            "information": found.information,
            "points": found.points,
            "seed": found.seed,
            "calls": found.calls,
            "prior": json.dumps(priors),
            "best_fit": json.dumps(best),
            "truth": json.dumps(dict(self.truth)),
            "findings": "\n".join(self.sentences()),
            **self.origin,
            **versions(),
            "dynesty_version": version("dynesty"),
            "git_revision": revision,
            "git_dirty": dirty,
        }

    def _best(self) -> Array:
        return np.empty(0) if self.best is None else self.best.values

    def _likelihoods(self) -> Array:
        """Give the log likelihood of each draw, which is one of the samples."""
        known = {
            row.tobytes(): x
            for row, x in zip(self.posterior.samples, self.posterior.log_likelihood, strict=True)
        }
        return np.array([known[row.tobytes()] for row in self.draws])
