"""A rigid contact whose static friction is larger than its kinetic, and grows while it sticks."""

from dataclasses import dataclass
from math import log1p
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import MultiplierLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.friction.coulomb import STATIC_RATIO
from contactlab.laws.lagrange import stick_impulse, stick_or_slip_impulse
from contactlab.laws.memory import AT_SLIP, AT_TOUCH, InternalVariable
from contactlab.parameter import not_negative, positive


@final
@dataclass(frozen=True)
class LagrangeAgeing(MultiplierLaw):
    """Lagrange multiplier with a static coefficient of friction of its own that ages in stick.

    Stick holds what is inside of the static cone; what slides is dragged by mu, and stays behind as soon as
    its slip has ended and static friction can hold it, else it slides back. Slip makes the contact new. In an
    impact, friction that ends a slip is kinetic. Without ageing, delta = 0, it is the
    stick-slip of two coefficients; with mu_s = mu as well it is `lagrange_stick`.

    Source of the ageing: Dieterich (1972), J. Geophys. Res. 77, 3690; Rabinowicz (1958), Proc. Phys. Soc. 71,
    668, of the growth with the time of stick.
    """

    name = "lagrange_ageing"
    equation = "g = 0, N >= 0, |F| <= (mu_s + delta ln(1 + min(t, t_max)/t_0)) N, F = -mu N sign(v) in slip"
    source = "Dieterich (1972), J. Geophys. Res. 77, 3690; Andersen, Blanke and Helbo (2001), eqs. 60-66"
    validity = "sticks as long as the measured ones; others extrapolate"
    internal_variables = (InternalVariable("age", "t", "s", "age of stick"),)

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    static_ratio: Annotated[float, STATIC_RATIO] = 1.2
    strengthening: Annotated[float, not_negative("delta", "1", "growth of mu_s for an e-fold age")] = 0.01
    ageing_time: Annotated[float, positive("t_0", "s", "age at which friction begins to grow")] = 1e-5
    longest_age: Annotated[float, not_negative("t_max", "s", "age at which growth ends")] = 1e5

    @property
    def friction_limit(self) -> float:
        """That of the longest age."""
        fresh = self.friction_coefficient * self.static_ratio
        return float(fresh + self.strengthening * log1p(self.longest_age / self.ageing_time))

    @staticmethod
    @kernel
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, static_ratio):
        p_n, p_t = stick_impulse(approach, slip, d_nn, d_nt, d_tt)
        # Friction that ends a slip is kinetic; a slip at rest, or that reverses, meets fresh static friction.
        if p_t * slip >= 0.0 and abs(p_t) <= friction_coefficient * static_ratio * p_n:
            return p_n, p_t
        return stick_or_slip_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient)

    @staticmethod
    @kernel
    def bound(normal, slip, age, friction_coefficient, static_ratio, strengthening, ageing_time, longest_age):
        mu = friction_coefficient
        if slip == 0.0:
            mu = mu * static_ratio + strengthening * log1p(min(age, longest_age) / ageing_time)
        return mu * max(normal, 0.0)

    @staticmethod
    @kernel
    def rate(slip):
        return 1.0 if slip == 0.0 else 0.0

    @staticmethod
    @kernel
    def jump(event, age):
        return 0.0 if event in (AT_SLIP, AT_TOUCH) else age
