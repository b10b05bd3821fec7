"""Frictions of a composed law, a family a module."""

from contactlab.laws.base import Friction
from contactlab.laws.friction.bristles import ElastoPlastic, LuGre
from contactlab.laws.friction.coulomb import Coulomb, cone_bound
from contactlab.laws.friction.iwan import Iwan
from contactlab.laws.friction.mindlin import Mindlin
from contactlab.laws.friction.rate_and_state import RateAndState
from contactlab.laws.friction.regularised import Regularised

FRICTIONS: dict[str, type[Friction]] = {
    part.name: part for part in (Coulomb, Regularised, Mindlin, LuGre, ElastoPlastic, Iwan, RateAndState)
}
