"""Contact laws and parts of a composed law: frozen parameters and compiled scalar kernels.

A law never sees a mode shape. Its kernels map the state of one contact with a normal and a tangential
direction (signs in `contactlab.motor.geometry`) to a force or an impulse.

A kernel is a static method whose argument names say what it needs, in any order:

* coefficients: the fields of the class, or what `coefficients` derives from them;
* internal variables by their names, see `contactlab.laws.memory`;
* quantities of the contact. Compliant: gap and depth = -gap [m], gap_rate and depth_rate [m/s], slip [m/s],
  impact_speed [m/s], the approach at which the contact began (zero where it was pressed together);
  once the normal force is known also normal [N]. Frictions of a composed law have besides
  normal_stiffness = dN/dd [N/m] and its rate normal_stiffness_rate [N m^-1 s^-1], its dampings elastic_force
  [N], elastic_energy [J] and elastic_stiffness [N/m]. Rigid: see `MultiplierLaw.impact` and
  `MultiplierLaw.bound`;
* z and parameters, the internal variables and the coefficients as arrays, where their number varies.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Self

from contactlab.compiler.kernels import kernel
from contactlab.laws.declaration import FRICTION_COEFFICIENT, Coefficient, Declared, LawError
from contactlab.laws.memory import Remembering

FREE, SLIP, STICK = 0, 1, 2
"""Contact modes, as recorded."""

SET_VALUED, ELASTOPLASTIC, RATE_DEPENDENT = 0, 1, 2
"""Kinds of friction: stick without any slip; a spring that a slider ends (a Jenkins element); a force that
the slip and the internal variable determine."""

Kernel = Callable[..., Any]
"""A kernel of a law or a part: a scalar function that names what it needs, see the module."""


@kernel
def cone(normal: float, slip: float, friction_coefficient: float, static_ratio: float) -> float:
    """Return the bound of Coulomb's cone [N]: mu_s N in stick, where the slip [m/s] is exactly zero, else mu
    N.

    A pull N < 0 gives no friction.
    """
    ratio = static_ratio if slip == 0.0 else 1.0
    return float(friction_coefficient * ratio * max(normal, 0.0))


@kernel
def coulomb(normal: float, friction_coefficient: float) -> float:
    """Return the bound of Coulomb's cone with one coefficient [N]."""
    return float(friction_coefficient * max(normal, 0.0))


class Tangential(Remembering):
    """What a law, or the friction of a composed one, says of its tangential direction."""

    friction_kind: ClassVar[int] = SET_VALUED
    """SET_VALUED; ELASTOPLASTIC, where |F| is held inside the bound; or RATE_DEPENDENT, without a bound."""
    convergence_order: ClassVar[float] = 1.0
    """Order at which the error falls with the contact step of a rigid law, the tolerance of a compliant."""
    keeps_tolerance: ClassVar[bool] = True
    """Whether errors are within a hundred times the tolerance, and what a run states of them; else the run
    says that they are not."""
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
    def coupled(self) -> int:
        """Number of internal variables that are solved together with the friction, 0 or 1.

        Without a kernel `rate` or `jump` the friction's own kernel returns the rate of the only one.
        """
        return int(bool(self.internal_variables) and self.rate is None and self.jump is None)


