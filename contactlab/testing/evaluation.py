"""The bound kernels of any law, evaluated in Python whatever the law names."""

from typing import Any, final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.binding import functions_of, row_of
from contactlab.engine.state import HEAD, SPEED
from contactlab.laws.base import ContactLaw, PenaltyLaw
from contactlab.laws.consistency import CANARIES, guarded

Limits = tuple[float, float]


@final
class Evaluator:
    """Evaluate the kernels of a law; internal variables are `kept`, shape (variable,), in the order declared.

    First in it is the variable of the friction's own kernel, where there is one. On either side of the law's
    row stands a canary, by default no number.
    """

    def __init__(self, law: ContactLaw, canary: float = np.nan) -> None:
        self.law, self.variables = law, law.internal_variables
        self.own = law.coupled if isinstance(law, PenaltyLaw) else 0
        self.initial = np.array([each.initial for each in self.variables], dtype=np.float64)
        row = row_of(law)
        # Behind the internal variables, too.
        row[HEAD + len(self.variables)] = canary
        self._kernels, self._row = functions_of(law), guarded(row, canary)
        # What kernels may only read is written here.
        self._written: Any = np.asarray(self._row.base)[CANARIES:]
        self._count = len(self.variables)

    @property
    def has_friction(self) -> bool:
        """Whether there is a kernel of friction beside that of the force."""
        return isinstance(self.law, PenaltyLaw) and self.law.friction_force is not None

    def _seen(self, kept: Array) -> Array:
        self._written[HEAD : HEAD + self._count] = kept
        return self._row

    def force(self, gap: float, rate: float, slip: float, speed: float, kept: Array) -> tuple[float, ...]:
        """Return what `PenaltyLaw.force` does."""
        self._written[SPEED] = speed
        normal, _, bound, stored, loss = self._kernels["force"](gap, rate, slip, speed, self._seen(kept))
        return normal, bound, stored, loss

    def friction(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Any:
        """Return friction [N], the rate of the friction's own variable, energy [J] and stiffness [N/m]."""
        return self._kernels["friction_force"](gap, rate, slip, normal, self._seen(kept))

    def rates(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Return the rates of all internal variables."""
        result, row = np.zeros(len(self.variables)), self._seen(kept)
        if self.own:
            result[0] = self.friction(gap, rate, slip, normal, kept)[1]
        for k in range(self.own, self._count):
            result[k] = self._kernels["rate"](k, gap, rate, slip, normal, row)
        return result

    def guards(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Return all guards."""
        row, guard = self._seen(kept), self._kernels["guard"]
        return np.array([guard(k, gap, rate, slip, normal, row) for k in range(self.law.guards)])

    def jumped(self, event: int, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Return the internal variables after an event."""
        after, row = kept.copy(), self._seen(kept)
        for k in range(self.own, self._count):
            after[k] = self._kernels["jump"](k, event, gap, rate, slip, normal, row)
        return after

    def limits(self, kept: Array) -> Limits:
        """Return the gaps at which a contact begins and ends [m]."""
        begin, end = self._kernels["limits"](0.0, self._seen(kept))
        return float(begin), float(end)

    def impact(self, impact: tuple[float, ...], kept: Array) -> Any:
        """Return the impulses [N s] of a rigid law for one of `drawn_impacts`."""
        return self._kernels["impact"](*impact, self._seen(kept))

    def bound(self, normal: float, slip: float, kept: Array) -> float:
        """Return the friction bound of a rigid law [N]."""
        return float(self._kernels["bound"](normal, slip, self._seen(kept)))
