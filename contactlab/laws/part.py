"""What a composed law is made of: a normal force, a damping and a friction, each a few lines.

A part is an immutable dataclass like a law. Its kernel reads its coefficients, as many as they are, from
the law's array, from the place `at` on.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from contactlab.arrays import Array
from contactlab.laws.base import Forces, Tangential
from contactlab.laws.declaration import Declared

ElasticKernel = Callable[[float, Array, int], Forces]
DampedKernel = Callable[[float, float, float, Array, int], float]
StateKernel = Callable[[float, float, float, float, float, Array, int], Forces]


class NormalForce(Declared):
    """An elastic normal force of the penetration d >= 0."""

    family: ClassVar[str] = "normal"

    def coefficients(self) -> tuple[float, ...]:
        """Give what the kernel reads: the fields in their order, unless something follows from them."""
        return tuple(self.describe().values())

    @property
    @abstractmethod
    def elastic(self) -> ElasticKernel:
        """The kernel.

        elastic(depth, parameters, at)
            -> force [N], stored energy [J], stiffness dN/dd [N/m], its slope d2N/dd2 [N/m^2]
        """


class Damping(Declared):
    """A normal loss: what the elastic force becomes while the bodies move."""

    family: ClassVar[str] = "damping"

    @abstractmethod
    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """Give what the kernel reads, solved for an elastic force."""

    @property
    @abstractmethod
    def damped(self) -> DampedKernel:
        """The kernel.

        damped(elastic, depth_rate, impact_speed, parameters, at) -> normal force [N]

        depth_rate is the rate of the penetration, impact_speed its value at the touch-down [m/s].
        """


class Friction(Declared, Tangential):
    """A tangential law. Set-valued friction needs nothing but its cone; any other a kernel too.

    Subclasses have a field `friction_coefficient`, and `static_ratio` where they tell static friction.
    """

    family: ClassVar[str] = "friction"

    def coefficients(self) -> tuple[float, ...]:
        """Give what the kernels read: mu, mu_s / mu, and the other fields in their order."""
        given = self.describe()
        first = given.pop("friction_coefficient"), given.pop("static_ratio", 1.0)
        return *first, *given.values()

    @property
    def state(self) -> StateKernel | None:
        """The kernel of friction that is not set-valued, else None.

        state(normal, stiffness, stiffness_rate, slip, z, parameters, at)
            -> friction [N], rate of z, stored energy [J], tangential stiffness [N/m]

        z is the internal variable; stiffness is that of the elastic normal force [N/m], and its rate in
        time [N m^-1 s^-1].
        """
        return None


Part = NormalForce | Damping | Friction
