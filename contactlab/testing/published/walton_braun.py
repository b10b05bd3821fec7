"""Walton and Braun (1986): a restitution of two stiffnesses."""

from math import sqrt

from contactlab.laws import Composed, Coulomb
from contactlab.laws.normal import WaltonBraun
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import restitution
from contactlab.testing.plants import block, run


def rebound(mass: float = 2e-3, loading: float = 1e7, unloading: float = 2.5e7) -> Claims:
    """A rebound of sqrt(k_1/k_2) at any speed, less with hardening, S (Walton and Braun 1986)."""
    for speed, hardening in ((0.1, 0.0), (0.4, 0.0), (0.1, 1e6)):
        law = Composed(WaltonBraun(loading, unloading, hardening), friction=Coulomb(0.0))
        result = restitution(run(block(mass, height=1e-6, gap_rate=-speed), law, 1e-6 / speed + 1e-3))
        expected = sqrt(loading / (unloading + hardening * speed * sqrt(mass * loading)))
        yield close(f"restitution at {speed:g} m/s, S = {hardening:g}/m", result, expected, 1e-6)
