"""Hermite cubic elements of a clamped-clamped Bernoulli-Euler beam, in coordinates of their curvature.

A cubic element bends with a linear curvature, w'' = a + b s for s from -1 to 1, and stores the
energy (E I h / 2) (a^2 + b^2 / 3): two numbers an element, no coupling between elements. From the
left clamp on, deflection and slope of the nodes are sums of them,

    theta_(e+1) = theta_e + a h,    w_(e+1) = w_e + theta_e h + a h^2 / 2 - b h^2 / 6,

and the right clamp is two linear conditions. In coordinates y = (a sqrt(E I h), b sqrt(E I h / 3))
that satisfy these conditions the stiffness matrix is the identity: with the nodes at x = T y,

    K^-1 = T T',    K phi = omega^2 M phi  <=>  (T' M T) y = y / omega^2,  phi = omega T y.

It is the same space as assembled elements span, without their stiffness matrix, whose condition
number grows like the fourth power of length over element: a short element beside a long one costs
no digit here, and low frequencies keep all of theirs on fine meshes.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from contactlab.arrays import Array


@final
@dataclass(frozen=True)
class HermiteBeam:
    """A clamped-clamped beam in elements of constant section.

    Args:
        size: h of every element from the left clamp on [m], shape (element,).
        rigidity: E I [N m^2], shape (element,).

    Degrees of freedom are (deflection [m], slope [1]) of every node but the left clamp, in this
    order; the last two are the right clamp's and remain zero.
    """

    size: Array
    rigidity: Array

    @cached_property
    def nodes(self) -> Array:
        """Position of every node [m], both clamps included, shape (element + 1,)."""
        return np.concatenate([[0.0], np.cumsum(self.size)])

    @cached_property
    def shapes(self) -> Array:
        """T [m J^-1/2 and J^-1/2], shape (dof, 2 element), with K^-1 = T T'."""
        h = self.size
        constant = 1.0 / np.sqrt(self.rigidity * h)
        linear = np.sqrt(3.0) * constant
        count = h.size
        # Row: node at the end of an element; column: element that bends, at or before it.
        before = np.tril(np.ones((count, count)))
        arm = self.nodes[1:, None] - self.nodes[None, 1:]
        free = np.zeros((2 * count, 2 * count))
        free[0::2, 0::2] = before * (0.5 * h**2 + h * arm) * constant
        free[0::2, 1::2] = before * (-(h**2) / 6.0) * linear
        free[1::2, 0::2] = before * h * constant
        clamp = np.linalg.qr(free[-2:].T)[0]
        return np.asarray(free - (free @ clamp) @ clamp.T, dtype=np.float64)

    def mass_matrix(self, mass: Array) -> Array:
        """M [kg, kg m, kg m^2] of a mass per length in every element [kg/m], shape (dof, dof)."""
        count = self.size.size
        matrix = np.zeros((2 * count + 2, 2 * count + 2))
        for e, (h, m) in enumerate(zip(self.size, mass, strict=True)):
            matrix[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += m * h / 420.0 * _element_mass(h)
        return matrix[2:, 2:]

    def node_at(self, position: float) -> int:
        """The degree of freedom of the deflection nearest to a position [m]; its slope is the next one.

        Raises:
            ValueError: at the left clamp, which has no degree of freedom.
        """
        node = int(np.abs(self.nodes - position).argmin())
        if node == 0:
            raise ValueError(
                f"The node at {position} m is the left clamp; it must be another, since the clamp "
                "does not move. Leave its loads out, they do no work."
            )
        return 2 * (node - 1)


def _element_mass(h: float) -> Array:
    """The consistent mass matrix of one element over m h / 420."""
    return np.array(
        [
            [156.0, 22.0 * h, 54.0, -13.0 * h],
            [22.0 * h, 4.0 * h**2, 13.0 * h, -3.0 * h**2],
            [54.0, 13.0 * h, 156.0, -22.0 * h],
            [-13.0 * h, -3.0 * h**2, -22.0 * h, 4.0 * h**2],
        ]
    )
