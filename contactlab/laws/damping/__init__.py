"""Normal losses by name. A new one is one class in a module here, and one name below."""

from contactlab.laws.damping.dashpot import LinearDamping, Undamped
from contactlab.laws.damping.hysteresis import Flores, HuntCrossley, LankaraniNikravesh
from contactlab.laws.part import Damping

DAMPINGS: dict[str, type[Damping]] = {
    part.name: part for part in (Undamped, LinearDamping, HuntCrossley, LankaraniNikravesh, Flores)
}
