"""What a contact law is, and a part of a composed one: frozen parameters and compiled scalar kernels.

A law never sees a mode shape. It is given the state of one contact with a normal and a tangential
direction (signs in `contactlab.motor.geometry`) and gives back a force or an impulse.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from numba import types

from contactlab.arrays import Array
from contactlab.laws.declaration import FRICTION_COEFFICIENT, Declared
from contactlab.laws.memory import InternalVariable, Remembering

FREE, SLIP, STICK = 0, 1, 2
"""Contact modes, as recorded."""

SET_VALUED, ELASTOPLASTIC, RATE_DEPENDENT = 0, 1, 2
"""Kinds of friction: stick without any slip; a spring that a slider ends (a Jenkins element); a force that
the slip and the internal variable determine."""

_real = types.float64
_parameters = types.Array(types.float64, 1, "C", readonly=True)

PENALTY_SIGNATURE = types.UniTuple(_real, 4)(*[_real] * 4, _parameters)
FRICTION_SIGNATURE = types.UniTuple(_real, 4)(*[_real] * 5, _parameters)
MULTIPLIER_SIGNATURE = types.Tuple((_real, _real, types.int64))(*[_real] * 7, _parameters)

Forces = tuple[float, float, float, float]
PenaltyKernel = Callable[..., Forces]
FrictionKernel = Callable[..., Forces]
MultiplierKernel = Callable[..., tuple[float, float, int]]
"""Kernels of a law; what they are called with hangs on whether it remembers."""


class Tangential(Remembering):
    """What a law, or the friction of a composed one, says of its tangential direction."""

    friction_kind: ClassVar[int] = SET_VALUED
    """SET_VALUED; ELASTOPLASTIC, where |F| is held inside the bound; or RATE_DEPENDENT, without a bound."""
    convergence_order: ClassVar[float] = 1.0
    """Order at which the error falls with the contact step of a rigid law, the tolerance of a compliant."""
    exact_stick: ClassVar[bool] = True
    """Whether contact that sticks has no slip at all; else it creeps or chatters."""
    violations: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Claims of `contactlab.testing.LawContract` that this law breaks, each with the reason why."""

    @property
    def friction_limit(self) -> float:
        """Largest |F|/N that it allows [1]: mu mu_s/mu of its fields, unless it says otherwise."""
        mu = float(getattr(self, "friction_coefficient", 0.0))
        return mu * float(getattr(self, "static_ratio", 1.0))

    @property
    def friction_offset(self) -> float:
        """Force C [N] that widens the cone by cohesion: |F| <= friction_limit (N + C)."""
        return 0.0

    @property
    def friction_remembers(self) -> bool:
        """Whether the kernel of its friction has internal variables as an array and gives no rate."""
        return bool(self.remembered)

    @property
    def friction_variable(self) -> InternalVariable | None:
        """The one variable that the friction's own kernel flows, where there is no `rate` and no `jump`."""
        return self.internal_variables[0] if self.internal_variables and not self.remembered else None


class ContactLaw(Declared, Tangential):
    """A contact law. Subclass one of the two families; `contactlab.testing` checks what it declares.

    >>> import contactlab as cl
    >>> law = cl.law("hertz_penalty", stiffness=2e10)
    >>> law.name, law.equation, isinstance(law, cl.PenaltyLaw)
    ('hertz_penalty', 'N = K max(-g, 0)^1.5, |F| <= mu N, F = -mu N sign(v) where v != 0', True)
    """

    WORDS = ("name", "equation", "source", "default_contact_step")

    default_contact_step: ClassVar[float]
    """Step in contact [s] where the configuration gives none."""
    allows_tension: ClassVar[bool] = False
    """Whether the normal force may pull."""

    @property
    def title(self) -> str:
        """What tells the law from others that are made alike."""
        return self.name

    def parameters(self) -> Array:
        """Give what the kernel receives, shape (parameter,), SI: the fields in their order, NaN for None."""
        values = [getattr(self, f.name) for f in fields(self)]  # type: ignore[arg-type]
        return np.array(values, dtype=np.float64)

    def on_rotor(self, radius: float) -> Self:
        """Give the law with what follows from the radius of the rotor [m]; every run asks for it."""
        return self


