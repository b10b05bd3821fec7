"""Oblique rebounds of spheres that were measured, and what a law predicts of them.

A sphere of mass m and radius R that comes without spin has the Delassus matrix diag(1, 7/2)/m at its
contact. With D, the friction impulse against the slip over m [m/s], and v_t = v sin(incidence),

    tangential restitution   1 - D/v_t          of the centre, not of the contact
    rebound angle            atan((v_t - D)/v_n+)
    spin                     5/2 D/R

so that each of the three tells D, and so the other two.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pandas
from scipy.optimize import least_squares

from contactlab.arrays import Array
from contactlab.impacts import velocities_after
from contactlab.laws import ContactLaw
from contactlab.laws.damping import loss_number

SPEED, RESTITUTION, FRICTION = 3.9, 0.98, 0.092
"""Of the impacts [m/s], and as measured [1], [1]."""

RADIUS, DENSITY = 2.5e-3, 4000.0
"""Of the spheres [m], [kg/m^3]."""

MASS = DENSITY * 4.0 / 3.0 * np.pi * RADIUS**3
DELASSUS = np.diag([1.0, 3.5]) / MASS

DIGITISED = 0.01
"""Error of a number read off a figure, of full scale."""

FULL_SCALE: Final = {"tangential_restitution": 1.0, "rebound_angle_deg": 90.0, "spin_rad_per_s": 700.0}
"""Of the axes: a choice, as the file does not say how far they go. The spins end at 613 rad/s."""

INCIDENCE_ERROR = DIGITISED * 90.0
"""Of the other axis [degrees], the same choice."""

NODES = np.array([2.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0])
"""Incidences of the impacts, about [degrees]: where any curve at all is free in `floor`."""

COLUMNS = ("quantity", "incidence_deg", "value")


@dataclass(frozen=True)
class Rebounds:
    """What was measured, a number a point.

    Args:
        quantity: which, a key of `FULL_SCALE`.
        incidence: from the normal [degrees].
        value: in the unit that the quantity has in its name.
    """

    quantity: Array
    incidence: Array
    value: Array

    @property
    def error(self) -> Array:
        """Error of the values by digitisation."""
        return DIGITISED * np.array([FULL_SCALE[str(name)] for name in self.quantity])


def read_rebounds(path: str | Path) -> Rebounds:
    """Read the CSV file of the digitised figures.

    Raises:
        ValueError: it cannot be read, or has other columns, quantities or no numbers; a sentence.
    """
    try:
        table = pandas.read_csv(path, comment="#", dtype=str)
    except (OSError, ValueError) as error:
        needed = f"it must be a CSV file with the columns {', '.join(COLUMNS)}"
        raise ValueError(f"'{path}' cannot be read ({error}); {needed}.") from error
    if table.empty or {*table} != {*COLUMNS}:
        raise ValueError(f"'{path}' must have the columns {', '.join(COLUMNS)} and one row at least.")
    if unknown := {*table.quantity} - {*FULL_SCALE}:
        known = ", ".join(FULL_SCALE)
        raise ValueError(f"'{path}' has the quantity {unknown.pop()!r}; it must be one of {known}.")
    try:
        incidence, value = (np.array(table[name], dtype=np.float64) for name in COLUMNS[1:])
    except ValueError as error:
        raise ValueError(f"'{path}' has an entry that is no number ({error}).") from error
    if not np.isfinite(value).all() or not ((incidence > 0.0) & (incidence < 90.0)).all():
        raise ValueError(f"'{path}' must have finite values at incidences between 0 and 90 degrees.")
    return Rebounds(np.array(table.quantity, dtype=str), incidence, value)


def approach(incidence: Array) -> Array:
    """Return the velocities before an impact at some incidences [degrees]: (-v_n, v_t), shape (impact, 2)."""
    angle = np.radians(incidence)
    return np.stack([-SPEED * np.cos(angle), SPEED * np.sin(angle)], axis=-1)


def quantities(before: Array, after: Array) -> dict[str, Array]:
    """Return all three quantities of impacts from the velocities of their contacts, shape (impact, 2)."""
    taken = (before[:, 1] - after[:, 1]) / (MASS * DELASSUS[1, 1])
    left = before[:, 1] - taken
    return {
        "tangential_restitution": left / before[:, 1],
        "rebound_angle_deg": np.degrees(np.arctan2(left, after[:, 0])),
        "spin_rad_per_s": 2.5 * taken / RADIUS,
    }


def of_points(rebounds: Rebounds, all_three: dict[str, Array]) -> Array:
    """Return of all quantities at every point the one that was measured there."""
    return np.select([rebounds.quantity == name for name in all_three], [*all_three.values()])


def law_predictions(make: Callable[[float], ContactLaw]) -> Callable[[Array], dict[str, Array]]:
    """Return what predicts the quantities at incidences [degrees], from a law made for an approach [m/s]."""

    def predicted(incidence: Array) -> dict[str, Array]:
        before = approach(incidence)
        laws = [make(-float(speed)) for speed in before[:, 0]]
        if len(set(laws)) == 1:
            return quantities(before, velocities_after(laws[0], DELASSUS, before))
        pairs = zip(laws, before, strict=True)
        after = [velocities_after(law, DELASSUS, item[None])[0] for law, item in pairs]
        return quantities(before, np.array(after))

    return predicted


def microslip(
    modulus: float, stiffness_ratio: float, springs: int = 200, steps: int = 2000
) -> Callable[[Array], dict[str, Array]]:
    """Return what predicts the quantities where the contact slips from its rim inwards, as Mindlin has it.

    It is what the law `microslip` is checked against, in another discretisation. A foundation of springs
    E* dx, which the profile x^2/R presses in and each of which slides by itself at mu of its own normal
    force, is the solution of Cattaneo and Mindlin for spheres exactly, also under a force that changes:
    Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, ch. 5. The
    damping is that of Flores. Leapfrog; twice as many springs and steps change no digit that is shown.

    Args:
        modulus, stiffness_ratio: E* [Pa] and kappa [1] of the pair.
        springs, steps: of half the patch, of the time that an impact lasts.
    """

    def predicted(incidence: Array) -> dict[str, Array]:
        before = approach(incidence)
        w, v = -before[:, 0], before[:, 1].copy()
        hertz = 4.0 / 3.0 * modulus * np.sqrt(RADIUS)
        deepest = (1.25 * MASS * w**2 / hertz) ** 0.4
        h, loss = 3.2 * deepest / w / steps, loss_number(RESTITUTION) / w
        width = np.sqrt(1.05 * RADIUS * deepest)[:, None]
        x, dx = (np.arange(springs) + 0.5) / springs * width, 2.0 * width / springs
        depth, stretch = np.zeros_like(w), np.zeros_like(x)
        for _ in range(steps):
            depth = depth + 0.5 * h * w
            damped = np.maximum(1.0 + loss * w, 0.0)[:, None]
            pressed = np.maximum(depth[:, None] - x**2 / RADIUS, 0.0) * damped
            limit = FRICTION * pressed / stiffness_ratio
            stretch = np.clip(stretch + (h * v)[:, None], -limit, limit)
            w = w - h * (modulus * dx * pressed).sum(1) / MASS
            v = v - h * DELASSUS[1, 1] * (stiffness_ratio * modulus * dx * stretch).sum(1)
            depth = depth + 0.5 * h * w
        return quantities(before, np.stack([-w, v], axis=-1))

    return predicted


def misfits(rebounds: Rebounds, predicted: Callable[[Array], dict[str, Array]]) -> tuple[Array, Array]:
    """Return the misfit at each point in errors of digitisation, of the value alone and of both axes.

    The second has sqrt(error^2 + (slope times that of the incidence)^2) of the prediction's slope.
    """
    here, near = (of_points(rebounds, predicted(rebounds.incidence + step)) for step in (0.0, 0.1))
    apart = here - rebounds.value
    both = np.hypot(rebounds.error, (near - here) / 0.1 * INCIDENCE_ERROR)
    return apart / rebounds.error, apart / both


def rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def any_curve(nodes: Array) -> Callable[[Array], dict[str, Array]]:
    """Return the quantities of a tangential restitution that is any curve: linear between `NODES`."""

    def predicted(incidence: Array) -> dict[str, Array]:
        before = approach(incidence)
        taken = (1.0 - np.interp(incidence, NODES, nodes)) * before[:, 1]
        after = np.stack([-RESTITUTION * before[:, 0], before[:, 1] - MASS * DELASSUS[1, 1] * taken], axis=-1)
        return quantities(before, after)

    return predicted


def floor(rebounds: Rebounds, *, both_axes: bool = False) -> Callable[[Array], dict[str, Array]]:
    """Return that curve which fits all three quantities best: what is left of its misfit no law can mend."""
    result = least_squares(
        lambda nodes: misfits(rebounds, any_curve(nodes))[both_axes], np.full(NODES.size, 0.75)
    )
    return any_curve(result.x)


def scatter_of_incidence(rebounds: Rebounds) -> float:
    """Return how far the figures differ in the incidence of one impact [degrees], as a standard deviation.

    The figures show the same impacts. Those within 2 degrees of one in each other figure are one.
    """
    each = [rebounds.incidence[rebounds.quantity == name] for name in FULL_SCALE]
    groups = []
    for incidence in each[0]:
        group = [float(others[np.argmin(np.abs(others - incidence))]) for others in each]
        if np.ptp(group) < 2.5:
            groups.append(group)
    return float(np.sqrt(np.mean(np.var(groups, axis=1, ddof=1))))
