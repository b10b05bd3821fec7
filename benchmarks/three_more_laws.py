"""Three rigid impacts beside those of the package, so that there are ten that answer differently."""

from dataclasses import dataclass
from math import exp
from types import MappingProxyType
from typing import Annotated, ClassVar

from contactlab.compiler.kernels import kernel
from contactlab.laws import FRICTION_COEFFICIENT, RESTITUTION, MultiplierLaw, Parameter
from contactlab.laws.base import SLIP
from contactlab.laws.lagrange import stick_or_slip_impulse
from contactlab.parameter import not_negative

OF_THE_APPROACH = MappingProxyType(
    {"dissipates": "the rebound is a share of the whole approach, whatever friction has taken of it."}
)


@dataclass(frozen=True)
class TurningImpact(MultiplierLaw):
    """An impact that gives back slip too, as rubber balls do, as far as friction can."""

    name: ClassVar[str] = "turning_impact"
    equation: ClassVar[str] = "gdot+ = -e gdot-, v+ = -beta v- or |p_t| = mu p_n"
    source: ClassVar[str] = "Foerster et al. (1994), Phys. Fluids 6, 1108"
    default_contact_step: ClassVar[float] = 5e-8
    violations = MappingProxyType({"friction_opposes_slip": "it gives back slip that it has turned."})

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    restitution: Annotated[float, RESTITUTION] = 0.5
    turned: Annotated[float, Parameter("beta", "1", "share of the slip", at_least=0.0, at_most=1.0)] = 0.4

    @staticmethod
    @kernel
    def solve(
        normal_rate,
        tangential_rate,
        gap_rate,
        slip,
        d_nn,
        d_nt,
        d_tt,
        friction_coefficient,
        restitution,
        turned,
    ):
        """Return impulses [N s] and mode."""
        rate = normal_rate + restitution * min(gap_rate, 0.0)
        along = tangential_rate + turned * slip
        p_n, p_t, mode = stick_or_slip_impulse(rate, along, slip, d_nn, d_nt, d_tt, friction_coefficient)
        return p_n, p_t, SLIP if turned > 0.0 else mode


@dataclass(frozen=True)
class ViscoelasticImpact(MultiplierLaw):
    """An impact of viscoelastic spheres, whose restitution falls with the speed."""

    name: ClassVar[str] = "viscoelastic_impact"
    equation: ClassVar[str] = "gdot+ = -e gdot-, e = max(1 - C |gdot-|^(1/5), 0)"
    source: ClassVar[str] = "Kuwabara and Kono (1987), Jpn. J. Appl. Phys. 26, 1230"
    default_contact_step: ClassVar[float] = 5e-8
    violations = OF_THE_APPROACH

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    loss: Annotated[float, not_negative("C", "m-0.2 s0.2", "loss of an approach at 1 m/s")] = 0.5

    @staticmethod
    @kernel
    def solve(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, friction_coefficient, loss):
        """Return impulses [N s] and mode."""
        approach = min(gap_rate, 0.0)
        rate = normal_rate + max(1.0 - loss * (-approach) ** 0.2, 0.0) * approach
        return stick_or_slip_impulse(rate, tangential_rate, slip, d_nn, d_nt, d_tt, friction_coefficient)


@dataclass(frozen=True)
class SlantingImpact(MultiplierLaw):
    """An impact whose restitution falls the more the approach slants: no law of the literature."""

    name: ClassVar[str] = "slanting_impact"
    equation: ClassVar[str] = "gdot+ = -e gdot-, e = e_0 exp(-s |v-/gdot-|)"
    source: ClassVar[str] = "none; a stand-in for laws whose restitution depends on the slip"
    default_contact_step: ClassVar[float] = 5e-8
    violations = OF_THE_APPROACH

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    restitution: Annotated[float, RESTITUTION] = 0.5
    slant: Annotated[float, not_negative("s", "1", "fall of the restitution with the slant")] = 0.3

    @staticmethod
    @kernel
    def solve(
        normal_rate,
        tangential_rate,
        gap_rate,
        slip,
        d_nn,
        d_nt,
        d_tt,
        friction_coefficient,
        restitution,
        slant,
    ):
        """Return impulses [N s] and mode."""
        approach = min(gap_rate, 0.0)
        kept = exp(slant * abs(slip) / approach) if approach < 0.0 else 0.0
        rate = normal_rate + restitution * kept * approach
        return stick_or_slip_impulse(rate, tangential_rate, slip, d_nn, d_nt, d_tt, friction_coefficient)
