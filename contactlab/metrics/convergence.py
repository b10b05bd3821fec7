"""Dependence of a law's results on the step, the basis of the resonator and friction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isfinite, nan
from typing import TYPE_CHECKING, Any, Final, NamedTuple, final

import numpy as np

from contactlab.metrics.catalogue import SENSITIVITIES, STEP_METRICS, measured, metric, of_steps
from contactlab.metrics.response import finite_peak, peak_force, rotor_velocity, total_impulse
from contactlab.metrics.run import NotApplicableError, Run, needed, positive
from contactlab.refinement import LEVELS, Refinement

if TYPE_CHECKING:
    import xarray

SAME_RATIO: Final = 1e-6  # relative difference of ratios of steps that count as equal

LEAST_ORDER: Final = 0.5
"""Smallest observed order that is extrapolated: below it the extrapolation exceeds two of the differences
(Oberkampf and Roy 2010, Verification and Validation in Scientific Computing, sec. 8.7)."""


@final
class Ladder(NamedTuple):
    """Runs of one law on one motor at successive contact steps or tolerances, coarsest first."""

    refinement: Refinement
    runs: Sequence[Run]


ROACHE: Final = "Roache (1998), Verification and Validation in Computational Science, ch. 5"


def _exponent(ladder: Ladder, value: Callable[[Run], float], form: Any = float) -> float:
    """Return the slope of the line through the logarithms of values over steps, or its size."""
    needed(len(ladder.runs) > 1)
    values = np.array([value(run) for run in ladder.runs])
    needed(np.isfinite(values).all() and (values > 0.0).all())
    x = np.log(ladder.refinement.values)
    x -= x.mean()
    return float(form(x @ np.log(values) / positive(float(x @ x))))


def _impulse(run: Run) -> float:
    """Return the normal impulse of a drive period [N s]: settled motions may repeat after several."""
    return total_impulse(run) / run.periods


for _value, _judged, _key, _symbol, _name, _except in (
    (
        peak_force,
        finite_peak,
        "peak_force",
        "N_max",
        "peak force",
        "; not applicable to rigid laws, whose impacts have an impulse and no force",
    ),
    (_impulse, _impulse, "impulse", "sum(p_n)", "normal impulse", ""),
):
    of_steps(
        f"d(ln {_symbol}) / d(ln h)",
        f"exponent of the {_name} in the step, by least squares",
        key=f"{_key}_exponent",
        source="paper, fig. 9",
    )(partial(_exponent, value=_value))
    of_steps(
        f"|d(ln {_symbol}) / d(ln h)|",
        f"dependence of the {_name} on the step{_except}",
        key=f"{_key}_step_dependence",
        bound=0.05,
        reason="a physical quantity does not depend on the step: the exponent of one that converges is its "
        "order times its remaining error, 0.05 for five per cent at first order",
        source="paper, fig. 9 and its discussion",
    )(partial(_exponent, value=_judged, form=abs))


def _velocities(ladder: Ladder) -> list[float]:
    """Return the rotor velocities of the three finest steps [rad/s], whose ratios must be equal."""
    needed(len(ladder.runs) >= LEVELS)
    coarse, middle, fine = ladder.refinement.values[-LEVELS:]
    needed(abs(coarse * fine / middle**2 - 1.0) <= SAME_RATIO)
    return [rotor_velocity(run) for run in ladder.runs[-LEVELS:]]


@of_steps(
    "p = ln(d_1/d_2) / ln(h_1/h_2)",
    "observed order of the rotor velocity over the three finest steps",
    source=ROACHE,
)
def velocity_order(ladder: Ladder) -> float:
    order = ladder.refinement.observed_order(_velocities(ladder))
    needed(isfinite(order))
    return order


@of_steps(
    "Omega_3 - d_2 / (r^p - 1), r = h_1/h_2",
    "rotor velocity extrapolated to a step of zero",
    "rad s-1",
    source=ROACHE,
)
def extrapolated_rotor_velocity(ladder: Ladder) -> float:
    _, second, third = _velocities(ladder)
    order = velocity_order(ladder)
    needed(order >= LEAST_ORDER)
    return third - (second - third) / (float(ladder.refinement.factor**order) - 1.0)


@of_steps(
    "|Omega_3 - Omega_extrapolated| / |Omega_3|",
    "numerical error of the rotor velocity at the finest step; the range of three without a valid order",
    source=ROACHE,
)
def velocity_error(ladder: Ladder) -> float:
    velocities = _velocities(ladder)
    finest = velocities[-1]
    try:
        error = abs(finest - extrapolated_rotor_velocity(ladder))
    except NotApplicableError:
        error = float(np.ptp(velocities))
    needed(finest != 0.0)
    return error / abs(finest)


def assess_steps(runs: Sequence[tuple[float, xarray.DataTree | Run]]) -> dict[str, float]:
    """Return the metrics of a step-size hierarchy.

    Args:
        runs: contact step [s] or tolerance [1] and run, of one law on one motor, coarsest first.

    Returns:
        A number for every key of `STEP_METRICS`; NaN where there are too few steps.

    Raises:
        ValueError: the steps are not positive and falling.
    """
    steps = [float(step) for step, _ in runs]
    if any(step <= 0.0 for step in steps) or sorted(set(steps), reverse=True) != steps:
        raise ValueError(
            f"The steps are {steps}; they must be positive and fall from run to run, coarsest first."
        )
    factor = steps[-2] / steps[-1] if len(steps) > 1 else nan
    refinement = Refinement(factor, order=nan, values=tuple(steps))
    return measured(STEP_METRICS, Ladder(refinement, [Run.of(run) for _, run in runs]))


def _sensitivity(runs: Mapping[str, tuple[float, Run]], thing: str, value: Callable[[Run], float]) -> float:
    """Return ((x_changed - x) / x) / amount."""
    needed(thing in runs and runs[thing][0] != 0.0)
    amount, variant = runs[thing]
    before = value(runs["base"][1])
    needed(before != 0.0)
    return (value(variant) - before) / before / amount


for _thing, _symbol, _base in (
    ("basis", "d{0} / {0}", "with the basis"),
    ("friction", "(d{0} / {0}) / (dmu / mu)", "over that of the friction coefficient"),
):
    for _value, _key, _letter, _name in (
        (rotor_velocity, "rotor_velocity", "Omega", "mean rotor velocity"),
        (peak_force, "peak_force", "N_max", "peak normal force"),
        (_impulse, "total_impulse", "P", "sum P of the normal impulses of a drive period"),
    ):
        metric(
            _symbol.format(_letter),
            f"relative change of the {_name} {_base}",
            catalogue=SENSITIVITIES,
            key=f"{_key}_by_{_thing}",
        )(partial(_sensitivity, thing=_thing, value=_value))


def assess_variants(
    base: xarray.DataTree | Run, **variants: tuple[float, xarray.DataTree | Run]
) -> dict[str, float]:
    """Return the sensitivities of a law's results to basis and friction.

    Args:
        base: the run.
        variants: `basis=(1.0, run)`, with another basis of the resonator, and `friction=(amount, run)`, with
            the friction coefficient changed by a share of it [1].

    Returns:
        A number for every key of `SENSITIVITIES`; NaN without the variant.
    """
    runs = {name: (float(amount), Run.of(run)) for name, (amount, run) in variants.items()}
    return measured(SENSITIVITIES, {"base": (0.0, Run.of(base)), **runs})
