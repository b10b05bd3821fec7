"""Brach (1989): the ratio of the impulses of an impact."""

from contactlab.laws import Brach
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import impulses_of


def critical_ratio(mass: float = 0.1, e: float = 0.6, speed: float = 0.2, slip: float = 0.15) -> Claims:
    """A solid ball ends its slip at p_t/p_n = 2/7 r/(1 + e) and loses what is published (Brach 1989)."""
    share = 3.5
    ratio = slip / speed / (share * (1.0 + e))
    law = Brach(3.0 * ratio, e)
    d = (1.0 / mass, 0.0, share / mass)
    p_n, p_t, _ = impulses_of(law, -speed, slip, d)
    yield close("critical ratio of the impulses", -p_t / p_n, ratio, 1e-12)
    r = slip / speed
    lost = 0.5 * mass * speed**2 * (1 + e) * (1 - e + 2 * ratio * r - (1 + e) * share * ratio**2)
    result = -0.5 * (p_n * (-speed + (-speed + p_n / mass)) + p_t * (slip + slip + d[2] * p_t))
    yield close("loss of the impact", result, lost, 1e-12, "J")
