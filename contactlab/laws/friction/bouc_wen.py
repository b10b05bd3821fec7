"""The hysteresis of Bouc and Wen as a friction."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Self, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import RATE_DEPENDENT, Friction
from contactlab.laws.memory import ODD, InternalVariable
from contactlab.parameter import Parameter, positive

SHAPE = Parameter(
    "beta", "1", "share of beta in beta + gamma", at_least=0.5, hint="Below 0.5 unloading would make energy."
)


@final
@dataclass(frozen=True)
class BoucWen(Friction):
    """Friction that grows with the way and slides at mu N, with loops of many shapes.

    Wen's equation is dz/dt = A v - beta |v| |z|^(n-1) z - gamma v |z|^n, with the ultimate value
    z_u = (A/(beta + gamma))^(1/n). Friction reaches mu N there, so that of his four constants three are
    left: Y = z_u/A, beta/(beta + gamma) and n, as Constantinou et al. have them for sliding bearings. See
    `of_wen`. The hardening spring alpha k x of a structure is left out. The larger n, the sharper the knee;
    with beta = 0.5 it unloads along a straight line, and for n = 1 and beta = 1 it is `dahl` with
    i = 1. At constant N it loses energy along any way; small cycles drift.

    Source: Bouc (1967), Proc. 4th Conf. on Nonlinear Oscillations, Prague; Wen (1976); Constantinou,
    Mokha and Reinhorn (1990), J. Struct. Eng. 116, 455.
    """

    name = "bouc_wen"
    equation = "F = -mu N z/Y, dz/dt = v - beta |v| |z/Y|^(n-1) z/Y - (1 - beta) v |z/Y|^n"
    source = "Wen (1976), J. Eng. Mech. Div. 102, 249; Constantinou et al. (1990), J. Struct. Eng. 116, 455"
    validity = "large cycles: small ones drift"
    friction_kind = RATE_DEPENDENT
    exact_stick = False
    internal_variables = (InternalVariable("deflection", "z", "m", "hysteretic deflection", parity=ODD),)
    violations = MappingProxyType(
        {
            "friction_opposes_slip": "a deflected contact grows stiffer with the normal force, which gives "
            "it energy that nothing brought."
        }
    )

    yield_displacement: Annotated[float, positive("Y", "m", "yield displacement")] = 3e-7
    shape: Annotated[float, SHAPE] = 0.5
    exponent: Annotated[float, Parameter("n", "1", "sharpness of the knee", at_least=1.0)] = 2.0

    @classmethod
    def of_wen(cls, mu: float, a: float, beta: float, gamma: float, n: float) -> Self:
        """Return the friction of Wen's A [1], beta and gamma [m^-n] and n that slides at mu N.

        Raises:
            ValueError: A is not positive, or beta < |gamma|, which would make energy.
        """
        if a <= 0.0 or beta + gamma <= 0.0:
            raise ValueError(f"A is {a:g} and beta + gamma {beta + gamma:g}; both must be greater than 0.")
        ultimate = (a / (beta + gamma)) ** (1.0 / n)
        return cls(mu, ultimate / a, beta / (beta + gamma), n)

    @staticmethod
    @kernel
    def state(normal, slip, deflection, friction_coefficient, yield_displacement, shape, exponent):
        share = deflection / yield_displacement
        # Steps may overshoot by their tolerance; the force stays in the cone.
        force = -friction_coefficient * max(normal, 0.0) * min(max(share, -1.0), 1.0)
        # The rate goes on along its tangent there, so that no step is solved by a root far beyond.
        size = abs(share)
        bent = size**exponent if size < 1.0 else 1.0 + exponent * (size - 1.0)
        signed = shape if slip * deflection > 0.0 else -shape
        return force, slip * (1.0 - bent * (signed + 1.0 - shape)), -0.5 * force * deflection, 0.0
