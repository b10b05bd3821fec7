"""Friction by name. A new one is one module and one entry here."""

from contactlab.laws.friction.coulomb import Coulomb
from contactlab.laws.friction.elasto_plastic import ElastoPlastic
from contactlab.laws.friction.lugre import LuGre
from contactlab.laws.friction.mindlin import Mindlin
from contactlab.laws.friction.regularised import Regularised
from contactlab.laws.part import Friction

FRICTIONS: dict[str, type[Friction]] = {
    part.name: part for part in (Coulomb, Regularised, Mindlin, LuGre, ElastoPlastic)
}

__all__ = ["FRICTIONS", "Coulomb", "ElastoPlastic", "LuGre", "Mindlin", "Regularised"]
