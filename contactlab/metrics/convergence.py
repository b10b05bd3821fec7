"""How a law's answers depend on the step, on the basis of the resonator and on the friction."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import log
from typing import Final

import numpy as np
import xarray

from contactlab.metrics.catalogue import SENSITIVITIES, STEP_METRICS, measured, metric, of_steps
from contactlab.metrics.response import peak_force, rotor_velocity, total_impulse
from contactlab.metrics.run import NotApplicableError, Run, needed, positive

EXPONENT: Final = 0.05
ONE_RATIO: Final = 1e-6
"""Relative difference at which two ratios of steps are the same: steps are given in decimals."""

LEAST_ORDER: Final = 0.5
"""Below it an extrapolation is no more than a guess: it goes further than two of the differences that it is
made from (Oberkampf and Roy 2010, Verification and Validation in Scientific Computing, sec. 8.7)."""

FIGURE_9: Final = "paper, fig. 9"
ROACHE: Final = "Roache (1998), Verification and Validation in Computational Science, ch. 5"

Ladder = Sequence[tuple[float, Run]]
"""Step [s] or tolerance [1] and run, of one law on one motor, coarsest first."""

Variants = Mapping[str, tuple[float, Run]]
"""Runs of one law: `base` by 0, and with the `basis` or the `friction` changed by an amount [1]."""


def _exponent(ladder: Ladder, value: Callable[[Run], float]) -> float:
    """Give the slope of the line through the logarithms of values over steps, by least squares."""
    needed(len(ladder) > 1)
    values = np.array([value(run) for _, run in ladder])
    needed(bool(np.isfinite(values).all() and (values > 0.0).all()))
    x = np.log([step for step, _ in ladder])
    x -= x.mean()
    return float(x @ np.log(values) / positive(float(x @ x)))


def _velocities(ladder: Ladder) -> tuple[float, float, float, float]:
    """Give the rotor velocities of the three finest steps [rad/s], and the one ratio of these steps."""
    needed(len(ladder) > 2)
    coarse, middle, fine = (step for step, _ in ladder[-3:])
    needed(coarse > middle > fine > 0.0)
    needed(abs(coarse * fine / middle**2 - 1.0) <= ONE_RATIO)
    first, second, third = (rotor_velocity(run) for _, run in ladder[-3:])
    return first, second, third, middle / fine


@of_steps(
    "d ln N_max / d ln h",
    "exponent of the peak force in the step, by least squares",
    source=FIGURE_9,
)
def peak_force_exponent(ladder: Ladder) -> float:
    return _exponent(ladder, peak_force)


@of_steps(
    "|d ln N_max / d ln h|",
    "dependence of the peak force on the step",
    bound=EXPONENT,
    reason="a physical force does not depend on the step: one that converges has an exponent of its order "
    "times its remaining error, 0.05 for five per cent at first order; a force made as impulse over step "
    "has one",
    source=f"{FIGURE_9} and its discussion",
)
def peak_force_step_dependence(ladder: Ladder) -> float:
    return abs(_exponent(ladder, peak_force))


@of_steps(
    "d ln sum p_n / d ln h",
    "exponent of the normal impulse in the step, by least squares",
    source=FIGURE_9,
)
def impulse_exponent(ladder: Ladder) -> float:
    return _exponent(ladder, total_impulse)


@of_steps(
    "|d ln sum p_n / d ln h|",
    "dependence of the normal impulse on the step",
    bound=EXPONENT,
    reason="as that of the peak force: what moves the rotor may not depend on the step",
    source=f"{FIGURE_9} and its discussion",
)
def impulse_step_dependence(ladder: Ladder) -> float:
    return abs(_exponent(ladder, total_impulse))


@of_steps(
    "p = ln(d1/d2) / ln(h1/h2)",
    "observed order of the rotor velocity over the three finest steps",
    source=ROACHE,
)
def velocity_order(ladder: Ladder) -> float:
    first, second, third, ratio = _velocities(ladder)
    before, after = first - second, second - third
    # Round-off has no order; equal signs and a fall are what convergence looks like.
    needed(abs(after) > 1e-12 * abs(third) and before * after > 0.0 and abs(before) > abs(after))
    return log(before / after) / log(ratio)


@of_steps(
    "Omega_3 - d2 / (ratio^p - 1)",
    "rotor velocity extrapolated to no step at all",
    "rad s-1",
    source=ROACHE,
)
def extrapolated_rotor_velocity(ladder: Ladder) -> float:
    _, second, third, ratio = _velocities(ladder)
    order = velocity_order(ladder)
    needed(order >= LEAST_ORDER)
    return third - (second - third) / (float(ratio**order) - 1.0)


@of_steps(
    "|Omega_3 - Omega_extrapolated| / |Omega_3|",
    "numerical error of the rotor velocity at the finest step; where no order can be trusted, the range of "
    "the three finest over the finest",
    source=ROACHE,
)
def velocity_error(ladder: Ladder) -> float:
    *coarser, finest, _ = _velocities(ladder)
    try:
        error = abs(finest - extrapolated_rotor_velocity(ladder))
    except NotApplicableError:
        error = float(np.ptp([*coarser, finest]))
    needed(finest != 0.0)
    return error / abs(finest)


def assess_steps(runs: Sequence[tuple[float, xarray.DataTree | Run]]) -> dict[str, float]:
    """Judge a ladder of steps.

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
            f"The steps are {steps}; they must be positive and fall from run to run. Sort the runs, "
            "coarsest first, and give each step once."
        )
    return measured(STEP_METRICS, [(float(step), Run.of(run)) for step, run in runs])


def _sensitivity(runs: Variants, thing: str, value: Callable[[Run], float]) -> float:
    """Give ((x_changed - x) / x) / amount."""
    needed(thing in runs and runs[thing][0] != 0.0)
    amount, variant = runs[thing]
    before = value(runs["base"][1])
    needed(before != 0.0)
    return (value(variant) - before) / before / amount


for _thing, _symbol, _meaning in (
    ("basis", "d {0} / {0}", "relative change of the {} with the basis"),
    (
        "friction",
        "(d {0} / {0}) / (d mu / mu)",
        "relative change of the {} over that of the friction coefficient",
    ),
):
    for _value, _letter, _words in (
        (rotor_velocity, "Omega", "mean rotor velocity"),
        (peak_force, "N_max", "peak normal force"),
        (total_impulse, "sum p_n", "sum of the normal impulses"),
    ):
        metric(
            _symbol.format(_letter),
            _meaning.format(_words),
            catalogue=SENSITIVITIES,
            key=f"{_value.__name__}_by_{_thing}",
        )(partial(_sensitivity, thing=_thing, value=_value))


def assess_variants(
    base: xarray.DataTree | Run,
    basis: xarray.DataTree | Run | None = None,
    friction: tuple[float, xarray.DataTree | Run] | None = None,
) -> dict[str, float]:
    """Give how much a law's answers change with what is known least.

    Args:
        base: the run.
        basis: a run with another basis of the resonator.
        friction: relative change of the friction coefficient [1], and a run with it.

    Returns:
        A number for every key of `SENSITIVITIES`; NaN where the variant is not given.
    """
    runs = {"base": (0.0, Run.of(base))}
    if basis is not None:
        runs["basis"] = (1.0, Run.of(basis))
    if friction is not None:
        runs["friction"] = (float(friction[0]), Run.of(friction[1]))
    return measured(SENSITIVITIES, runs)
