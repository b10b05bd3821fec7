"""Normal forces of a composed law, a family a module."""

from contactlab.laws.base import NormalForce
from contactlab.laws.normal.elastic import (
    HertzElliptic,
    HertzPoint,
    Line,
    Linear,
    Lining,
    approach_factor,
    hertz_elastic,
)

NORMAL_FORCES: dict[str, type[NormalForce]] = {
    part.name: part for part in (HertzPoint, HertzElliptic, Line, Linear, Lining)
}
