"""The paper's basis of smooth beam shapes: its matrices and their normal modes.

Source: Andersen, Blanke and Helbo (2001), eqs. 19-34; what of the print is corrected is said in
`contactlab.motor.patched_beam`.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated, final

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import Checked
from contactlab.motor.motor import NormalModes
from contactlab.motor.patched_beam import PatchedBeam, resolved_eigenpairs
from contactlab.parameter import Parameter, positive

MOST_SHAPES = 40
"""Shapes that are verified (orthogonality and boundary conditions to 1e-10)."""

SHAPES = Parameter("n", "1", "number of beam shapes", at_least=1, at_most=MOST_SHAPES)

# Finding the nodes on [-1, 1] takes a hundred times as long as using them.
_gauss_rule = cache(np.polynomial.legendre.leggauss)


@final
@dataclass(frozen=True)
class ClampedBeam(Checked):
    """The first eigenshapes of a clamped-clamped Bernoulli-Euler beam, in a form that does not cancel.

    The textbook form psi = cosh z - cos z - s (sinh z - sin z), z = b x, subtracts numbers of size exp(b x)
    and has lost every digit by the twelfth shape. With the small number 1 - s written as 2 eta exp(-b L),

        psi = exp(-z) + eta [exp(-(b L - z)) - exp(-(b L + z))] - cos z + s sin z,
        eta = (cos b L - sin b L - exp(-b L)) / (1 - exp(-2 b L) - 2 exp(-b L) sin b L),
        s   = 1 - 2 eta exp(-b L),

    which is the same function with every term bounded. The scale is the textbook's, int psi^2 = L.
    """

    length: Annotated[float, positive("L", "m", "length between the clamps")]
    shapes: Annotated[int, SHAPES]

    @cached_property
    def wave_numbers(self) -> Array:
        """b_i [1/m], shape (shapes,): roots of cos(b L) cosh(b L) = 1."""
        z = (np.arange(1, self.shapes + 1) + 0.5) * np.pi
        # Newton's method doubles the digits, of which the first root has two here.
        for _ in range(5):
            z -= (np.cos(z) - 1.0 / np.cosh(z)) / (np.tanh(z) / np.cosh(z) - np.sin(z))
        return np.asarray(z / self.length)

    def evaluate(self, position: Array | float, derivative: int = 0) -> Array:
        """Return the shapes [1] or their first or second derivative [1/m, 1/m^2] at positions x [m].

        Of shape (shapes, *position.shape).
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
        near, far, beyond = np.exp(-z), np.exp(z - bl), np.exp(-(z + bl))
        if derivative == 0:
            value: Array = near + eta * (far - beyond) - np.cos(z) + s * np.sin(z)
        elif derivative == 1:
            value = b * (-near + eta * (far + beyond) + np.sin(z) + s * np.cos(z))
        else:
            value = b**2 * (near + eta * (far - beyond) + np.cos(z) - s * np.sin(z))
        return value

    def integrate(self, start: float, end: float, derivative: int = 0) -> Array:
        """Return the Gram matrix of a derivative over [start, end], int psi psi' dx, shape (shapes, shapes).

        Gauss-Legendre with enough points that the fastest product is integrated to round-off.
        """
        points, weights = _gauss_rule(8 * self.shapes + 32)
        half = 0.5 * (end - start)
        values = self.evaluate(start + half * (points + 1.0), derivative)
        gram: Array = (values * (half * weights)) @ values.T
        return gram


@final
@dataclass(frozen=True)
class RitzMatrices:
    """The matrices of eqs. 19-34 in the basis of beam shapes.

    Args:
        mass, damping, stiffness: M, C, K, shape (shape, shape), SI.
        coupling: Gamma [N/V], shape (shape, electrode).
        capacitance: C_p [F], shape (electrode, electrode).
        tip_displacement, tip_slope: shapes and slopes at the beam's centre, shape (shape,).
    """

    mass: Array
    damping: Array
    stiffness: Array
    coupling: Array
    capacitance: Array
    tip_displacement: Array
    tip_slope: Array

    def modes(self) -> NormalModes:
        """Normal modes, which decouple the damping as well: C = alpha M + beta K, or by damping ratio."""
        stiffness, vectors = resolved_eigenpairs(self.stiffness, self.mass)
        # A mode's sign is free; fix it so that equal inputs give equal modes on every machine.
        largest = np.abs(vectors).argmax(axis=0)
        vectors = vectors * np.sign(vectors[largest, np.arange(vectors.shape[1])])
        damping = np.einsum("ij,ik,kj->j", vectors, self.damping, vectors)
        return NormalModes(
            stiffness=stiffness,
            damping=damping,
            coupling=vectors.T @ self.coupling,
            tip_displacement=vectors.T @ self.tip_displacement,
            tip_slope=vectors.T @ self.tip_slope,
            shape_coupling=self.coupling,
        )


@final
@dataclass(frozen=True)
class RitzResonator(PatchedBeam):
    """The patched beam in the paper's basis: eigenshapes of the bare, clamped beam, four in the paper.

    The frequencies converge slowly because smooth shapes cannot bend sharply at a patch edge.

        >>> import contactlab as cl
        >>> cl.RitzResonator().modes.natural_frequency.round(1)
        array([ 3210.1,  5460.7, 13202.5, 17786.3])
        >>> cl.RitzResonator(shapes=40).modes.natural_frequency[:2].round(1)
        array([2291.9, 3969.1])
    """

    shapes: Annotated[int, SHAPES] = 4

    @cached_property
    def matrices(self) -> RitzMatrices:
        """M, C, K, Gamma and C_p of eqs. 19-34."""
        beam = ClampedBeam(self.length, self.shapes)
        displacement, slope = (beam.evaluate(0.5 * self.length, order) for order in (0, 1))
        mass = self.steel_mass * beam.integrate(0.0, self.length)
        stiffness = self.steel_rigidity * beam.integrate(0.0, self.length, 2)
        coupling = np.empty((self.shapes, len(self.patches)))
        for electrode, (start, end) in enumerate(self.patches):
            mass += self.layer_mass * beam.integrate(start, end)
            stiffness += self.layer_rigidity * beam.integrate(start, end, 2)
            turn = beam.evaluate(end, 1) - beam.evaluate(start, 1)
            coupling[:, electrode] = self.moment_per_voltage * turn
        mass += self.tip_mass * np.outer(displacement, displacement)
        mass += self.tip_inertia * np.outer(slope, slope)
        damping = self.mass_damping * mass + self.stiffness_damping * stiffness
        if self.damping_ratio is not None:
            squares, vectors = resolved_eigenpairs(stiffness, mass)
            across = mass @ vectors
            damping = (across * self.modal_damping(squares)) @ across.T
        return RitzMatrices(
            mass=mass,
            damping=damping,
            stiffness=stiffness,
            coupling=coupling,
            capacitance=self.capacitance,
            tip_displacement=displacement,
            tip_slope=slope,
        )

    def _solve(self) -> NormalModes:
        if self.residual_mass:
            return self._with_residual_modes()
        return self.matrices.modes()
