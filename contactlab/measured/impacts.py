"""Measured impacts: velocities of the contact before and after, and the Delassus matrix.

Signs as in `contactlab.motor.geometry`: velocities of the contact are (gap rate, slip), the gap rate is
negative on approach, and an impulse p = (p_n, p_t) makes u+ = u- + D p.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.checks import check_kind, check_shape
from contactlab.impacts import Impacts

_ROUND_OFF = 1e-12
"""Error of symmetry and eigenvalues, over the largest element of a matrix."""


@final
@dataclass(frozen=True, eq=False)
class MeasuredImpacts:
    """Planar impacts that were measured, all at one kind of contact.

    Args:
        delassus: D = G M^-1 G' [1/kg], shape (impact, 2, 2), symmetric and positive definite.
        velocity_before, velocity_after: gap rate and slip [m/s], shape (impact, 2).
        kinetic_energy: of all measured coordinates before the impact, v'Mv/2 [J], shape (impact,);
            u'D^-1 u/2 where only contact velocities are known.
        outside: energy r'Mr/2 [J] of that part r of the velocity jump that no impulse at the contact
            makes, shape (impact,); zero where only contact velocities are known.
        covariance: of the error of the velocity after, including that of the velocity before [m^2/s^2], shape
            (impact, 2, 2); None where it is unknown.
        title, source, licence: of the data.
        left_out: number of impacts in the file that a flag excludes.
        number: of each impact in its file, from 1, shape (impact,), whole numbers.
        notes: sentences of the file and of its reader.
        measurement: label of the measurement that each impact repeats, shape (impact,), whole numbers; None
            where each is a measurement of its own. Impacts of one label stay in one fold of `validate`.

    Raises:
        TypeError, ValueError: an array of another kind or shape, a matrix that is not positive definite, a
            negative energy.
    """

    delassus: Array
    velocity_before: Array
    velocity_after: Array
    kinetic_energy: Array
    outside: Array
    covariance: Array | None
    title: str
    source: str
    licence: str
    left_out: int
    number: NDArray[np.int64]
    notes: tuple[str, ...] = ()
    measurement: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        n = len(self)
        check_shape("The Delassus matrix", self.delassus, (n, 2, 2), "(impact, 2, 2)")
        for when in ("before", "after"):
            check_shape(
                f"The velocity {when}", getattr(self, f"velocity_{when}"), (n, 2), "(impact, direction)"
            )
        check_shape("The kinetic energy", self.kinetic_energy, (n,), "(impact,)")
        check_shape("The energy outside of the impulses' span", self.outside, (n,), "(impact,)")
        check_shape("The number of the impacts", self.number, (n,), "(impact,)", "iu")
        if self.measurement is not None:
            check_shape("The measurement of the impacts", self.measurement, (n,), "(impact,)", "iu")
        if self.covariance is not None:
            check_shape("The covariance", self.covariance, (n, 2, 2), "(impact, 2, 2)")
            self._check(self.covariance, "covariance", strictly=False)
        self._check(self.delassus, "Delassus matrix", strictly=True)
        check_kind("How many impacts are left out", self.left_out, int)
        if n and not (self.kinetic_energy.min() > 0.0 and self.outside.min() >= 0.0):
            raise ValueError(
                "The kinetic energy before an impact must be positive and the energy outside of the "
                f"impulses' span not negative; the least are {self.kinetic_energy.min():g} J and "
                f"{self.outside.min():g} J."
            )

    def _check(self, matrices: Array, name: str, *, strictly: bool) -> None:
        """Raise a ValueError for matrices that are not symmetric or not positive (semi)definite."""
        off, size = np.abs(matrices[:, 0, 1] - matrices[:, 1, 0]), np.abs(matrices).max((1, 2))
        least = np.linalg.eigvalsh(matrices)[:, 0]
        # A product with the Jacobian has lost some digits.
        definite = least > _ROUND_OFF * size if strictly else least >= -1e-9 * size
        bad = (off > _ROUND_OFF * size) | ~definite
        if bad.any():
            first = int(np.argmax(bad))
            raise ValueError(
                f"The {name} of impact {self.number[first]} is {matrices[first].tolist()}; it must be "
                f"symmetric and positive {'' if strictly else 'semi'}definite."
            )

    def __len__(self) -> int:
        return len(self.velocity_before) if isinstance(self.velocity_before, np.ndarray) else 0

    @cached_property
    def before(self) -> Impacts:
        """The state before the impacts, from which laws predict the one after."""
        return Impacts(self.delassus, self.velocity_before)

    def errors(self, predicted: Array) -> Array:
        """Return the errors of predictions relative to the motion before the impact [1], shape (impact,).

            ||v+ - v+_predicted||_M / ||v-||_M = sqrt((r' D^-1 r + 2 outside) / (2 kinetic_energy))

        with r = velocity_after - predicted, in the norm of the kinetic energy; NaN where a prediction is.

        Args:
            predicted: gap rate and slip after the impacts [m/s], shape (impact, 2).
        """
        missed = self.velocity_after - predicted
        inside = np.einsum("ni,ni->n", missed, np.linalg.solve(self.delassus, missed[..., None])[..., 0])
        return np.asarray(np.sqrt((inside + 2.0 * self.outside) / (2.0 * self.kinetic_energy)))

    def part(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Self:
        """Return some of the impacts, by a mask or by indices, shape (any,)."""
        fields = ("delassus", "velocity_before", "velocity_after", "kinetic_energy", "outside", "covariance")
        columns = {name: getattr(self, name) for name in (*fields, "number", "measurement")}
        parts: dict[str, Any] = {name: x if x is None else x[chosen] for name, x in columns.items()}
        return replace(self, **parts)
