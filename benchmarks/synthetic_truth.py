"""Whether fits find the truth where it is known: coverage of the intervals, and the true law among ten.

    python benchmarks/synthetic_truth.py [--fits N] [--series N] [--sets N] [--short N] [--output DIR]

Coverage: truths are drawn from the priors, data made with them, and the 90 % intervals of the posteriors
counted that hold the truth: of impacts under `newton`, with and without a stated error, and of a rotor's
velocity under `hertz_penalty`, where stiffness, friction and noise are free. Nine of ten must, within the
binomial error of the count.

Laws: each of ten makes data, and the evidence of all ten is computed from them. "Right" is the true law with
the largest evidence and a Bayes factor over the second that is significant (above 3 and above three of its
errors), "wrong" another law so; all else is "inconclusive". A law whose largest likelihood is below the
largest evidence by `MARGIN` and more is not sampled: its evidence is smaller than its likelihood.
"""

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import hypot, log, pi
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pandas
from three_more_laws import SlantingImpact, TurningImpact, ViscoelasticImpact
from tqdm import tqdm

import contactlab as cl
from contactlab.config.schema import declared_in
from contactlab.inference.fit import strength
from contactlab.inference.free_parameters import FreeParameter, free_parameters, with_values
from contactlab.inference.impact_problem import ImpactProblem, LawPredictor
from contactlab.inference.least_squares import best_fit
from contactlab.inference.motor_problem import series_problem
from contactlab.inference.nested_sampling import sample
from contactlab.inference.synthetic import made_impacts, made_series, without_errors
from contactlab.processes import begin_worker

POINTS, COVERING = 50, 150
"""Live points of evidence, with which ln Z is known to 0.45, and of coverage. With 50 the ends of intervals
lie at 5.6 % and 93.9 % of a posterior by quadrature (40 fits), with 150 at 5.2 % and 94.7 %."""

MARGIN = 6.0
"""Of ln Z, by which a law is out of the question."""

ENDS = (0.05, 0.95)
FRICTION = {"friction_coefficient": (0.02, 0.8)}
RESTITUTION = {"restitution": (0.0, 1.0)}
IMPACTS = 60
NOISE = 0.05
"""Of the impacts that coverage is counted with."""

CLEAN = 0.02
"""Of those that tell laws apart."""

COUNTS = (100, 20, 5)
"""Numbers of impacts from which laws are distinguished, the data that are long enough first."""

LAWS: dict[str, tuple[Any, dict[str, tuple[float, float]], dict[str, tuple[float, float]]]] = {
    law.name: (law, FRICTION | ranges, {"friction_coefficient": (0.1, 0.4)} | truths)
    for law, ranges, truths in (
        (cl.law("lagrange_slip"), {}, {}),
        (cl.law("lagrange_stick"), {}, {}),
        (cl.law("newton"), RESTITUTION, {"restitution": (0.3, 0.8)}),
        (cl.law("poisson"), RESTITUTION, {"restitution": (0.3, 0.8)}),
        (cl.law("stronge"), RESTITUTION, {"restitution": (0.3, 0.8)}),
        (cl.law("johnson"), {"yield_strength": (1e6, 1e10)}, {"yield_strength": (1e7, 1e9)}),
        (
            cl.law("chatterjee_ruina"),
            RESTITUTION | {"tangential_restitution": (-1.0, 1.0)},
            {"restitution": (0.3, 0.8), "tangential_restitution": (0.2, 0.8)},
        ),
        (
            TurningImpact(),
            RESTITUTION | {"turned": (0.0, 1.0)},
            {"restitution": (0.3, 0.8), "turned": (0.2, 0.8)},
        ),
        (ViscoelasticImpact(), {"loss": (0.0, 1.0)}, {"loss": (0.2, 0.7)}),
        (
            SlantingImpact(),
            RESTITUTION | {"slant": (0.0, 1.0)},
            {"restitution": (0.3, 0.8), "slant": (0.1, 0.6)},
        ),
    )
}
"""Laws by name, with the priors of what is free and the ranges that truths are drawn from."""