class ContactLaw(Declared, Tangential):
    """A contact law. Subclass one of the two families; `contactlab.testing` checks what it declares.

    >>> import contactlab as cl
    >>> law = cl.law("hertz_penalty", stiffness=2e10)
    >>> law.name, law.equation, isinstance(law, cl.PenaltyLaw)
    ('hertz_penalty', 'N = K max(-g, 0)^1.5, |F| <= mu N, F = -mu N sign(v) where v != 0', True)
    """

    WORDS = ("name", "equation", "source", "default_contact_step")

    default_contact_step: ClassVar[float]
    """Longest step in contact [s] where the configuration gives none; of a rigid law in time stepping."""
    allows_tension: ClassVar[bool] = False
    """Whether the normal force may pull."""

    @property
    def title(self) -> str:
        """What tells the law from others that are made alike."""
        return self.name

    def on_rotor(self, radius: float) -> Self:
        """Return the law with what follows from the radius of the rotor [m]; every run asks for it."""
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
        ...     def force(depth, stiffness):
        ...         normal = stiffness * depth
        ...         return normal, 0.0, 0.5 * normal * depth, 0.0
        ...
        >>> Spring(1e7).force(2e-6, 1e7)[0]
        20.0
    """

    @property
    @abstractmethod
    def force(self) -> Kernel:
        """The kernel of the normal force, a static method as a rule.

            force(...) -> normal force N [N], friction bound [N], stored energy [J], normal loss [W]

        Evaluated in contact only, for a gap below the end of its `limits` (zero without); the slip is exactly
        zero where the contact sticks, so that a bound may have a static and a kinetic value. Set-valued
        friction: the engine finds |F| <= bound in stick and F = -bound sign(slip) in slip. The stored energy
        V makes N = -dV/dgap + (a part whose power -(N + dV/dgap) gap_rate is the normal loss); where internal
        variables flow, dV/dz dz/dt is subtracted from that loss.
        """

    @property
    def bounds(self) -> Kernel | None:
        """The kernel of an asymmetric bound of set-valued friction, else None.

            bounds(...) -> least friction F- [N], largest friction F+ [N]

        Stick has F- <= F <= F+; slip v > 0 has F = F-, slip v < 0 has F = F+. It replaces the bound of
        `force`.
        """
        return None

    @property
    def friction_force(self) -> Kernel | None:
        """The kernel of friction that is not set-valued, else None.

            friction_force(...) -> friction F [N], rate of z, stored energy [J], tangential stiffness [N/m]

        z is the one internal variable, which the engine solves together with F. In ELASTOPLASTIC friction it
        is the stretch of a spring [m], F = -stiffness z; the engine evaluates this while it holds, and in
        slip keeps F on the bound and z with it. In RATE_DEPENDENT friction z may be anything; the stiffness
        is not read. With a kernel `rate` or `jump` the friction is RATE_DEPENDENT and the kernel returns
        three numbers: the rates are those of `rate`.
        """
        return None


class MultiplierLaw(ContactLaw):
    """A rigid law: an impact at touch-down, then a contact that holds the gap at zero, in a friction bound.

    It is solved in its limit of no step, see `contactlab.engine.constrained`, or stepped in time where a
    contact step is given, see `contactlab.engine.rigid`.

    >>> import contactlab as cl
    >>> law = cl.Newton(friction_coefficient=0.3, restitution=0.5)
    >>> isinstance(law, cl.MultiplierLaw), law.default_contact_step
    (True, 5e-08)
    """

    default_contact_step: ClassVar[float] = 5e-8

    projects: ClassVar[bool] = True
    """Whether displacements are put back onto the closed gap after every step, as the paper's index-2
    corrector does, and the last step is shortened to the release; else the constraint is one of
    velocities only, the contact may penetrate by O(step), and it lasts until the gap is open."""
    sticks: ClassVar[bool] = True
    """Whether time stepping holds a slip at zero inside the bound; else a contact slides at the bound against
    the slip at the start of each step, as the paper's law without stick does."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "solve" in vars(cls):
            raise LawError(
                f"The law {vars(cls).get('name', cls.__name__)} has a kernel solve, which rigid laws no "
                "longer have. Write impact(approach, slip, d_nn, d_nt, d_tt, ...) -> normal impulse, "
                "friction impulse for its impacts, and bound(normal, slip, ...) -> largest friction where "
                "that of a contact that lasts is not Coulomb's."
            )

    @property
    @abstractmethod
    def impact(self) -> Kernel:
        """The kernel of an impact, a static method as a rule.

            impact(...) -> normal impulse p_n [N s], friction impulse p_t [N s]

        Its quantities: approach, the gap rate before the impact [m/s], negative; slip, the slip before it
        [m/s]; d_nn, d_nt, d_tt, the symmetric Delassus matrix [1/kg]. The impact leaves the gap rate
        approach + d_nn p_n + d_nt p_t, which must not be negative, and the slip slip + d_nt p_n + d_tt p_t. A
        normal impulse that is not positive means that the law has none for this approach (Painleve).
        """

    bound: ClassVar[Kernel] = staticmethod(coulomb)
    """The kernel of the friction bound of a contact that lasts, by default that of Coulomb's cone.

    bound(normal, slip, ...) -> largest friction [N]

    Stick has |F| <= bound, slip F = -bound sign(slip); the slip is exactly zero in stick. A law without
    friction coefficient has none.
    """


