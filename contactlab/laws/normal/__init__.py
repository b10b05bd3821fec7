"""Elastic normal forces by name. A new one is one module and one entry here."""

from contactlab.laws.normal.hertz_elliptic import HertzElliptic
from contactlab.laws.normal.hertz_point import HertzPoint
from contactlab.laws.normal.line import Line
from contactlab.laws.normal.linear import Linear
from contactlab.laws.normal.lining import Lining
from contactlab.laws.part import NormalForce

NORMAL_FORCES: dict[str, type[NormalForce]] = {
    part.name: part for part in (HertzPoint, HertzElliptic, Line, Linear, Lining)
}

__all__ = ["NORMAL_FORCES", "HertzElliptic", "HertzPoint", "Line", "Linear", "Lining"]
