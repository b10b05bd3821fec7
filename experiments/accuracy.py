"""Numbers of the pages on accuracy, fits and data sheets.

The reference case beside numbers of independent solvers; the motor on truncated bases; how many intervals of
90 % hold the truth, and which of the rigid laws that differ has made the data. They are made by remake.py.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from math import hypot, log, pi
from typing import Any, Final

import numpy as np
from fit_coverage import KINDS, coverage as intervals
from impact_mass import FREQUENCY, STEPS, mass_met
from references import HERTZ_CASE_A, RIGID_CASE_A

import contactlab as cl
from contactlab.config.nesting import flat
from contactlab.config.schema import declared_in
from contactlab_data.inference.evidence import strength
from contactlab_data.inference.fit import ENDS
from contactlab_data.inference.free_parameters import FreeParameter, free_parameters, with_values
from contactlab_data.inference.impact_problem import ImpactProblem, LawPredictor
from contactlab_data.inference.least_squares import best_fit
from contactlab_data.inference.motor_problem import series_problem
from contactlab_data.inference.nested_sampling import POINTS, sample
from contactlab_data.inference.synthetic import made_impacts, made_series, without_errors

CASE_A: Final = ["experiment=case_a"]
STEPPED, FINELY = "solver.contact_step=5e-8", "solver.contact_step=1e-8"
CASES: Final = {
    "hertz_penalty": ["law=hertz_penalty"],
    "lagrange_stick": ["law=lagrange_stick"],
    "lagrange_slip": ["law=lagrange_slip"],
    "lagrange_stick, stepped": ["law=lagrange_stick", STEPPED],
}
"""Laws and methods of the reference case."""

BASES: Final = {
    "4 Ritz shapes": ["resonator.shapes=4"],
    "40 Ritz shapes": ["resonator.shapes=40"],
    "4 modes, truncated": ["kept_modes=4", "static_correction=false"],
    "4 modes, corrected": ["kept_modes=4"],
    "6 modes, corrected (the option's default)": [],
    "24 modes, corrected": ["kept_modes=24"],
}
"""Bases, the last four of finite elements."""

ELEMENTS: Final = {"four shapes": [], "converged": ["resonator=finite_element"]}
SHEETS: Final = ("lagrange_slip", "lagrange_stick", "hertz_penalty")
"""Bases and laws of data sheets."""

FITS: Final = 16
"""Fits of either kind whose intervals are counted."""

MADE: Final = 200
"""Sets of data of each kind whose intervals by least squares are counted."""

IMPACTS, NOISE = 60, 0.05
"""Impacts of each of them, and their error over the approach."""

FRICTION: Final = {"friction_coefficient": (0.02, 0.8)}
RESTITUTION: Final = FRICTION | {"restitution": (0.0, 1.0)}
TRUTHS: Final = {
    "friction_coefficient": (0.1, 0.4),
    "restitution": (0.3, 0.8),
    "tangential_restitution": (0.2, 0.8),
    "yield_strength": (1e7, 1e9),
}
"""Ranges that truths are drawn from where laws are distinguished."""

LAWS: Final[dict[str, dict[str, tuple[float, float]]]] = {
    "lagrange_slip": FRICTION,
    "lagrange_stick": FRICTION,
    "newton": RESTITUTION,
    "poisson": RESTITUTION,
    "stronge": RESTITUTION,
    "johnson": FRICTION | {"yield_strength": (1e6, 1e10)},
    "chatterjee_ruina": RESTITUTION | {"tangential_restitution": (-1.0, 1.0)},
}
"""Rigid laws whose impulses differ, and the priors of their numbers."""

COUNTS, SETS, CLEAN, FEW = (5, 20, 100), 1, 0.02, 50
"""Numbers of impacts, sets of data by each law, their noise, and live points."""

MARGIN: Final = 6.0
"""A law whose largest likelihood is less than the largest evidence by this [ln Z] is not sampled."""

RUN: Final = ["law=hertz_penalty", "solver.duration=2e-3", "record.interval=1e-5"]
ROTOR: Final = {"law.stiffness": (1e9, 1e11), "contact.friction_coefficient": (0.1, 0.5)}
"""Priors of the fit to a rotor's velocity."""

SPOILED: Final = 0.01
"""Noise of that velocity over its root mean square."""


