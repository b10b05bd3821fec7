"""Eigenshapes of a clamped-clamped Bernoulli-Euler beam, in a form that does not cancel.

The textbook form psi = cosh z - cos z - s (sinh z - sin z), z = b x, subtracts numbers of size
exp(b x) from each other and has lost every digit by the twelfth shape. With the small number 1 - s
written as 2 eta exp(-b L),

    psi = exp(-z) + eta [exp(-(b L - z)) - exp(-(b L + z))] - cos z + s sin z,
    eta = (cos b L - sin b L - exp(-b L)) / (1 - exp(-2 b L) - 2 exp(-b L) sin b L),
    s   = 1 - 2 eta exp(-b L),

which is the same function with every term bounded. The scale is the textbook's, int psi^2 = L.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated, final

import numpy as np
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.checks import check_fields
from contactlab.parameter import Parameter

MOST_SHAPES = 40
"""Shapes that are verified (orthogonality and boundary conditions to 1e-10)."""

SHAPES = Parameter(
    "n", "1", f"number of beam shapes, 1 to {MOST_SHAPES}", at_least=1, at_most=MOST_SHAPES
)


@final
@dataclass(frozen=True)
class ClampedBeam:
    """The first eigenshapes of a beam that is clamped at both ends."""

    length: Annotated[float, Parameter("L", "m", "length between the clamps", above=0.0)]
    shapes: Annotated[int, SHAPES]

    def __post_init__(self) -> None:
        check_fields(self)

    @cached_property
    def wave_numbers(self) -> Array:
        """b_i [1/m], shape (shapes,): roots of cos(b L) cosh(b L) = 1."""
        centres = [(i + 0.5) * np.pi for i in range(1, self.shapes + 1)]
        roots = [brentq(_characteristic, c - 0.5, c + 0.5, xtol=1e-15, rtol=1e-15) for c in centres]
        return np.array(roots) / self.length

    def evaluate(self, position: Array | float, derivative: int = 0) -> Array:
        """Shapes or their first or second derivative.

        Args:
            position: x along the beam [m], scalar or shape (points,).
            derivative: 0, 1 or 2.

        Returns:
            [1], [1/m] or [1/m^2], shape (shapes, *position.shape).
        """
        if derivative not in (0, 1, 2):
            raise ValueError(f"The derivative is {derivative}; it must be 0, 1 or 2.")
        x = np.asarray(position, dtype=np.float64)
        b = self.wave_numbers.reshape(-1, *([1] * x.ndim))
        bl = b * self.length
        z = b * x
        decay = np.exp(-bl)
        eta = (np.cos(bl) - np.sin(bl) - decay) / (1.0 - decay**2 - 2.0 * decay * np.sin(bl))
        s = 1.0 - 2.0 * eta * decay
        near = np.exp(-z)
        far = np.exp(z - bl)
        beyond = np.exp(-(z + bl))
        if derivative == 0:
            value = near + eta * (far - beyond) - np.cos(z) + s * np.sin(z)
        elif derivative == 1:
            value = b * (-near + eta * (far + beyond) + np.sin(z) + s * np.cos(z))
        else:
            value = b**2 * (near + eta * (far - beyond) + np.cos(z) - s * np.sin(z))
        return np.asarray(value, dtype=np.float64)

    def integrate(self, start: float, end: float, derivative: int = 0) -> Array:
        """Gram matrix of the shapes' derivative over [start, end], int psi psi' dx, shape (shapes, shapes).

        Gauss-Legendre with enough points that the fastest product is integrated to round-off.
        """
        points, weights = _gauss_rule(8 * self.shapes + 32)
        half = 0.5 * (end - start)
        values = self.evaluate(start + half * (points + 1.0), derivative)
        return np.asarray((values * (half * weights)) @ values.T, dtype=np.float64)


def _characteristic(z: float) -> float:
    return float(np.cos(z) - 1.0 / np.cosh(z))


@cache
def _gauss_rule(count: int) -> tuple[Array, Array]:
    """Nodes and weights on [-1, 1]; finding them takes a hundred times as long as using them."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights
