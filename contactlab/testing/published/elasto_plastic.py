"""Dupont et al. (2002): a small load bends the bristles, and nothing drifts."""

from contactlab.laws import Composed, ElastoPlastic, Linear
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import run, way_of


def deflection(mu: float = 0.3, share: float = 0.3) -> Claims:
    """Under a load P it comes to rest at P / (sigma_0 N), where `lugre` goes on (Dupont et al. 2002)."""
    sigma = 1e5
    law = Composed(Linear(SPRING), friction=ElastoPlastic(mu, bristle_stiffness=sigma, bristle_damping=1e2))
    way = way_of(run(resting(push=share * mu * WEIGHT), law, 0.1, 1e-4, 0.05).series["tip_slope"])
    expected = share * mu / sigma
    yield close("bristles that do not drag: deflection", way[-1], expected, 1e-6, "m")
    yield close("bristles that do not drag: drift", way[-1] - way[-2], 0.0, 1e-6, "m", expected)