def drawn(ranges: dict[str, tuple[float, float]], seed: int) -> dict[str, float]:
    """Draw numbers evenly; those of a range that is wide, evenly in the logarithm."""
    draws = np.random.default_rng([seed, 3])
    wide = {name: low > 0.0 and high / low >= 100.0 for name, (low, high) in ranges.items()}
    return {
        name: float(np.exp(draws.uniform(*np.log([low, high]))) if wide[name] else draws.uniform(low, high))
        for name, (low, high) in ranges.items()
    }


def of_impacts(stated: bool, seed: int) -> dict[str, bool]:
    """Return which intervals cover, of one fit to impacts; without a stated error its size is found."""
    law, ranges, _ = LAWS["newton"]
    free = free_parameters(law, ranges)
    truth = drawn(ranges, seed)
    made = with_values(law, free, [truth[item.name] for item in free])
    data: Any = made_impacts(made, IMPACTS, NOISE, seed)
    predictor = LawPredictor(law, free, law.name)
    problem = ImpactProblem(data if stated else without_errors(data), predictor, discrepancy=not stated)
    if not stated:
        truth["discrepancy"] = NOISE
    return covered(problem, truth, seed)


def of_series(seed: int) -> dict[str, bool]:
    """Return which intervals cover, of one fit to a rotor's velocity."""
    ranges = {"law.stiffness": (1e9, 1e11), "contact.friction_coefficient": (0.1, 0.5)}
    truth = drawn(ranges, seed)
    label = [f"{key}={value!r}" for key, value in truth.items()]
    setup = cl.build(["law=hertz_penalty", "solver.duration=2e-3", "record.interval=2e-5", *label])
    data = without_errors(made_series(setup, ["rotor_velocity"], 0.01, seed))
    text = declared_in(setup.configuration)
    keys = [FreeParameter(key, *ends, key == "law.stiffness", text[key]) for key, ends in ranges.items()]
    problem = series_problem(data, setup.configuration, keys, discrepancy=False)
    errors = made_series(setup, ["rotor_velocity"], 0.01, seed).errors["rotor_velocity"]
    return covered(problem, truth | {"noise.rotor_velocity": float(errors[0])}, seed)


def covered(problem: Any, truth: dict[str, float], seed: int) -> dict[str, bool]:
    """Return which of the intervals of a posterior hold the truth."""
    ends = sample(problem, points=COVERING, seed=seed, workers=1, single_mode=True).quantiles(ENDS)
    return {
        item.name: bool(low <= truth[item.name] <= high)
        for item, (low, high) in zip(problem.free, ends, strict=True)
    }


def contest(count: int, case: int) -> dict[str, Any]:
    """Let one of the ten laws make data, and find the evidence of all."""
    names = [*LAWS]
    true = names[case % len(names)]
    law, ranges, truths = LAWS[true]
    free = free_parameters(law, ranges)
    values = drawn(truths, case)
    made = with_values(law, free, [values[item.name] for item in free])
    data = made_impacts(made, count, CLEAN, case)
    models, most = {}, {}
    for name, (other, priors, _) in LAWS.items():
        own = free_parameters(other, priors)
        models[name] = model = ImpactProblem(data, LawPredictor(other, own, name))
        constant = -0.5 * sum(log(np.linalg.det(2.0 * pi * each)) for each in data.covariance)
        most[name] = constant - best_fit(model.residuals, own, 2, case).cost
    evidences: dict[str, tuple[float, float]] = {}
    for name in sorted(names, key=lambda each: -most[each]):
        largest = max((z for z, _ in evidences.values()), default=-np.inf)
        if most[name] > largest - MARGIN:
            result = sample(models[name], points=POINTS, seed=case, workers=1, single_mode=True)
            evidences[name] = result.log_evidence, result.error
    first, *others = sorted(evidences, key=lambda name: -evidences[name][0])
    lead, error = np.inf, 0.0
    if others:
        (z, e), (z_2, e_2) = evidences[first], evidences[others[0]]
        lead, error = z - z_2, hypot(e, e_2)
    word = ("right" if first == true else "wrong") if strength(lead, error) else "inconclusive"
    return {
        "impacts": count,
        "true": true,
        "first": first,
        "second": others[0] if others else "",
        "lead": lead,
        "error": error,
        "verdict": word,
    }


