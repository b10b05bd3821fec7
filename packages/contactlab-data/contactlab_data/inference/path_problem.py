"""Forces of a contact on a prescribed path as an inference problem: loops of friction, curves of force."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from typing import Final, cast, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import ConfigurationError
from contactlab.driving import (
    DEGREE,
    FRAME,
    Frame,
    LawOnPath,
    at_breaks,
    driven_by,
    longest_step,
    stays_closed,
)
from contactlab.engine import simulate
from contactlab.engine.state import RUNNING
from contactlab.laws import ContactLaw, LawError
from contactlab.motor.waveform import Waveform
from contactlab.trajectory import Ending
from contactlab_data.inference.free_parameters import FreeParameter, with_values
from contactlab_data.inference.motor_problem import OverTime, check_noise
from contactlab_data.measured.series import FORCES, MeasuredSeries

CORRELATED: Final = 0.05
"""Correlation time of the discrepancy over the duration of the path."""

TOLERANCE: Final = 1e-11
"""Error of a step [1], well below any noise."""


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class PathProblem(OverTime):
    """Forces of a law by itself; see `Problem`.

    Args:
        base: the law with the values of what is not free.
        degree: of the spline through the path.
        frame: that the path pulls, with the values of what is not free; None for a path of the slip itself.
    """

    base: ContactLaw
    degree: int = DEGREE
    frame: Frame | None = None

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

        Where a force jumps, as friction does at a reversal of the slip, it is the limit from the left, before
        the jump; at the first time it is that from the right.

        Raises:
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        try:
            numbers = [*zip(self.keys, values, strict=False)]
            of_law = [(item, x) for item, x in numbers if item.name not in FRAME]
            law = with_values(self.base, [item for item, _ in of_law], [x for _, x in of_law])
            frame = self.frame and self.frame.changed({x.name: y for x, y in numbers if x.name in FRAME})
            if (loop := _loop_of(self)) is None:
                forces = self._from_run(law)
            else:
                # None where the contact does not stay closed.
                forces = loop.path.forces.copy() if loop.run(law, frame)["ending"] == RUNNING else None
        # Values that are admitted one by one need not be so together.
        except (LawError, ValueError):
            return None
        if forces is None:
            return None
        return {name: forces[:, FORCES.index(name)] for name in self.measured.values}

    def _from_run(self, law: ContactLaw) -> Array | None:
        """Return the forces of a contact that may open, or None."""
        time = self.measured.time - self.measured.time[0]
        span, motor = (
            float(time[-1]),
            driven_by(law, self.measured.time, **self.measured.path, degree=self.degree),
        )
        run = simulate(
            motor,
            law,
            duration=span,
            record_interval=span,
            contact_step=longest_step(motor, law),
            tolerance=TOLERANCE,
            instants=at_breaks(cast(Waveform, motor.drive.waveform).pieces.x, time),
        )
        if run.ending is Ending.INTERRUPTED:
            raise KeyboardInterrupt(run.message)
        if not run.ending.reached_end:
            return None
        left, right = run.instant_forces[:, 0], run.instant_forces[:, 1]
        return np.where(np.isnan(left), right, left)


@lru_cache(maxsize=16)
def _loop_of(problem: PathProblem) -> LawOnPath | None:
    """Return the path made ready for the law of a problem; None where the contact may open, which runs."""
    path, time = problem.measured.path, problem.measured.time
    if problem.frame is None and not stays_closed(problem.base, path.get("gap")):
        return None
    return LawOnPath(
        problem.base, time, **path, degree=problem.degree, frame=problem.frame, instants=time - time[0]
    )


def path_problem(
    measured: MeasuredSeries,
    law: ContactLaw,
    keys: Sequence[FreeParameter],
    *,
    discrepancy: bool,
    degrees_of_freedom: float | None = inf,
    degree: int = DEGREE,
    frame: Frame | None = None,
) -> PathProblem:
    """Return the problem of forces on a path.

    Args:
        measured: forces and path.
        law: with the values of what is not free.
        keys: free numbers of the law.
        discrepancy: whether the law may be wrong, by a process that a twentieth of the path correlates.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.
        degree: of the spline through the samples of the path, 1, 3, 5 or 7.
        frame: that the path of the slip pulls.

    Raises:
        ConfigurationError: no force is measured, the path is not one of the law's, a contact opens behind a
            frame, or a discrepancy has Student-t noise, whose likelihood has no closed form.
    """
    check_noise(discrepancy, degrees_of_freedom)
    if not measured.values:
        raise ConfigurationError(f"The data have a path and no force; they must have {' or '.join(FORCES)}.")
    try:
        driven_by(law, measured.time, **measured.path, degree=degree)
        LawOnPath(law, measured.time, **measured.path, degree=degree, frame=frame) if frame else None
    except ValueError as error:
        raise ConfigurationError(f"law={law.name}: {error}") from error
    span = float(measured.time[-1] - measured.time[0])
    return PathProblem(
        measured=measured,
        configuration={},
        keys=tuple(keys),
        base=law,
        degree=degree,
        frame=frame,
        correlation=CORRELATED * span if discrepancy else 0.0,
        degrees_of_freedom=degrees_of_freedom,
    )
