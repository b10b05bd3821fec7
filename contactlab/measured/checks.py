"""Consistency of measured impacts: definite matrices, approach, signs of the Jacobian, energies."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.special import fdtrc

from contactlab.arrays import Array
from contactlab.measured.bodies import BodyImpacts
from contactlab.measured.table import MeasurementError

LARGEST_SHARE: Final = 1e-4
"""Share of the jump's energy outside of the impulses' span below which a wrong sign makes no difference to a
comparison of laws: that of a hundredth of the jump."""

BEYOND_ERRORS: Final = 4.0
"""Ratio of that share to the one that stated errors explain, and to that of another sign, above which a sign
is wrong."""

BY_CHANCE: Final = 0.01
"""Probability that a sign reduces the share by chance, over all signs."""

ROUND_OFF: Final = 1e-12

PASSES_THROUGH: Final = 0.05
"""Share of the approach with which bodies may leave into each other, median: errors of a plastic impact."""


def check_positive(matrices: Array, name: str, places: Sequence[str], least: float) -> None:
    """Raise a MeasurementError unless every eigenvalue exceeds a share of the largest one.

    Args:
        matrices: symmetric, shape (impact, n, n).
        name: of the matrix.
        places: of the impacts in their file.
        least: the share; negative for semidefinite matrices.
    """
    values = np.linalg.eigvalsh(matrices)
    if (bad := (values[:, 0] < least * values[:, -1]) | ((least > 0.0) & (values[:, 0] <= 0.0))).any():
        first = int(np.argmax(bad))
        raise MeasurementError(
            f"the {name} of {places[first]} is {matrices[first].tolist()}; it must be positive "
            f"{'semi' if least < 0.0 else ''}definite."
        )


def check_approach(before: Array, after: Array, places: Sequence[str]) -> None:
    """Raise a MeasurementError for bodies that do not approach, or that pass through each other.

    Args:
        before, after: gap rates [m/s], shape (impact,).
        places: of the impacts in their file.
    """
    leaving = before >= 0.0
    if leaving.any():
        first, count = int(np.argmax(leaving)), int(leaving.sum())
        way_out = (
            "reverse the normal columns or the gap rates, or exchange before and after"
            if 2 * count > before.size
            else "correct these impacts, or mark them in the column 'flag'"
        )
        raise MeasurementError(
            f"the gap rate before the impact is {before[first]:.4g} m/s in {places[first]}; it must be "
            "negative, "
            f"and is not in {count} of {before.size} impacts: {way_out}."
        )
    passing = float(np.median(after / before))
    if passing > PASSES_THROUGH:
        raise MeasurementError(
            f"the gap rate after the impact is {passing:.3g} times that before it (median), so that the "
            "bodies "
            "pass through each other; it must be positive. Correct the sign of the after columns."
        )


def check_signs(bodies: BodyImpacts, angles: Mapping[str, bool], *, keep: bool) -> list[str]:
    """Raise a MeasurementError for a Jacobian with a wrong sign, by the jumps that no impulse makes.

    A sign is wrong where the median share of the jump's energy outside of the impulses' span is larger than
    LARGEST_SHARE, or BEYOND_ERRORS times what stated errors explain, and the other sign makes it so much
    smaller that chance is excluded: the ratio of two sums of squares of n (coordinates - 2) errors each is
    F-distributed.

    Args:
        bodies: the impacts.
        angles: whether each coordinate is an angle, by name.
        keep: whether the file states that its Jacobian is right.

    Returns:
        Sentences on the share.
    """
    if bodies.before.shape[1] < 3:
        return []
    share, explained = bodies.outside_share(), bodies.share_of_errors()
    sentence = f"{_percent(share)} of the jump's energy (median) lies outside of what impulses can do"
    if explained is not None:
        sentence += f", and the stated errors explain {_percent(explained)}"
    column, reversed_share = _best_sign(bodies, angles)
    freedom = len(bodies.before) * (len(angles) - 2)
    ratio = share / max(reversed_share, ROUND_OFF)
    better = ratio > BEYOND_ERRORS and 2 * len(angles) * float(fdtrc(freedom, freedom, ratio)) < BY_CHANCE
    too_large = share > (LARGEST_SHARE if explained is None else BEYOND_ERRORS * explained)
    if better and too_large and not keep:
        raise MeasurementError(
            f"{sentence} with the Jacobian as it stands, and {_percent(reversed_share)} with the sign of "
            f"{column} "
            "reversed. Reverse that column, or state that the Jacobian is right by 'jacobian: checked'."
        )
    if better:
        return [f"{sentence}; it would be {_percent(reversed_share)} with the sign of {column} reversed."]
    if too_large:
        return [f"{sentence}, and no other sign in the Jacobian makes it much less."]
    return [f"{sentence}."]


def _best_sign(bodies: BodyImpacts, angles: Mapping[str, bool]) -> tuple[str, float]:
    """Return the component of the Jacobian whose reversal leaves the least share outside, and that share."""
    shares = []
    # Arms first: their sign is often wrong, and the reversal of another component may have the same span.
    for name in sorted(angles, key=lambda each: not angles[each]):
        sign = np.array([-1.0 if each == name else 1.0 for each in angles])
        for row in ("tangential", "normal"):
            other = replace(bodies, **{row: getattr(bodies, row) * sign})
            values = np.linalg.eigvalsh(other.delassus())
            if (values[:, 0] > 1e-9 * values[:, 1]).all():
                shares.append((f"{row}_{name}", other.outside_share()))
    least = min(share for _, share in shares)
    return next((name, share) for name, share in shares if share <= 1.05 * least + ROUND_OFF)


def odd_energies(before: Array, after: Array, delassus: Array) -> list[str]:
    """Return sentences on impacts that gain energy, pull, or go on approaching.

    Args:
        before, after: velocities of the contact [m/s], shape (impact, 2).
        delassus: [1/kg], shape (impact, 2, 2).
    """
    impulse = np.linalg.solve(delassus, (after - before)[..., None])[..., 0]
    counts = {
        "gain energy": np.einsum("ni,ni->n", impulse, before + after) > 0.0,
        "have a normal impulse that pulls": impulse[:, 0] <= 0.0,
        "go on approaching": after[:, 0] < 0.0,
    }
    return [f"{int(odd.sum())} of {len(before)} impacts {what}." for what, odd in counts.items() if odd.any()]


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
