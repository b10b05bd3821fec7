"""A law by itself: impacts of which the Delassus matrix and the velocities before are known.

    import contactlab as cl

    ball = cl.impact(cl.Newton(restitution=0.8), [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.5])
    print(ball.velocity_after.values)

Velocities of a contact are gap rate and slip [m/s], with the signs of `contactlab.motor.geometry`; the gap
rate is negative on approach. With impulses p = (p_n, p_t) [N s] they are u+ = u- + D p after the impact.
"""

import json
from typing import Any, Final, final

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray

from contactlab.arrays import Array
from contactlab.checks import check_kind, check_shape, shown
from contactlab.engine.strikes import Struck, struck, velocities
from contactlab.laws.base import ContactLaw, MultiplierLaw
from contactlab.results.netcdf import cf_attributes
from contactlab.results.provenance import code_attributes
from contactlab.trajectory import Ending
from contactlab.variables import CONTACT_MODE, CONTACTS, SERIES, Variable

SYMMETRY: Final = 1e-9
"""Largest |D_nt - D_tn| over sqrt(D_nn D_tt) that is round-off."""

DEFINITE: Final = 1e-12
"""Least D_nn D_tt - D_nt^2 over D_nn D_tt: below it round-off decides whether D is positive definite."""

_PAIR: Final = ("impact", "direction")
_MATRIX: Final = ("impact", "direction", "other_direction")
_RECORD: Final = ("impact", "record")
_KNOWN: Final = {variable.name: variable for variable in (*CONTACTS, *SERIES)}


def _along(name: str, dims: tuple[str, ...], long_name: str = "") -> Variable:
    """Give a quantity of runs along other dimensions."""
    known = _KNOWN[name]
    return Variable(name, dims, known.units, known.symbol, long_name or known.long_name)


VARIABLES: Final = (
    Variable("delassus", _MATRIX, "kg-1", "D", "Delassus matrix G M^-1 G'"),
    Variable("velocity_before", _PAIR, "m s-1", "u-", "gap rate and slip before the impact"),
    Variable("velocity_after", _PAIR, "m s-1", "u+", "gap rate and slip after the impact"),
    Variable("impulse", _PAIR, "N s", "p", "normal impulse and friction impulse"),
    Variable(
        "mode", ("impact",), "1", "m", "contact mode at the end of the impact", flags=CONTACT_MODE.flags
    ),
    _along("duration", ("impact",)),
    _along("stick_duration", ("impact",)),
    _along("peak_normal_force", ("impact",)),
    _along("max_penetration", ("impact",)),
    Variable(
        "energy_loss",
        ("impact",),
        "J",
        "W",
        "kinetic energy (u-' D^-1 u- - u+' D^-1 u+) / 2 that the impact took",
    ),
    Variable("released", ("impact",), "1", "", "whether the bodies have parted again"),
    Variable(
        "status",
        ("impact",),
        "1",
        "",
        "how the impact ended",
        flags=tuple(ending.name.lower() for ending in Ending),
    ),
    Variable("reason", ("impact",), "1", "", "why there are no numbers"),
)
HISTORY: Final = (
    Variable("time", _RECORD, "s", "t", "time since the touch-down"),
    *(_along(name, _RECORD) for name in ("normal_force", "friction_force", "gap")),
)


