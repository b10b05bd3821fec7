"""Dependence of a law's results on the step, the basis of the resonator and friction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import log
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from contactlab.arrays import Array
from contactlab.laws.base import is_stepped
from contactlab.metrics.catalogue import SENSITIVITIES, STEP_METRICS, measured, metric, of_steps
from contactlab.metrics.response import finite_peak, peak_force, rotor_velocity, total_impulse
from contactlab.metrics.run import NotApplicableError, Run, needed, positive

if TYPE_CHECKING:
    import xarray

    from contactlab.config import Setup

SAME_RATIO: Final = 1e-6  # relative difference of ratios of steps that count as equal

LEAST_ORDER: Final = 0.5
"""Smallest observed order that is extrapolated: below it the extrapolation exceeds two of the differences
(Oberkampf and Roy 2010, Verification and Validation in Scientific Computing, sec. 8.7)."""

Ladder = Sequence[tuple[float, Run]]
"""Step [s] or tolerance [1] and run, of one law on one motor, coarsest first."""

FINER: Final = {"contact_step": (1.0, 2.0, 4.0), "tolerance": (1.0, 10.0, 100.0)}
"""Divisors of the contact step of time stepping, of the tolerance of collocated contact."""


def control_of(setup: Setup) -> str:
    """Return the option of the solver that is refined in a setup."""
    return "contact_step" if is_stepped(setup.law, setup.contact_step) else "tolerance"


SLOWEST: Final = 0.9
"""Ratio of successive differences of a sequence that does not converge."""

ROACHE: Final = "Roache (1998), Verification and Validation in Computational Science, ch. 5"


def richardson(values: Sequence[Any], factor: float, order: float) -> Array:
    """Return the error of the last of three values from steps that fall by a factor.

    With differences that fall by the ratio q the error is q / (1 - q) times the last of them, where q is the
    observed ratio, at least that of the declared order and at most `SLOWEST`: the error of a sequence that
    does not converge is nine times its last change.
    """
    before, last = np.abs(np.diff(np.asarray(values, dtype=np.float64), axis=0))
    # A whole series has one ratio: where a difference passes through zero there is none.
    whole = float(np.sum(before))
    seen = float(np.sum(last)) / whole if whole > 0.0 else 0.0
    ratio = float(np.clip(seen, factor**-order, SLOWEST))
    return np.asarray(last * ratio / (1.0 - ratio))


def _exponent(ladder: Ladder, value: Callable[[Run], float], form: Any = float) -> float:
    """Return the slope of the line through the logarithms of values over steps, or its size."""
    needed(len(ladder) > 1)
    values = np.array([value(run) for _, run in ladder])
    needed(np.isfinite(values).all() and (values > 0.0).all())
    x = np.log([step for step, _ in ladder])
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


def _velocities(ladder: Ladder) -> tuple[float, float, float, float]:
    """Return the rotor velocities of the three finest steps [rad/s], and the ratio of the steps."""
    needed(len(ladder) > 2)
    (coarse, first), (middle, second), (fine, third) = ladder[-3:]
    needed(coarse > middle > fine > 0.0)
    needed(abs(coarse * fine / middle**2 - 1.0) <= SAME_RATIO)
    return rotor_velocity(first), rotor_velocity(second), rotor_velocity(third), middle / fine


@of_steps(
    "p = ln(d_1/d_2) / ln(h_1/h_2)",
    "observed order of the rotor velocity over the three finest steps",
    source=ROACHE,
)
def velocity_order(ladder: Ladder) -> float:
    first, second, third, ratio = _velocities(ladder)
    before, after = first - second, second - third
    # Round-off has no order; converging differences have one sign and decrease.
    needed(abs(after) > 1e-12 * abs(third) and before * after > 0.0 and abs(before) > abs(after))
    return log(before / after) / log(ratio)


@of_steps(
    "Omega_3 - d_2 / (r^p - 1), r = h_1/h_2",
    "rotor velocity extrapolated to a step of zero",
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
    "numerical error of the rotor velocity at the finest step; the range of three without a valid order",
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
    return measured(STEP_METRICS, [(float(step), Run.of(run)) for step, run in runs])


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
