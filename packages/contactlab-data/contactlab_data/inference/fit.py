"""Fit of a law to measurements: the result of least squares or of nested sampling, as one tree of datasets.

A posterior predictive check compares a discrepancy T of the data y with that of data replicated by the same
posterior sample x:

    p = P(T(y_rep, x) >= T(y, x) | y)

T is the deviance, which is chi-square for normal noise, and, for series over time, the correlation of
successive residuals, which a noise of free size does not hide.

Sources: Gelman, Meng and Stern (1996), Stat. Sinica 6, 733; Gelman et al. (2013), Bayesian Data Analysis,
3rd ed., ch. 6.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from math import erfc, sqrt
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.progress import part_of_progress
from contactlab.studies.compare.repeats import MARGIN, not_stated
from contactlab_data.inference.candidates import Candidate
from contactlab_data.inference.determination import determinations
from contactlab_data.inference.free_parameters import from_cube, to_cube
from contactlab_data.inference.held_out import HeldOut, folds_of, held_out_misfits, residuals_of
from contactlab_data.inference.least_squares import Optimum
from contactlab_data.inference.maximum_likelihood import (
    STARTS,
    covariance_of,
    followed_search,
    normal_posterior,
    scale_of,
)
from contactlab_data.inference.nested_sampling import POINTS, sample
from contactlab_data.inference.posterior import ENDS as ENDS, Posterior
from contactlab_data.inference.problem import Problem

SEARCHED: Final = 0.2
"""Share of the time of a fit that least squares take, roughly."""

DRAWS: Final = 1000
"""Posterior samples of equal weight that are kept."""

PREDICTED: Final = 250
"""Number of them whose predictions are kept."""

REPLICAS: Final = 8
"""Data sets replicated by each of them for the posterior predictive check; the first is kept."""

MIDDLE: Final = (0.25, 0.75)
"""Quantiles of the intervals by which outliers are noticed, 50 %."""

ERRORS: Final = 3.0
"""Standard deviations by which the coverage of the data may be off, and by which ln B is significant."""

IMPROBABLE: Final = 0.5 * erfc(ERRORS / sqrt(2.0))
"""Posterior predictive p-value below which a law does not fit: a normal distribution beyond `ERRORS`."""

SEARCH: Final = ("spread", "best_fit", "misfit", "held_out_misfit", "followed", "search")
"""Attributes of least squares that a result by another method has too."""

UNINFORMED: Final = 0.95
"""Width of a posterior's interval over the prior's from which on the data do not inform it."""

AT_END: Final = 2e-3
"""Distance of an interval from an end of the range below which it lies there, as a share of the range."""

SAMPLED: Final = ("chain", "draw")


def fitted(
    candidate: Candidate,
    checkpoint: Path | None = None,
    *,
    points: int = POINTS,
    seed: int = 0,
    starts: int = STARTS,
    held_out: HeldOut = "auto",
    workers: int | None = None,
) -> xarray.DataTree:
    """Fit a law by least squares, then by nested sampling; arguments as of `searched` and `sampled`."""
    with part_of_progress(0.0, SEARCHED):
        first = searched(candidate, seed=seed, starts=starts, held_out=held_out)
    with part_of_progress(SEARCHED, 1.0):
        return sampled(candidate, first, checkpoint, points=points, seed=seed, workers=workers)


def searched(
    candidate: Candidate, *, seed: int = 0, starts: int = STARTS, held_out: HeldOut = "auto"
) -> xarray.DataTree:
    """Fit a law by least squares: optimum, covariance, intervals by the profile likelihood, held-out misfits.

    Args:
        seed: the same gives the same bits.
        starts: of least squares.
        held_out: parts of the data that are predicted by fits to the others.

    Returns:
        ArviZ's groups posterior, posterior_predictive, log_likelihood, sample_stats and observed_data;
        weighted_samples; summary, a row for each number; residuals at the optimum, and held_out, unless the
        response is no function of its inputs; attributes.

    Raises:
        ValueError: the law predicts nothing at any start.
    """
    problem, label = candidate.problem, candidate.label
    folds = folds_of(problem, held_out, seed)
    origin = map(candidate.origin.get, ("tracks", "duplicates", "series"))
    lines = [line for line in (*origin, candidate.numbers) if line]
    try:
        with part_of_progress(0.0, 0.5, f"{label}: "):
            near, best = followed_search(problem, starts, seed)
    except ValueError as error:
        raise ValueError(f"{label}: {error}") from error
    spread = problem.spread(best.values) if problem.parameters else 0.0
    stated = spread <= MARGIN
    with part_of_progress(0.5, 0.8, f"{label}: "):
        every = determinations(near, best) if stated else []
    ends = np.array([item.ends for item in every] or np.full((len(best.free), 2), np.nan)).reshape(-1, 2)
    posterior = normal_posterior(problem, best, ends, seed)
    predict = linear_predictions(problem, best)
    groups, about = {}, {"spread": spread, "best_fit": "{}", "misfit": np.nan, "held_out_misfit": np.nan}
    about["followed"] = int(near is not problem)
    if stated:
        lines.append(f"Least squares: {best.hits} of {best.costs.size} starts reached the optimum.")
        lines += [f"Least squares: {phrase}." for phrase in best.warnings()]
        lines += [f"{item.number.name}: {item.remark}." for item in every if item.remark]
        residuals = problem.residuals(best.values)
        groups["residuals"] = residuals_of(problem, residuals)
        about |= {"best_fit": json.dumps(best.by_name), "misfit": float(np.sqrt(np.mean(residuals**2)))}
        if folds and problem.parameters:
            with part_of_progress(0.8, 1.0, f"{label}: "):
                groups["held_out"] = misfits = held_out_misfits(near, folds, best.values, seed)
            square = np.average(misfits["misfit"] ** 2, weights=misfits["count"])
            about["held_out_misfit"] = float(np.sqrt(square))
    else:
        # A response that is no function of its inputs has no best values.
        none = np.full_like(posterior.best, np.nan)
        posterior = replace(posterior, best=none, ends=np.full((none.size, 2), np.nan))
        lines = [candidate.numbers, not_stated("misfit and no best value", {label: spread}, "misfit", MARGIN)]
    about["search"] = "\n".join(lines)
    return _tree(candidate, posterior, predict, posterior.best, groups, about)


def sampled(
    candidate: Candidate,
    first: xarray.DataTree,
    checkpoint: Path | None = None,
    *,
    points: int = POINTS,
    seed: int = 0,
    workers: int | None = None,
) -> xarray.DataTree:
    """Fit a law by nested sampling: posterior and evidence of all that is free.

    Args:
        first: of `searched`, whose optimum, residuals and held-out misfits the result has too.
        points: live points of nested sampling.
        seed: the same gives the same bits.
        checkpoint: file from which an interrupted fit resumes.
        workers: processes; None is one a processor where that pays.
    """
    problem, best = candidate.problem, first["summary"].to_dataset()["best"].values
    if first.attrs["followed"] and np.isfinite(best).all():
        problem = problem.following(best[: len(problem.parameters)])
    with part_of_progress(0.0, 1.0, f"{candidate.label}: "):
        posterior = sample(problem, points=points, seed=seed, checkpoint=checkpoint, workers=workers)
    about = {name: first.attrs[name] for name in SEARCH}
    kept = {name: first[name].to_dataset() for name in ("residuals", "held_out") if name in first.children}

    def predict(values: Array) -> dict[str, Array]:
        predicted = problem.predict(values)
        # A sample has a likelihood.
        assert predicted is not None
        return predicted

    return _tree(candidate, posterior, predict, best, kept, about)


def linear_predictions(problem: Problem, best: Optimum) -> Callable[[Array], dict[str, Array]]:
    """Return predictions that are linear in the unit cube, by differences over a standard deviation.

    Where there is no prediction on one side that of the other counts; a number without any has no effect.
    """
    middle = problem.predict(best.values)
    # An optimum has a prediction.
    assert middle is not None
    slopes = []
    for place, size in enumerate(np.sqrt(np.diag(covariance_of(best.jacobian, scale_of(problem, best)[0])))):
        slope = {name: np.zeros_like(x) for name, x in middle.items()}
        for step in (size, -size):
            point = np.clip(best.point + step * np.eye(best.point.size)[place], 0.0, 1.0)
            moved = problem.predict(from_cube(best.free, point))
            if moved is not None and (by := point[place] - best.point[place]):
                slope = {name: (moved[name] - x) / by for name, x in middle.items()}
                break
        slopes.append(slope)

    def predict(values: Array) -> dict[str, Array]:
        off = to_cube(best.free, values[: best.point.size]) - best.point
        return {
            name: x + sum((by * slope[name] for by, slope in zip(off, slopes, strict=True)), np.zeros_like(x))
            for name, x in middle.items()
        }

    return predict


def _tree(
    candidate: Candidate,
    posterior: Posterior,
    predict: Callable[[Array], dict[str, Array]],
    best: Array,
    kept: Mapping[str, xarray.Dataset],
    about: Mapping[str, Any],
) -> xarray.DataTree:
    """Return the result of a method: its draws and their predictions, checks, summary and findings."""
    problem = candidate.problem
    drawn = posterior.draws(DRAWS)
    units = {item.name: item.parameter.units for item in problem.free}
    columns = zip(units.items(), posterior.samples[drawn].T, strict=True)
    predictive, checks = _predictive(problem, posterior.samples[drawn[:PREDICTED]], posterior.seed, predict)
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
    for name, data in kept.items():
        tree[name] = xarray.DataTree(data)
    coverage = _coverage(problem, predictive["posterior_predictive"])
    tree.attrs = {**_attributes(candidate, posterior), **about, **coverage, **checks}
    stated = about["spread"] <= MARGIN
    tree.attrs["fits"] = int(stated and coverage["covers"] and min(checks.values()) >= IMPROBABLE)
    lines = about["search"].splitlines()
    tree.attrs["findings"] = "\n".join([*lines, *(_findings(candidate, posterior, tree) if stated else [])])
    tree["posterior"].attrs |= tree.attrs
    return tree


def _predictive(
    problem: Problem, draws: Array, seed: int, predict: Callable[[Array], dict[str, Array]]
) -> tuple[dict[str, dict[str, Any]], dict[str, float]]:
    """Return predictions, replicated data and log densities of posterior samples, and p-values of checks."""
    generator = np.random.default_rng([seed, 2])
    measured = {str(name): item.values for name, item in problem.data.items()}
    discrepancies: dict[str, Callable[..., float]] = {"p_deviance": problem.deviance}
    if over_time := [
        name for name, item in problem.data.items() if str(item.dims[0]).endswith(("time", "row"))
    ]:
        discrepancies["p_succession"] = partial(succession, [str(name) for name in over_time])
    exceeded = dict.fromkeys(discrepancies, 0)
    parts: list[dict[str, list[Array]]] = [{}, {}, {}]
    for values in draws:
        predicted = predict(values)
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


def summary_of(candidate: Candidate, best: Array, posterior: Posterior) -> xarray.Dataset:
    """Return optimum, posterior, truth and prior of each number."""
    free = candidate.problem.free
    names = [item.name for item in free]
    mean, covariance = posterior.moments()
    deviation = np.sqrt(np.diag(covariance))
    interval = posterior.interval
    columns: dict[str, Any] = {
        "best": best,
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


def _attributes(candidate: Candidate, posterior: Posterior) -> dict[str, Any]:
    priors = {
        item.name: {"low": item.low, "high": item.high, "logarithmic": item.logarithmic}
        for item in candidate.problem.free
    }
    return {
        "title": f"Posterior of {candidate.label}",
        "method": posterior.method,
        "law": candidate.problem.law,
        "log_evidence": posterior.log_evidence,
        "log_evidence_error": posterior.error,
        "information": posterior.information,
        "points": posterior.points,
        "seed": posterior.seed,
        "calls": posterior.calls,
        "prior": json.dumps(priors),
        "truth": json.dumps(dict(candidate.truth)),
        **candidate.origin,
        "dynesty_version": version("dynesty"),
    }


def _findings(candidate: Candidate, posterior: Posterior, tree: xarray.DataTree) -> list[str]:
    """Return sentences on the posterior and on what it does not determine."""
    result = []
    if posterior.calls:
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
    # Of least squares the profile has said so.
    rows = zip(candidate.problem.free, summary["low"].values, summary["high"].values, strict=True)
    for item, low, high in rows if posterior.calls else ():
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
