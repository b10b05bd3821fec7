"""Internal variables of a law: how they flow and jump, and the gaps at which a contact begins and ends.

Kernels name them as they name everything else, see `contactlab.laws.base`; z has all of them. `which` is the
place of the variable or guard, `event` the number of a guard or one of the events below:

    rate(which, ...)         -> rate of variable `which`
    guard(which, ...)        -> positive until event `which`
    jump(which, event, ...)  -> variable `which` after the event (the reset map)
    limits(...)              -> gaps at which a contact begins and ends [m]

Where a guard falls through zero a step ends and all variables jump; guards are evaluated in contact only. The
stored energy that a jump takes, and that is left at a release, is a loss of the contact. Quantities are those
of the contact with its normal force, `limits` has the gap rate. In stick the slip is zero.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, final

AT_TOUCH, AT_RELEASE, AT_SLIP, AT_STICK = -4, -3, -2, -1
"""Events that are no guard's: a contact begins, ends; stick gives way to slip, slip to stick."""

EVENTS = AT_TOUCH, AT_RELEASE, AT_SLIP, AT_STICK

MOST_VARIABLES = 128
"""Largest number of internal variables of a law."""

ODD, EVEN = -1, 1
"""Parities of an internal variable: whether it changes its sign where left and right are exchanged."""


@final
@dataclass(frozen=True)
class InternalVariable:
    """An internal variable of a law.

        >>> import contactlab as cl
        >>> bend = cl.InternalVariable("bend", "z", "m", "bend of the bristles")
        >>> bend.initial, bend.life
        (0.0, 'contact')

    Args:
        name: an identifier; datasets record it as `internal_NAME`.
        symbol: as in the equations.
        units: SI, as in the CF conventions.
        meaning: a few words.
        initial: its value where its life begins.
        life: "contact", until the gap exceeds the one at which a first contact begins, or "run".
        parity: ODD as of a stretch, EVEN as of an age.
        discrete: whether it only jumps, as a count, a flag or a grid: a state of the contact, as stick is.
    """

    name: str
    symbol: str
    units: str
    meaning: str
    initial: float = 0.0
    life: Literal["contact", "run"] = "contact"
    parity: int = EVEN
    discrete: bool = False

    def __str__(self) -> str:
        return f"{self.meaning} [{self.units}]" if self.units != "1" else self.meaning


def dependent(declared: Callable[[Any], Any]) -> Any:
    """Make a declaration that depends on the parameters: a property in place of a class attribute."""
    return property(declared)


class Remembering:
    """Internal variables of a law or part, and their kernels; see the module."""

    internal_variables: ClassVar[tuple[InternalVariable, ...]] = ()
    """Internal variables; `dependent` where they depend on the parameters."""
    guards: ClassVar[int] = 0
    """Number of guards."""

    @property
    def rate(self) -> Any:
        """The kernel of the rates, or None: variables only jump, or friction's kernel returns the rate."""
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

        A contact ends where the gap passes its limit as it opens; begin <= end always. A residual indentation
        may delay the next beginning until the gap exceeds the one of a first contact.
        """
        return None

    @property
    def lasting(self) -> tuple[InternalVariable, ...]:
        """Internal variables whose life is the run: part of the motor's state in free flight."""
        return tuple(each for each in self.internal_variables if each.life == "run")
