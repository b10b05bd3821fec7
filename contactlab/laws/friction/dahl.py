"""Dahl's friction: a force of the way, as the stress of a metal that yields."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import RATE_DEPENDENT, Friction
from contactlab.laws.memory import ODD, InternalVariable
from contactlab.parameter import Parameter, positive


@final
@dataclass(frozen=True)
class Dahl(Friction):
    """Friction that grows with the way until it slides at mu N; the way alone counts, not the speed.

        dF/dx = sigma |1 - (F/F_c) sgn v|^i sgn(1 - (F/F_c) sgn v)     of the resisting F, F_c = mu N

    Here it is in proportion to N, with sigma = sigma_0 N: z, |z| < mu/sigma_0, is the deflection.

    At constant N from rest i = 1 has F = F_c (1 - exp(-sigma x/F_c)), and loses
    4 F_c (X - (F_c/sigma) tanh(sigma X/F_c)) in a cycle of amplitude X. The larger i, the later it slides.
    Brittle i < 1 is refused: the rate has no derivative where it slides. Loads that swing inside of mu N
    make it drift, as they do `lugre`.

    Source: Dahl (1976); Dahl (1968), Aerospace Corp. TOR-0158(3107-18)-1, for the exponent.
    """

    name = "dahl"
    equation = "F = -N sigma_0 z, dz/dt = v |1 - s|^i sgn(1 - s), s = (sigma_0 z/mu) sgn(v)"
    source = "Dahl (1976), AIAA J. 14, 1675"
    validity = "loads that do not swing inside of mu N: it drifts"
    friction_kind = RATE_DEPENDENT
    exact_stick = False
    internal_variables = (InternalVariable("deflection", "z", "m", "deflection of the contact", parity=ODD),)
    violations = MappingProxyType(
        {
            "friction_opposes_slip": "a deflected contact grows stiffer with the normal force, which gives "
            "it energy that nothing brought."
        }
    )

    rest_stiffness: Annotated[float, positive("sigma_0", "m-1", "stiffness at F = 0 over N")] = 1e6
    exponent: Annotated[float, Parameter("i", "1", "exponent of yielding", at_least=1.0)] = 1.0

    @staticmethod
    @kernel
    def state(normal, slip, deflection, friction_coefficient, rest_stiffness, exponent):
        if friction_coefficient == 0.0:
            return 0.0, 0.0, 0.0, 0.0
        share = rest_stiffness * deflection / friction_coefficient
        # Steps may overshoot by their tolerance; the force stays in the cone.
        force = -friction_coefficient * max(normal, 0.0) * min(max(share, -1.0), 1.0)
        left = 1.0 - share * (1.0 if slip > 0.0 else -1.0)
        pace = abs(left) ** exponent
        return force, slip * (pace if left > 0.0 else -pace), -0.5 * force * deflection, 0.0
