"""Refinement of the contact step or tolerance, and the error that the finest of them leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log, nan
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.laws.base import is_stepped

if TYPE_CHECKING:
    from contactlab.config import Setup

FACTORS: Final = {"contact_step": 2.0, "tolerance": 10.0}
"""Ratio of successive contact steps of time stepping, and of tolerances of collocated contact."""

LEVELS: Final = 3
"""Steps of a refinement from which the ratio of successive differences is observed."""

ROUND_OFF: Final = 1e-12
"""Relative difference of two numbers below which they are equal."""

SLOWEST: Final = 0.9
"""Ratio of successive differences of a sequence that does not converge."""


def richardson(numbers: Sequence[float] | Array, factor: float, order: float) -> float:
    """Return the error of the last of three numbers from steps that fall by a factor.

    With differences that fall by the ratio q the error is q / (1 - q) times the last of them, where q is the
    observed ratio, at least that of the declared order, factor^-order, and at most `SLOWEST`: the error of a
    sequence that does not converge is nine times its last change.
    """
    before, last = np.abs(np.diff(np.asarray(numbers, dtype=np.float64))).tolist()
    observed = last / before if before > 0.0 else 0.0
    ratio = float(np.clip(observed, factor**-order, SLOWEST))
    return float(last * ratio / (1.0 - ratio))


@final
@dataclass(frozen=True)
class Refinement:
    """Contact steps or tolerances that fall by a factor r, and the errors of a number computed at each.

    The error of the last number is `richardson` of three. Of two no ratio of differences is observed; the
    declared order p gives |x_2 - x_1| / (r^p - 1). One number has none.

        >>> import contactlab as cl
        >>> from contactlab.refinement import Refinement
        >>> refinement = Refinement.of(cl.build(["law=lagrange_stick", "solver.contact_step=4 us"]))
        >>> refinement.control, refinement.values
        ('contact_step', (4e-06, 2e-06, 1e-06))
        >>> refinement.error([9.0, 7.0, 6.0])
        1.0

    Args:
        factor: r, ratio of successive steps.
        order: p, of convergence, as the law declares it; NaN where it is not known.
        control: option of the solver that is refined, 'contact_step' [s] or 'tolerance' [1].
        values: of it, coarsest first.
    """

    factor: float
    order: float
    control: str = ""
    values: tuple[float, ...] = ()

    @classmethod
    def of(cls, setup: Setup, levels: int = LEVELS) -> Refinement:
        """Return the refinement of a setup, whose contact step or tolerance is the coarsest."""
        control = "contact_step" if is_stepped(setup.law, setup.contact_step) else "tolerance"
        factor, coarsest = FACTORS[control], getattr(setup, control)
        values = tuple(coarsest / factor**level for level in range(levels))
        return cls(factor, setup.law.convergence_order, control, values)

    @classmethod
    def of_difference(cls, orders: Sequence[float]) -> Refinement:
        """Return that of a difference of laws, which falls like the slower of them.

        They may be refined by different factors; the least of `FACTORS` gives the largest error.
        """
        return cls(min(FACTORS.values()), min(orders))

    def setups(self, setup: Setup) -> list[Setup]:
        """Return a setup at each step, coarsest first."""
        changes: list[dict[str, Any]] = [{self.control: value} for value in self.values]
        return [replace(setup, **change) for change in changes]

    def error(self, numbers: Sequence[float] | Array) -> float:
        """Return the error of the last of one, two or three numbers at successive steps."""
        if len(numbers) == LEVELS:
            return richardson(numbers, self.factor, self.order)
        return float(np.ptp(numbers) / (self.factor**self.order - 1.0))

    def errors(self, numbers: Array) -> Array:
        """Return the error of each number: that of the last, and the distance from it."""
        return np.asarray(np.abs(numbers - numbers[-1]) + self.error(numbers))

    def estimate(
        self, numbers: Sequence[float] | Array, statistical: Sequence[float] | Array = (0.0,)
    ) -> Estimate:
        """Return the last number and its error, of discretisation and statistics together.

        Numbers that differ by less than their statistical errors show no order; their range is the error of
        discretisation. An infinite one, as the force of a rigid impact is at every step, has none.

        Args:
            numbers: at successive steps.
            statistical: their errors at each step, NaN where none is known.
        """
        left = float(np.ptp(numbers)) if np.isfinite(numbers).all() else 0.0
        if left > np.nan_to_num(statistical).max():
            left = self.error(numbers)
        return Estimate(float(numbers[-1]), left + float(statistical[-1]))

    def observed_order(self, numbers: Sequence[float]) -> float:
        """Return p = ln(d_1 / d_2) / ln(r) of the last three numbers, with d_1 and d_2 their differences.

        NaN where the differences do not fall with one sign, or the last is round-off.
        """
        first, second, third = numbers[-LEVELS:]
        before, after = first - second, second - third
        falls = before * after > 0.0 and abs(before) > abs(after) > ROUND_OFF * abs(third)
        return log(before / after) / log(self.factor) if falls else nan
