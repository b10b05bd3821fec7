"""What can be wrong with measured impacts, each in a sentence with the value, the bound and the way out."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, final

import numpy as np
from scipy.special import fdtrc

from contactlab.arrays import Array
from contactlab.measured.reduction import BodyImpacts

LARGEST_SHARE: Final = 1e-4
"""Share of the jump's energy outside of the impulses' span below which a wrong sign makes no difference that
a comparison of laws would see: that of a hundredth of the jump."""

BEYOND_ERRORS: Final = 4.0
"""How many times the share that the stated errors explain is too much, twice them; and by how much another
sign must reduce it to be meant."""

BY_CHANCE: Final = 0.01
"""Probability at which a sign that reduces the share may do so by chance, over all signs that are tried."""

ROUND_OFF: Final = 1e-12
"""Share that is none."""

PASSES_THROUGH: Final = 0.05
"""Share of the approach with which bodies may leave into each other, median: errors of a plastic impact."""


@final
class MeasurementError(ValueError):
    """A file of measurements that cannot be used; the message is a sentence."""


def check_mass(mass: Array, places: Sequence[str]) -> None:
    """Refuse mass matrices, shape (impact, coordinate, coordinate), that are not positive definite."""
    least = np.linalg.eigvalsh(mass)[:, 0]
    if (bad := least <= 0.0).any():
        first = int(np.argmax(bad))
        raise MeasurementError(
            f"the mass matrix of {places[first]} is {mass[first].tolist()}, which is not positive definite; "
            "every body must have a kinetic energy. Correct the columns mass_NAME and mass_NAME_OTHER."
        )


def check_directions(delassus: Array, places: Sequence[str]) -> None:
    """Refuse Delassus matrices, shape (impact, 2, 2), that are not positive definite."""
    values = np.linalg.eigvalsh(delassus)
    if (bad := values[:, 0] <= 1e-9 * values[:, 1]).any():
        first = int(np.argmax(bad))
        raise MeasurementError(
            f"the Delassus matrix of {places[first]} is {delassus[first].tolist()} 1/kg, which is not "
            "positive definite; its two directions must be independent. Correct the delassus columns, or the "
            "normal and tangential ones."
        )


def check_approach(before: Array, after: Array, places: Sequence[str], columns: str) -> None:
    """Refuse impacts whose bodies do not approach, and a file whose bodies pass through each other.

    Args:
        before, after: gap rates [m/s], shape (impact,).
        places: where each impact is in the file.
        columns: whose sign it is.
    """
    leaving = before >= 0.0
    count = int(leaving.sum())
    if 2 * count > before.size:
        raise MeasurementError(
            f"the gap rate before the impact is not negative in {count} of {before.size} impacts; bodies "
            "must approach. The normal points the wrong way, or before and after are exchanged: reverse "
            f"{columns}."
        )
    if count:
        first = int(np.argmax(leaving))
        raise MeasurementError(
            f"the gap rate before the impact is {before[first]:.4g} m/s in {places[first]}, and not negative "
            f"in {count} of {before.size} impacts; bodies must approach. Correct these impacts, or flag them "
            "in the column 'flag'."
        )
    passing = float(np.median(after / before))
    if passing > PASSES_THROUGH:
        raise MeasurementError(
            f"the gap rate after the impact is {passing:.3g} times that before it (median): the bodies would "
            "pass through each other; it must be positive. Correct the sign of the after columns."
        )


def check_span(bodies: BodyImpacts, names: Sequence[str], angles: Sequence[bool], *, keep: bool) -> list[str]:
    """Refuse a Jacobian of which one sign is wrong, by the part of the jumps that no impulse makes.

    A sign is taken for wrong where the median share of the jump's energy outside of the impulses' span is
    larger than LARGEST_SHARE, or BEYOND_ERRORS times what stated errors explain, and the other sign makes it
    so much smaller that chance is no explanation: the ratio of two sums of squares of n (coordinates - 2)
    errors each is F-distributed.

    Args:
        bodies: the impacts.
        names, angles: of the coordinates, and which of them are angles.
        keep: whether the file says that its Jacobian is right.

    Returns:
        What was found, a sentence each.
    """
    if bodies.before.shape[1] < 3:
        return []
    stands = bodies.outside_share()
    words = f"{_percent(stands)} of the jump's energy (median) lies outside of what impulses can do"
    explained = bodies.share_of_errors()
    if explained is not None:
        words += f", and the stated errors explain {_percent(explained)}"
    column, turned = _best_sign(bodies, names, angles)
    freedom = len(bodies.before) * (len(names) - 2)
    ratio = stands / max(turned, ROUND_OFF)
    chance = 2 * len(names) * float(fdtrc(freedom, freedom, ratio))
    better = ratio > BEYOND_ERRORS and chance < BY_CHANCE
    too_large = stands > (LARGEST_SHARE if explained is None else BEYOND_ERRORS * explained)
    if better and too_large and not keep:
        raise MeasurementError(
            f"{words} with the Jacobian as it stands, and {_percent(turned)} with the sign of {column} "
            f"reversed. Reverse that column, or say that the Jacobian is right by 'jacobian: checked' among "
            "the words of the file."
        )
    if better:
        return [f"{words}; it would be {_percent(turned)} with the sign of {column} reversed."]
    if too_large:
        return [f"{words}, and no other sign in the Jacobian makes it much less."]
    return [f"{words}."]


def _best_sign(bodies: BodyImpacts, names: Sequence[str], angles: Sequence[bool]) -> tuple[str, float]:
    """Find the component of the Jacobian whose other sign leaves the least share outside, and that share."""
    found = []
    # Arms first: their sign is what one gets wrong, and another's reversal may have the same span.
    for place in sorted(range(len(names)), key=lambda each: not angles[each]):
        sign = np.ones(len(names))
        sign[place] = -1.0
        for row in ("tangential", "normal"):
            turned = replace(bodies, **{row: getattr(bodies, row) * sign})
            values = np.linalg.eigvalsh(turned.delassus())
            if (values[:, 0] > 1e-9 * values[:, 1]).all():
                found.append((f"{row}_{names[place]}", turned.outside_share()))
    least = min(share for _, share in found)
    return next((name, share) for name, share in found if share <= 1.05 * least + ROUND_OFF)


def told_energies(before: Array, after: Array, delassus: Array) -> list[str]:
    """Count impacts that gain energy at the contact and impulses that pull, a sentence each.

    Args:
        before, after: velocities of the contact [m/s], shape (impact, 2).
        delassus: [1/kg], shape (impact, 2, 2).
    """
    impulse = np.linalg.solve(delassus, (after - before)[..., None])[..., 0]
    gained = 0.5 * np.einsum("ni,ni->n", impulse, before + after)
    counts = {
        "gain energy": int((gained > 0.0).sum()),
        "have a normal impulse that pulls": int((impulse[:, 0] <= 0.0).sum()),
        "go on approaching": int((after[:, 0] < 0.0).sum()),
    }
    return [f"{count} of {len(before)} impacts {what}." for what, count in counts.items() if count]


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
