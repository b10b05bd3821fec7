"""Impacts of bodies in generalised coordinates, and the velocities of their contact.

With the mass matrix M and the contact Jacobian G, whose rows are the normal and the tangential one,

    u = G v,    D = G M^-1 G',    v+ - v- = M^-1 G' p + r,    G r = 0

so that r is the part of the jump that no impulse p at the contact makes: an error of the measurement, or of
the model of rigid bodies with one contact.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from contactlab.arrays import Array


@final
@dataclass(frozen=True, eq=False)
class BodyImpacts:
    """Impacts in generalised coordinates, in coherent units.

    Args:
        before, after: velocities of the coordinates, shape (impact, coordinate).
        mass: mass matrix, shape (impact, coordinate, coordinate).
        normal, tangential: rows of the contact Jacobian, shape (impact, coordinate): gap rate and slip are
            their products with the velocities.
        covariance: of the error of the jump, shape (impact, coordinate, coordinate), or None.
    """

    before: Array
    after: Array
    mass: Array
    normal: Array
    tangential: Array
    covariance: Array | None = None

    @property
    def jacobian(self) -> Array:
        """G, shape (impact, 2, coordinate)."""
        return np.stack([self.normal, self.tangential], axis=1)

    def delassus(self) -> Array:
        """Return D = G M^-1 G', shape (impact, 2, 2), symmetric to the last bit."""
        jacobian = self.jacobian
        return _symmetric(jacobian @ np.linalg.solve(self.mass, jacobian.transpose(0, 2, 1)))

    def contact(self, velocities: Array) -> Array:
        """Return gap rate and slip for velocities of the coordinates, shape (impact, 2)."""
        return np.asarray(np.einsum("ndc,nc->nd", self.jacobian, velocities))

    def energy(self, velocities: Array) -> Array:
        """Return v'Mv/2 of velocities of the coordinates [J], shape (impact,)."""
        return np.asarray(0.5 * np.einsum("ni,nij,nj->n", velocities, self.mass, velocities))

    def outside_of(self, jump: Array) -> Array:
        """Return the part of a jump of the velocities that no impulse makes, shape (impact, coordinate)."""
        impulse = np.linalg.solve(self.delassus(), self.contact(jump)[..., None])
        return np.asarray(
            jump - np.linalg.solve(self.mass, self.jacobian.transpose(0, 2, 1) @ impulse)[..., 0]
        )

    def outside(self) -> Array:
        """Return the energy r'Mr/2 of the part of the jump that no impulse makes [J], shape (impact,)."""
        return self.energy(self.outside_of(self.after - self.before))

    def outside_share(self) -> float:
        """Return the share of the jump's energy that lies outside, median over the impacts [1]."""
        return self._share(self.outside())

    def share_of_errors(self) -> float | None:
        """Return the share that errors of the stated covariance leave outside; None without one."""
        if self.covariance is None:
            return None
        # The mean energy of the errors is that of the columns of a root of the covariance.
        values, vectors = np.linalg.eigh(self.covariance)
        roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
        parts = [self.energy(self.outside_of(roots[:, :, place])) for place in range(roots.shape[2])]
        return self._share(np.sum(parts, axis=0))

    def _share(self, energy: Array) -> float:
        jump = self.energy(self.after - self.before)
        moved = jump > 0.0
        return float(np.median(energy[moved] / jump[moved])) if moved.any() else 0.0

    def contact_covariance(self) -> Array | None:
        """Return the covariance G C G' of the contact's velocities [m^2/s^2], shape (impact, 2, 2)."""
        if self.covariance is None:
            return None
        return _symmetric(self.jacobian @ self.covariance @ self.jacobian.transpose(0, 2, 1))


def _symmetric(matrices: Array) -> Array:
    return np.asarray(0.5 * (matrices + matrices.transpose(0, 2, 1)))
