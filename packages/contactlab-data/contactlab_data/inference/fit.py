"""Fit of laws to measurements: optimum, posterior with evidence, and predictions, as one tree of datasets.

Laws are compared by Bayes factors B = Z_1 / Z_2, by which the data change the odds of law 1 over law 2.
Evidence is of law and prior together: an even range that is ten times as wide takes ln 10 from a parameter
that the data determine. It ranks laws whether or not any is right, so odds are stated only between laws of
which the one with the larger evidence passes a posterior predictive check.

The check compares a discrepancy T of the data y with that of data replicated by the same posterior sample x:

    p = P(T(y_rep, x) >= T(y, x) | y)

T is the deviance, which is chi-square for normal noise, and, for series over time, the correlation of
successive residuals, which a noise of free size does not hide.

Sources: Gelman, Meng and Stern (1996), Stat. Sinica 6, 733; Gelman et al. (2013), Bayesian Data Analysis,
3rd ed., ch. 6.
"""

import json
from collections import ChainMap
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from itertools import product
from math import erfc, exp, hypot, inf, log, sqrt
from pathlib import Path
from typing import Any, Final, Literal, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, Setup
from contactlab.driving import DEGREE
from contactlab.estimate import Estimate
from contactlab.laws.composed import label_of
from contactlab.progress import part_of_progress
from contactlab.results.yaml_text import write_yaml
from contactlab.studies.compare.repeats import MARGIN, not_stated
from contactlab.studies.law_study import NO_LAW
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.held_out import HeldOut, folds_of, held_out_misfits, residuals_of
from contactlab_data.inference.impact_problem import ImpactProblem, LawPredictor
from contactlab_data.inference.influence import without_influence
from contactlab_data.inference.joint_problem import JointProblem
from contactlab_data.inference.law_numbers import Free, corrections_in, free_numbers, numbers_of
from contactlab_data.inference.least_squares import Optimum, best_fit
from contactlab_data.inference.motor_problem import points_problem, series_problem
from contactlab_data.inference.nested_sampling import POINTS, Posterior, sample
from contactlab_data.inference.path_problem import path_problem
from contactlab_data.inference.problem import Problem
from contactlab_data.inference.synthetic import truth_in
from contactlab_data.measured.impacts import MeasuredImpacts
from contactlab_data.measured.series import MeasuredPoints, MeasuredSeries

STARTS: Final = 16
"""Default number of starts of least squares."""


FEWEST: Final = 3
"""Least number of impacts to which a law is fitted."""

SEARCHED: Final = 0.2
"""Share of the time of a fit that least squares take, roughly."""

DRAWS: Final = 1000
"""Posterior samples of equal weight that are kept."""

PREDICTED: Final = 250
"""Number of them whose predictions are kept."""

REPLICAS: Final = 8
"""Data sets replicated by each of them for the posterior predictive check; the first is kept."""

ENDS: Final = (0.05, 0.95)
"""Quantiles of the intervals, 90 %."""

MIDDLE: Final = (0.25, 0.75)
"""Quantiles of the intervals by which outliers are noticed, 50 %."""

ERRORS: Final = 3.0
"""Standard deviations by which the coverage of the data may be off, and by which ln B is significant."""

IMPROBABLE: Final = 0.5 * erfc(ERRORS / sqrt(2.0))
"""Posterior predictive p-value below which a law does not fit: a normal distribution beyond `ERRORS`."""

UNINFORMED: Final = 0.95
"""Width of a posterior's interval over the prior's from which on the data do not inform it."""

AT_END: Final = 2e-3
"""Distance of an interval from an end of the range below which it lies there, as a share of the range."""

LEAST: Final = log(3.0)
"""Smallest significant |ln B|."""

_STRENGTHS: Final = (
    (log(100.0), "decisive"),
    (log(30.0), "very strong"),
    (log(10.0), "strong"),
    (LEAST, "substantial"),
)

SAMPLED: Final = ("chain", "draw")

