"""Materials of the resonator, reduced to what bending needs: modulus, coupling, density.

Bending strains a fibre by -1 along the beam and by +nu through the thickness (the layers are
stress-free there), b = [0, -1, nu, 0, 0, 0] in Voigt order with x2 along the beam and x3 through
the thickness (Andersen, Blanke and Helbo 2001, eqs. 13 and 33).
"""

from dataclasses import dataclass
from typing import Annotated, final

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import Checked
from contactlab.parameter import Parameter, positive

VACUUM_PERMITTIVITY = 8.8541878128e-12
"""F/m, CODATA 2018."""

_DENSITY = positive("rho_p", "kg m-3", "density")
_POISSON = Parameter("nu", "1", "Poisson's ratio", above=-1.0, below=0.5)
_STRAIN_RATIO = Parameter(
    "nu_p", "1", "ratio of the strains through the thickness and along the beam"
)
_PERMITTIVITY = positive("eps33^S", "F m-1", "clamped permittivity through the thickness")


def bending_vector(poisson_ratio: float) -> Array:
    """Give the strain of a fibre under unit curvature at unit height, b = [0, -1, nu, 0, 0, 0] (eq. 33)."""
    return np.array([0.0, -1.0, poisson_ratio, 0.0, 0.0, 0.0])


@final
@dataclass(frozen=True)
class Steel(Checked):
    """An isotropic beam material."""

    youngs_modulus: Annotated[float, positive("E", "Pa", "Young's modulus")] = 210e9
    poisson_ratio: Annotated[float, _POISSON] = 0.3
    density: Annotated[float, positive("rho_s", "kg m-3", "density")] = 7850.0

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
class Piezoceramic(Checked):
    """A piezoceramic layer poled through its thickness, by modulus and coupling in bending.

    The modulus is b c^E b' (eq. 30), the coupling nu_p e33 - e31 (eq. 31). The defaults are PZ26 with
    both identified from the couplings and frequencies of Table 1; `PiezoceramicDatasheet` has the
    catalogue's values.
    """

    bending_modulus: Annotated[float, positive("c_p", "Pa", "bending modulus")] = 94.295e9
    bending_coupling: Annotated[float, Parameter("e_p", "C m-2", "bending coupling")] = 9.196
    density: Annotated[float, _DENSITY] = 7700.0
    permittivity: Annotated[float, _PERMITTIVITY] = 700.0 * VACUUM_PERMITTIVITY


@final
@dataclass(frozen=True)
class PiezoceramicDatasheet(Checked):
    """The constants of a piezoceramic, transversely isotropic about x3, in which it is poled; those of PZ26.

    c12 enters no bending quantity of a beam that is free to strain across its width.
    """

    c11: Annotated[float, positive("c11^E", "Pa", "elastic constant")] = 168e9
    c12: Annotated[float, Parameter("c12^E", "Pa", "elastic constant")] = 110e9
    c13: Annotated[float, Parameter("c13^E", "Pa", "elastic constant")] = 99.9e9
    c33: Annotated[float, positive("c33^E", "Pa", "elastic constant")] = 123e9
    e31: Annotated[float, Parameter("e31", "C m-2", "piezoelectric constant")] = -2.8
    e33: Annotated[float, Parameter("e33", "C m-2", "piezoelectric constant")] = 14.7
    poisson_ratio: Annotated[float, _STRAIN_RATIO] = 0.334
    density: Annotated[float, _DENSITY] = 7700.0
    permittivity: Annotated[float, _PERMITTIVITY] = 700.0 * VACUUM_PERMITTIVITY

    def in_bending(self) -> Piezoceramic:
        """Give what bending needs of it (eqs. 30 and 31)."""
        c11, c12, c13 = self.c11, self.c12, self.c13
        normal = np.array([[c11, c12, c13], [c12, c11, c13], [c13, c13, self.c33]])
        b = bending_vector(self.poisson_ratio)[:3]
        modulus, coupling = b @ normal @ b, b @ np.array([self.e31, self.e31, self.e33])
        return Piezoceramic(float(modulus), float(coupling), self.density, self.permittivity)
