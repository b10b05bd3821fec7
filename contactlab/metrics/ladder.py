"""How a law's answers depend on the step: exponents, observed order and what is left of error."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log
from typing import Final, final

import numpy as np

from contactlab.metrics.measure import Measure
from contactlab.metrics.metric import Metric
from contactlab.metrics.record import NotApplicableError, Record, needed
from contactlab.metrics.response import mean_velocity, peak_force, total_impulse

EXPONENT: Final = 0.05
ONE_RATIO: Final = 1e-6
"""Relative difference at which two ratios of steps are the same: steps are given in decimals."""

LEAST_ORDER: Final = 0.5
"""Below it an extrapolation is no more than a guess: it goes further than two of the differences that it is
made from (Oberkampf and Roy 2010, Verification and Validation in Scientific Computing, sec. 8.7)."""


@final
@dataclass(frozen=True)
class Ladder:
    """Runs of one law on one motor.

    Args:
        steps: steps [s] or tolerances [1], coarsest first.
        records: their runs.
    """

    steps: Sequence[float]
    records: Sequence[Record]

    def exponent(self, value: Callable[[Record], float]) -> float:
        """Slope of the straight line through the logarithms of values over steps, by least squares.

        Raises:
            NotApplicableError: fewer than two steps, or a value that has no logarithm.
        """
        needed(len(self.steps) > 1)
        values = np.array([value(record) for record in self.records])
        needed(bool(np.isfinite(values).all() and (values > 0.0).all()))
        x = np.log(self.steps)
        x = x - x.mean()
        needed(bool(x.any()))
        return float(x @ np.log(values) / (x @ x))

    def velocities(self) -> tuple[float, float, float]:
        """Rotor velocities of the three finest steps, which are in one ratio [rad/s].

        Raises:
            NotApplicableError: there are not three, or their ratios differ.
        """
        needed(len(self.steps) > 2)
        coarse, middle, fine = self.steps[-3:]
        needed(coarse > middle > fine > 0.0)
        needed(abs(coarse * fine / middle**2 - 1.0) <= ONE_RATIO)
        first, second, third = (mean_velocity(record) for record in self.records[-3:])
        return first, second, third

    def order(self) -> float:
        """Observed order, log(d1/d2) / log(ratio) with the differences d of the three finest steps.

        Raises:
            NotApplicableError: the differences change sign or do not fall: no order shows.
        """
        first, second, third = self.velocities()
        before, after = first - second, second - third
        # Round-off has no order; equal signs and a fall are what convergence looks like.
        needed(
            abs(after) > 1e-12 * abs(third) and before * after > 0.0 and abs(before) > abs(after)
        )
        return log(before / after) / log(self.steps[-2] / self.steps[-1])

    def extrapolated(self) -> float:
        """Rotor velocity at no step at all, v3 - d2 / (ratio^p - 1) [rad/s].

        Raises:
            NotApplicableError: as `order`, or the order is too low to be trusted.
        """
        _, second, third = self.velocities()
        order = self.order()
        needed(order >= LEAST_ORDER)
        growth = float((self.steps[-2] / self.steps[-1]) ** order)
        return third - (second - third) / (growth - 1.0)

    def error(self) -> float:
        """Error of the finest rotor velocity, relative: against the extrapolated one.

        Where no order can be trusted, the largest difference among the three finest.
        """
        velocities = self.velocities()
        try:
            error = abs(velocities[-1] - self.extrapolated())
        except NotApplicableError:
            error = float(np.ptp(velocities))
        needed(velocities[-1] != 0.0)
        return error / abs(velocities[-1])


_ROACHE: Final = "Roache (1998), Verification and Validation in Computational Science, ch. 5"

MEASURES: Final[tuple[Measure[Ladder], ...]] = (
    Measure(
        Metric(
            "peak_force_exponent",
            "d ln N_max / d ln h",
            "1",
            "exponent of the peak force in the step, by least squares",
            source="paper, fig. 9",
        ),
        lambda ladder: ladder.exponent(peak_force),
    ),
    Measure(
        Metric(
            "peak_force_step_dependence",
            "|d ln N_max / d ln h|",
            "1",
            "dependence of the peak force on the step",
            "<=",
            EXPONENT,
            "a physical force does not depend on the step: one that converges has an exponent of its "
            "order times its remaining error, 0.05 for five per cent at first order; a force made as "
            "impulse over step has one",
            "paper, fig. 9 and its discussion",
        ),
        lambda ladder: abs(ladder.exponent(peak_force)),
    ),
    Measure(
        Metric(
            "impulse_exponent",
            "d ln sum p_n / d ln h",
            "1",
            "exponent of the normal impulse in the step, by least squares",
            source="paper, fig. 9",
        ),
        lambda ladder: ladder.exponent(total_impulse),
    ),
    Measure(
        Metric(
            "impulse_step_dependence",
            "|d ln sum p_n / d ln h|",
            "1",
            "dependence of the normal impulse on the step",
            "<=",
            EXPONENT,
            "as that of the peak force: what moves the rotor may not depend on the step",
            "paper, fig. 9 and its discussion",
        ),
        lambda ladder: abs(ladder.exponent(total_impulse)),
    ),
    Measure(
        Metric(
            "velocity_order",
            "p = ln(d1/d2) / ln(h1/h2)",
            "1",
            "observed order of the rotor velocity over the three finest steps",
            source=_ROACHE,
        ),
        Ladder.order,
    ),
    Measure(
        Metric(
            "extrapolated_rotor_velocity",
            "Omega_3 - d2 / (ratio^p - 1)",
            "rad s-1",
            "rotor velocity extrapolated to no step at all",
            source=_ROACHE,
        ),
        Ladder.extrapolated,
    ),
    Measure(
        Metric(
            "velocity_error",
            "|Omega_3 - Omega_extrapolated| / |Omega_3|",
            "1",
            "numerical error of the rotor velocity at the finest step; where no order can be "
            "trusted, the range of the three finest over the finest",
            source=_ROACHE,
        ),
        Ladder.error,
    ),
)
"""Metrics of a ladder of steps."""