class PenaltyLaw(ContactLaw):
    """A compliant law: force from gap, gap rate and slip of bodies that interpenetrate.

    Set-valued friction needs nothing but `force`, which gives its bound. Any other says so in
    `friction_kind` and has a second kernel, `friction_force`.

        >>> from dataclasses import dataclass
        >>> from typing import Annotated
        >>> import contactlab as cl
        >>> @dataclass(frozen=True)
        ... class Spring(cl.PenaltyLaw):
        ...     name = "spring"
        ...     equation = "N = k d"
        ...     source = "Hooke (1678)"
        ...     default_contact_step = 4e-6
        ...     stiffness: Annotated[float, cl.Parameter("k", "N m-1", "stiffness", above=0.0)] = 1e7
        ...     @staticmethod
        ...     def force(gap, gap_rate, slip, approach, parameters):
        ...         normal = -parameters[0] * gap
        ...         return normal, 0.0, -0.5 * normal * gap, 0.0
        ...
        >>> Spring(1e7).force(-2e-6, 0.0, 0.0, 0.0, (1e7,))[0]
        20.0
    """

    @property
    @abstractmethod
    def force(self) -> PenaltyKernel:
        """The kernel, a static method as a rule.

            force(gap, gap_rate, slip, impact_speed, parameters)
            force(gap, gap_rate, slip, impact_speed, z, parameters)     with internal variables
                -> normal force N [N], friction bound [N], stored energy [J], normal loss [W]

        Called for gap < 0 only [m], or below the end of its `limits`, gap_rate [m/s], slip [m/s]; the slip
        is exactly zero where the contact sticks, so that a bound may have a static and a kinetic value.
        impact_speed is the approach at which the contact began [m/s], zero where it was pressed together.
        Set-valued friction: the engine finds |F| <= bound in stick and F = -bound sign(slip) in slip. The
        stored energy V makes N = -dV/dgap + (a part whose power -(N + dV/dgap) gap_rate is the normal loss);
        where internal variables flow, dV/dz dz/dt is taken from that loss.
        """

    @property
    def friction_force(self) -> FrictionKernel | None:
        """The kernel of friction that is not set-valued, else None.

            friction_force(gap, gap_rate, slip, normal, z, parameters)
                -> friction F [N], rate of z, stored energy [J], tangential stiffness [N/m]

        normal is the normal force [N], z the one internal variable, a number. ELASTOPLASTIC friction has
        the stretch of its spring there [m], F = -stiffness z; the engine calls this while it holds, and in
        slip keeps F on the bound and z with it. In RATE_DEPENDENT friction z may be anything; the stiffness
        is not read. With z an array, see `contactlab.laws.memory`, the friction is RATE_DEPENDENT and the
        kernel gives three numbers: the rates are those of `rate`.
        """
        return None

    @property
    def moment(self) -> Any:
        """The kernel of the moments that a patch of some extent has, else None.

            moment(tilt, spin, gap, normal, parameters)     z before the parameters as in `force`
                -> moment against tilt [N m], moment against spin [N m], stored energy [J]

        tilt is the angle of the tip to the rotor's tangent [rad], spin thdot - Omega [rad/s]; both moments
        turn the tip as th grows. One against tilt shifts the pressure, which is normal to the rotor and does
        not turn it; one against spin turns the rotor the other way. Their power is that of tilt rate and
        spin; what they do not store is lost as friction.
        """
        return None


class MultiplierLaw(ContactLaw):
    """A rigid law: holds the gap at zero by the impulse of one step.

    >>> import contactlab as cl
    >>> law = cl.Newton(friction_coefficient=0.3, restitution=0.5)
    >>> isinstance(law, cl.MultiplierLaw), law.default_contact_step
    (True, 5e-08)
    """

    projects: ClassVar[bool] = True
    """Whether displacements are put back onto the closed gap after every step, as the paper's index-2
    corrector does, and the last step is shortened to the release; else the constraint is one of
    velocities only, the contact may penetrate by O(step), and it lasts until the gap is open."""
    told: ClassVar[bool] = False
    """Whether `solve` is told of step, impact and memory; one with internal variables has to be."""

    @property
    @abstractmethod
    def solve(self) -> MultiplierKernel:
        """The kernel, a static method as a rule.

            solve(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters)
                -> normal impulse [N s], friction impulse [N s], mode

        normal_rate and tangential_rate are gap rate and slip at the end of the step without
        contact [m/s]; gap_rate and slip are those of its start [m/s], where the gap rate is that of
        the approach in an impact and zero but for round-off while a contact lasts; d is the symmetric
        2x2 Delassus matrix [1/kg] of the step. With impulses p the step ends with
        normal_rate + d_nn p_n + d_nt p_t and tangential_rate + d_nt p_n + d_tt p_t. The mode is SLIP or
        STICK. A normal impulse that is not positive means release.

        A law that is `told` more has

            solve(normal_rate, ..., d_tt, step, impact, z, parameters)

        with the length of the step [s], whether it is that of an impact, and the internal variables. Those
        flow with the mean force of the step.
        """


