"""Impacts of a disc whose law is known, measured with a known error."""

import numpy as np

from contactlab.impacts import velocities_after
from contactlab.laws import ContactLaw
from contactlab_data.measured.impacts import MeasuredImpacts

MASS, HALF_AXES = 0.04, (0.035, 0.025)


def struck_discs(law: ContactLaw, count: int, seed: int, spread: float = 0.0) -> MeasuredImpacts:
    """Return impacts of an elliptical disc at any orientation, with errors of `spread` [m/s]."""
    rng = np.random.default_rng(seed)
    inertia = MASS * (HALF_AXES[0] ** 2 + HALF_AXES[1] ** 2) / 4.0
    along, across = rng.uniform(-0.012, 0.012, count), rng.uniform(0.025, 0.035, count)
    delassus = np.empty((count, 2, 2))
    delassus[:, 0, 0] = 1.0 / MASS + along**2 / inertia
    delassus[:, 1, 1] = 1.0 / MASS + across**2 / inertia
    delassus[:, 0, 1] = delassus[:, 1, 0] = along * across / inertia
    before = np.column_stack([-rng.uniform(1.0, 3.0, count), rng.uniform(-2.0, 2.0, count)])
    after = velocities_after(law, delassus, before) + rng.normal(0.0, spread, (count, 2))
    energy = 0.5 * np.einsum("ni,ni->n", before, np.linalg.solve(delassus, before[..., None])[..., 0])
    stated = np.broadcast_to(spread**2 * np.eye(2), (count, 2, 2)).copy() if spread else None
    number = np.arange(1, count + 1)
    outside = np.zeros(count)
    return MeasuredImpacts(
        delassus, before, after, energy, outside, stated, "Discs", "A generator", "CC0-1.0", 0, number
    )
