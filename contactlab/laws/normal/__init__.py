"""Elastic normal forces by name. A new one is one module and one entry here."""

from typing import TYPE_CHECKING

from contactlab.laws.table import Table

if TYPE_CHECKING:
    from contactlab.laws.part import NormalForce

NORMAL_FORCES: "Table[type[NormalForce]]" = Table(
    {
        "hertz_point": "contactlab.laws.normal.hertz_point:HertzPoint",
        "hertz_elliptic": "contactlab.laws.normal.hertz_elliptic:HertzElliptic",
        "line": "contactlab.laws.normal.line:Line",
        "linear": "contactlab.laws.normal.linear:Linear",
        "lining": "contactlab.laws.normal.lining:Lining",
    }
)

__getattr__ = NORMAL_FORCES.attribute
