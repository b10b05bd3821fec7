"""Lower bounds of the error of contact laws: the best impulse of each impact, and the same impulse in all.

In the norm of the kinetic energy an impulse p misses the measured velocities by q'Dq, q = p - p*, where
p* = D^-1 (u+ - u-) produces them. With w = L'p, D = LL', this is a distance in the plane, where admissible
impulses are a convex set, a disc cut by straight lines:

    p_n >= 0                        the contact does not pull
    u_n- + (Dp)_n >= 0              the bodies separate
    p'(u- + u+)/2 <= 0              no energy is gained: |w + L^-1 u-| <= |L^-1 u-|
    |p_t| <= mu p_n                 with a friction cone

The nearest point is one of a few in closed form, the projections and the corners.
"""

from itertools import combinations
from typing import Final

import numpy as np

from contactlab.arrays import Array
from contactlab_data.measured.impacts import MeasuredImpacts

ROUND_OFF: Final = 1e-9
"""Distance beyond the admissible set, over the radius of the disc, that is round-off."""


def best_impulses(impacts: MeasuredImpacts) -> Array:
    """Return the impulses p* that produce the measured velocities [N s], shape (impact, 2).

    Their error is that of `impacts.outside` alone.
    """
    jump = impacts.velocity_after - impacts.velocity_before
    return np.asarray(np.linalg.solve(impacts.delassus, jump[..., None])[..., 0])


def best_admissible_impulses(impacts: MeasuredImpacts, friction_coefficient: float | None = None) -> Array:
    """Return the nearest impulses that neither pull, close nor gain energy [N s], shape (impact, 2).

    No passive law, or passive law of Coulomb friction with this coefficient, has a smaller error.

    Args:
        friction_coefficient: mu of the friction cone, 0 or more; None for no cone.

    Raises:
        ValueError: the friction coefficient is negative or not finite.
    """
    mu = friction_coefficient
    if mu is not None and not 0.0 <= mu < np.inf:
        raise ValueError(f"The friction coefficient is {mu}; it must be at least 0, or None for no cone.")
    if not len(impacts):
        return np.zeros((0, 2))
    root: Array = np.asarray(np.linalg.cholesky(impacts.delassus), dtype=np.float64)
    centre: Array = np.asarray(-np.linalg.solve(root, impacts.velocity_before[..., None])[..., 0], np.float64)
    radius = _length(centre)
    measured = np.einsum("nji,nj->ni", root, best_impulses(impacts))
    lines = _lines(impacts, root, mu)
    away = measured - centre
    with np.errstate(invalid="ignore", divide="ignore"):
        onto_circle = centre + away * (radius / _length(away))[:, None]
    candidates = np.stack(
        [
            measured,
            onto_circle,
            *(_onto_line(measured, normal, offset) for normal, offset in lines),
            *(_crossing(*line, *other) for line, other in combinations(lines, 2)),
            *(point for line in lines for point in _through_circle(*line, centre, radius)),
        ]
    )
    excess = [_length(candidates - centre) - radius]
    excess += [offset - np.einsum("cni,ni->cn", candidates, normal) for normal, offset in lines]
    # Points that do not exist are NaN, and so not below any bound.
    admissible = np.all([each <= ROUND_OFF * radius for each in excess], axis=0)
    distance = np.where(admissible, _length(candidates - measured), np.inf)
    nearest = candidates[np.argmin(distance, axis=0), np.arange(len(impacts))]
    return np.asarray(np.linalg.solve(root.transpose(0, 2, 1), nearest[..., None])[..., 0])


def velocities_after(impacts: MeasuredImpacts, impulses: Array) -> Array:
    """Return the velocities u- + D p after impulses [m/s], shape (impact, 2)."""
    return np.asarray(impacts.velocity_before + np.einsum("nij,nj->ni", impacts.delassus, impulses))


def with_constant_impulse(impacts: MeasuredImpacts, impulse: Array) -> Array:
    """Return the velocities after one impulse (p_n, p_t), p_t against the slip [m/s], shape (impact, 2)."""
    signs = np.stack([np.ones(len(impacts)), -np.sign(impacts.velocity_before[:, 1])], axis=1)
    return velocities_after(impacts, impulse * signs)


def _lines(impacts: MeasuredImpacts, root: Array, mu: float | None) -> list[tuple[Array, Array]]:
    """Return unit normals a and offsets b of the bounds a . w >= b in the plane of w."""
    zero = np.zeros(len(impacts))
    # A direction c of impulses, c . p, is L^-1 c in the plane; that of the gap rate is a row of L.
    bounds: list[tuple[Array, Array]] = [(root[:, 0, :], -impacts.velocity_before[:, 0])]
    directions = [(1.0, 0.0)] if mu is None else [(mu, -1.0), (mu, 1.0), (1.0, 0.0)]
    for direction in directions:
        across = np.broadcast_to(np.array(direction)[:, None], (len(impacts), 2, 1))
        bounds.append((np.linalg.solve(root, across)[..., 0], zero))
    lengths = [_length(normal) for normal, _ in bounds]
    return [(a / size[:, None], b / size) for (a, b), size in zip(bounds, lengths, strict=True)]


def _length(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vectors, vectors)))


def _onto_line(point: Array, normal: Array, offset: Array) -> Array:
    return np.asarray(point + (offset - np.einsum("ni,ni->n", point, normal))[:, None] * normal)


def _crossing(normal: Array, offset: Array, other: Array, other_offset: Array) -> Array:
    """Return the intersection of two lines, not finite where they are parallel."""
    turned = normal[:, 0] * other[:, 1] - normal[:, 1] * other[:, 0]
    x = offset * other[:, 1] - other_offset * normal[:, 1]
    y = other_offset * normal[:, 0] - offset * other[:, 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.stack([x / turned, y / turned], axis=1)


def _through_circle(normal: Array, offset: Array, centre: Array, radius: Array) -> tuple[Array, Array]:
    """Return the two intersections of a line and the circle, NaN without any."""
    foot = _onto_line(centre, normal, offset)
    away = _length(foot - centre)
    with np.errstate(invalid="ignore"):
        half = np.sqrt((radius - away) * (radius + away))
    along = np.stack([-normal[:, 1], normal[:, 0]], axis=1) * half[:, None]
    return foot + along, foot - along
