"""What no contact law can do better than: the best impulses there are, and one that is the same for all.

In the norm of the kinetic energy an impulse p misses the measured velocities by q'Dq, q = p - p*, where
p* = D^-1 (u+ - u-) is the impulse that gives them. With w = L'p, D = LL', this is a distance in the plane,
where what is admissible is convex, a disc cut by straight lines:

    p_n >= 0                        the contact does not pull
    u_n- + (Dp)_n >= 0              the bodies separate
    p'(u- + u+)/2 <= 0              no energy is gained: |w + L^-1 u-| <= |L^-1 u-|
    |p_t| <= mu p_n                 where a cone is asked for

The nearest point of it is found in closed form, by trying all that it can be.
"""

from itertools import combinations
from typing import Final

import numpy as np

from contactlab.arrays import Array
from contactlab.measured.impacts import MeasuredImpacts

ROUND_OFF: Final = 1e-9
"""By how much of the radius of the disc, the approach, a point may lie outside of what is admissible."""


def best_impulses(impacts: MeasuredImpacts) -> Array:
    """Give the impulses p* that make the measured velocities [N s], shape (impact, 2).

    What they miss is `impacts.outside` alone, the floor of everything.
    """
    jump = impacts.velocity_after - impacts.velocity_before
    return np.asarray(np.linalg.solve(impacts.delassus, jump[..., None])[..., 0])


def best_admissible_impulses(impacts: MeasuredImpacts, friction_coefficient: float | None = None) -> Array:
    """Give the impulses nearest to the measured ones that neither pull, close nor gain energy [N s].

    Args:
        impacts: what was measured.
        friction_coefficient: mu of the cone that they lie in, 0 or more; None for no cone.

    Returns:
        Impulses, shape (impact, 2): the floor of every law that is passive, or passive and of Coulomb's
        friction with this mu.

    Raises:
        ValueError: the friction coefficient is negative or no number.
    """
    mu = friction_coefficient
    if mu is not None and not 0.0 <= mu < np.inf:
        raise ValueError(f"The friction coefficient is {mu}; it must be at least 0, or None for no cone.")
    if not len(impacts):
        return np.zeros((0, 2))
    root = _root(impacts)
    centre: Array = np.asarray(-np.linalg.solve(root, impacts.velocity_before[..., None])[..., 0], np.float64)
    radius = _length(centre)
    measured = np.einsum("nji,nj->ni", root, best_impulses(impacts))
    lines = _lines(impacts, root, mu)
    candidates = np.stack(
        [
            measured,
            _onto_circle(measured, centre, radius),
            *(_onto_line(measured, normal, offset) for normal, offset in lines),
            *(_crossing(*one, *other) for one, other in combinations(lines, 2)),
            *(point for line in lines for point in _through_circle(*line, centre, radius)),
        ]
    )
    excess = [_length(candidates - centre) - radius]
    excess += [offset - np.einsum("cni,ni->cn", candidates, normal) for normal, offset in lines]
    # What does not exist is NaN, and so not below any bound.
    admissible = np.all([each <= ROUND_OFF * radius for each in excess], axis=0)
    distance = np.where(admissible, _length(candidates - measured), np.inf)
    nearest = candidates[np.argmin(distance, axis=0), np.arange(len(impacts))]
    return np.asarray(np.linalg.solve(root.transpose(0, 2, 1), nearest[..., None])[..., 0])


def velocities_after(impacts: MeasuredImpacts, impulses: Array) -> Array:
    """Give the velocities u- + D p that impulses leave [m/s], shape (impact, 2)."""
    return np.asarray(impacts.velocity_before + np.einsum("nij,nj->ni", impacts.delassus, impulses))


def constant_impulse(impacts: MeasuredImpacts) -> Array:
    """Fit the one impulse (p_n, p_t) that is best for all impacts, p_t against the slip before [N s].

    Best is the least sum of squares of `MeasuredImpacts.errors`, a linear problem.
    """
    root = _root(impacts)
    weight = 1.0 / np.sqrt(2.0 * impacts.kinetic_energy)
    directions = root.transpose(0, 2, 1) * _against_slip(impacts)[:, None, :] * weight[:, None, None]
    jump = impacts.velocity_after - impacts.velocity_before
    wanted = np.linalg.solve(root, jump[..., None])[..., 0] * weight[:, None]
    return np.asarray(np.linalg.lstsq(directions.reshape(-1, 2), wanted.ravel())[0])


def with_constant_impulse(impacts: MeasuredImpacts, impulse: Array) -> Array:
    """Give the velocities that the impulse of `constant_impulse` leaves [m/s], shape (impact, 2)."""
    return velocities_after(impacts, impulse * _against_slip(impacts))


def _against_slip(impacts: MeasuredImpacts) -> Array:
    """Give the signs of a normal impulse that pushes and a tangential one that brakes, shape (impact, 2)."""
    return np.stack([np.ones(len(impacts)), -np.sign(impacts.velocity_before[:, 1])], axis=1)


def _lines(impacts: MeasuredImpacts, root: Array, mu: float | None) -> list[tuple[Array, Array]]:
    """Give unit normals a and offsets b in the plane of w of all that is a . w >= b."""
    nothing = np.zeros(len(impacts))
    # A direction c of impulses, c . p, is L^-1 c in the plane; that of the gap rate is a row of L.
    wanted: list[tuple[Array, Array]] = [(root[:, 0, :], -impacts.velocity_before[:, 0])]
    directions = [(1.0, 0.0)] if mu is None else [(mu, -1.0), (mu, 1.0), (1.0, 0.0)]
    for direction in directions:
        across = np.broadcast_to(np.array(direction)[:, None], (len(impacts), 2, 1))
        wanted.append((np.linalg.solve(root, across)[..., 0], nothing))
    lengths = [_length(normal) for normal, _ in wanted]
    return [(a / size[:, None], b / size) for (a, b), size in zip(wanted, lengths, strict=True)]


def _root(impacts: MeasuredImpacts) -> Array:
    """Give the lower triangular L of D = LL', shape (impact, 2, 2)."""
    return np.asarray(np.linalg.cholesky(impacts.delassus), dtype=np.float64)


def _length(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vectors, vectors)))


def _onto_line(point: Array, normal: Array, offset: Array) -> Array:
    return np.asarray(point + (offset - np.einsum("ni,ni->n", point, normal))[:, None] * normal)


def _onto_circle(point: Array, centre: Array, radius: Array) -> Array:
    away = point - centre
    distance = _length(away)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(centre + away * (radius / distance)[:, None])


def _crossing(normal: Array, offset: Array, other: Array, other_offset: Array) -> Array:
    """Give the point where two lines cross, not finite where they are parallel."""
    turned = normal[:, 0] * other[:, 1] - normal[:, 1] * other[:, 0]
    x = offset * other[:, 1] - other_offset * normal[:, 1]
    y = other_offset * normal[:, 0] - offset * other[:, 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.stack([x / turned, y / turned], axis=1)


def _through_circle(normal: Array, offset: Array, centre: Array, radius: Array) -> tuple[Array, Array]:
    """Give the two points where a line goes through the circle, NaN where it does not."""
    foot = _onto_line(centre, normal, offset)
    away = _length(foot - centre)
    with np.errstate(invalid="ignore"):
        half = np.sqrt((radius - away) * (radius + away))
    along = np.stack([-normal[:, 1], normal[:, 0]], axis=1) * half[:, None]
    return foot + along, foot - along
