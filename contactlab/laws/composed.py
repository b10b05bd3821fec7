"""A compliant law composed of a normal force, a damping and a friction."""

from dataclasses import dataclass, field
from math import nan
from typing import Any, final

import numpy as np

from contactlab.arrays import Array
from contactlab.laws import composition
from contactlab.laws.base import Damping, Friction, NormalForce, PenaltyLaw
from contactlab.laws.damping import Undamped
from contactlab.laws.friction import Coulomb
from contactlab.laws.memory import InternalVariable, dependent
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
    friction_offset = _of_friction("friction_offset")
    friction_variable = _of_friction("friction_variable")
    friction_remembers = _of_friction("friction_remembers")
    exact_stick = _of_friction("exact_stick")
    violations = _of_friction("violations")

    def __post_init__(self) -> None:
        super().__post_init__()
        normal = self.normal
        if not self.damping.any_force and (normal.elastic is None or normal.allows_tension):
            raise ValueError(
                f"{self.name}: damping is {self.damping.name} and normal is {normal.name}; such a damping is "
                "solved for an elastic force that does not pull. Choose damping none or another normal force."
            )
        if self.friction.limits is not None:
            raise ValueError(
                f"{self.name}: friction is {self.friction.name}, which has limits; where a contact begins "
                "and ends is the normal force's. Give them to that."
            )

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

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """The friction's, then the normal force's."""
        return *self.friction.internal_variables, *self.normal.internal_variables

    @property
    def remembered(self) -> tuple[InternalVariable, ...]:
        """See `Remembering.remembered`."""
        return *self.friction.remembered, *self.normal.remembered

    @dependent
    def guards(self) -> int:
        """The friction's and the normal force's."""
        return self.friction.guards + self.normal.guards

    @dependent
    def allows_tension(self) -> bool:
        """Whether the normal force may pull."""
        return self.normal.allows_tension

    @dependent
    def convergence_order(self) -> float:
        """That of the part which has the lower one."""
        return min(self.friction.convergence_order, self.normal.convergence_order)

    @property
    def _plain(self) -> bool:
        """Whether it is an elastic force that never pulls, in Coulomb's cone or what replaces it."""
        special = self.normal.force, self.normal.limits, self.friction.bound
        return not self.remembered and all(each is None for each in special)

    @property
    def _spring(self) -> Any:
        limited = self.normal.limits is not None
        return composition.spring_of(self.normal.force, self.normal.elastic, limited)

    @property
    def force(self) -> Any:
        """See `PenaltyLaw.force`."""
        normal, friction, damped = self.normal, self.friction, self.damping.damped
        if self._plain:
            return composition.force_of(normal.elastic, damped, *self.places)
        bound = composition.bound_of(friction.bound, bool(friction.remembered))
        first = len(friction.remembered)
        made = composition.remembering_force(self._spring, damped, bound, *self.places, first)
        return made if self.remembered else composition.forgetful_force(made)

    @property
    def friction_force(self) -> Any:
        """See `PenaltyLaw.friction_force`; over a normal force with a memory of its own z is both."""
        state, place = self.friction.state, self.places[1]
        if state is None:
            return None
        if self._plain:
            return composition.friction_of(self.normal.elastic, state, place)
        first = len(self.friction.remembered)
        made = composition.remembering_friction(self._spring, state, not first, place, first)
        return made if self.remembered else composition.forgetful_friction(made)

    @property
    def rate(self) -> Any:
        """See `contactlab.laws.memory`."""
        return self._of_both(self.friction.rate, self.normal.rate, len(self.friction.remembered))

    @property
    def guard(self) -> Any:
        """See `contactlab.laws.memory`."""
        return self._of_both(self.friction.guard, self.normal.guard, self.friction.guards)

    @property
    def jump(self) -> Any:
        """See `contactlab.laws.memory`."""
        jumps = self.friction.jump, self.normal.jump
        if jumps == (None, None):
            return None
        first = len(self.friction.remembered)
        return composition.jump_of(self._spring, *jumps, self.friction.guards, self.places[1], first)

    @property
    def limits(self) -> Any:
        """See `contactlab.laws.memory`."""
        own, first = self.normal.limits, len(self.friction.remembered)
        remembers = bool(self.normal.remembered)
        return own and composition.limits_of(own, remembers, first, bool(self.remembered))

    def _of_both(self, of_friction: Any, of_normal: Any, count: int) -> Any:
        """Give the kernel of both parts' rates or guards; None where neither has any."""
        if not self.remembered or (of_friction, of_normal) == (None, None):
            return None
        place, first = self.places[1], len(self.friction.remembered)
        return composition.of_both(self._spring, of_friction, of_normal, count, place, first)
