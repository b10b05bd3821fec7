"""Elastic constants of handbook materials, and the effective modulus of two in contact."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Final, final

from contactlab.checks import Checked, check_kind
from contactlab.motor.patched_beam import Steel
from contactlab.parameter import Parameter, positive
from contactlab.suggestion import suggestion


@final
@dataclass(frozen=True)
class Material(Checked):
    """An isotropic elastic material."""

    youngs_modulus: Annotated[float, positive("E", "Pa", "Young's modulus")]
    poisson_ratio: Annotated[float, Parameter("nu", "1", "Poisson's ratio", above=-1.0, at_most=0.5)]


MATERIALS: Final[Mapping[str, Material]] = MappingProxyType(
    {
        "steel": Material(Steel().youngs_modulus, Steel().poisson_ratio),
        "stainless steel": Material(215e9, 0.283),
        "aluminium": Material(70.3e9, 0.345),
        "brass": Material(101e9, 0.350),
        "copper": Material(130e9, 0.343),
        "titanium": Material(120e9, 0.361),
        "tungsten": Material(411e9, 0.280),
        "alumina": Material(400e9, 0.22),
        "silicon carbide": Material(396e9, 0.22),
        "glass": Material(69e9, 0.20),
        "fused silica": Material(70e9, 0.18),
        "epoxy": Material(3.5e9, 0.33),
        "nylon": Material(2.7e9, 0.41),
        "polycarbonate": Material(2.4e9, 0.38),
        "PMMA": Material(2.7e9, 0.35),
        "PTFE": Material(0.55e9, 0.46),
    }
)
"""Handbook materials at room temperature, after Dowling, Mechanical Behavior of Materials (2013), table 5.2.

Steel is that of the motor's beam, PTFE the middle of data sheets, 0.3 to 0.7 GPa by grade. Grades of metals
differ by some per cent, ceramics by a tenth with their porosity, polymers by a third and with the rate.
"""

Materials = str | tuple[Material, Material]
"""Two bodies in contact: "steel on alumina", or each with its constants."""


def effective_modulus(materials: Materials) -> float:
    """Return the effective modulus of a contact [Pa]: 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2.

    >>> f"{effective_modulus('steel on alumina'):.4g} Pa"
    '1.49e+11 Pa'

    Raises:
        TypeError, ValueError: these are no two materials, or there is none of such a name.
    """
    pair = materials.split(" on ") if isinstance(materials, str) else materials
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise ValueError(f"materials is {materials!r}; it must be two of them, as 'steel on alumina'.")
    compliance = 0.0
    for item in pair:
        if isinstance(item, str) and item not in MATERIALS:
            hint = suggestion(item, MATERIALS, "Give a Material(youngs_modulus, poisson_ratio) instead.")
            raise ValueError(f"materials has '{item}'; it must be one of {', '.join(MATERIALS)}. {hint}")
        material = MATERIALS[item] if isinstance(item, str) else item
        check_kind("Each of the materials", material, Material)
        compliance += (1.0 - material.poisson_ratio**2) / material.youngs_modulus
    return 1.0 / compliance
