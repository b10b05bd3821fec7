"""Derjaguin, Muller and Toporov (1975)."""

from math import pi

from contactlab.laws.normal import Dmt
from contactlab.testing.claim import Claims, close


def pull_off(work: float = 0.1, radius: float = 4.2e-3) -> Claims:
    """The pull-off force is 2 pi w R (Derjaguin, Muller and Toporov 1975)."""
    normal = Dmt(radius, work_of_adhesion=work)
    result = -normal.evaluate("elastic", depth=0.0)[0]
    yield close("pull-off force", result, 2.0 * pi * work * radius, 1e-12, "N")
