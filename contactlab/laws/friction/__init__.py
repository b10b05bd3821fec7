"""Frictions of a composed law, a family a module."""

from contactlab.laws.base import Friction
from contactlab.laws.friction.ageing import AgeingStick
from contactlab.laws.friction.bouc_wen import BoucWen
from contactlab.laws.friction.bristles import ElastoPlastic, LuGre
from contactlab.laws.friction.cohesive import Cohesive
from contactlab.laws.friction.coulomb import Coulomb
from contactlab.laws.friction.dahl import Dahl
from contactlab.laws.friction.evolution import Nagata, PerrinRiceZheng, Ruina, TwoState
from contactlab.laws.friction.iwan import Iwan
from contactlab.laws.friction.microslip import Microslip
from contactlab.laws.friction.mindlin import Mindlin
from contactlab.laws.friction.rate_and_state import RateAndState
from contactlab.laws.friction.regularised import Regularised
from contactlab.laws.friction.stribeck import Stribeck

FRICTIONS: dict[str, type[Friction]] = {
    part.name: part
    for part in (
        *(Coulomb, Regularised, Mindlin, LuGre, ElastoPlastic),
        *(Stribeck, Cohesive, AgeingStick, Dahl, BoucWen, Iwan, Microslip, RateAndState),
        *(Ruina, PerrinRiceZheng, Nagata, TwoState),
    )
}