Discrepancy = Literal["off", "on", "both"]
Data = MeasuredSeries | MeasuredImpacts | MeasuredPoints


@final
@dataclass(frozen=True, eq=False)
class Candidate:
    """A law that is to be fitted.

    Args:
        label: of the law, and of the discrepancy where the law is fitted with and without.
        problem: data, law, free numbers and noise.
        truth: values of free numbers of synthetic data, by name.
        origin: attributes of the result: data, digest, configuration, likelihood.
        numbers: sentence on free and fixed numbers.
    """

    label: str
    problem: Problem
    truth: Mapping[str, float]
    origin: Mapping[str, str]
    numbers: str


def candidates_of(
    data: Data | Mapping[str, Data],
    setups: Mapping[str, Setup],
    free: Free,
    known: Collection[str] = (),
    *,
    own: Collection[str] = (),
    discrepancy: Discrepancy = "off",
    degrees_of_freedom: float | None = inf,
    degree: int = DEGREE,
    name: str = "",
    digest: str = "",
) -> list[Candidate]:
    """Return the laws to be fitted, twice if with and without discrepancy.

    Args:
        data: measurements, or several by label.
        setups: of the laws by label, which names those that are not named by their laws alone.
        free: ranges by key.
        known: keys of numbers that have the values of the setups.
        own: keys of numbers that each of several measurements has of its own.
        discrepancy: whether the laws may be wrong.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.
        degree: of the spline through the samples of a path.
        name: of the data.
        digest: of their file.

    Raises:
        ConfigurationError: with every fault.
    """
    sets = data if isinstance(data, Mapping) else {"": data}
    of_impacts = [each for each in sets.values() if isinstance(each, MeasuredImpacts)]
    for each in of_impacts:
        _check_impacts(each, discrepancy)
    if not setups:
        raise ConfigurationError(NO_LAW)
    if own and len(sets) == 1:
        raise ConfigurationError("study.own is set and there is one data set; leave it out.")
    every, corrections = free_numbers(setups, free, known), corrections_in(free)
    if unknown := sorted({*own} - {item.name for keys in every.values() for item in keys}):
        raise ConfigurationError(
            [f"study.own has {key}, which is not free; leave it out." for key in unknown]
        )
    tails = "free" if degrees_of_freedom is None else f"{degrees_of_freedom:g}"
    likelihood = "normal" if degrees_of_freedom == inf else f"Student-t, degrees of freedom: {tails}"
    result, faults = list[Candidate](), list[str]()
    cases = {"off": (False,), "on": (True,), "both": (False, True)}[discrepancy]
    laws = {place: label_of(setup.law) for place, setup in setups.items()}
    if len({*laws.values()}) < len(laws):
        laws = {place: place.replace("/", ".") for place in laws}
    for (place, setup), may_err in product(setups.items(), cases):
        keys = every[place]
        try:
            problem = _problem_of(sets, setup, keys, corrections, own, degrees_of_freedom, degree, may_err)
            problem, idle = _with_influence(problem, keys)
        except ConfigurationError as error:
            faults += error.faults
            continue
        configuration = write_yaml(setup.configuration)
        origin = {"data": name, "digest": digest, "configuration": configuration, "likelihood": likelihood}
        notes = {
            "duplicates": [each.copies_warning() for each in of_impacts],
            "tracks": [each.tracks.attrs["findings"] for each in of_impacts if each.tracks is not None],
        }
        origin |= {key: "\n".join(lines) for key, lines in notes.items() if any(lines)}
        label = laws[place] + (" + discrepancy" if may_err and discrepancy == "both" else "")
        numbers = dict(ChainMap(*(truth_in(each, setup.configuration) for each in sets.values())))
        truth = {item.name: numbers[item.name] for item in problem.parameters if item.name in numbers}
        stated = numbers_of(setup, [item for item in keys if item.name not in idle], [*free, *known])
        if idle:
            stated += f" Not free, since they have no influence on these data: {', '.join(idle)}."
        result.append(Candidate(label, problem, truth, origin, stated))
    if faults:
        raise ConfigurationError(list(dict.fromkeys(faults)))
    return result