@final
class Impacts:
    """Impacts that many laws are asked about, as a fit does: what is given is checked once.

    Args:
        delassus: D [1/kg], shape (2, 2), or (impact, 2, 2); symmetric, positive definite.
        velocity_before: gap rate and slip [m/s], shape (2,), or (impact, 2); every gap rate negative.

    Raises:
        TypeError, ValueError: what is given is none of that; the message is a sentence.
    """

    def __init__(self, delassus: ArrayLike, velocity_before: ArrayLike) -> None:
        matrices = _numbers("The Delassus matrix", delassus, (2, 2), "in 1/kg")
        rates = _numbers("The velocity before", velocity_before, (2,), "gap rate and slip in m/s")
        counts = {len(matrices), len(rates)} - {1}
        if len(counts) > 1:
            raise ValueError(
                f"There are {len(matrices)} Delassus matrices and {len(rates)} velocities before; give as "
                "many of both, or one for all."
            )
        count = counts.pop() if counts else 1
        if not count:
            raise ValueError("There is no impact among those given; give one at least.")
        _check_matrices(matrices)
        _check_rates(rates)
        self.contacts: Array = np.empty((count, 5))
        self.contacts[:, :2] = rates
        self.contacts[:, 2:] = matrices.reshape(-1, 4)[:, [0, 1, 3]]

    def velocities_after(self, law: ContactLaw, tolerance: float | None = None) -> Array:
        """Give gap rates and slips after the impacts [m/s], shape (impact, 2), see `velocities_after`."""
        return velocities(law, self.contacts, tolerance)

    def dataset(self, law: ContactLaw, *, tolerance: float | None = None, history: int = 0) -> xarray.Dataset:
        """Give all that is known of the impacts, see `impact`."""
        check_kind("The number of records", history, int)
        if history < 0:
            raise ValueError(f"The history has {history} records; it must have one at least, or 0 for none.")
        if history and isinstance(law, MultiplierLaw):
            raise ValueError(
                f"A history of {history} records is asked for, but {law.name} is rigid: its impact is an "
                "impulse, which has none. Leave the history out, or take a compliant law."
            )
        found = struck(law, self.contacts, tolerance, history)
        return self._dataset(law, found, history > 0)

    def _dataset(self, law: ContactLaw, found: Struck, with_history: bool) -> xarray.Dataset:
        outcomes = found.outcomes
        before = self.contacts[:, :2]
        after = np.column_stack([outcomes["normal_rate"], outcomes["slip"]])
        impulse = np.column_stack([outcomes["normal_impulse"], outcomes["friction_impulse"]])
        values: dict[str, NDArray[Any]] = {
            "delassus": self.contacts[:, [2, 3, 3, 4]].reshape(-1, 2, 2),
            "velocity_before": before.copy(),
            "velocity_after": after,
            "impulse": impulse,
            "mode": outcomes["mode"].astype(np.int8),
            # W = -p' (u- + u+) / 2, as u+ - u- = D p: no difference of large numbers.
            "energy_loss": -0.5 * (impulse * (before + after)).sum(axis=1),
            "released": outcomes["released"] != 0,
            "status": found.endings,
            "reason": np.array(found.reasons),
        }
        for name in ("duration", "stick_duration", "peak_normal_force", "max_penetration"):
            values[name] = outcomes[name].copy()
        if with_history:
            values |= {one.name: found.histories[one.name].copy() for one in HISTORY}
        directions = np.array(["normal", "tangential"])
        return xarray.Dataset(
            {v.name: (v.dims, values[v.name], _words(v)) for v in (*VARIABLES, *HISTORY) if v.name in values},
            coords={"direction": directions, "other_direction": directions},
            attrs={
                **code_attributes(),
                "title": f"Impacts under the contact law {law.title}",
                "law": law.name,
                "law_parameters": json.dumps(law.describe()),
            },
        )