def mapped(work: Any, count: int, workers: int, what: str) -> Iterator[dict[str, Any]]:
    """Do some work for so many seeds, by several processes."""
    with ProcessPoolExecutor(workers, get_context("fork"), begin_worker) as pool:
        yield from tqdm(pool.map(work, range(count)), total=count, desc=what, disable=None)


def work_name(kind: str) -> str:
    """Return the name of a file from what is fitted."""
    return kind.replace(",", "").replace(" ", "_")


def coverage(kind: str, rows: list[dict[str, bool]]) -> pandas.DataFrame:
    """Count what is covered, with its binomial error."""
    table = pandas.DataFrame(rows)
    share = table.mean()
    return pandas.DataFrame(
        {
            "data": kind,
            "parameter": share.index,
            "fits": len(table),
            "covered [%]": 100.0 * share.to_numpy(),
            "error [%]": 100.0 * np.sqrt(0.9 * 0.1 / len(table)),
        }
    )


def verdicts(rows: pandas.DataFrame) -> pandas.DataFrame:
    """Return the shares of right, wrong and inconclusive over the number of impacts."""
    lines = []
    for count, group in rows.groupby("impacts"):
        shares = group["verdict"].value_counts(normalize=True)
        line = {"impacts": count, "sets": len(group)}
        line |= {f"{word} [%]": 100.0 * shares.get(word, 0.0) for word in ("right", "wrong", "inconclusive")}
        line["true law first [%]"] = 100.0 * float((group["first"] == group["true"]).mean())
        line["median error of ln B"] = float(group["error"][np.isfinite(group["lead"])].median())
        lines.append(line)
    return pandas.DataFrame(lines)


def main(arguments: list[str] | None = None) -> None:
    """Do all of it, print the tables and write them as CSV."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--fits", type=int, default=200, help="to impacts, of either kind: %(default)s")
    parser.add_argument("--series", type=int, default=50, help="fits to series: %(default)s")
    parser.add_argument("--sets", type=int, default=100, help="of many impacts: %(default)s")
    parser.add_argument("--short", type=int, default=50, help="sets of few impacts: %(default)s")
    parser.add_argument("--workers", type=int, default=2, help="processes: %(default)s")
    parser.add_argument("--output", type=Path, default=Path("outputs/synthetic_truth"))
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    began, parts = perf_counter(), []
    # What is compiled or loaded here the forks have.
    contest(min(COUNTS), 0), of_series(0)
    works = {
        "impacts, error stated": (partial(of_impacts, True), options.fits),
        "impacts, error found": (partial(of_impacts, False), options.fits),
        "rotor velocity": (of_series, options.series),
    }
    for kind, (work, count) in works.items():
        if count:
            result = []
            for row in mapped(work, count, options.workers, kind):
                result.append(row)
                # What there is by now is kept, whatever stops the rest.
                pandas.DataFrame(result).to_csv(options.output / f"{work_name(kind)}.csv", index=False)
            parts.append(coverage(kind, result))
    if parts:
        covering = pandas.concat(parts, ignore_index=True)
        covering.to_csv(options.output / "coverage.csv", index=False)
        print(covering.to_string(index=False, float_format="{:.1f}".format), flush=True)
    if options.sets:
        rows = []
        for count in COUNTS:
            sets = options.sets if count == max(COUNTS) else options.short
            for row in mapped(partial(contest, count), sets, options.workers, f"{count} impacts"):
                rows.append(row)
                pandas.DataFrame(rows).to_csv(options.output / "laws.csv", index=False)
        every = pandas.DataFrame(rows)
        print(verdicts(every).to_string(index=False, float_format="{:.2g}".format))
        longest = every[every["impacts"] == max(COUNTS)]
        missed = longest[longest["verdict"] != "right"]
        print(missed.to_string(index=False, float_format="{:.2g}".format))
    print(f"{perf_counter() - began:.0f} s with {options.workers} processes. Written to {options.output}.")


if __name__ == "__main__":
    main()
