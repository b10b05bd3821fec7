"""Chatterjee and Ruina (1998): an impact of two plastic ones."""

import numpy as np

from contactlab.laws import ChatterjeeRuina
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import impulses_of


def impulse(mu: float = 0.3, e: float = 0.6, e_t: float = 0.4) -> Claims:
    """Their impulse in vectors, inside of the cone and on it (1998, J. Appl. Mech. 65, 939)."""
    d, n, law = np.array([[600.0, 150.0], [150.0, 800.0]]), np.array([1.0, 0.0]), ChatterjeeRuina(mu, e, e_t)
    for text, slip in (("in the cone", 0.01), ("on the cone", 0.5)):
        v = np.array([-0.1, slip])
        free, stuck = -(n @ v) / (n @ d @ n) * n, -np.linalg.solve(d, v)
        expected = (1.0 + e) * free + (1.0 + e_t) * (stuck - free)
        if abs(expected[1]) > mu * expected[0]:
            down = abs(stuck[1]) - mu * (n @ (stuck - free))
            expected = (1.0 + e) * free + mu * (1.0 + e) * (n @ free) / down * (stuck - free)
        result = impulses_of(law, -0.1, slip, (600.0, 150.0, 800.0))
        yield close(f"friction impulse {text}", result[1], float(expected[1]), 1e-9, "N s")
        yield close(f"normal impulse {text}", result[0], float(expected[0]), 1e-9, "N s")
