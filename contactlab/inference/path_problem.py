"""Forces of a contact on a prescribed path as an inference problem: loops of friction, curves of force."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Final, final

import numpy as np
from scipy.interpolate import CubicSpline

from contactlab.arrays import Array
from contactlab.config import ConfigurationError
from contactlab.driving import driven_by, longest_step
from contactlab.engine import simulate
from contactlab.inference.free_parameters import FreeParameter, with_values
from contactlab.inference.motor_problem import OverTime, check_noise
from contactlab.laws import ContactLaw, LawError
from contactlab.measured.series import FORCES, MeasuredSeries

FINER: Final = 4
"""Number of records within the mean interval of the data."""

CORRELATED: Final = 0.05
"""Correlation time of the discrepancy over the duration of the path."""

TOLERANCE: Final = 1e-8
"""Error of a step [1], well below any noise."""


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class PathProblem(OverTime):
    """Forces of a law by itself; see `Problem`.

    Args:
        base: the law with the values of what is not free.
    """

    base: ContactLaw

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.base.name

    def spread(self, values: Array) -> float:
        """Return zero: nothing but the path moves the contact."""
        del values
        return 0.0

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the forces at the times of the data, by name; None if the law does not reach the end.

        A force is the rate of its impulse, which the records have exactly.
        """
        time = self.measured.time
        span = float(time[-1] - time[0])
        try:
            law = with_values(self.base, self.keys, values[: len(self.keys)])
            motor = driven_by(law, time, **self.measured.path)
            run = simulate(
                motor,
                law,
                duration=span,
                record_interval=span / (FINER * (time.size - 1)),
                contact_step=longest_step(motor, law),
                tolerance=TOLERANCE,
            )
        # Values that are admitted one by one need not be so together.
        except (LawError, ValueError):
            return None
        if not run.ending.reached_end:
            return None
        intervals, result = np.diff(run.time), {}
        for name in self.measured.values:
            impulse = np.append(0.0, np.cumsum(run.series[name][1:] * intervals))
            result[name] = CubicSpline(run.time, impulse)(time - time[0], 1)
        return result


def path_problem(
    measured: MeasuredSeries,
    law: ContactLaw,
    keys: Sequence[FreeParameter],
    *,
    discrepancy: bool,
    degrees_of_freedom: float | None = inf,
) -> PathProblem:
    """Return the problem of forces on a path.

    Args:
        measured: forces and path.
        law: with the values of what is not free.
        keys: free numbers of the law.
        discrepancy: whether the law may be wrong, by a process that a twentieth of the path correlates.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.

    Raises:
        ConfigurationError: no force is measured, the path is not one of the law's, or a discrepancy has
            Student-t noise, whose likelihood has no closed form.
    """
    check_noise(discrepancy, degrees_of_freedom)
    if not measured.values:
        raise ConfigurationError(f"The data have a path and no force; they must have {' or '.join(FORCES)}.")
    try:
        driven_by(law, measured.time, **measured.path)
    except ValueError as error:
        raise ConfigurationError(f"law={law.name}: {error}") from error
    span = float(measured.time[-1] - measured.time[0])
    return PathProblem(
        measured=measured,
        configuration={},
        keys=tuple(keys),
        base=law,
        correlation=CORRELATED * span if discrepancy else 0.0,
        degrees_of_freedom=degrees_of_freedom,
    )
