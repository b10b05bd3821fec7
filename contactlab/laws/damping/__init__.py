"""Normal losses by name. A new one is one module and one entry here."""

from typing import TYPE_CHECKING

from contactlab.laws.table import Table

if TYPE_CHECKING:
    from contactlab.laws.part import Damping

DAMPINGS: "Table[type[Damping]]" = Table(
    {
        "none": "contactlab.laws.damping.undamped:Undamped",
        "linear": "contactlab.laws.damping.linear:LinearDamping",
        "hunt_crossley": "contactlab.laws.damping.hunt_crossley:HuntCrossley",
        "lankarani_nikravesh": "contactlab.laws.damping.lankarani_nikravesh:LankaraniNikravesh",
        "flores": "contactlab.laws.damping.flores:Flores",
    }
)

__getattr__ = DAMPINGS.attribute