def _check_impacts(data: MeasuredImpacts, discrepancy: Discrepancy) -> None:
    """Raise a ConfigurationError for impacts to which no law can be fitted as asked."""
    faults = []
    if len(data) < FEWEST:
        faults.append(f"There are {len(data)} impacts; there must be at least {FEWEST}.")
    if data.covariance is None and discrepancy != "off":
        faults.append(
            "study.discrepancy must be off: the data state no noise, from which it could be distinguished. "
            "State it by noise."
        )
    if faults:
        raise ConfigurationError(faults)


def of_law(data: Data) -> bool:
    """Return whether measurements are of a law alone, without a motor."""
    return isinstance(data, MeasuredImpacts) or (isinstance(data, MeasuredSeries) and bool(data.path))


def _problem_of(
    sets: Mapping[str, Data],
    setup: Setup,
    keys: Sequence[FreeParameter],
    corrections: tuple[FreeParameter, ...],
    own: Collection[str],
    degrees_of_freedom: float | None,
    degree: int,
    discrepancy: bool,
) -> Problem:
    """Return the problem of one law."""
    of_laws, others = [*map(of_law, sets.values())], [item.name for item in keys if not item.field]
    if all(of_laws) and others:
        raise ConfigurationError(f"{', '.join(others)} is of the motor; these data depend on the law alone.")
    impacts = any(isinstance(data, MeasuredImpacts) for data in sets.values())
    if corrections and not impacts:
        raise ConfigurationError(f"{corrections[0].name} is of measured impacts; the data have none.")
    parts = {}
    for (label, data), alone in zip(sets.items(), of_laws, strict=True):
        chosen = [item for item in keys if item.field or not alone]
        of_data = corrections if isinstance(data, MeasuredImpacts) else ()
        parts[label] = _problem(
            data, setup, chosen, of_data, degrees_of_freedom, degree, discrepancy=discrepancy
        )
    problem = parts[""] if [*parts] == [""] else JointProblem(parts, own)
    if not problem.free:
        raise ConfigurationError(f"No number of law={setup.law.name} is free; add a range, KEY=LOW..HIGH.")
    return problem


def _with_influence(problem: Problem, keys: Sequence[FreeParameter]) -> tuple[Problem, list[str]]:
    """Return the problem without the numbers that have no influence on its data, and their keys.

    Raises:
        ConfigurationError: no number has influence, and nothing else is free.
    """
    reduced = without_influence(problem)
    ends = {item.name.removeprefix(f"{label}.") for item in reduced.parameters for label in _labels(problem)}
    idle = [item.name for item in keys if item.name not in ends]
    if not reduced.free:
        raise ConfigurationError(f"{', '.join(idle)} has no influence on these data; free another number.")
    return reduced, idle


def _labels(problem: Problem) -> list[str]:
    """Return the labels of the data sets of a problem, "" of a single one."""
    return [*problem.parts] if isinstance(problem, JointProblem) else [""]


def _problem(
    data: Data,
    setup: Setup,
    keys: Sequence[FreeParameter],
    corrections: tuple[FreeParameter, ...],
    degrees_of_freedom: float | None,
    degree: int,
    *,
    discrepancy: bool,
) -> Problem:
    """Return the problem of one law and one data set."""
    if isinstance(data, MeasuredImpacts):
        predictor = LawPredictor(setup.law, tuple(keys), label_of(setup.law), tolerance=None)
        unknown = discrepancy or data.covariance is None
        return ImpactProblem(data, predictor, unknown, degrees_of_freedom, corrections)
    if isinstance(data, MeasuredSeries) and data.path:
        noise: dict[str, Any] = {"discrepancy": discrepancy, "degrees_of_freedom": degrees_of_freedom}
        return path_problem(data, setup.law, keys, **noise, degree=degree)
    if "resonator" not in setup.configuration:
        raise ConfigurationError("A motor made in Python has no configuration, by which it is fitted.")
    if isinstance(data, MeasuredSeries):
        return series_problem(
            data, setup.configuration, keys, discrepancy=discrepancy, degrees_of_freedom=degrees_of_freedom
        )
    if discrepancy:
        raise ConfigurationError("study.discrepancy must be off: operating points have no time.")
    return points_problem(data, setup.configuration, keys, degrees_of_freedom=degrees_of_freedom)


