"""What a law remembers: internal variables, how they flow and jump, and between which gaps a contact lasts.

Most laws have none, and their kernels are as their family says. A law or part that has a kernel `rate` or
`jump` gets its internal variables as the array z, shape (variable,), before `parameters` in every kernel:

    rate(which, STATE, z, parameters)           -> rate of z[which]
    guard(which, STATE, z, parameters)          -> positive while what the law says goes on
    jump(which, event, STATE, z, parameters)    -> z[which] after the event
    limits(z, parameters)                       -> gaps at which a contact begins and ends [m]

STATE is gap [m], gap rate [m/s], slip [m/s], zero in stick, and normal force [N] for a law; depth [m] and its
rate [m/s] for a normal force; normal force [N], stiffness dN/dd [N/m], its rate [N m^-1 s^-1] and slip [m/s]
for a friction. Parts have the place `at` of their coefficients after `parameters`.

Where a guard falls through zero the step ends, and all variables jump by the number of that guard. They jump
at the events below as well. What they do to the stored energy at an event is a loss of the contact; so is
what is stored still at a release. A guard is looked at while a contact lasts. `limits` is without z where
there are no variables.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, final

AT_TOUCH, AT_RELEASE, AT_SLIP, AT_STICK = -4, -3, -2, -1
"""Events that are no guard's: a contact begins, ends; stick gives way to slip, slip to stick."""

EVENTS = AT_TOUCH, AT_RELEASE, AT_SLIP, AT_STICK

MOST_VARIABLES = 128
"""Internal variables that the state of a run has room for."""

ODD, EVEN = -1, 1
"""Parities of an internal variable: whether it changes its sign where left and right are exchanged."""


@final
@dataclass(frozen=True)
class InternalVariable:
    """One number that a law remembers.

        >>> import contactlab as cl
        >>> bend = cl.InternalVariable("bend", "z", "m", "bend of the bristles")
        >>> bend.initial, bend.life
        (0.0, 'contact')

    Args:
        name: its word; datasets record it as `internal_NAME`.
        symbol: as in the equations.
        units: SI, in the words of the CF conventions.
        meaning: a few words.
        initial: its value where its life begins.
        life: "contact", from one touch-down until the gap is clear of the next, or "run".
        parity: ODD as of a stretch, EVEN as of an age.
    """

    name: str
    symbol: str
    units: str
    meaning: str
    initial: float = 0.0
    life: Literal["contact", "run"] = "contact"
    parity: int = EVEN

    def __str__(self) -> str:
        return f"{self.meaning} [{self.units}]" if self.units != "1" else self.meaning


def dependent(declared: Callable[[Any], Any]) -> Any:
    """Let what a law declares of itself hang on its parameters: a property in place of a class attribute."""
    return property(declared)


class Remembering:
    """What a law or a part says of its memory, and its kernels; see the module."""

    internal_variables: ClassVar[tuple[InternalVariable, ...]] = ()
    """What it remembers; `dependent` where that hangs on its parameters."""
    guards: ClassVar[int] = 0
    """How many guards it has."""

    @property
    def rate(self) -> Any:
        """The kernel of the rates, or None: they only jump, or the friction's own kernel gives its one."""
        return None

    @property
    def guard(self) -> Any:
        """The kernel of the guards, or None."""
        return None

    @property
    def jump(self) -> Any:
        """The kernel of the jumps, or None: variables keep their values at all events."""
        return None

    @property
    def limits(self) -> Any:
        """The kernel of the limits, or None: a contact begins and ends at a gap of zero.

        A contact ends where the gap that is not less than its limit opens; begin <= end always. What a
        contact has left (a dent) may put off where the next begins, until the gap is clear of it.
        """
        return None

    @property
    def lasting(self) -> tuple[InternalVariable, ...]:
        """Internal variables whose life is the run: part of the motor's state in free flight."""
        return tuple(one for one in self.internal_variables if one.life == "run")
