"""Rigid impacts with a restitution of the slip as well, that create no energy."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.impact.newton import ImpactLaw
from contactlab.laws.lagrange import stick_impulse
from contactlab.parameter import Parameter


@final
@dataclass(frozen=True)
class ChatterjeeRuina(ImpactLaw):
    """An impact between two plastic ones, without friction (I) and with stick (II), each overdone.

    II - I leaves the gap rate alone, so that e is that of Newton. With w = v_t - v_n d_nt/d_nn, the slip at
    the end of a compression without friction, the impact leaves

        v_n+ = -e v_n,  w+ = (1 - k) w,  k = 1 + e_t inside of the cone, less on it

    and the energy of both is apart: v_n^2/d_nn + w^2/(d_tt - d_nt^2/d_nn), over two. So no e <= 1 and no
    |e_t| <= 1 creates energy, where Newton's law may. A rubber ball has e_t > 0 and comes back with its slip
    reversed; e_t = -1 is no friction. On the cone it is Newton's slip.
    """

    name = "chatterjee_ruina"
    equation = "p = (1 + e) p_I + k (p_II - p_I), k = 1 + e_t, or less on |p_t| = mu p_n"
    source = "Chatterjee and Ruina (1998), J. Appl. Mech. 65, 939"
    violations = MappingProxyType(
        {
            "friction_opposes_slip": "friction that is given back drives the slip that it has reversed, and "
            "in a body that couples both directions so does the rebound behind the stick."
        }
    )

    tangential_restitution: Annotated[
        float, Parameter("e_t", "1", "tangential coefficient of restitution", at_least=-1.0, at_most=1.0)
    ] = 0.0

    @staticmethod
    @kernel
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution, tangential_restitution):
        mu, k = friction_coefficient, 1.0 + tangential_restitution
        _, stuck = stick_impulse(approach, slip, d_nn, d_nt, d_tt)
        bounce = -(1.0 + restitution) * approach / d_nn
        # What stick adds to the normal impulse keeps the gap rate.
        added = -stuck * d_nt / d_nn
        if k * abs(stuck) > mu * (bounce + k * added):
            k = mu * bounce / (abs(stuck) - mu * added)
        return bounce + k * added, k * stuck