def is_stepped(law: ContactLaw, contact_step: float | None) -> bool:
    """Return whether a law is rigid and stepped in time, by a contact step [s]."""
    return isinstance(law, MultiplierLaw) and contact_step is not None


class NormalForce(Declared, Remembering):
    """A part of a composed law: a normal force of the penetration d >= 0.

    It has a kernel `elastic`, or where it dissipates `force`. Internal variables of an elastic force tell the
    branch that it is on: between its kinks, at which guards end the steps, it is smooth.

        >>> import contactlab as cl
        >>> part = cl.Linear(stiffness=2e7)
        >>> force, energy, stiffness, slope = part.evaluate("elastic", depth=1e-6)
        >>> cl.Composed(normal=part).title, float(force)
        ('composed of normal linear, damping none, friction coulomb', 20.0)
    """

    family: ClassVar[str] = "normal"
    allows_tension: ClassVar[bool] = False
    """Whether it may pull."""
    convergence_order: ClassVar[float] = 1.0
    """As of a law: less where the force jumps, which coarse tolerances do not see."""
    smooth_stiffness: ClassVar[bool] = True
    """Whether dN/dd has no kink, nor rises as fast as behind one."""
    rises: ClassVar[bool] = True
    """Whether a force that presses has one depth alone."""
    violations: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """As of a law."""

    @property
    def elastic(self) -> Kernel | None:
        """The kernel of an elastic force, else None.

        elastic(...) -> force [N], stored energy [J], stiffness dN/dd [N/m], its slope d2N/dd2 [N/m^2]
        """
        return None

    @property
    def force(self) -> Kernel | None:
        """The kernel of a force that dissipates, else None.

        force(...) -> force [N], stored energy [J], stiffness [N/m], its slope [N/m^2], loss [W]

        Stiffness and slope are those at constant rate and internal variables.
        """
        return None


class Damping(Declared):
    """A part of a composed law: the normal force of an elastic one while the bodies move.

    >>> import contactlab as cl
    >>> law = cl.Composed(damping=cl.HuntCrossley(restitution=0.7, impact_speed=0.1))
    >>> after = cl.impact(law, [[1 / 2e-3, 0.0], [0.0, 3.5 / 2e-3]], [-0.1, 0.0])["velocity_after"]
    >>> f"{after.values[0, 0]:.4f} m/s"
    '0.0700 m/s'
    """

    family: ClassVar[str] = "damping"
    any_force: ClassVar[bool] = True
    """Whether it may act on a normal force that pulls, or that has a memory and losses of its own."""
    convergence_order: ClassVar[float] = 1.0
    """As of a law."""
    violations: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """As of a law."""

    def solved(self, normal: NormalForce) -> Mapping[str, Coefficient]:
        """Return the coefficients for an elastic force, by name; its own where they do not depend on it."""
        return self.coefficients()

    @property
    @abstractmethod
    def damped(self) -> Kernel:
        """The kernel.

        damped(elastic_force, ...) -> normal force [N]
        """


@dataclass(frozen=True)
class Friction(Declared, Tangential):
    """A part of a composed law: set-valued friction has a bound only, any other a kernel `state` too.

    Where static friction is larger than kinetic it has a field `static_ratio`, mu_s / mu.

        >>> import contactlab as cl
        >>> friction = cl.Stribeck(0.25, static_ratio=2.0)
        >>> friction.friction_limit, friction.exact_stick
        (0.5, True)
    """

    family: ClassVar[str] = "friction"

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    bound: ClassVar[Kernel] = staticmethod(cone)
    """The kernel of the bound, by default that of Coulomb's cone.

    bound(normal, slip, ...) -> largest friction [N]

    The slip is exactly zero in stick.
    """

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the fields by name; the static ratio of a friction without is 1."""
        return {"static_ratio": 1.0, **super().coefficients()}

    @property
    def bounds(self) -> Kernel | None:
        """The kernel of an asymmetric bound, else None; see `PenaltyLaw.bounds`."""
        return None

    @property
    def state(self) -> Kernel | None:
        """The kernel of friction that is not set-valued, else None.

            state(...) -> friction [N], rate of z, stored energy [J], tangential stiffness [N/m]

        See `PenaltyLaw.friction_force`.
        """
        return None


Part = NormalForce | Damping | Friction
