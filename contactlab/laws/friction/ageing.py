"""Static friction that grows with the age of stick."""

from dataclasses import dataclass
from math import log1p
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import Friction
from contactlab.laws.memory import AT_SLIP, AT_TOUCH, InternalVariable
from contactlab.parameter import not_negative, positive


@final
@dataclass(frozen=True)
class AgeingStick(Friction):
    """Set-valued friction with tangentially rigid stick, the stronger the longer it sticks.

    t is the age, the time since the present stick began: slip of any length forgets it, where
    rate-and-state friction needs a distance. Tenfold age adds delta ln 10 once t is well above t_0.
    Dieterich (1972) has A log10(1 + B t), here delta = A/ln 10 and t_0 = 1/B. There is no end to his
    logarithm; t_max ends it, so that friction has a largest value.

    Source: Dieterich (1972), J. Geophys. Res. 77, 3690; that static friction grows with the time of
    stick: Rabinowicz (1951), J. Appl. Phys. 22, 1373, and (1958), Proc. Phys. Soc. 71, 668.
    """

    name = "ageing_stick"
    equation = "|F| <= (mu + delta ln(1 + min(t, t_max)/t_0)) N in stick, F = -mu N sign(v) in slip"
    source = "Dieterich (1972), J. Geophys. Res. 77, 3690"
    validity = "sticks as long as the measured ones; others extrapolate"
    internal_variables = (InternalVariable("age", "t", "s", "age of stick"),)

    strengthening: Annotated[float, not_negative("delta", "1", "growth of mu_s for an e-fold age")] = 0.01
    ageing_time: Annotated[float, positive("t_0", "s", "age at which friction begins to grow")] = 1e-5
    longest_age: Annotated[float, not_negative("t_max", "s", "age at which growth ends")] = 1e5

    @property
    def friction_limit(self) -> float:
        """That of the longest age."""
        return self.friction_coefficient + self.strengthening * log1p(self.longest_age / self.ageing_time)

    @staticmethod
    @kernel
    def bound(normal, slip, age, friction_coefficient, strengthening, ageing_time, longest_age):
        grown = strengthening * log1p(min(age, longest_age) / ageing_time) if slip == 0.0 else 0.0
        return (friction_coefficient + grown) * max(normal, 0.0)

    @staticmethod
    @kernel
    def rate(slip):
        return 1.0 if slip == 0.0 else 0.0

    @staticmethod
    @kernel
    def jump(event, age):
        return 0.0 if event in (AT_SLIP, AT_TOUCH) else age
