"""Records of forces on a path: at some of its times, or as means over the interval before each."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Final, final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from contactlab.arrays import Array
from contactlab.driving import DEGREE, Frame
from contactlab.laws import Composed, ContactLaw
from contactlab.laws.damping import Undamped
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.motor_problem import OverTime
from contactlab_data.inference.path_problem import PathProblem, path_problem
from contactlab_data.measured.series import MeasuredSeries

PIECES: Final = 8
"""Equal pieces of an interval over whose middles a mean is taken."""


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class RecordProblem(OverTime):
    """Forces of a record on a path; see `Problem`.

    Args:
        whole: forces at every time that is needed.
        places: indices of the times whose mean each datum is, shape (time, any).
    """

    whole: PathProblem
    places: NDArray[np.int64]

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.whole.law

    def spread(self, values: Array) -> float:
        """Return zero: nothing but the path moves the contact."""
        return self.whole.spread(values)

    @cached_property
    def path(self) -> PathProblem:
        """The path with the numbers that are free here."""
        return replace(self.whole, keys=self.keys)

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the forces of the record, by name; None if the law does not reach the end of the path."""
        forces = self.path.predict(values)
        return forces and {name: x[self.places].mean(axis=1) for name, x in forces.items()}


def record_problem(
    measured: MeasuredSeries,
    law: ContactLaw,
    keys: Sequence[FreeParameter],
    *,
    discrepancy: bool,
    degrees_of_freedom: float | None = inf,
    degree: int = DEGREE,
    frame: Frame | None = None,
) -> PathProblem | RecordProblem:
    """Return the problem of forces on a path; arguments and errors as of `path_problem`.

    Rows without a measured force count for the path alone. Where the normal force is prescribed it is that at
    rest, of which damping has no part: the law is taken without.
    """
    if "normal" in measured.path and isinstance(law, Composed) and law.damping.name != Undamped.name:
        law = replace(law, damping=Undamped())
        keys = [item for item in keys if not item.field.startswith("damping.")]

    def problem(of: MeasuredSeries) -> PathProblem:
        return path_problem(
            of,
            law,
            keys,
            discrepancy=discrepancy,
            degrees_of_freedom=degrees_of_freedom,
            degree=degree,
            frame=frame,
        )

    seen = np.full(measured.time.size, True)
    for values in measured.values.values():
        seen &= np.isfinite(values)
    if not measured.means:
        if seen.all():
            return problem(measured)
        whole, places = measured, np.flatnonzero(seen)[:, None]
    else:
        # Before the first time there is no interval.
        seen = seen & (np.arange(measured.time.size) > 0)
        parts = (np.arange(PIECES) + 0.5) / PIECES
        middles = measured.time[:-1, None] + np.diff(measured.time)[:, None] * parts
        time = np.union1d(measured.time, middles)
        splines = {name: make_interp_spline(measured.time, x, degree) for name, x in measured.path.items()}
        path = {name: np.asarray(spline(time)) for name, spline in splines.items()}
        forces = dict.fromkeys(measured.values, np.zeros_like(time))
        whole = replace(measured, time=time, values=forces, errors={}, path=path)
        places = np.searchsorted(time, middles)[seen[1:]]
    inner = problem(whole)
    return RecordProblem(
        measured=measured.rows(seen),
        configuration={},
        keys=inner.keys,
        correlation=inner.correlation,
        degrees_of_freedom=degrees_of_freedom,
        whole=inner,
        places=places,
    )
