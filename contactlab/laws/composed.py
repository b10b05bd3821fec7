"""A compliant law composed of a normal force, a damping and a friction."""

from dataclasses import dataclass, field
from functools import cache
from math import nan
from typing import Any, final

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import fleeting_kernel
from contactlab.laws.base import Damping, Friction, NormalForce, PenaltyLaw
from contactlab.laws.damping import Undamped
from contactlab.laws.friction import Coulomb, cone_bound
from contactlab.laws.normal import HertzPoint


def _of_friction(name: str) -> Any:
    """Give a property that is the friction's."""
    return property(lambda law: getattr(law.friction, name), doc="That of the friction.")


@final
@dataclass(frozen=True)
class Composed(PenaltyLaw):
    """Any normal force with any damping and any friction."""

    name = "composed"
    equation = "N of law/normal and law/damping, F of law/friction"
    source = "that of its parts"
    default_contact_step = 4e-6

    normal: NormalForce = field(default_factory=HertzPoint)
    damping: Damping = field(default_factory=Undamped)
    friction: Friction = field(default_factory=Coulomb)

    friction_kind = _of_friction("friction_kind")
    friction_limit = _of_friction("friction_limit")
    internal_variables = _of_friction("internal_variables")
    internal_parity = _of_friction("internal_parity")
    exact_stick = _of_friction("exact_stick")
    convergence_order = _of_friction("convergence_order")
    violations = _of_friction("violations")

    @property
    def title(self) -> str:
        """The names of the parts."""
        parts = self.normal, self.damping, self.friction
        return f"{self.name} of {', '.join(f'{part.family} {part.name}' for part in parts)}"

    @property
    def coefficients(self) -> tuple[tuple[float, ...], ...]:
        """What the kernels of the parts read, with no number between those of one and the next."""
        normal, damping = self.normal.coefficients(), self.damping.coefficients(self.normal)
        return (*normal, nan), (*damping, nan), self.friction.coefficients()

    def parameters(self) -> Array:
        """Give the coefficients of the parts in their order."""
        return np.concatenate(self.coefficients)

    @property
    def places(self) -> tuple[int, int]:
        """Where the coefficients of damping and friction begin among them."""
        normal, damping, _ = map(len, self.coefficients)
        return normal, normal + damping

    @property
    def force(self) -> Any:
        """See `PenaltyLaw.force`."""
        return _force_of(self.normal.elastic, self.damping.damped, *self.places)

    @property
    def friction_force(self) -> Any:
        """See `PenaltyLaw.friction_force`."""
        state = self.friction.state
        return state and _friction_of(self.normal.elastic, state, self.places[1])


# The kernels of a composition depend on how many coefficients its parts have, and not on their values: one
# compilation serves a whole sweep.
@cache
def _force_of(elastic: Any, damped: Any, damping: int, friction: int) -> Any:
    def composed_force(gap, gap_rate, slip, impact_speed, parameters):
        spring, stored, _, _ = elastic(max(-gap, 0.0), parameters, 0)
        normal = damped(spring, -gap_rate, impact_speed, parameters, damping)
        bound = cone_bound(normal, slip, parameters, friction)
        return normal, bound, stored, (spring - normal) * gap_rate

    return fleeting_kernel(composed_force)


@cache
def _friction_of(elastic: Any, state: Any, friction: int) -> Any:
    def composed_friction(gap, gap_rate, slip, normal, z, parameters):
        _, _, stiffness, slope = elastic(max(-gap, 0.0), parameters, 0)
        rate = -slope * gap_rate
        return state(normal, stiffness, rate, slip, z, parameters, friction)

    return fleeting_kernel(composed_friction)
