"""Normal forces of a composed law, a family a module."""

from contactlab.laws.base import NormalForce
from contactlab.laws.normal.dmt import Dmt
from contactlab.laws.normal.elastic import (
    HertzElliptic,
    HertzPoint,
    Line,
    Linear,
    Lining,
    approach_factor,
    hertz_elastic,
)
from contactlab.laws.normal.force_table import ForceTable
from contactlab.laws.normal.jkr import Jkr, tabor_number
from contactlab.laws.normal.maugis import Maugis
from contactlab.laws.normal.prony import Prony
from contactlab.laws.normal.thornton import Thornton
from contactlab.laws.normal.walton_braun import WaltonBraun

NORMAL_FORCES: dict[str, type[NormalForce]] = {
    part.name: part
    for part in (
        *(HertzPoint, HertzElliptic, Line, Linear, Lining),
        *(Thornton, WaltonBraun, Jkr, Dmt, Maugis, Prony, ForceTable),
    )
}
