"""What a composed law is made of: a normal force, a damping and a friction, each a few lines.

A part is an immutable dataclass like a law. Its kernel reads its coefficients, as many as they are, from
the law's array, from the place `at` on.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from contactlab.laws.base import ODD, SET_VALUED
from contactlab.laws.parameter import check_parameters
from contactlab.laws.soundness import refuse_unsound

Array = NDArray[np.float64]

ElasticKernel = Callable[[float, Array, int], tuple[float, float, float, float]]
DampedKernel = Callable[[float, float, float, Array, int], float]
StateKernel = Callable[
    [float, float, float, float, float, Array, int], tuple[float, float, float, float]
]

PART_WORDS = ("family", "name", "equation", "source")
"""What every part says of itself."""


class Part(ABC):
    """A part of a composed law: an immutable dataclass whose fields are its parameters in SI units.

    Raises:
        TypeError: a parameter that is no number, or a class that is no dataclass or lacks a word.
        ValueError: a parameter outside of its range.
    """

    family: ClassVar[str]
    """Which part of a law it is: the word of its configuration group."""
    name: ClassVar[str]
    """The part's word among its family."""
    equation: ClassVar[str]
    """The part in one line."""
    source: ClassVar[str]
    """Where it is published."""

    def __init__(self, *given: object, **named: object) -> None:
        # A dataclass has its own: this one is reached where the decorator is missing.
        refuse_unsound(type(self), PART_WORDS)

    def __post_init__(self) -> None:
        refuse_unsound(type(self), PART_WORDS)
        check_parameters(self)

    def describe(self) -> dict[str, float]:
        """The parameters by name, SI."""
        return {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]


class NormalForce(Part):
    """An elastic normal force of the penetration d >= 0."""

    family: ClassVar[str] = "normal"

    def coefficients(self) -> tuple[float, ...]:
        """What the kernel reads: the fields in their order, unless something follows from them."""
        return tuple(self.describe().values())

    @property
    @abstractmethod
    def elastic(self) -> ElasticKernel:
        """The compiled kernel.

        elastic(depth, parameters, at)
            -> force [N], stored energy [J], stiffness dN/dd [N/m], its slope d2N/dd2 [N/m^2]
        """


class Damping(Part):
    """A normal loss: what the elastic force becomes while the bodies move."""

    family: ClassVar[str] = "damping"

    @abstractmethod
    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """What the kernel reads, solved for an elastic force."""

    @property
    @abstractmethod
    def damped(self) -> DampedKernel:
        """The compiled kernel.

        damped(elastic, closing_rate, approach, parameters, at) -> normal force [N]

        closing_rate is the rate of the penetration, approach its value at the touch-down [m/s].
        """


class Friction(Part):
    """A tangential law. Set-valued friction needs nothing but its cone; any other a kernel with memory too.

    Subclasses have a field `friction_coefficient`, and `static_ratio` where they tell static friction.
    """

    family: ClassVar[str] = "friction"
    friction_kind: ClassVar[int] = SET_VALUED
    exact_stick: ClassVar[bool] = True
    convergence_order: ClassVar[float] = 1.0
    internal_variables: ClassVar[tuple[str, ...]] = ()
    internal_parity: ClassVar[int] = ODD
    violations: ClassVar[Mapping[str, str]] = MappingProxyType({})
    friction_coefficient: float

    @property
    def friction_limit(self) -> float:
        """Largest |F|/N [1]."""
        return self.friction_coefficient * float(getattr(self, "static_ratio", 1.0))

    def coefficients(self) -> tuple[float, ...]:
        """What the kernels read: mu, mu_s / mu, and the other fields in their order."""
        given = self.describe()
        first = given.pop("friction_coefficient"), given.pop("static_ratio", 1.0)
        return *first, *given.values()

    @property
    def state(self) -> StateKernel | None:
        """The compiled kernel of friction that has a memory, or creeps; None for set-valued friction.

        state(normal, stiffness, stiffness_rate, slip, memory, parameters, at)
            -> friction [N], rate of the memory, stored energy [J], tangential stiffness [N/m]

        stiffness is that of the elastic normal force [N/m], and its rate in time [N m^-1 s^-1].
        """
        return None
