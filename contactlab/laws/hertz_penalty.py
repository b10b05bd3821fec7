"""A compliant contact after Hertz with set-valued Coulomb friction."""

from dataclasses import dataclass, replace
from math import sqrt
from typing import Annotated, final

from contactlab.checks import checked_arguments
from contactlab.compiler.kernels import kernel
from contactlab.laws.base import PenaltyLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.normal import hertz_elastic
from contactlab.parameter import Parameter, positive

PER_RADIUS = "A 5 mm steel tip has about 1e10 N/m^1.5; null takes it from law.tip_radius."
LEFT_OUT = "Leave it out where law.stiffness is given."
STIFFNESS = positive("K", "N m-1.5", "contact stiffness", hint=PER_RADIUS)
TIP_RADIUS = positive("r", "m", "radius of the tip", hint=LEFT_OUT)


@final
@dataclass(frozen=True)
class HertzPenalty(PenaltyLaw):
    """Hertz point contact, Coulomb friction: `law=composed law/normal=hertz_point law/friction=coulomb`.

    Elastic: the normal direction loses nothing, V = 2/5 K max(-g, 0)^(5/2). Exactly one of stiffness and tip
    radius is given; the other way round the stiffness is that of steel on a rotor (`on_rotor`). The
    composed law takes any other friction in the place of `coulomb`.
    """

    name = "hertz_penalty"
    equation = "N = K max(-g, 0)^1.5, |F| <= mu N, F = -mu N sign(v) where v != 0"
    source = "Hertz (1881); Johnson, Contact Mechanics (1985), eq. 4.23"
    validity = "contact radius well below the tip's radius; no yield (Johnson 1985, ch. 4)"
    default_contact_step = 4e-6

    stiffness: Annotated[float | None, STIFFNESS] = 1e10
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    tip_radius: Annotated[float | None, TIP_RADIUS] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.stiffness is None) == (self.tip_radius is None):
            raise ValueError(
                f"{self.name}: stiffness is {self.stiffness} and tip_radius is {self.tip_radius}; exactly "
                "one of them must be a number and the other null (None). Give the stiffness in N/m^1.5, or "
                "the tip's radius in m to have it computed."
            )

    def on_rotor(self, radius: float) -> "HertzPenalty":
        """Return the law with the stiffness of its tip on a rotor of a radius [m], both of steel."""
        if self.tip_radius is None:
            return self
        stiffness = hertz_stiffness(self.tip_radius, radius)
        return replace(self, stiffness=stiffness, tip_radius=None)

    @staticmethod
    @kernel
    def force(depth, stiffness, friction_coefficient):
        normal, stored, _, _ = hertz_elastic(max(depth, 0.0), stiffness)
        return normal, friction_coefficient * normal, stored, 0.0


@checked_arguments(rotor_radius="m")
def hertz_stiffness(
    tip_radius: Annotated[float, positive("r", "m", "radius of the tip")],
    rotor_radius: float,
    youngs_modulus: Annotated[float, positive("E", "Pa", "Young's modulus of both bodies")] = 210e9,
    poisson_ratio: Annotated[float, Parameter("nu", "1", "Poisson's ratio", above=-1.0, at_most=0.5)] = 0.3,
) -> float:
    """Return K = 4/3 E* sqrt(R_e) of a spherical tip on a cylindrical rotor of the same material [N m^-3/2].

        1/E* = 2 (1 - nu^2) / E,   R_e = [ (1/r) (1/r + 1/R) ]^(-1/2)

    R_e is the geometric mean of the two relative radii, exact for a circular contact and good to
    a fraction of a percent in K while r is well below R (Johnson 1985, sec. 4.2). The radii r of the tip
    and R of the rotor are in m, Young's modulus E of both bodies in Pa.

        >>> import contactlab as cl
        >>> f"{cl.hertz_stiffness(tip_radius=1e-3, rotor_radius=25e-3):.3e}"
        '4.818e+09'
    """
    if rotor_radius == 0.0 or not 1.0 / tip_radius + 1.0 / rotor_radius > 0.0:
        raise ValueError(
            f"rotor_radius is {rotor_radius:g} m; it must be positive, or, of a hollow rotor, less than "
            f"{-tip_radius:g} m, minus the tip_radius."
        )
    effective_modulus = youngs_modulus / (2.0 * (1.0 - poisson_ratio**2))
    effective_radius = ((1.0 / tip_radius) * (1.0 / tip_radius + 1.0 / rotor_radius)) ** -0.5
    return 4.0 / 3.0 * effective_modulus * sqrt(effective_radius)
