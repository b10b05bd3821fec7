"""Friction by name. A new one is one module and one entry here."""

from contactlab.laws.friction.coulomb import Coulomb
from contactlab.laws.part import Friction

FRICTIONS: dict[str, type[Friction]] = {part.name: part for part in (Coulomb,)}

__all__ = ["FRICTIONS", "Coulomb"]
