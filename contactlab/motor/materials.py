"""Materials of the resonator, reduced to what bending needs: modulus, coupling, density.

Bending strains a fibre by -1 along the beam and by +nu through the thickness (the layers are
stress-free there), b = [0, -1, nu, 0, 0, 0] in Voigt order with x2 along the beam and x3 through
the thickness (Andersen, Blanke and Helbo 2001, eqs. 13 and 33).
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from contactlab.checks import check_fields

Array = NDArray[np.float64]

VACUUM_PERMITTIVITY = 8.8541878128e-12
"""F/m, CODATA 2018."""


def bending_vector(poisson_ratio: float) -> Array:
    """Strain of a fibre under unit curvature at unit height, b = [0, -1, nu, 0, 0, 0] (eq. 33)."""
    return np.array([0.0, -1.0, poisson_ratio, 0.0, 0.0, 0.0])


@final
@dataclass(frozen=True)
class Steel:
    """An isotropic beam material.

    Args:
        youngs_modulus: E [Pa].
        poisson_ratio: nu [1].
        density: rho_s [kg/m^3].
    """

    youngs_modulus: float = 210e9
    poisson_ratio: float = 0.3
    density: float = 7850.0

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def bending_modulus(self) -> float:
        """c_s = b c b' with the full isotropic tensor [Pa] (eq. 29); 235.442 GPa for steel."""
        nu = self.poisson_ratio
        shear = self.youngs_modulus / (2.0 * (1.0 + nu))
        lame = self.youngs_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        tensor = np.diag([2.0 * shear] * 3 + [shear] * 3)
        tensor[:3, :3] += lame
        b = bending_vector(nu)
        return float(b @ tensor @ b)


@final
@dataclass(frozen=True)
class Piezoceramic:
    """A piezoceramic layer poled through its thickness.

    Args:
        bending_modulus: c_p = b c^E b' [Pa] (eq. 30).
        bending_coupling: e_p = nu_p e33 - e31 [C/m^2] (eq. 31).
        density: rho_p [kg/m^3].
        permittivity: clamped permittivity through the thickness, eps33^S [F/m] (eq. 32).

    The defaults are PZ26 with modulus and coupling identified from the couplings and
    frequencies of Table 1; `from_datasheet` gives the catalogue's values.
    """

    bending_modulus: float = 94.295e9
    bending_coupling: float = 9.196
    density: float = 7700.0
    permittivity: float = 700.0 * VACUUM_PERMITTIVITY

    def __post_init__(self) -> None:
        check_fields(self)

    @classmethod
    def from_datasheet(
        cls,
        c11: float = 168e9,
        c12: float = 110e9,
        c13: float = 99.9e9,
        c33: float = 123e9,
        e31: float = -2.8,
        e33: float = 14.7,
        poisson_ratio: float = 0.334,
        density: float = 7700.0,
        permittivity: float = 700.0 * VACUUM_PERMITTIVITY,
    ) -> "Piezoceramic":
        """PZ26 from its elastic [Pa] and piezoelectric [C/m^2] constants, transversely isotropic about x3.

        c12 enters no bending quantity of a beam that is free to strain across its width; it is
        part of the tensor and kept with it.
        """
        normal = np.array([[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]])
        b = bending_vector(poisson_ratio)[:3]
        coupling = b @ np.array([e31, e31, e33])
        return cls(float(b @ normal @ b), float(coupling), density, permittivity)