def impact(
    law: ContactLaw,
    delassus: ArrayLike,
    velocity_before: ArrayLike,
    *,
    tolerance: float | None = None,
    history: int = 0,
) -> xarray.Dataset:
    """Ask a law what it makes of impacts, one or many at once.

    A rigid law is asked once for each impact. Under a compliant one the engine integrates the relative motion
    of two bodies that are joined by that matrix and by nothing else, from the touch-down on a flat contact
    until they part. Where they do not (a pull that holds them, a law that dissipates all), they are watched
    100 times as long as the law's force needs to stop the approach; `released` is False then, and the
    velocity after is the one at that time.

    A law without an impulse for an impact (Painleve's paradox), or that answers with no number, leaves NaN
    there; `status` and `reason` say why. A radius of the rotor that the law asks for is that of a plate.

    Args:
        law: of either family.
        delassus: D = G M^-1 G' [1/kg], shape (2, 2), or (impact, 2, 2); symmetric, positive definite.
        velocity_before: gap rate and slip [m/s], shape (2,), or (impact, 2); every gap rate negative.
        tolerance: error of a compliant step as of `contactlab.simulate` [1]; None takes the default.
        history: number of records over each compliant contact, at equal parts of its duration, the last one
            at its end; forces are means since the record before, so that their sum times the interval is the
            impulse. 0 records nothing.

    Returns:
        A dataset with the dimensions impact and direction ("normal", "tangential"): velocity_before,
        velocity_after [m/s], impulse [N s], mode (flags), duration, stick_duration [s], peak_normal_force
        [N], max_penetration [m], energy_loss [J], released, status, reason; with a history time,
        normal_force, friction_force and gap besides, shape (impact, record). A rigid law's duration and
        penetration are zero, and its peak force, which is infinite, NaN.

    Raises:
        TypeError, ValueError: an argument of another kind or out of range; the message is a sentence.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.

    Example:
        >>> import contactlab as cl
        >>> found = cl.impact(cl.Newton(restitution=0.8), [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.0])
        >>> found.velocity_after.values
        array([[0.8, 0. ]])
    """
    return Impacts(delassus, velocity_before).dataset(law, tolerance=tolerance, history=history)


def velocities_after(
    law: ContactLaw, delassus: ArrayLike, velocity_before: ArrayLike, tolerance: float | None = None
) -> Array:
    """Give what `impact` says of the velocities after, shape (impact, 2) [m/s], and nothing else.

    Arguments, errors and numbers are those of `impact`, NaN where the law gives none. A law is asked whether
    it contradicts itself for the first of its parameters only, so that other parameters cost nothing but
    their answers. To ask about the same impacts many times, see `Impacts`.
    """
    return Impacts(delassus, velocity_before).velocities_after(law, tolerance)


def _words(variable: Variable) -> dict[str, object]:
    """Give the attributes of a variable; what is true or false, and text, has no unit."""
    attributes = cf_attributes(variable)
    if variable.name in ("released", "reason"):
        del attributes["units"], attributes["symbol"]
    return attributes


def _numbers(words: str, given: ArrayLike, shape: tuple[int, ...], meaning: str) -> Array:
    """Give numbers of many impacts, one or many being given."""
    try:
        values = np.asarray(given)
    except ValueError:
        raise ValueError(f"{words} is {shown(given)}; its rows must be of one length.") from None
    if values.ndim <= len(shape):
        values = values[None]
    check_shape(words, values, (-1, *shape), f"(impact, ...), {meaning}")
    return values.astype(np.float64)


def _check_matrices(matrices: Array) -> None:
    """Refuse what no two bodies have, by a ValueError."""
    nn, nt, tn, tt = matrices.reshape(-1, 4).T
    for words, wrong in (
        ("D_nn, which must be positive", nn <= 0.0),
        ("D_tt, which must be positive", tt <= 0.0),
    ):
        _refuse(wrong, lambda i, w=words: f"has the Delassus matrix {matrices[i].tolist()} with {w}")
    size = nn * tt
    _refuse(
        np.abs(nt - tn) > SYMMETRY * np.sqrt(size),
        lambda i: f"has the Delassus matrix {matrices[i].tolist()}; it must be symmetric: D = G M^-1 G'.",
    )
    _refuse(
        size - nt * nt <= DEFINITE * size,
        lambda i: (
            f"has the Delassus matrix {matrices[i].tolist()}, whose D_nn D_tt - D_nt^2 is "
            f"{size[i] - nt[i] ** 2:.6g}; it must be positive definite."
        ),
    )


def _check_rates(rates: Array) -> None:
    """Refuse what is no approach, by a ValueError."""
    _refuse(
        rates[:, 0] >= 0.0,
        lambda i: (
            f"has a gap rate of {rates[i, 0]:.6g} m/s before; it must be negative, as the bodies approach. "
            "Change the sign if yours is positive on approach."
        ),
    )


def _refuse(wrong: NDArray[np.bool_], words: Any) -> None:
    for i in np.flatnonzero(wrong)[:1]:
        raise ValueError(f"Impact {i}, counted from 0, {words(i)}")