def fitted(
    candidate: Candidate,
    *,
    points: int = POINTS,
    seed: int = 0,
    starts: int = STARTS,
    held_out: HeldOut = "off",
    checkpoint: Path | None = None,
    workers: int | None = None,
) -> xarray.DataTree:
    """Fit a law: least squares of law and motor, then posterior and evidence of all that is free.

    Args:
        points: live points of nested sampling.
        seed: the same gives the same bits.
        starts: of least squares.
        held_out: parts of the data that are predicted by fits to the others.
        checkpoint: file from which an interrupted fit resumes.
        workers: processes; None is one a processor where that pays.

    Returns:
        ArviZ's groups posterior, posterior_predictive, log_likelihood, sample_stats and observed_data;
        weighted_samples of nested sampling; summary, a row for each number; residuals at the optimum, and
        held_out if wanted, unless the response is no function of its inputs; attributes.

    Raises:
        ValueError: the law predicts nothing at any start.
    """
    problem, best = candidate.problem, None
    folds = None if held_out == "off" else folds_of(problem, held_out)
    if problem.parameters:
        try:
            with part_of_progress(0.0, SEARCHED, f"{candidate.label}: "):
                best = best_fit(problem.residuals, problem.parameters, starts, seed, step=problem.step)
        except ValueError as error:
            raise ValueError(f"{candidate.label}: {error}") from error
    # A response that is no function of its inputs has no best values.
    spread = 0.0 if best is None else problem.spread(best.values)
    best = None if spread > MARGIN else best
    with part_of_progress(SEARCHED, 1.0, f"{candidate.label}: "):
        posterior = sample(problem, points=points, seed=seed, checkpoint=checkpoint, workers=workers)
    drawn = posterior.draws(DRAWS)
    units = {item.name: item.parameter.units for item in problem.free}
    columns = zip(units.items(), posterior.samples[drawn].T, strict=True)
    predictive, checks = _predictive(problem, posterior.samples[drawn[:PREDICTED]], seed)
    groups: dict[str, Mapping[Any, Any]] = {
        "posterior": {name: (SAMPLED, column[None], {"units": unit}) for (name, unit), column in columns},
        **predictive,
        "sample_stats": {"lp": (SAMPLED, posterior.log_likelihood[drawn][None])},
        "observed_data": problem.data.data_vars,
        "weighted_samples": {
            "value": (("sample", "parameter"), posterior.samples),
            "log_weight": ("sample", posterior.log_weight),
            "log_likelihood": ("sample", posterior.log_likelihood),
        },
    }
    coordinates: dict[Any, Any] = {
        **dict(problem.data.coords),
        "chain": np.arange(1),
        "draw": np.arange(DRAWS),
        "parameter": np.array([*units], dtype=object),
    }
    tree = xarray.DataTree()
    for group, content in groups.items():
        data = xarray.Dataset(content)
        known = {name: x[: data.sizes[name]] for name, x in coordinates.items() if name in data.dims}
        tree[group] = xarray.DataTree(data.assign_coords(known))
    tree["summary"] = xarray.DataTree(summary_of(candidate, best, posterior))
    if spread <= MARGIN:
        values = np.empty(0) if best is None else best.values
        tree["residuals"] = xarray.DataTree(residuals_of(problem, problem.residuals(values)))
        if folds:
            tree["held_out"] = xarray.DataTree(held_out_misfits(problem, folds, values, seed))
    coverage = _coverage(problem, predictive["posterior_predictive"])
    tree.attrs = {**_attributes(candidate, best, posterior), "spread": spread, **coverage, **checks}
    explains = spread <= MARGIN and coverage["covers"] and min(checks.values()) >= IMPROBABLE
    tree.attrs["fits"] = int(explains)
    unstated = not_stated("misfit and no best value", {candidate.label: spread}, "misfit", MARGIN)
    findings = [candidate.numbers, unstated] if unstated else _findings(candidate, best, posterior, tree)
    tree.attrs["findings"] = "\n".join(findings)
    tree["posterior"].attrs |= tree.attrs
    return tree


