"""The study `validate`: contact laws against measured impacts to which they were not fitted."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from itertools import combinations, pairwise, product
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final

import numpy as np
import pandas
import xarray

from contactlab.estimate import Estimate
from contactlab.laws.registry import classes_of
from contactlab.results.provenance import code_digest
from contactlab.studies.function import function_of, of_laws
from contactlab.studies.law_study import OF_MOTOR, read_file
from contactlab.studies.run_state import code_of
from contactlab.studies.study import Setups, Study, Task, option
from contactlab.studies.tables import UNIT, table
from contactlab_data.inference.candidates import Candidate
from contactlab_data.inference.cross_validation import (
    BASELINE,
    FOLDS,
    SAME,
    assessed,
    cross_validated,
    distinct,
    laws_in,
    predictors_of,
)
from contactlab_data.inference.fit import fitted
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.impact_problem import ImpactPredictor, ImpactProblem, LawPredictor
from contactlab_data.inference.law_numbers import FreeNumbers, by_key, corrections_in, law_predictors
from contactlab_data.inference.nested_sampling import POINTS
from contactlab_data.measured.files import read_impacts
from contactlab_data.measured.impacts import MeasuredImpacts
from contactlab_data.studies.fit import FIRST, Method, findings_of, part_of, tables_of

SHOWN: Final = 40
"""Largest number of unexplained impacts in a sentence; the dataset has all of them."""

LEAST: Final = 1e-4
"""Difference below which four decimals show nothing."""

FIT: Final = "fit"
"""Group of the fits to all impacts, and beginning of the keys of their tasks."""

TRACKS: Final = "tracks"
"""Group of the tracks from which the impacts follow."""


@dataclass(frozen=True, kw_only=True)
class Validate(Study):
    """How well do contact laws predict measured impacts to which they were not fitted?

    Every impact is held out once, equal rows and repeats of one measurement together; a law is fitted to the
    others and predicts it. Errors and their differences have bootstrap intervals, and stand beside those of
    the frictionless law, of the best constant impulse and of the best impulse of each impact, which no law
    can surpass. Numbers of the laws law=A,B that are not stated are free, in ranges
    KEY=LOW..HIGH if they are given; without law= these are all rigid laws and some compliant ones. Numbers
    of the geometry, data.NAME=LOW..HIGH, are fitted with those of every law. Verdicts on pairs are corrected
    for their number. Intervals of the numbers are by least squares of all impacts, with method=nested besides
    by nested sampling, which weighs the laws by their evidence.

        >>> import contactlab as cl
        >>> laws = [cl.build([f"law={name}"]) for name in ("newton", "poisson")]
        >>> cl.validate(laws, data="impacts.csv", folds=3)  # doctest: +SKIP

    Raises:
        ConfigurationError, ValidationError: laws or impacts cannot be used.
    """

    name: ClassVar[str] = "validate"
    several: ClassVar[bool] = True
    ignored: ClassVar[tuple[str, ...]] = OF_MOTOR
    files: ClassVar[str] = "data"
    early: ClassVar[bool] = True

    data: Annotated[str | Path | MeasuredImpacts, option("file of measured impacts, or of tracks")] = ""
    free: Annotated[FreeNumbers, option("ranges of free numbers, KEY=LOW..HIGH")] = None
    known: Annotated[list[str] | None, option("keys of a law's numbers that are not free")] = None
    method: Annotated[Method, option("least_squares, or nested sampling of all impacts besides")] = FIRST
    folds: Annotated[int, option("parts that are held out in turn", at_least=2)] = FOLDS
    seed: Annotated[int, option("seed of folds, searches and resamples", at_least=0)] = 0
    repeats: Annotated[int, option("number of seeds, from the first on", at_least=1, at_most=1000)] = 1
    block: Annotated[int, option("impacts in a row that are resampled together", at_least=1)] = 1
    points: Annotated[int, option("live points", at_least=25, at_most=100_000)] = POINTS

    @cached_property
    def impacts(self) -> MeasuredImpacts:
        """The measured impacts.

        Raises:
            ConfigurationError: the file cannot be read or contains no impacts.
        """
        data = self.data
        return read_file(data, read_impacts) if isinstance(data, str | Path) else data

    @property
    def base(self) -> Mapping[str, Any]:
        """The data state no motor; without a law the usual ones are validated."""
        return {}

    @property
    def seeds(self) -> range:
        """The seeds."""
        return range(self.seed, self.seed + self.repeats)

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one task for each law and seed, the slow ones first.

        Raises:
            ConfigurationError, ValidationError: laws or impacts cannot be used.
        """
        free = by_key(self.free, self.known)
        corrections = corrections_in(free)
        predictors = predictors_of(self.impacts, law_predictors(setups, free, self.known or ()), self.folds)
        # Refused before any of them is fitted.
        ImpactProblem(self.impacts, predictors[0], corrections=corrections)
        for each in predictors:
            problem = ImpactProblem(
                self.impacts, each, self.impacts.covariance is None, corrections=corrections
            )
            if not each.baseline:
                key = f"{FIT} {self._digest(each, corrections)} {each.label}"
                numbers = f"Free: {'; '.join(map(str, problem.parameters)) or 'nothing'}."
                self._made[key] = Candidate(each.label, problem, {}, {}, numbers)
        return [
            Task(
                f"{seed} {place} {self._digest(predictor, corrections)}",
                part_of,
                (cross_validated, {}, predictor, self.impacts, self.folds, seed, corrections),
            )
            for seed in self.seeds
            for place, predictor in sorted(enumerate(predictors), key=lambda each: not each[1].integrated)
        ]

    @cached_property
    def _made(self) -> dict[str, Candidate]:
        """The laws by the keys of the tasks of nested sampling, once tasks are made."""
        return {}

    def further_tasks(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> Iterable[Task]:
        """Return fits of every law to all impacts after the cross-validation, if they are wanted."""
        del setups
        if self.method == FIRST or any(key in parts for key in self._made):
            return []
        workers = None if self.workers == 1 and self.scheduler is None else 1
        settings: dict[str, Any] = {"points": self.points, "seed": self.seed, "workers": workers}
        return [
            Task(key, part_of, (fitted, settings, item), resumes=True) for key, item in self._made.items()
        ]

    def _digest(self, predictor: ImpactPredictor, corrections: tuple[FreeParameter, ...]) -> str:
        """Return the digest of all that a cross-validation depends on besides the seed."""
        if isinstance(predictor, LawPredictor):
            code = code_of(*classes_of(predictor.law))
        else:
            code = (code_digest(),)
        depends = (predictor, self.folds, self.impacts.content_digest, corrections, *code)
        return sha256(repr(depends).encode()).hexdigest()[:16]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the assessment, see `inference.cross_validation`; further seeds and tracks are groups."""
        del setups
        groups = {}
        for seed in self.seeds:
            keys = [key for key in parts if key.startswith(f"{seed} ")]
            # In the order of the laws, not of the tasks.
            keys.sort(key=lambda key: int(key.split()[1]))
            outcomes = [parts[key].to_dataset() for key in keys]
            groups[f"seed_{seed}"] = assessed(outcomes, self.impacts, self.folds, seed, self.block)
        first = groups.pop(f"seed_{self.seed}")
        if self.impacts.tracks is not None:
            groups[TRACKS] = self.impacts.tracks
        tree = xarray.DataTree(first, {name: xarray.DataTree(data) for name, data in groups.items()})
        if fits := {item.label: parts[key] for key, item in self._made.items() if key in parts}:
            tree[FIT] = _renamed(xarray.DataTree(children=fits), lambda name: f"{FIT}_{name}")
        return tree

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the mean held-out error of each law, with half its interval."""
        every = data.to_dataset()
        halves = 0.5 * np.diff(every["prediction_error_interval"].values, axis=1)[:, 0]
        return {
            str(label): Estimate(float(error), float(half))
            for label, error, half in zip(
                every["law"].values, every["prediction_error"].values, halves, strict=True
            )
        }

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the order of the laws, what limits it, and which impacts no law explains."""
        every = data.to_dataset()
        seeds = [child for name, child in data.children.items() if name not in (TRACKS, FIT)]
        trees = [every, *(child.to_dataset() for child in seeds)]
        tracks = data[TRACKS].attrs["findings"].splitlines() if TRACKS in data.children else []
        return [
            headline(every),
            *comparisons(every),
            *(agreement(trees) if len(trees) > 1 else []),
            *limits(every),
            unexplained(every),
            *tracks,
            *(findings_of(fits) if (fits := _fits(data)) else []),
        ]

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return errors and fitted parameters."""
        every = data.to_dataset()
        rows = []
        for label, number in self.numbers(data).items():
            here = every.sel(law=label)
            low, high = map(float, here["prediction_error_interval"].values)
            errors = {"held-out error": number.value, "low": low, "high": high}
            group, size = (int(here[name]) or "" for name in ("group", "fitted_on"))
            rows.append(
                {"law": label, "kind": str(here["kind"].item()), **errors, "group": group, "fitted on": size}
            )
        caption = (
            "Mean error ||v+ - v+ predicted|| / ||v-|| in the norm of the kinetic energy, 95 % interval. "
            "Laws of a group are not distinguishable from its first. A compliant law is fitted to a "
            "sample of the other folds."
        )
        own = {
            "errors": table(rows, caption=caption),
            "parameters": table(
                [*parameters(every)],
                caption="Fitted parameters: median of the folds, least, greatest; 90 % interval by all",
            ),
        }
        return own | (tables_of(fits) if (fits := _fits(data)) else {})

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return errors, paired differences, residuals, and a map of the impacts."""
        # Imported here: it brings matplotlib.
        from contactlab_data.studies.validate_figures import (
            draw_differences,
            draw_errors,
            draw_impacts,
            draw_residuals,
            draw_tracks,
        )

        every = data.to_dataset()
        figures = {
            "prediction_error": draw_errors(every),
            "paired_differences": draw_differences(every),
            "residuals": draw_residuals(every),
            "impacts": draw_impacts(every),
        }
        if TRACKS in data.children:
            figures[TRACKS] = draw_tracks(data.children[TRACKS].to_dataset(inherit=False))
        for name, figure in figures.items():
            figure.set_label(CAPTIONS[name])
        return figures


CAPTIONS: Final = {
    "prediction_error": "Errors of the laws on impacts to which they were not fitted, with 95 % intervals.",
    "paired_differences": "Differences of the errors of laws on the same impacts, by pairs of laws.",
    "residuals": "Errors and residuals (measured less predicted) over the impact before: medians of the best "
    "law of each of four groups at most, quartiles of the best.",
    "impacts": "Impacts over slip and approach velocity, coloured by the least error under any law.",
    TRACKS: "Positions of the first tracks, their flights and impacts.",
}
"""Captions of the figures by name."""


def _renamed(tree: xarray.DataTree, name: Callable[[str], str]) -> xarray.DataTree:
    """Return a tree whose dimensions have other names: those of a group must be those above it."""
    groups = {path: node.to_dataset(inherit=False) for path, node in tree.subtree_with_keys}
    names = {path: {*map(str, data.dims), *map(str, data.coords)} for path, data in groups.items()}
    return xarray.DataTree.from_dict(
        {path: data.rename({old: name(old) for old in names[path]}) for path, data in groups.items()}
    )


def _fits(data: xarray.DataTree) -> xarray.DataTree | None:
    """Return the fits to all impacts; None without."""
    if FIT not in data.children:
        return None
    return _renamed(data.children[FIT], lambda name: name.removeprefix(f"{FIT}_"))


def headline(data: xarray.Dataset) -> str:
    """Return a sentence on the best law and its distance from the best impulse."""
    laws = laws_in(data)
    best, floor = laws.isel(law=0), data.isel(law=-1)
    first = laws["law"].values[laws["group"].values == 1]
    low, high = best["prediction_error_interval"].values
    error = Estimate(float(best["prediction_error"]), 0.5 * float(high - low)).text()
    others = f", not distinguishable from {', '.join(map(str, first[1:]))}" if len(first) > 1 else ""
    return (
        f"{best['law'].item()} predicts best: {error}{others}. The best impulse of each impact leaves "
        f"{float(floor['prediction_error']):.4f}."
    )


def comparisons(data: xarray.Dataset) -> list[str]:
    """Return a sentence for each law and the next in the order of their errors, and for the baselines."""
    laws = [str(label) for label in laws_in(data)["law"].values]
    baselines = [str(label) for label in data["law"].values[data["kind"].values == BASELINE]]
    return [
        *(comparison(data, better, worse) for better, worse in pairwise(laws)),
        *(comparison(data, laws[0], baseline, "the baseline ") for baseline in baselines),
    ]


def comparison(data: xarray.Dataset, better: str, worse: str, kind: str = "") -> str:
    """Return a sentence on which of two laws predicts better and by how much."""
    apart = float(data["difference"].sel(law=worse, other=better))
    ends = data["difference_interval"].sel(law=worse, other=better).values
    largest = float(np.abs(ends).max())
    if largest < SAME:
        return f"{better} and {kind}{worse} predict the same."
    by = Estimate(apart, 0.5 * float(ends[1] - ends[0])).text()
    by = by if largest >= LEAST else f"less than {LEAST}"
    if not distinct(data, better, worse):
        return f"{better} and {kind}{worse} are not distinguishable: their errors differ by {by}."
    return f"{better} predicts better than {kind}{worse} by {by}."


def agreement(seeds: Sequence[xarray.Dataset]) -> list[str]:
    """Return sentences on whether laws have the same order under all seeds."""
    pairs = combinations(map(str, laws_in(seeds[0])["law"].values), 2)
    # Signs of the difference over the seeds, 0 where the laws are not distinct.
    orders = {
        (a, b): {int(distinct(data, b, a)) - int(distinct(data, a, b)) for data in seeds} for a, b in pairs
    }
    settled = sum(len(signs) == 1 and 0 not in signs for signs in orders.values())
    never = sum(signs == {0} for signs in orders.values())
    opposite = [pair for pair, signs in orders.items() if {-1, 1} <= signs]
    odd = [set(entry["impact"].values[entry["unexplained"].values != 0].tolist()) for entry in seeds]
    return [
        f"Of {len(orders)} pairs of laws {settled} are distinct in one order under all {len(seeds)} seeds, "
        f"{never} under none, {len(opposite)} in opposite orders.",
        *(f"{a} and {b} predict better than each other under different seeds." for a, b in opposite),
        f"No law explains {len(set.intersection(*odd))} impacts under any seed, and "
        f"{len(set.union(*odd))} under at least one.",
    ]


def limits(data: xarray.Dataset) -> list[str]:
    """Return what limits the result: copied rows, what determines numbers, impacts without a prediction."""
    remarks = {
        "at_end": "on an end of the range; the optimum may lie beyond",
        "unmoved": "without effect on the impacts and fixed",
        "unanswered": "impacts without a prediction; no change is assumed",
    }
    result = [copies] if (copies := data.attrs.get("copies")) else []
    for label in map(str, data["law"].values):
        here = data.sel(law=label)
        result += [
            f"{label}: {here[name].item()} {text}." for name, text in remarks.items() if here[name].item()
        ]
        limited = zip(here["parameter"].values, here["remark"].values, strict=True)
        result += [f"{label}: {name}: {text}." for name, text in limited if text]
    return result


def unexplained(data: xarray.Dataset) -> str:
    """Return a sentence on the impacts whose error is above noise under every law."""
    noise = data.attrs["noise"]
    if not isfinite(float(data["noise_bound"].max())):
        return f"Unexplained impacts cannot be identified, as the noise is {noise}."
    numbers = data["impact"].values[data["unexplained"].values != 0]
    if not numbers.size:
        return f"Every impact is explained by some law: its error is below that of noise, {noise}."
    least = laws_in(data)["error"].min("law").sel(impact=numbers).values
    worst = numbers[np.argsort(-least, kind="stable")]
    rest = f" and {numbers.size - SHOWN} more, in the dataset" if numbers.size > SHOWN else ""
    return (
        f"No law explains {numbers.size} of {data.sizes['impact']} impacts, for "
        f"{data.attrs['unexplained_by_noise']:.3g} of which noise alone may account: under every law their "
        f"error is above that of noise, {noise}; by number in their file, the worst first: "
        f"{', '.join(map(str, worst[:SHOWN]))}{rest}."
    )


def parameters(data: xarray.Dataset) -> Iterable[dict[str, Any]]:
    """Yield a row for each fitted parameter: median of the folds, least, greatest, interval by all."""
    for label, name in product(map(str, data["law"].values), map(str, data["parameter"].values)):
        here = data.sel(law=label, parameter=name)
        values = here["value"].values
        if np.isfinite(values).any():
            low, high = map(float, here["interval"].values)
            yield {
                "law": label,
                "parameter": name,
                UNIT: str(here["units"].item()),
                "median": float(np.median(values)),
                "least": float(values.min()),
                "greatest": float(values.max()),
                "5 %": low,
                "95 %": high,
                "remark": here["remark"].item(),
            }


validate = function_of(Validate, of_laws)
