"""Measured impacts that nobody measured: drawn bodies, whose jumps impulses make but for an error."""

import numpy as np

from contactlab.arrays import Array
from contactlab_data.measured.bodies import BodyImpacts
from contactlab_data.measured.impacts import MeasuredImpacts


def drawn_bodies(count: int, seed: int, noise: float = 0.0, coordinates: int = 3) -> BodyImpacts:
    """Draw a flat body, or several, that approaches; half of the impacts leave it slipping the other way."""
    rng = np.random.default_rng(seed)
    extra = coordinates - 3
    mass = np.broadcast_to(
        np.diag([0.04, 0.04, 1.7e-5, *[0.02] * extra]), (count, coordinates, coordinates)
    ).copy()
    arms = rng.uniform(-0.03, 0.03, (count, 2))
    nothing = np.zeros(count)
    rest = rng.uniform(-0.3, 0.3, (2, count, extra))
    normal = np.column_stack([nothing, nothing + 1.0, arms[:, 0], rest[0]])
    tangential = np.column_stack([nothing + 1.0, nothing, arms[:, 1], rest[1]])
    before = rng.normal(size=(count, coordinates)) * [0.5, 0.3, 5.0, *[0.1] * extra] - np.eye(coordinates)[1]
    bodies = BodyImpacts(before, before, mass, normal, tangential)
    approach = bodies.contact(before)[:, 0]
    before = before + np.eye(coordinates)[1] * np.minimum(0.0, -0.2 - approach)[:, None]
    delassus = bodies.delassus()
    share = rng.uniform(0.3, 0.9, count)
    impulse_n = -(1.0 + share) * bodies.contact(before)[:, 0] / delassus[:, 0, 0]
    impulse = np.column_stack([impulse_n, rng.uniform(-0.6, 0.6, count) * impulse_n])
    # The friction tilts the separation; what is left is still one.
    spare = bodies.contact(before)[:, 0] + np.einsum("nj,nj->n", delassus[:, 0, :], impulse)
    impulse[:, 1] *= np.where(spare > 0.01, 1.0, 0.0)
    jump = np.linalg.solve(mass, bodies.jacobian.transpose(0, 2, 1) @ impulse[..., None])[..., 0]
    error = rng.normal(size=jump.shape) * noise / np.sqrt(np.einsum("nii->ni", mass) / mass[0, 0, 0])
    return BodyImpacts(before, before + jump + error, mass, normal, tangential)


def drawn_impacts(count: int, seed: int, *, covariance: bool = False) -> MeasuredImpacts:
    """Draw contact velocities of all kinds, admissible or not, and any Delassus matrices."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(count, 2, 2)) + 2.0 * np.eye(2)
    delassus = roots @ roots.transpose(0, 2, 1)
    delassus = 0.5 * (delassus + delassus.transpose(0, 2, 1))
    before = np.column_stack([-rng.uniform(0.1, 2.0, count), rng.normal(size=count)])
    after = rng.normal((0.5, 0.0), size=(count, 2))
    after[:, 0] = np.where(np.arange(count) % 4 < 3, np.abs(after[:, 0]), after[:, 0])
    least = 0.5 * np.einsum("ni,ni->n", before, np.linalg.solve(delassus, before[..., None])[..., 0])
    spread = 1e-4 * roots @ roots.transpose(0, 2, 1)
    return MeasuredImpacts(
        delassus,
        before,
        after,
        least * rng.uniform(1.0, 2.0, count),
        1e-3 * rng.uniform(size=count),
        0.5 * (spread + spread.transpose(0, 2, 1)) if covariance else None,
        "Drawn",
        "A generator of random numbers",
        "CC0-1.0",
        int(rng.integers(100)),
        rng.permutation(10 * count)[:count] + 1,
    )


def kinetic(delassus: Array, velocity: Array) -> float:
    """Kinetic energy of one contact's velocities."""
    return 0.5 * float(velocity @ np.linalg.solve(delassus, velocity))
