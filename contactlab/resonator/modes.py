"""A resonator as everything after it sees it, whatever basis it was computed in."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from contactlab.checks import check_shape

Array = NDArray[np.float64]


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
