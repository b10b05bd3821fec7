"""Rigid impacts of the literature: with a restitution along the surface too, and with one of the speed."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated

from contactlab.compiler.kernels import kernel
from contactlab.laws import FRICTION_COEFFICIENT, RESTITUTION, MultiplierLaw, Parameter
from contactlab.laws.lagrange import stick_or_slip_impulse
from contactlab.parameter import not_negative

OF_THE_APPROACH = "the rebound is a share of the whole approach, whatever friction has taken of it."


@dataclass(frozen=True)
class TurningImpact(MultiplierLaw):
    """An impact that turns slip as well, as that of rubber balls, as far as friction can."""

    name = "turning_impact"
    equation = "gdot+ = -e gdot-, v+ = -beta v- or |p_t| = mu p_n"
    source = "Walton and Braun (1986), J. Rheol. 30, 949; Foerster et al. (1994), Phys. Fluids 6, 1108"
    default_contact_step = 5e-8
    violations = MappingProxyType({"friction_opposes_slip": "it gives back slip that it has turned."})

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    restitution: Annotated[float, RESTITUTION] = 0.5
    turned: Annotated[float, Parameter("beta", "1", "share of the slip", at_least=0.0, at_most=1.0)] = 0.4

    @staticmethod
    @kernel
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution, turned):
        rate, along = approach + restitution * approach, slip + turned * slip
        return stick_or_slip_impulse(rate, along, d_nn, d_nt, d_tt, friction_coefficient)


@dataclass(frozen=True)
class ViscoelasticImpact(MultiplierLaw):
    """An impact of viscoelastic spheres, whose restitution falls with the speed."""

    name = "viscoelastic_impact"
    equation = "gdot+ = -e gdot-, e = max(1 - C |gdot-|^(1/5), 0)"
    source = "Kuwabara and Kono (1987), Jpn. J. Appl. Phys. 26, 1230"
    default_contact_step = 5e-8
    violations = MappingProxyType({"dissipates": OF_THE_APPROACH})

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    loss: Annotated[float, not_negative("C", "m-0.2 s0.2", "loss of an approach at 1 m/s")] = 0.5

    @staticmethod
    @kernel
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, loss):
        rate = approach + max(1.0 - loss * (-approach) ** 0.2, 0.0) * approach
        return stick_or_slip_impulse(rate, slip, d_nn, d_nt, d_tt, friction_coefficient)
