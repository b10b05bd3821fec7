"""A compliant law composed of a normal force, a damping and a friction."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import fleeting_kernel
from contactlab.laws.base import FrictionKernel, PenaltyKernel, PenaltyLaw
from contactlab.laws.damping import Undamped
from contactlab.laws.friction import Coulomb
from contactlab.laws.friction.cone import cone_bound
from contactlab.laws.normal import HertzPoint
from contactlab.laws.part import Damping, Friction, NormalForce, Part
from contactlab.parameter import Parameter, parameters_of

Array = NDArray[np.float64]

GUARD = (np.nan,)
"""Stands behind the coefficients of each part: a kernel that reads past its own finds no number."""


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
    def title(self) -> str:
        """The names of the parts."""
        return f"{self.name} of {', '.join(f'{part.family} {part.name}' for part in self.parts)}"

    @property
    def parts(self) -> tuple[Part, ...]:
        """The three parts."""
        return self.normal, self.damping, self.friction

    @property
    def coefficients(self) -> tuple[tuple[float, ...], ...]:
        """What the kernels of the parts read."""
        return (
            self.normal.coefficients(),
            self.damping.coefficients(self.normal),
            self.friction.coefficients(),
        )

    @property
    def places(self) -> tuple[int, int]:
        """Where the coefficients of damping and friction begin in the law's."""
        normal, damping, _ = map(len, self.coefficients)
        return normal + len(GUARD), normal + damping + 2 * len(GUARD)

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

    def declared(self) -> dict[str, Parameter]:
        """What the parts say of their parameters, by the same names."""
        return {
            f"{part.family}.{name}": parameter
            for part in self.parts
            for name, parameter in parameters_of(type(part)).items()
        }

    def changed(self, name: str, value: float) -> "Composed":
        """See `ContactLaw.changed`."""
        family, _, parameter = name.partition(".")
        part: Any = getattr(self, family)
        changed: Any = {family: replace(part, **{parameter: value})}
        return replace(self, **changed)

    def parameters(self) -> Array:
        """What the kernels read: the coefficients of the parts in their order, a guard behind each."""
        normal, damping, friction = self.coefficients
        return np.array([*normal, *GUARD, *damping, *GUARD, *friction], dtype=np.float64)

    @property
    def friction_kind(self) -> int:  # type: ignore[override]
        """That of the friction."""
        return self.friction.friction_kind

    @property
    def internal_variables(self) -> tuple[str, ...]:  # type: ignore[override]
        """That of the friction."""
        return self.friction.internal_variables

    @property
    def internal_parity(self) -> int:  # type: ignore[override]
        """That of the friction."""
        return self.friction.internal_parity

    @property
    def exact_stick(self) -> bool:  # type: ignore[override]
        """That of the friction."""
        return self.friction.exact_stick

    @property
    def convergence_order(self) -> float:  # type: ignore[override]
        """That of the friction."""
        return self.friction.convergence_order

    @property
    def violations(self) -> Mapping[str, str]:  # type: ignore[override]
        """Those of the friction."""
        return self.friction.violations

    @property
    def force(self) -> PenaltyKernel:
        """The kernel; see `PenaltyLaw.force`."""
        return _force_of(self.normal.elastic, self.damping.damped, *self.places)

    @property
    def friction_force(self) -> FrictionKernel | None:
        """The kernel; see `PenaltyLaw.rub`."""
        state = self.friction.state
        return None if state is None else _friction_of(self.normal.elastic, state, self.places[1])


# The kernels of a composition depend on how many coefficients its parts have, and not on their values: one
# compilation serves a whole sweep.
@cache
def _force_of(elastic: Any, damped: Any, damping: int, friction: int) -> PenaltyKernel:
    def composed_force(
        gap: float, gap_rate: float, slip: float, approach: float, parameters: Array
    ) -> tuple[float, float, float, float]:
        spring, stored, _, _ = elastic(max(-gap, 0.0), parameters, 0)
        normal = damped(spring, -gap_rate, approach, parameters, damping)
        return (
            normal,
            cone_bound(normal, slip, parameters, friction),
            stored,
            (spring - normal) * gap_rate,
        )

    return fleeting_kernel(composed_force)


@cache
def _friction_of(elastic: Any, state: Any, friction: int) -> FrictionKernel:
    def composed_friction(
        gap: float, gap_rate: float, slip: float, normal: float, memory: float, parameters: Array
    ) -> tuple[float, float, float, float]:
        _, _, stiffness, slope = elastic(max(-gap, 0.0), parameters, 0)
        return state(  # type: ignore[no-any-return]
            normal, stiffness, -slope * gap_rate, slip, memory, parameters, friction
        )

    return fleeting_kernel(composed_friction)
