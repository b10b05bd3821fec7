"""The contact laws by name. A new law is one module, one entry here and one file in `conf/law`."""

from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.hertz_penalty import HertzPenalty, hertz_stiffness
from contactlab.laws.lagrange_slip import LagrangeSlip
from contactlab.laws.lagrange_stick import LagrangeStick

LAWS: dict[str, type[ContactLaw]] = {
    law.name: law for law in (LagrangeSlip, LagrangeStick, HertzPenalty)
}

__all__ = [
    "LAWS",
    "ContactLaw",
    "HertzPenalty",
    "LagrangeSlip",
    "LagrangeStick",
    "MultiplierLaw",
    "PenaltyLaw",
    "hertz_stiffness",
]
