"""Friction by name. A new one is one module and one entry here."""

from typing import TYPE_CHECKING

from contactlab.laws.table import Table

if TYPE_CHECKING:
    from contactlab.laws.part import Friction

FRICTIONS: "Table[type[Friction]]" = Table(
    {
        "coulomb": "contactlab.laws.friction.coulomb:Coulomb",
        "regularised": "contactlab.laws.friction.regularised:Regularised",
        "mindlin": "contactlab.laws.friction.mindlin:Mindlin",
        "lugre": "contactlab.laws.friction.lugre:LuGre",
        "elasto_plastic": "contactlab.laws.friction.elasto_plastic:ElastoPlastic",
    }
)

__getattr__ = FRICTIONS.attribute
