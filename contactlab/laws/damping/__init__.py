"""Normal losses by name. A new one is one module and one entry here."""

from contactlab.laws.damping.none import Undamped
from contactlab.laws.part import Damping

DAMPINGS: dict[str, type[Damping]] = {part.name: part for part in (Undamped,)}

__all__ = ["DAMPINGS", "Undamped"]
