"""Normal losses by name. A new one is one module and one entry here."""

from typing import TYPE_CHECKING

from contactlab.laws.table import Table

if TYPE_CHECKING:
    from contactlab.laws.part import Damping

DAMPINGS: "Table[type[Damping]]" = Table(
    {
        "none": "contactlab.laws.damping.none:Undamped",
    }
)

__getattr__ = DAMPINGS.attribute
