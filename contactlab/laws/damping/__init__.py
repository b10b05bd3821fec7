"""Normal losses by name. A new one is one module and one entry here."""

from contactlab.laws.damping.flores import Flores
from contactlab.laws.damping.hunt_crossley import HuntCrossley
from contactlab.laws.damping.lankarani_nikravesh import LankaraniNikravesh
from contactlab.laws.damping.linear import LinearDamping
from contactlab.laws.damping.undamped import Undamped
from contactlab.laws.part import Damping

DAMPINGS: dict[str, type[Damping]] = {
    part.name: part for part in (Undamped, LinearDamping, HuntCrossley, LankaraniNikravesh, Flores)
}

__all__ = [
    "DAMPINGS",
    "Flores",
    "HuntCrossley",
    "LankaraniNikravesh",
    "LinearDamping",
    "Undamped",
]
