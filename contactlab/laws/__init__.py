"""The contact laws by name. A new law is one module, one entry here and one file in `conf/law`."""

from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.hertz_penalty import HertzPenalty, hertz_stiffness
from contactlab.laws.lagrange_slip import LagrangeSlip
from contactlab.laws.lagrange_stick import LagrangeStick
from contactlab.laws.moreau_jean import MoreauJean
from contactlab.laws.newton import Newton
from contactlab.laws.poisson import Poisson
from contactlab.laws.stronge import Stronge

LAWS: dict[str, type[ContactLaw]] = {
    law.name: law
    for law in (LagrangeSlip, LagrangeStick, HertzPenalty, Newton, Poisson, Stronge, MoreauJean)
}

__all__ = [
    "LAWS",
    "ContactLaw",
    "HertzPenalty",
    "LagrangeSlip",
    "LagrangeStick",
    "MoreauJean",
    "MultiplierLaw",
    "Newton",
    "PenaltyLaw",
    "Poisson",
    "Stronge",
    "hertz_stiffness",
]
