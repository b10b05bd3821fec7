"""Frictions by name. A new one is one class in a module here, and one name below."""

from contactlab.laws.friction.bristles import ElastoPlastic, LuGre
from contactlab.laws.friction.coulomb import Coulomb, Regularised
from contactlab.laws.friction.mindlin import Mindlin
from contactlab.laws.part import Friction

FRICTIONS: dict[str, type[Friction]] = {
    part.name: part for part in (Coulomb, Regularised, Mindlin, LuGre, ElastoPlastic)
}