def _predictive(
    problem: Problem, draws: Array, seed: int
) -> tuple[dict[str, dict[str, Any]], dict[str, float]]:
    """Return predictions, replicated data and log densities of posterior samples, and p-values of checks."""
    generator = np.random.default_rng([seed, 2])
    measured = {str(name): item.values for name, item in problem.data.items()}
    discrepancies: dict[str, Callable[..., float]] = {"p_deviance": problem.deviance}
    if over_time := [name for name, item in problem.data.items() if str(item.dims[0]).endswith("time")]:
        discrepancies["p_succession"] = partial(succession, [str(name) for name in over_time])
    exceeded = dict.fromkeys(discrepancies, 0)
    parts: list[dict[str, list[Array]]] = [{}, {}, {}]
    for values in draws:
        predicted = problem.predict(values)
        # A sample has a likelihood.
        assert predicted is not None
        replicas = [problem.replicate(predicted, values, generator) for _ in range(REPLICAS)]
        for name, discrepancy in discrepancies.items():
            least = discrepancy(predicted, values, measured)
            exceeded[name] += sum(discrepancy(predicted, values, each) >= least for each in replicas)
        results = predicted, replicas[0], problem.log_densities(predicted, values)
        for part, result in zip(parts, results, strict=True):
            for name, numbers in result.items():
                part.setdefault(name, []).append(numbers)

    def over(name: str, numbers: list[Array], **attributes: str) -> xarray.Variable:
        """Return a variable over the draws; both directions of an impact have one density."""
        values = np.array(numbers)
        dims = map(str, problem.data[name].dims[: values.ndim - 1])
        return xarray.Variable((*SAMPLED, *dims), values[None], attributes)

    units = {str(name): str(item.attrs["units"]) for name, item in problem.data.items()}
    predictive = {name: over(name, x, units=units[name]) for name, x in parts[1].items()}
    for name, x in parts[0].items():
        meaning = f"{name} without noise and discrepancy"
        predictive[f"{name}_predicted"] = over(name, x, units=units[name], long_name=meaning)
    groups = {
        "posterior_predictive": predictive,
        "log_likelihood": {name: over(name, x) for name, x in parts[2].items()},
    }
    return groups, {name: count / (REPLICAS * len(draws)) for name, count in exceeded.items()}


def succession(
    names: Sequence[str], predicted: Mapping[str, Array], values: Array, observed: Mapping[str, Array]
) -> float:
    """Return the correlation of successive residuals, the largest of the series with these names."""
    del values
    every = [observed[name] - predicted[name] for name in names]
    return max(float(x[1:] @ x[:-1]) / (float(x @ x) or 1.0) for x in every)


def summary_of(candidate: Candidate, best: Optimum | None, posterior: Posterior) -> xarray.Dataset:
    """Return optimum, posterior, truth and prior of each number."""
    free = candidate.problem.free
    names = [item.name for item in free]
    mean, covariance = posterior.moments()
    deviation = np.sqrt(np.diag(covariance))
    optimum = {} if best is None else best.by_name
    interval = posterior.quantiles(ENDS)
    columns: dict[str, Any] = {
        "best": [optimum.get(name, np.nan) for name in names],
        "mean": mean,
        "deviation": deviation,
        "low": interval[:, 0],
        "high": interval[:, 1],
        "truth": [candidate.truth.get(name, np.nan) for name in names],
        "prior_low": [item.low for item in free],
        "prior_high": [item.high for item in free],
        "units": np.array([item.parameter.units for item in free], dtype=object),
    }
    data = xarray.Dataset({name: ("parameter", values) for name, values in columns.items()})
    with np.errstate(invalid="ignore"):
        data["correlation"] = ("parameter", "other"), covariance / np.multiply.outer(deviation, deviation)
    return data.assign_coords(parameter=np.array(names, dtype=object), other=np.array(names, dtype=object))


