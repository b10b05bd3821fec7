"""Elastic normal forces by name. A new one is one class in a module here, and one name below."""

from contactlab.laws.normal.hertz import HertzElliptic, HertzPoint, Line
from contactlab.laws.normal.springs import Linear, Lining
from contactlab.laws.part import NormalForce

NORMAL_FORCES: dict[str, type[NormalForce]] = {
    part.name: part for part in (HertzPoint, HertzElliptic, Line, Linear, Lining)
}
