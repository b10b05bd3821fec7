"""Impacts of bodies in generalised coordinates, and the velocities of their contact.

With the mass matrix M and the contact Jacobian G, whose rows are the normal and the tangential one,

    u = G v,    D = G M^-1 G',    v+ - v- = M^-1 G' p + r,    G r = 0

so that r is the part of the jump that no impulse p at the contact makes: an error of the measurement, or of
the model of rigid bodies with one contact. A wrong sign in G makes it large.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from contactlab.arrays import Array
from contactlab.motor.table import MeasurementError
from contactlab.parameter import Parameter, positive

LARGEST_SHARE: Final = 1e-4
"""Share of the jump's energy outside of the impulses' span below which a wrong sign makes no difference to a
comparison of laws: that of a hundredth of the jump."""

BEYOND_ERRORS: Final = 4.0
"""Ratio of that share to the one that stated errors explain, and to that of another sign, above which a sign
is wrong."""

BY_CHANCE: Final = 0.01
"""Probability that a sign reduces the share by chance, over all signs."""

ROUND_OFF: Final = 1e-12

CORRECTIONS: Final[Mapping[str, Parameter]] = {
    "normal_arm": Parameter("a_n", "m", "offset of the normal row's arm"),
    "tangential_arm": Parameter("a_t", "m", "offset of the tangential row's arm"),
    "tilt": Parameter("phi", "rad", "angle by which the contact's normal is turned"),
    "inertia": positive("c_I", "1", "factor of the moment of inertia"),
}
"""Numbers of the geometry of a planar body that may be wrong in the data, see `BodyImpacts.corrected`."""


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
        rotation: place of the angle of a planar body; None for other coordinates.
    """

    before: Array
    after: Array
    mass: Array
    normal: Array
    tangential: Array
    covariance: Array | None = None
    rotation: int | None = None

    def part(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Self:
        """Return some of the impacts, by a mask or by indices, shape (any,)."""
        names = ("before", "after", "mass", "normal", "tangential", "covariance")
        columns: dict[str, Any] = {name: getattr(self, name) for name in names}
        return replace(self, **{name: x[chosen] for name, x in columns.items() if x is not None})

    def corrected(
        self, normal_arm: float = 0.0, tangential_arm: float = 0.0, tilt: float = 0.0, inertia: float = 1.0
    ) -> Self:
        """Return the impacts of a planar body with another geometry; velocities stay as measured.

            n = n_0 cos(phi) + t_0 sin(phi) + a_n e,  t = t_0 cos(phi) - n_0 sin(phi) + a_t e

        with e the unit vector of the angle, and c_I times the moment of inertia.

        Args:
            normal_arm, tangential_arm: a_n, a_t [m].
            tilt: phi [rad].
            inertia: c_I [1].

        Raises:
            ValueError: the coordinates are not those of a planar body.
        """
        if self.rotation is None:
            raise ValueError("The impacts are not those of a planar body in coordinates with one angle.")
        arm, scale = np.eye(self.mass.shape[1])[self.rotation], np.ones(self.mass.shape[1])
        scale[self.rotation] = inertia**0.5
        return replace(
            self,
            normal=np.cos(tilt) * self.normal + np.sin(tilt) * self.tangential + normal_arm * arm,
            tangential=np.cos(tilt) * self.tangential - np.sin(tilt) * self.normal + tangential_arm * arm,
            mass=self.mass * np.outer(scale, scale),
        )

    def after_impulses(self, impulses: Array) -> Array:
        """Return the velocities of the coordinates after impulses p, v + M^-1 G' p, as `before`.

        Args:
            impulses: normal and tangential [N s], shape (impact, 2).
        """
        pushed = self.jacobian.transpose(0, 2, 1) @ impulses[..., None]
        return np.asarray(self.before + np.linalg.solve(self.mass, pushed)[..., 0])

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
        """Return the energy r'Mr/2 of the part of a jump that no impulse makes [J], shape (impact,)."""
        impulse = np.linalg.solve(self.delassus(), self.contact(jump)[..., None])
        made = np.linalg.solve(self.mass, self.jacobian.transpose(0, 2, 1) @ impulse)[..., 0]
        return self.energy(jump - made)

    def outside(self) -> Array:
        """Return that energy of the measured jump [J], shape (impact,)."""
        return self.outside_of(self.after - self.before)

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
        parts = [self.outside_of(roots[:, :, place]) for place in range(roots.shape[2])]
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


def sign_note(bodies: BodyImpacts, angles: Mapping[str, bool], *, keep: bool) -> str:
    """Return a sentence on the share of the jump's energy that no impulse makes.

    A sign of the Jacobian is wrong where the median share outside of the impulses' span is larger than
    `LARGEST_SHARE`, or `BEYOND_ERRORS` times what stated errors explain, and the other sign makes it so much
    smaller that chance is excluded: the ratio of two sums of squares of n (coordinates - 2) errors each is
    F-distributed.

    Args:
        bodies: the impacts, of three or more coordinates.
        angles: whether each coordinate is an angle, by name.
        keep: whether the file states that its Jacobian is right.

    Raises:
        MeasurementError: a sign is wrong, and the Jacobian is not stated to be right.
    """
    share, explained = bodies.outside_share(), bodies.share_of_errors()
    sentence = f"{_percent(share)} of the jump's energy (median) lies outside of what impulses can do"
    if explained is not None:
        sentence += f", and the stated errors explain {_percent(explained)}"
    column, reversed_share = _best_sign(bodies, angles)
    freedom = len(bodies.before) * (len(angles) - 2)
    ratio = share / max(reversed_share, ROUND_OFF)
    better = ratio > BEYOND_ERRORS and 2 * len(angles) * float(fdtrc(freedom, freedom, ratio)) < BY_CHANCE
    too_large = share > (LARGEST_SHARE if explained is None else BEYOND_ERRORS * explained)
    if better and too_large and not keep:
        raise MeasurementError(
            f"{sentence} with the Jacobian as it stands, and {_percent(reversed_share)} with the sign of "
            f"{column} reversed. Reverse that column, or state that the Jacobian is right by 'jacobian: "
            "checked'."
        )
    if better:
        return f"{sentence}; it would be {_percent(reversed_share)} with the sign of {column} reversed."
    return f"{sentence}{', and no other sign in the Jacobian makes it much less' if too_large else ''}."


def _best_sign(bodies: BodyImpacts, angles: Mapping[str, bool]) -> tuple[str, float]:
    """Return the component of the Jacobian whose reversal leaves the least share outside, and that share."""
    shares = []
    # Arms first: their sign is often wrong, and the reversal of another component may have the same span.
    for name in sorted(angles, key=lambda each: not angles[each]):
        sign = np.array([-1.0 if each == name else 1.0 for each in angles])
        for row in ("tangential", "normal"):
            other = replace(bodies, **{row: getattr(bodies, row) * sign})
            values = np.linalg.eigvalsh(other.delassus())
            if (values[:, 0] > 1e-9 * values[:, 1]).all():
                shares.append((f"{row}_{name}", other.outside_share()))
    least = min(share for _, share in shares)
    return next((name, share) for name, share in shares if share <= 1.05 * least + ROUND_OFF)


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
