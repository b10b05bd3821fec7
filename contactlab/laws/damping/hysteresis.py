"""A loss in proportion to the elastic force: N = f(d) (1 + a dd/dt).

An impact of free bodies at the speed v, whatever f and the masses, has a restitution e with

    (1 + e) D = ln((1 + D) / (1 - e D)),   D = a v

from m u du / (1 + a u) = -f dd over compression and restitution. The published models say D as a function
of a nominal restitution, and achieve it near 1 only; here D is solved for what is asked.

    Hunt-Crossley         a = 3 (1 - e_n) / (2 v)       v a constant of the contact
    Lankarani-Nikravesh   a = 3 (1 - e_n^2) / (4 v)     v the speed of each approach
    Flores                a = 8 (1 - e_n) / (5 e_n v)   v the speed of each approach

A model whose largest nominal D, that of e_n = 0, is smaller than what is asked cannot achieve it and says so.
"""

from functools import cache
from math import exp, log, log1p

from scipy.optimize import brentq

from contactlab.parameter import Parameter

ACHIEVED_RESTITUTION = Parameter("e", "1", "restitution of a free impact", above=0.0, at_most=1.0)

LEAST_SPEED = Parameter("v_min", "m s-1", "slowest approach that is told apart", above=0.0)
"""A contact that begins without approach has no speed to divide by."""


NEARLY_PLASTIC, NEARLY_ELASTIC = 0.025, 1e-6
"""e below which 1 - e D is less than the unit of D, and 1 - e below which D is linear in it."""


@cache
def closing_number(restitution: float) -> float:
    """D = a v at which a free impact has a restitution, 0 < e <= 1 [1].

    With D = x/(1 + e x), x in (0, inf): (1 + e) D = ln(1 + (1 + e) x), free of cancellation. At the ends
    D is 1/e and 3/2 (1 - e) to double precision.
    """
    e = restitution
    if e < NEARLY_PLASTIC:
        return 1.0 / e
    if 1.0 - e < NEARLY_ELASTIC:
        return 1.5 * (1.0 - e)

    def missing(logarithm: float) -> float:
        x = exp(logarithm)
        return (1.0 + e) * x / (1.0 + e * x) - log1p((1.0 + e) * x)

    # From an x that is too small by far to one that is too large.
    x = exp(brentq(missing, log(1.0 - e), 2.0 / e + 2.0, xtol=1e-14))
    return float(x / (1.0 + e * x))


def refuse_beyond(name: str, restitution: float, most: float) -> None:
    """Refuse a restitution for which a model would need more than its largest D.

    Raises:
        ValueError: with the smallest restitution it can achieve.
    """
    if closing_number(restitution) <= most:
        return
    least = brentq(lambda e: closing_number(e) - most, restitution, 1.0, xtol=1e-12)
    raise ValueError(
        f"{name}: restitution is {restitution}; it must be at least {least:.6g}, which the model achieves "
        "with a nominal one of 0. Take flores, which has no such bound."
    )
