"""A compliant law composed of a normal force, a damping and a friction."""

from dataclasses import dataclass, field
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import fleeting_kernel
from contactlab.laws.base import FrictionKernel, PenaltyKernel, PenaltyLaw
from contactlab.laws.damping import Undamped
from contactlab.laws.friction import Coulomb
from contactlab.laws.normal import HertzPoint
from contactlab.laws.part import Damping, Friction, NormalForce, Part

Array = NDArray[np.float64]

DAMPING, FRICTION, SIZE = 4, 8, 16
"""Where the parts' parameters begin in the law's; those of the normal force at 0."""


@final
@dataclass(frozen=True)
class Composed(PenaltyLaw):
    """Any normal force with any damping and any friction.

    Args:
        normal, damping, friction: the parts.
    """

    name: ClassVar[str] = "composed"
    equation: ClassVar[str] = "N of law/normal and law/damping, F of law/friction"
    source: ClassVar[str] = "that of its parts"
    default_contact_step: ClassVar[float] = 4e-6

    normal: NormalForce = field(default_factory=HertzPoint)
    damping: Damping = field(default_factory=Undamped)
    friction: Friction = field(default_factory=Coulomb)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The three parts."""
        return self.normal, self.damping, self.friction

    @property
    def friction_limit(self) -> float:
        """Largest |F|/N [1]."""
        return self.friction.friction_limit

    def describe(self) -> dict[str, float]:
        """The parts' parameters by their dotted names, SI."""
        return {
            f"{part.family}.{name}": value
            for part in self.parts
            for name, value in part.describe().items()
        }

    def parameters(self) -> Array:
        """What the kernels read, each part's from its own place on."""
        values = np.zeros(SIZE)
        coefficients = (
            (0, self.normal.coefficients()),
            (DAMPING, self.damping.coefficients(self.normal)),
            (FRICTION, self.friction.coefficients()),
        )
        for at, given in coefficients:
            values[at : at + len(given)] = given
        return values

    @property
    def friction_kind(self) -> int:  # type: ignore[override]
        """That of the friction."""
        return self.friction.friction_kind

    @property
    def force(self) -> PenaltyKernel:
        """The kernel; see `PenaltyLaw.force`."""
        elastic_of: Any = self.normal.elastic
        damped_of: Any = self.damping.damped
        bound_of: Any = self.friction.bound

        def composed_force(
            gap: float, gap_rate: float, slip: float, approach: float, parameters: Array
        ) -> tuple[float, float, float, float]:
            elastic, stored, _, _ = elastic_of(max(-gap, 0.0), parameters, 0)
            normal = damped_of(elastic, -gap_rate, approach, parameters, DAMPING)
            bound = bound_of(normal, slip, parameters, FRICTION)
            return normal, bound, stored, (elastic - normal) * gap_rate

        return fleeting_kernel(composed_force)

    @property
    def rub(self) -> FrictionKernel | None:
        """The kernel; see `PenaltyLaw.rub`."""
        elastic_of: Any = self.normal.elastic
        state_of: Any = self.friction.state
        if state_of is None:
            return None

        def composed_friction(
            gap: float,
            gap_rate: float,
            slip: float,
            normal: float,
            memory: float,
            parameters: Array,
        ) -> tuple[float, float, float, float]:
            _, _, stiffness, slope = elastic_of(max(-gap, 0.0), parameters, 0)
            rate = -slope * gap_rate
            return state_of(normal, stiffness, rate, slip, memory, parameters, FRICTION)  # type: ignore[no-any-return]

        return fleeting_kernel(composed_friction)
