"""Measured impacts as a contact law sees them: contact velocities before and after, and the Delassus matrix.

Signs as in `contactlab.motor.geometry`: velocities of the contact are (gap rate, slip), the gap rate is
negative on approach, and an impulse p = (p_n, p_t) makes u+ = u- + D p.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.checks import check_kind, check_shape
from contactlab.impact import Impacts

_ROUND_OFF = 1e-12
"""Share of a matrix's largest element that its symmetry and its eigenvalues may be off by."""


@final
@dataclass(frozen=True, eq=False)
class MeasuredImpacts:
    """Planar impacts that were measured, all at one kind of contact.

    Args:
        delassus: D = G M^-1 G' [1/kg], shape (impact, 2, 2), symmetric and positive definite.
        velocity_before, velocity_after: gap rate and slip [m/s], shape (impact, 2).
        kinetic_energy: of all measured coordinates before the impact, v'Mv/2 [J], shape (impact,);
            u'D^-1 u/2 where only contact velocities are given.
        outside: energy r'Mr/2 [J] of that part r of the velocity jump that no impulse at the contact
            reaches, shape (impact,); zero where only contact velocities are given.
        covariance: of the error of the velocity after, with that of the velocity before in it where it is
            known [m^2/s^2], shape (impact, 2, 2); None where nothing is known of it.
        title, source, licence: of the data.
        left_out: how many impacts the file flags, which are not among these.
        number: of each impact in its file, from 1, shape (impact,), whole numbers.
        notes: what the reader found and did, a sentence each.
        measurement: label of the measurement that each impact repeats, shape (impact,), whole numbers; None
            where each is a measurement of its own. Impacts of one label stay in one fold of `validate`.

    Raises:
        TypeError, ValueError: an array of another kind or shape, a matrix that is not positive definite, an
            energy that is negative.
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
        for word in ("before", "after"):
            velocity = getattr(self, f"velocity_{word}")
            check_shape(f"The velocity {word}", velocity, (n, 2), "(impact, direction)")
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
        """Refuse 2x2 matrices that are not symmetric, or not positive definite (semidefinite)."""
        off, size = np.abs(matrices[:, 0, 1] - matrices[:, 1, 0]), np.abs(matrices).max((1, 2))
        least = np.linalg.eigvalsh(matrices)[:, 0]
        # That of a product with the Jacobian has lost some digits.
        wanted = least > _ROUND_OFF * size if strictly else least >= -1e-9 * size
        bad = (off > _ROUND_OFF * size) | ~wanted
        if bad.any():
            first = int(np.argmax(bad))
            words = "positive definite" if strictly else "positive semidefinite"
            raise ValueError(
                f"The {name} of impact {self.number[first]} is {matrices[first].tolist()}; it must be "
                f"symmetric and {words}."
            )

    def __len__(self) -> int:
        return len(self.velocity_before) if isinstance(self.velocity_before, np.ndarray) else 0

    @cached_property
    def before(self) -> Impacts:
        """The state before the impacts, from which laws predict the one after."""
        return Impacts(self.delassus, self.velocity_before)

    def errors(self, predicted: Array) -> Array:
        """Give how far predictions are from what was measured, relative to the motion before the impact.

            ||v+ - v+_predicted||_M / ||v-||_M = sqrt((r' D^-1 r + 2 outside) / (2 kinetic_energy))

        with r = velocity_after - predicted; what no impulse reaches is in it. The norm is that of the
        kinetic energy.

        Args:
            predicted: gap rate and slip after the impacts [m/s], shape (impact, 2).

        Returns:
            The errors [1], shape (impact,); NaN where a prediction is.
        """
        missed = self.velocity_after - predicted
        inside = np.einsum("ni,ni->n", missed, np.linalg.solve(self.delassus, missed[..., None])[..., 0])
        return np.asarray(np.sqrt((inside + 2.0 * self.outside) / (2.0 * self.kinetic_energy)))

    def part(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Self:
        """Give some of the impacts: a mask, or the places of those that are chosen, shape (any,)."""
        return replace(
            self,
            delassus=self.delassus[chosen],
            velocity_before=self.velocity_before[chosen],
            velocity_after=self.velocity_after[chosen],
            kinetic_energy=self.kinetic_energy[chosen],
            outside=self.outside[chosen],
            covariance=None if self.covariance is None else self.covariance[chosen],
            number=self.number[chosen],
            measurement=None if self.measurement is None else self.measurement[chosen],
        )