def case_a(cases: Iterable[str] = CASES) -> dict[str, Any]:
    """Return the reference case at its end, beside what independent solvers have."""
    stepped = cl.simulate(cl.build([*CASE_A, "law=lagrange_slip", FINELY]))
    references = {
        "hertz_penalty": HERTZ_CASE_A[0.3][0],
        "lagrange_stick": RIGID_CASE_A["rotor_velocity"][0],
        "lagrange_slip": float(stepped["rotor_velocity"][-1]),
    }
    return {name: _case(CASES[name], references[name.partition(",")[0]]) for name in cases}


def _case(overrides: list[str], reference: float) -> dict[str, Any]:
    run = cl.simulate(cl.build([*CASE_A, *overrides]))
    return {
        "rotor_velocity": float(run["rotor_velocity"][-1]),
        "reference": reference,
        "contacts": int(run.contacts.start_time.size),
        "residual": abs(float(run["energy_residual"][-1] / run["drive_work"][-1])),
    }


def bases(names: Iterable[str] = BASES) -> dict[str, Any]:
    """Return the motor on bases, at the converged first natural frequency and its double."""
    return {name: _basis(name, BASES[name]) for name in names}


def _basis(name: str, options: list[str]) -> dict[str, Any]:
    ritz = "Ritz" in name
    overrides = options if ritz else ["resonator=finite_element", *(f"resonator.{x}" for x in options)]
    setup = cl.build([*CASE_A, "law=hertz_penalty", f"drive.frequency={FREQUENCY}", *overrides])
    modes, steady = setup.motor.modes, cl.converged(setup).best
    return {
        "frequencies": modes.natural_frequency[:2].tolist(),
        "compliance": float(np.sum(modes.tip_displacement**2 / modes.stiffness)),
        "mass": mass_met(modes, STEPS[-1]),
        "peak_force": steady.peak_force.value,
        "rotor_velocity": steady.velocity.value,
    }


def drawn(ranges: Mapping[str, tuple[float, float]], seed: int) -> dict[str, float]:
    """Draw numbers evenly, or evenly in the logarithm as priors are."""
    rng = np.random.default_rng([seed, 3])

    def within(low: float, high: float) -> float:
        wide = high >= 100.0 * low > 0.0
        return float(np.exp(rng.uniform(*np.log([low, high]))) if wide else rng.uniform(low, high))

    return {name: within(*ends) for name, ends in ranges.items()}


def law_with(law: Any, free: Any, truth: Mapping[str, float]) -> Any:
    """Return a law with the numbers that are free."""
    return with_values(law, free, [truth[item.name] for item in free])


def covered(stated: bool, seed: int) -> dict[str, bool]:
    """Return which 90 % intervals hold the truth, of one fit to impacts whose error is stated or found."""
    law = cl.law("newton")
    free, truth = free_parameters(law, RESTITUTION), drawn(RESTITUTION, seed)
    data: Any = made_impacts(law_with(law, free, truth), IMPACTS, NOISE, seed)
    problem = ImpactProblem(
        data if stated else without_errors(data), LawPredictor(law, free, law.name), discrepancy=not stated
    )
    ends = sample(problem, points=POINTS, seed=seed, workers=1, single_mode=True).quantiles(ENDS)
    known = truth | {"discrepancy": NOISE}
    return {
        item.name: bool(low <= known[item.name] <= high)
        for item, (low, high) in zip(problem.free, ends, strict=True)
    }


def coverage(fits: int = FITS) -> dict[str, Any]:
    """Return how many of the intervals hold the truth."""
    counts = {
        kind: sum((Counter(covered(kind == "stated", seed)) for seed in range(fits)), Counter())
        for kind in ("stated", "found")
    }
    return {"fits": fits, "covered": {kind: dict(own) for kind, own in counts.items()}}


