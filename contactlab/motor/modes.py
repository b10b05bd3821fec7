"""A resonator as everything after it sees it, whatever basis it was computed in."""

from dataclasses import dataclass
from typing import final

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import check_shape

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


def refuse_unresolved(eigenvalues: Array) -> None:
    """Refuse eigenvalues whose smallest is the round-off of their largest.

    Args:
        eigenvalues: of one symmetric matrix, ascending, shape (mode,).

    Raises:
        ValueError: where the smallest one is not RESOLVED.
    """
    # Not the other way round: nothing is larger than what is no number.
    if not eigenvalues[0] > RESOLVED * eigenvalues[-1]:
        raise ValueError(UNRESOLVED)


@final
@dataclass(frozen=True)
class NormalModes:
    """A resonator as everything after it sees it: mass-orthonormal, decoupled oscillators.

        qdd_j + c_j qd_j + k_j q_j = sum_e coupling[j, e] U_e(t) + tip force terms

    Args:
        stiffness: k_j = omega_j^2 [1/s^2], shape (mode,).
        damping: c_j = 2 zeta_j omega_j [1/s], shape (mode,).
        coupling: modal force per voltage [N/V kg^-1/2], shape (mode, electrode).
        tip_displacement: u = tip_displacement . q [kg^-1/2], shape (mode,).
        tip_slope: theta = tip_slope . q [kg^-1/2 m^-1], shape (mode,).
        shape_coupling: Gamma [N/V], shape (shape, electrode), force per voltage on shapes psi of
            int psi^2 dx = L: those of the basis before the modes, or the modes themselves, so scaled.
    """

    stiffness: Array
    damping: Array
    coupling: Array
    tip_displacement: Array
    tip_slope: Array
    shape_coupling: Array

    def __post_init__(self) -> None:
        check_shape("stiffness", self.stiffness, (-1,), "one number a mode")
        count = self.stiffness.size
        for name in ("damping", "tip_displacement", "tip_slope"):
            check_shape(name, getattr(self, name), (count,), "one number a mode")
        check_shape("coupling", self.coupling, (count, 2), "a row a mode and a column an electrode")
        check_shape(
            "shape_coupling",
            self.shape_coupling,
            (-1, 2),
            "a row a shape and a column an electrode",
        )

    @property
    def natural_frequency(self) -> Array:
        """Undamped natural frequencies f_j [Hz], shape (mode,)."""
        return np.asarray(np.sqrt(self.stiffness) / (2.0 * np.pi), dtype=np.float64)

    @property
    def damping_ratio(self) -> Array:
        """zeta_j [1], shape (mode,); 1 is critical, more is overdamped."""
        return np.asarray(0.5 * self.damping / np.sqrt(self.stiffness), dtype=np.float64)
