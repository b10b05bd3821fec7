"""The contact laws by name. A new law is one module and one entry in `contactlab.laws.registry`."""

from typing import TYPE_CHECKING, Any

from contactlab.laws.failure import LawError
from contactlab.laws.registry import LAWS, law_class, law_names, origin_of

if TYPE_CHECKING:
    from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
    from contactlab.laws.composed import Composed
    from contactlab.laws.hertz_penalty import HertzPenalty, hertz_stiffness
    from contactlab.laws.lagrange_slip import LagrangeSlip
    from contactlab.laws.lagrange_stick import LagrangeStick

__all__ = [
    "LAWS",
    "Composed",
    "ContactLaw",
    "HertzPenalty",
    "LagrangeSlip",
    "LagrangeStick",
    "LawError",
    "MultiplierLaw",
    "PenaltyLaw",
    "hertz_stiffness",
    "law_class",
    "law_names",
    "origin_of",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: the names of the laws alone need no compiler."""
    if name in ("ContactLaw", "MultiplierLaw", "PenaltyLaw"):
        from contactlab.laws import base

        return getattr(base, name)
    if name == "hertz_stiffness":
        from contactlab.laws.hertz_penalty import hertz_stiffness

        return hertz_stiffness
    return LAWS.attribute(name)