class NormalForce(Declared, Remembering):
    """A part of a composed law: a normal force of the penetration d >= 0, elastic or with a memory.

    The kernel of a part reads its coefficients, as many as they are, from the place `at` of the law's array.
    It has `elastic`, or where it has internal variables `force`.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> part = cl.Linear(stiffness=2e7)
        >>> force, energy, stiffness, slope = part.elastic(1e-6, np.array(part.coefficients()), 0)
        >>> cl.Composed(normal=part).title, float(force)
        ('composed of normal linear, damping none, friction coulomb', 20.0)
    """

    family: ClassVar[str] = "normal"
    allows_tension: ClassVar[bool] = False
    """Whether it may pull."""
    convergence_order: ClassVar[float] = 1.0
    """As of a law: less where the force jumps, which coarse tolerances do not see."""

    def coefficients(self) -> tuple[float, ...]:
        """Give what the kernel reads: the fields in their order, unless something follows from them."""
        return tuple(self.describe().values())

    @property
    def elastic(self) -> Any:
        """The kernel of an elastic force, else None.

        elastic(depth, parameters, at)
            -> force [N], stored energy [J], stiffness dN/dd [N/m], its slope d2N/dd2 [N/m^2]
        """
        return None

    @property
    def force(self) -> Any:
        """The kernel of a force with internal variables, else None.

        force(depth, depth_rate, z, parameters, at)
            -> force [N], stored energy [J], stiffness [N/m], its slope [N/m^2], loss [W]

        Stiffness and slope are those at constant z.
        """
        return None


class Damping(Declared):
    """A part of a composed law: what the elastic force becomes while the bodies move.

    >>> import contactlab as cl
    >>> law = cl.Composed(damping=cl.HuntCrossley(restitution=0.7, impact_speed=0.1))
    >>> after = cl.impact(law, [[1 / 2e-3, 0.0], [0.0, 3.5 / 2e-3]], [-0.1, 0.0])["velocity_after"]
    >>> f"{after.values[0, 0]:.4f} m/s"
    '0.0700 m/s'
    """

    family: ClassVar[str] = "damping"
    any_force: ClassVar[bool] = True
    """Whether it may act on a normal force that pulls, or that has a memory and losses of its own."""

    @abstractmethod
    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """Give what the kernel reads, solved for an elastic force."""

    @property
    @abstractmethod
    def damped(self) -> Any:
        """The kernel.

        damped(elastic, depth_rate, impact_speed, parameters, at) -> normal force [N]

        depth_rate is the rate of the penetration, impact_speed its value at the touch-down [m/s].
        """


@dataclass(frozen=True)
class Friction(Declared, Tangential):
    """A part of a composed law: set-valued friction needs nothing but its cone, any other a kernel too.

    Where static friction is larger than kinetic it has a field `static_ratio`, mu_s / mu.

        >>> import contactlab as cl
        >>> friction = cl.Stribeck(0.25, static_ratio=2.0)
        >>> friction.friction_limit, friction.exact_stick
        (0.5, True)
    """

    family: ClassVar[str] = "friction"

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    def coefficients(self) -> tuple[float, ...]:
        """Give what the kernels read: mu, mu_s / mu, and the other fields in their order."""
        given = self.describe()
        first = given.pop("friction_coefficient"), given.pop("static_ratio", 1.0)
        return *first, *given.values()

    @property
    def bound(self) -> Any:
        """The kernel of a bound that is no cone of constant coefficients, else None.

        bound(normal, slip, parameters, at) -> largest friction [N]

        The slip is exactly zero in stick. With internal variables z comes before the parameters.
        """
        return None

    @property
    def state(self) -> Any:
        """The kernel of friction that is not set-valued, else None.

        state(normal, stiffness, stiffness_rate, slip, z, parameters, at)
            -> friction [N], rate of z, stored energy [J], tangential stiffness [N/m]

        z is the internal variable; stiffness is that of the normal force [N/m], and its rate in
        time [N m^-1 s^-1]. With z an array it gives three numbers, without the rate.
        """
        return None


Part = NormalForce | Damping | Friction
