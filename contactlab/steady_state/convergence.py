"""Discretisation error of a steady state, from three contact steps or tolerances."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from contactlab.config import Setup
from contactlab.engine.preparation import DEFAULT_TOLERANCE
from contactlab.estimate import Estimate
from contactlab.laws import ContactLaw
from contactlab.metrics.convergence import FINER, control_of, richardson
from contactlab.motor import Motor
from contactlab.steady_state.search import Steady, steady, steady_setup


@final
@dataclass(frozen=True)
class Converged:
    """A steady state at three steps or tolerances.

        >>> import contactlab as cl
        >>> found = cl.converged(cl.build(["law=hertz_penalty"])).details
        >>> found.control, len(found.steps)
        ('tolerance', 3)
        >>> f"{found.best.velocity.value:.5f} rad/s"
        '-2.19111 rad/s'

    Args:
        control: what is refined, 'contact_step' of a rigid law or 'tolerance' of a compliant one.
        values: of it, coarsest first.
        steps: the steady states, in the same order.
    """

    control: str
    values: tuple[float, ...]
    steps: tuple[Steady, ...]

    def __repr__(self) -> str:
        return f"<Converged: {self.best.kind}, {self.velocity.text()} rad/s over {self.control}>"

    @property
    def best(self) -> Steady:
        """The steady state at the finest step."""
        return self.steps[-1]

    def value(self, of: Callable[[Steady], tuple[float, float]]) -> Estimate:
        """Return a number at the finest step and its error, of discretisation and statistics together.

        Args:
            of: gives number and statistical error of a steady state, as `lambda each: each.velocity`.
        """
        numbers, statistical = np.transpose([of(each) for each in self.steps])
        left = float(np.ptp(numbers))
        # What statistics blur has no order to be seen, and a single step none at all.
        if numbers.size > 2 and left > np.nan_to_num(statistical).max():
            order = self.best.setup.law.convergence_order
            left = float(richardson(numbers, self.values[0] / self.values[1], order))
        return Estimate(float(numbers[-1]), left + float(statistical[-1]))

    @property
    def velocity(self) -> Estimate:
        """Mean rotor velocity and its error [rad/s]."""
        return self.value(lambda each: each.velocity)

    @property
    def torque(self) -> Estimate:
        """Mean torque of the contact on the rotor and its error [N m]."""
        return self.value(lambda each: each.torque)


def converged(
    motor: Motor | Setup, law: ContactLaw | None = None, *, refine: bool = True, **arguments: Any
) -> Converged:
    """Compute a steady state at three steps, each from the one before it.

    A rigid law takes contact steps h, h/2, h/4, a compliant one its tolerance, a tenth and a hundredth of it.

    Args:
        motor, law: as of `steady`; the contact step or tolerance is the coarsest.
        refine: False computes the coarsest alone, without a discretisation error.
        arguments: further ones of `steady`.

    Raises:
        NoPeriodError, NotSettledError, BrokenOffError: as of `contactlab.steady`.
    """
    coarsest = {name: arguments.pop(name) for name in FINER if name in arguments}
    setup = steady_setup(motor, law, **coarsest)
    control = control_of(setup.law)
    divisors = FINER[control] if refine else (1.0,)
    values = tuple((getattr(setup, control) or DEFAULT_TOLERANCE) / divisor for divisor in divisors)
    steps: list[Steady] = []
    for value in values:
        finer: dict[str, Any] = arguments | {control: value}
        steps.append(steady(setup, **finer))
        arguments["start"] = steps[-1]
    return Converged(control, values, tuple(steps))
