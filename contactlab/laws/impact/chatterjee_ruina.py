"""Rigid impacts with a restitution of the slip as well, that create no energy."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.impact.newton import ImpactLaw
from contactlab.laws.impact.step import approach_of, with_forces
from contactlab.laws.lagrange import stick_impulse, stick_or_slip_impulse
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
    reversed; e_t = -1 is no friction. On the cone it is Newton's slip. Contact that lasts has no
    restitution and is that of `lagrange_stick`.
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
        tangential_restitution,
    ):
        mu, e, e_t = friction_coefficient, restitution, tangential_restitution
        approach = approach_of(normal_rate, gap_rate)
        if approach == 0.0:
            return stick_or_slip_impulse(normal_rate, tangential_rate, slip, d_nn, d_nt, d_tt, mu)
        _, stuck = stick_impulse(approach, tangential_rate, d_nn, d_nt, d_tt)
        bounce = -(1.0 + e) * approach / d_nn
        # What stick adds to the normal impulse keeps the gap rate.
        k, added = 1.0 + e_t, -stuck * d_nt / d_nn
        left = -e_t * (tangential_rate - approach * d_nt / d_nn) - e * approach * d_nt / d_nn
        mode = STICK if left == 0.0 else SLIP
        if k * abs(stuck) > mu * (bounce + k * added):
            k, mode = mu * bounce / (abs(stuck) - mu * added), SLIP
            left = tangential_rate + d_nt * (bounce + k * added) + d_tt * k * stuck
        return with_forces(
            normal_rate, approach, left, bounce + k * added, k * stuck, mode, d_nn, d_nt, d_tt, mu
        )
