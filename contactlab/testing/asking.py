"""The kernels of any law, each asked in one form whatever the law remembers or is told."""

from typing import Any, final

import numpy as np

from contactlab.arrays import Array
from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.intake import GUARDS, guarded

Limits = tuple[float, float]


@final
class Asked:
    """Ask the kernels of a law; what they remember is `kept`, shape (variable,), in the order declared.

    First in it is the variable of the friction's own kernel, where there is one; the others are z. On
    either side of z and of the parameters stands a lure, by default no number.
    """

    def __init__(self, law: ContactLaw, lure: float = np.nan) -> None:
        self.law, self.row = law, guarded(law.parameters(), lure)
        self.variables = law.internal_variables
        self.own = 1 if law.friction_variable is not None else 0
        self.initial = np.array([one.initial for one in self.variables], dtype=np.float64)
        count = len(law.remembered)
        # One place for z, whose type is that of the parameters.
        self._space = np.full(count + 2 * GUARDS, lure)
        self._z = self._space[GUARDS : GUARDS + count]
        self._z.flags.writeable = self.row.flags.writeable
        self._behind: tuple[Array, ...] = (self._z, self.row) if count else (self.row,)
        # Properties may make their kernels anew.
        self._rate, self._guard, self._jump, self._limits = law.rate, law.guard, law.jump, law.limits
        self._force: Any = law.force if isinstance(law, PenaltyLaw) else None
        self._drag: Any = law.friction_force if isinstance(law, PenaltyLaw) else None
        self._solve: Any = law.solve if isinstance(law, MultiplierLaw) else None
        self._moment: Any = law.moment if isinstance(law, PenaltyLaw) else None
        self._told = isinstance(law, MultiplierLaw) and law.told
        self._of_a_number = not law.friction_remembers

    @property
    def has_friction(self) -> bool:
        """Whether there is a kernel of friction beside that of the force."""
        return self._drag is not None

    def _seen(self, kept: Array) -> tuple[Array, ...]:
        self._space[GUARDS : GUARDS + self._z.size] = kept[self.own :]
        return self._behind

    def force(self, gap: float, rate: float, slip: float, speed: float, kept: Array) -> Any:
        """Give what `PenaltyLaw.force` does."""
        return self._force(gap, rate, slip, speed, *self._seen(kept))

    def friction(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Any:
        """Give friction [N], the rate of the friction's own variable, energy [J] and stiffness [N/m]."""
        if not self._of_a_number:
            force, stored, stiffness = self._drag(gap, rate, slip, normal, *self._seen(kept))
            return force, 0.0, stored, stiffness
        variable = float(kept[0]) if self.own else 0.0
        return self._drag(gap, rate, slip, normal, variable, *self._seen(kept))

    def moments(self, tilt: float, spin: float, gap: float, normal: float, kept: Array) -> tuple[float, ...]:
        """Return what `PenaltyLaw.moment` does; nothing for a law without."""
        if self._moment is None:
            return ()
        return tuple(self._moment(tilt, spin, gap, normal, *self._seen(kept)))

    def rates(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Give the rates of all that is kept."""
        found, seen = np.zeros(len(self.variables)), self._seen(kept)
        if self.own:
            found[0] = self.friction(gap, rate, slip, normal, kept)[1]
        if self._rate is not None:
            for k in range(self._z.size):
                found[self.own + k] = self._rate(k, gap, rate, slip, normal, *seen)
        return found

    def guards(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Give all guards."""
        seen, count = self._seen(kept), self.law.guards
        return np.array([self._guard(k, gap, rate, slip, normal, *seen) for k in range(count)])

    def jumped(self, event: int, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Give what is kept after an event."""
        after, seen = kept.copy(), self._seen(kept)
        if self._jump is not None:
            for k in range(self._z.size):
                after[self.own + k] = self._jump(k, event, gap, rate, slip, normal, *seen)
        return after

    def limits(self, kept: Array) -> Limits:
        """Give the gaps at which a contact begins and ends [m]."""
        begin, end = self._limits(*self._seen(kept)) if self._limits is not None else (0.0, 0.0)
        return float(begin), float(end)

    def solve(self, step: tuple[float, ...], length: float, impact: bool, kept: Array) -> Any:
        """Give the impulses [N s] and the mode of a rigid law for one of `drawn_steps`."""
        if not self._told:
            return self._solve(*step, self.row)
        self._seen(kept)
        return self._solve(*step, length, impact, self._z, self.row)
