"""The beam that every basis describes: dimensions, materials and what follows from them alone.

Source: Andersen, Blanke and Helbo (2001), eqs. 19-34. Signs and factors follow the consistent
form: masses are positive (eqs. 23, 27, 28 print them negative), a patch set counts both of its
layers in the mass (eq. 28 prints one), and the sign of the coupling is that of the paper's Table 1
(eq. 31 prints the opposite).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from scipy.linalg import eigh
from threadpoolctl import threadpool_limits

from contactlab.arrays import Array
from contactlab.checks import Checked
from contactlab.motor.materials import Piezoceramic, Steel
from contactlab.motor.motor import NormalModes
from contactlab.parameter import not_negative, positive

RESOLVED = 1e-9
"""Smallest eigenvalue over the largest that is still known.

The eigenvalues of a symmetric matrix are found to within a few units of round-off of the largest one
(8 at most in what was measured), so that omega^2 is right to 2e-6 here, and omega to 1e-6."""

UNRESOLVED = (
    "Dimensions, materials, placement and tip together give modes that double precision does not "
    "resolve: mass and stiffness must be finite and positive definite, and the highest natural "
    f"frequency at most {RESOLVED**-0.5:.0f} times the lowest. Check the orders of magnitude, or take "
    "fewer modes."
)


def resolved_eigenpairs(a: Array, b: Array | None = None, **options: Any) -> tuple[Array, Array]:
    """Solve a x = lambda b x for symmetric matrices by `scipy.linalg.eigh`, eigenvalues ascending.

    Raises a ValueError where the smallest is the round-off of the largest, or a number is not finite.
    """
    if not all(np.isfinite(matrix).all() for matrix in (a, b) if matrix is not None):
        raise ValueError(UNRESOLVED)
    eigenvalues, vectors = eigh(a, b, **options)
    # Not the other way round: nothing is larger than what is no number.
    if not eigenvalues[0] > RESOLVED * eigenvalues[-1]:
        raise ValueError(UNRESOLVED)
    return eigenvalues, vectors


_TIP_INERTIA = not_negative("I_tip", "kg m2", "inertia of the tip about its foot")


@dataclass(frozen=True)
class PatchedBeam(Checked, ABC):
    """A clamped beam with two mirrored pairs of piezoceramic patches and a rigid tip at its centre.

    A layer is bonded to either side; the second set is the mirror image, [L - a_12, L - a_11], and
    C = alpha M + beta K. Not modelled: rotary inertia and shear of the layers, and adhesive between them.
    """

    length: Annotated[float, positive("L", "m", "length between the clamps")] = 57e-3
    width: Annotated[float, positive("w_s", "m", "width of beam and patches")] = 16e-3
    beam_thickness: Annotated[float, positive("t_s", "m", "thickness of the beam")] = 1e-3
    patch_thickness: Annotated[float, positive("t_p", "m", "thickness of a patch layer")] = 1e-3
    patch_start: Annotated[float, not_negative("a_11", "m", "where the patches begin")] = 0.914e-3
    patch_end: Annotated[float, positive("a_12", "m", "where the patches end")] = 10.146e-3
    tip_mass: Annotated[float, not_negative("M_tip", "kg", "mass of the tip")] = 1.181e-3
    tip_inertia: Annotated[float, _TIP_INERTIA] = 1.321e-7
    steel: Steel = field(default_factory=Steel)
    piezoceramic: Piezoceramic = field(default_factory=Piezoceramic)
    mass_damping: Annotated[float, not_negative("alpha", "s-1", "damping per mass")] = 7.5
    stiffness_damping: Annotated[float, not_negative("beta", "s", "damping per stiffness")] = 2e-5

    def __post_init__(self) -> None:
        super().__post_init__()
        half = 0.5 * self.length
        if not self.patch_start < self.patch_end <= half:
            raise ValueError(
                f"The patches lie at {self.patch_start} to {self.patch_end} m; they must satisfy "
                f"0 <= start < end <= {half} m, half the beam, or they leave it or overlap their mirror."
            )

    @cached_property
    def modes(self) -> NormalModes:
        """The normal modes in the basis of the subclass; a ValueError where double precision has none."""
        try:
            # More threads gain nothing for matrices of this size, wait for each other on a busy machine and
            # round otherwise. Numbers far from any motor may overflow on the way; the result says so.
            with threadpool_limits(1, user_api="blas"), np.errstate(all="ignore"):
                modes = self._solve()
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            raise ValueError(UNRESOLVED) from error
        finite = (np.isfinite(values).all() for values in vars(modes).values())
        if not (all(finite) and np.all(modes.stiffness > 0.0)):
            raise ValueError(UNRESOLVED)
        return modes

    @abstractmethod
    def _solve(self) -> NormalModes:
        """Compute the normal modes in the basis of the subclass."""

    @property
    def patches(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Start and end of both patch sets [m]: the given one (electrode 0) and its mirror (electrode 1)."""
        start, end = self.patch_start, self.patch_end
        return (start, end), (self.length - end, self.length - start)

    @property
    def steel_mass(self) -> float:
        """Mass of the bare beam per length, rho_s A_s [kg/m]."""
        return self.steel.density * self.width * self.beam_thickness

    @property
    def layer_mass(self) -> float:
        """Mass of both layers of a patch set per length, 2 rho_p A_p [kg/m] (eq. 28)."""
        return self.piezoceramic.density * 2.0 * self.width * self.patch_thickness

    @property
    def steel_rigidity(self) -> float:
        """Bending rigidity of the bare beam, c_s I_s [N m^2] (eq. 29)."""
        return self.steel.bending_modulus * (self.width * self.beam_thickness**3 / 12.0)

    @property
    def layer_rigidity(self) -> float:
        """Bending rigidity of both layers about the middle of the beam, c_p I_p [N m^2] (eq. 30)."""
        ts, tp = self.beam_thickness, self.patch_thickness
        inertia = 2.0 / 3.0 * self.width * (1.5 * tp**2 * ts + 0.75 * ts**2 * tp + tp**3)
        return self.piezoceramic.bending_modulus * inertia

    @property
    def moment_per_voltage(self) -> float:
        """Moment at the end of a patch set, w_s (t_s + t_p) e_p [N m/V]; minus that at its start (eq. 31)."""
        lever = self.width * (self.beam_thickness + self.patch_thickness)
        return lever * self.piezoceramic.bending_coupling
