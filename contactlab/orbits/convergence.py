"""What steps and tolerance of the solver do to a steady state: the same one at finer steps, and the rest."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, final

from contactlab.config import Setup
from contactlab.engine.simulation import DEFAULT_TOLERANCE
from contactlab.laws.base import MultiplierLaw
from contactlab.metrics.convergence import FINER, richardson
from contactlab.orbits.search import Steady, steady


@final
@dataclass(frozen=True)
class Converged:
    """A steady state at finer and finer steps.

    Args:
        control: what is refined, 'contact_step' of a rigid law or 'tolerance' of a compliant one.
        values: of it, coarsest first.
        steps: the steady states, in the same order.
    """

    control: str
    values: tuple[float, ...]
    steps: tuple[Steady, ...]

    @property
    def best(self) -> Steady:
        """The steady state at the finest step."""
        return self.steps[-1]

    def value(self, of: Callable[[Steady], tuple[float, float]]) -> tuple[float, float]:
        """Give a number at the finest step and its error, of discretisation and statistics together.

        Args:
            of: gives number and statistical error of a steady state, as `lambda each: each.velocity`.
        """
        found = [of(each) for each in self.steps]
        factor, order = self.values[0] / self.values[1], self.best.setup.law.convergence_order
        left = float(richardson([number for number, _ in found], factor, order))
        number, statistical = found[-1]
        return number, left + statistical

    @property
    def velocity(self) -> tuple[float, float]:
        """Mean rotor velocity and its error [rad/s]."""
        return self.value(lambda each: each.velocity)

    @property
    def torque(self) -> tuple[float, float]:
        """Mean torque of the contact on the rotor and its error [N m]."""
        return self.value(lambda each: each.torque)


def converged(setup: Setup, **arguments: Any) -> Converged:
    """Find a steady state at three steps: of a rigid law h, h/2, h/4; of a compliant one tolerance, /10, /100.

    Args:
        setup: as of `steady`; its contact step or tolerance is the coarsest.
        arguments: further ones of `steady`.

    Raises:
        What `steady` raises.
    """
    control = "contact_step" if isinstance(setup.law, MultiplierLaw) else "tolerance"
    values = tuple((getattr(setup, control) or DEFAULT_TOLERANCE) / divisor for divisor in FINER[control])
    steps = tuple(steady(replace(setup, **{control: value}), **arguments) for value in values)
    return Converged(control, values, steps)