def _coverage(problem: Problem, predictive: Mapping[str, xarray.Variable]) -> dict[str, Any]:
    """Return the shares of the data in the 90 % and 50 % intervals of their replicas, and their errors.

    Both directions of an impact count once in the binomial error.
    """
    count, result = sum(len(item) for item in problem.data.values()), {}
    for name, ends in {"coverage": ENDS, "coverage_50": MIDDLE}.items():
        inside = []
        for name_of_data, item in problem.data.items():
            low, high = np.quantile(predictive[str(name_of_data)].values[0], ends, axis=0)
            inside.append(((low <= item.values) & (item.values <= high)).ravel())
        level = ends[1] - ends[0]
        result[name] = float(np.mean(np.concatenate(inside)))
        result[f"{name}_error"] = float(np.sqrt(level * (1.0 - level) / count))
    covers = abs(result["coverage"] - (ENDS[1] - ENDS[0])) <= ERRORS * result["coverage_error"]
    return {**result, "covers": int(covers)}


def _attributes(candidate: Candidate, best: Optimum | None, posterior: Posterior) -> dict[str, Any]:
    problem, optimum = candidate.problem, {} if best is None else best.by_name
    priors = {
        item.name: {"low": item.low, "high": item.high, "logarithmic": item.logarithmic}
        for item in problem.free
    }
    return {
        "title": f"Posterior of {candidate.label}",
        "law": problem.law,
        "log_evidence": posterior.log_evidence,
        "log_evidence_error": posterior.error,
        "information": posterior.information,
        "points": posterior.points,
        "seed": posterior.seed,
        "calls": posterior.calls,
        "prior": json.dumps(priors),
        "best_fit": json.dumps(optimum),
        "truth": json.dumps(dict(candidate.truth)),
        **candidate.origin,
        "dynesty_version": version("dynesty"),
    }


def _findings(
    candidate: Candidate, best: Optimum | None, posterior: Posterior, tree: xarray.DataTree
) -> list[str]:
    """Return sentences on search and posterior, and on what they do not determine."""
    result = [
        line for line in (*map(candidate.origin.get, ("tracks", "duplicates")), candidate.numbers) if line
    ]
    if best is not None:
        result.append(f"Least squares: {best.hits} of {best.costs.size} starts reached the optimum.")
        result += [f"Least squares: {phrase}." for phrase in best.warnings()]
    result.append(
        f"ln Z = {Estimate(posterior.log_evidence, posterior.error).text()}, "
        f"{posterior.information:.1f} nat of information, {posterior.calls} evaluations, "
        f"{posterior.effective:.0f} effective samples."
    )
    about = tree.attrs
    checks = [f"{about['p_deviance']:.3f} by the deviance"]
    if "p_succession" in about:
        checks.append(f"{about['p_succession']:.3f} by the correlation of successive residuals")
    result.append(f"Posterior predictive p-value: {' and '.join(checks)}.")
    if candidate.problem.nuisances:
        free = ", ".join(item.name for item in candidate.problem.nuisances)
        result.append(f"{free} is free, and adapts to a wrong law: the deviance alone does not reject one.")
    result.append(
        f"{about['coverage']:.1%} of the data lie in the 90 % intervals of their predictions, noise included."
    )
    if about["coverage"] < ENDS[1] - ENDS[0] - ERRORS * about["coverage_error"]:
        result.append(
            f"Warning: 90 % +- {about['coverage_error']:.1%} of the data should lie there. The noise is "
            "understated or the law does not explain the data, and the intervals of the numbers are too "
            "narrow. Try noise=free, discrepancy=on or student=free."
        )
    elif not about["covers"] or about["coverage_50"] > 0.5 + ERRORS * about["coverage_50_error"]:
        result.append(
            f"Warning: the 50 % intervals contain {about['coverage_50']:.1%} of the data: the noise is "
            "overstated, or outliers have widened it for all. Try student=free."
        )
    summary = tree["summary"].to_dataset()
    for item, low, high in zip(
        candidate.problem.free, summary["low"].values, summary["high"].values, strict=True
    ):
        start, end = item.to_unit(float(low)), item.to_unit(float(high))
        if end - start > UNINFORMED * (ENDS[1] - ENDS[0]):
            result.append(f"{item.name}: the data do not inform it; its posterior is its prior.")
        elif min(start, 1.0 - end) < AT_END:
            limit = item.low if start < 1.0 - end else item.high
            result.append(f"{item.name} lies at an end of its range, {limit:.4g}; the truth may lie beyond.")
    if candidate.truth:
        known = summary.sel(parameter=[*candidate.truth])
        inside = int(((known["low"] <= known["truth"]) & (known["truth"] <= known["high"])).sum())
        result.append(f"Truth: {inside} of {len(candidate.truth)} known numbers lie in their 90 % intervals.")
    return result