def contest(true: str, count: int, seed: int) -> tuple[str, bool]:
    """Return the verdict on data that one law has made, and whether it has the largest evidence."""
    law = cl.law(true)
    free = free_parameters(law, LAWS[true])
    truth = drawn({name: TRUTHS[name] for name in LAWS[true]}, seed)
    data = made_impacts(law_with(law, free, truth), count, CLEAN, seed)
    models = {name: _problem(data, name) for name in LAWS}
    constant = -0.5 * sum(log(np.linalg.det(2.0 * pi * each)) for each in data.covariance)
    # An evidence is less than the largest likelihood.
    most = {name: constant - best_fit(own.residuals, own.free, 2, seed).cost for name, own in models.items()}
    evidences: dict[str, tuple[float, float]] = {}
    for name in sorted(most, key=lambda each: -most[each]):
        if not evidences or most[name] > max(evidences.values())[0] - MARGIN:
            own = sample(models[name], points=FEW, seed=seed, workers=1, single_mode=True)
            evidences[name] = own.log_evidence, own.error
    first, *others = sorted(evidences, key=lambda name: -evidences[name][0])
    (z, error), lead = evidences[first], np.inf
    if others:
        (other, its_error) = evidences[others[0]]
        lead, error = z - other, hypot(error, its_error)
    known = strength(lead, error)
    return ("right" if first == true else "wrong") if known else "open", first == true


def _problem(data: Any, name: str) -> ImpactProblem:
    law = cl.law(name)
    return ImpactProblem(data, LawPredictor(law, free_parameters(law, LAWS[name]), name))


def true_law(counts: Iterable[int] = COUNTS, sets: int = SETS) -> dict[str, Any]:
    """Return the verdicts over the number of impacts."""
    results = {}
    for count in counts:
        verdicts = [contest(law, count, n + sets * k) for k, law in enumerate(LAWS) for n in range(sets)]
        kinds = Counter(kind for kind, _ in verdicts)
        results[str(count)] = {
            "sets": len(verdicts),
            **{kind: kinds[kind] for kind in ("right", "wrong", "open")},
            "largest": sum(first for _, first in verdicts),
        }
    return results


def rotor_fit(points: int = POINTS) -> dict[str, Any]:
    """Return the posterior of stiffness and friction from a rotor's velocity with noise."""
    setup = cl.build(RUN)
    data = without_errors(made_series(setup, ["rotor_velocity"], SPOILED, 0))
    text = declared_in(setup.configuration)
    keys = [FreeParameter(key, *ends, key == "law.stiffness", text[key]) for key, ends in ROTOR.items()]
    problem = series_problem(data, setup.configuration, keys, discrepancy=False)
    posterior = sample(problem, points=points, seed=0, workers=1, single_mode=True)
    (mean, covariance), ends = posterior.moments(), posterior.quantiles(ENDS)
    truth, names = flat(setup.configuration), ("mean", "deviation", "low", "high")
    columns = zip(mean, np.sqrt(np.diag(covariance)), *ends.T, strict=True)
    return {
        item.name: {"truth": truth[item.name], **dict(zip(names, map(float, own), strict=True))}
        for item, own in zip(problem.free, columns, strict=True)
        if item.name in ROTOR
    }


def data_sheets(bases: Iterable[str] = ELEMENTS) -> dict[str, Any]:
    """Return the data sheets of the default motor under three laws on two bases."""
    return {basis: {law: _sheet([f"law={law}", *ELEMENTS[basis]]) for law in SHEETS} for basis in bases}


def _sheet(overrides: list[str]) -> dict[str, float]:
    sheet = cl.characterise(cl.build(overrides)).data.ds.isel(law=0)
    result = {}
    for name in ("no_load_velocity", "stall_torque", "output_power", "electrical_efficiency"):
        at = {} if sheet[name].ndim == 0 else {"point": int(sheet[name].argmax("point"))}
        result |= {each: float(sheet[each].isel(at)) for each in (name, f"{name}_error")}
    return result


SECTIONS: Final[dict[str, tuple[Callable[[], dict[str, Any]], Callable[[], dict[str, Any]]]]] = {
    "case A": (case_a, case_a),
    "bases": (bases, lambda: bases(("4 Ritz shapes", "4 modes, corrected"))),
    "data sheets": (data_sheets, lambda: data_sheets(["four shapes"])),
    "coverage": (coverage, lambda: coverage(1)),
    "true law": (true_law, lambda: true_law((100,))),
    "rotor fit": (rotor_fit, lambda: rotor_fit(10)),
    **{
        f"intervals of {kind}": (partial(intervals, kind, MADE), partial(intervals, kind, 1))
        for kind in KINDS
    },
}
"""What makes a section, and its short form."""