def strength(difference: float, error: float) -> str:
    """Return the word for a difference of ln Z of either sign; empty where it is not significant.

    Words of Jeffreys (1961), Theory of Probability, app. B.
    """
    size = abs(difference)
    if not size >= max(LEAST, ERRORS * error):
        return ""
    return next(word for limit, word in _STRENGTHS if size >= limit)


def misfits(fits: Mapping[str, xarray.DataTree]) -> dict[str, str]:
    """Return the laws that do not fit, by label, with p-value and share of the data in 90 % intervals."""
    result = {}
    for label, fit in fits.items():
        if (spread := fit.attrs["spread"]) > MARGIN:
            result[label] = f"no function of its inputs: its misfit differs by {100.0 * spread:.2g} %"
        elif not fit.attrs["fits"]:
            p = min(fit.attrs[name] for name in ("p_deviance", "p_succession") if name in fit.attrs)
            result[label] = f"p = {p:.3f}, {fit.attrs['coverage']:.1%} of the data in 90 % intervals"
    return result


def evidences_of(fits: Mapping[str, xarray.DataTree]) -> dict[str, Estimate]:
    """Return ln Z of the fits by label, in falling order."""
    every = {
        label: Estimate(float(fit.attrs["log_evidence"]), float(fit.attrs["log_evidence_error"]))
        for label, fit in fits.items()
    }
    return dict(sorted(every.items(), key=lambda item: -item[1].value))


def compared(fits: Mapping[str, xarray.DataTree]) -> list[str]:
    """Return which laws do not fit, then the law with the largest evidence beside each of the others."""
    (first, largest), *others = evidences_of(fits).items()
    result, failing = [], misfits(fits)
    if failing:
        head = "No fit within the noise"
        if others and len(failing) == len(fits):
            head = "No law here fits the data within the noise: evidence ranks misfits, and no odds follow"
        result.append(f"{head}: {'; '.join(f'{label} ({why})' for label, why in failing.items())}.")
    for other, evidence in others:
        difference, error = largest.value - evidence.value, hypot(largest.error, evidence.error)
        shown = f"ln B = {Estimate(difference, error).text()}"
        if (bad := first) in failing or fits[bad := other].attrs["spread"] > MARGIN:
            result.append(
                f"{first} has a larger evidence than {other} ({shown}), from which no odds follow, as {bad} "
                "does not fit."
            )
        elif word := strength(difference, error):
            odds = f"{exp(difference):.3g}" if difference < log(1e6) else f"10^{difference / log(10.0):.0f}"
            result.append(
                f"The evidence for {first} against {other} is {word}: odds of {odds} to 1 ({shown})."
            )
        else:
            result.append(f"{first} and {other} are not distinguishable ({shown}).")
    return result
