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
from contactlab.checks import as_array, check_kind, check_shape, checked_arguments
from contactlab.engine.arguments import check_law, check_tolerance
from contactlab.engine.defaults import DEFAULT_TOLERANCE
from contactlab.engine.impact import MOMENT, OUTCOME, WAY
from contactlab.engine.initial_state import fresh_state
from contactlab.engine.plant import MODES, TONES, Plant, plant_record
from contactlab.engine.preparation import Prepared, take_in
from contactlab.engine.propagator import Propagator, Workspace
from contactlab.engine.state import INCONSISTENT, PRESSED, RUNNING, STATE, ImpactBatch, Run, new_record
from contactlab.laws.base import ContactLaw, MultiplierLaw
from contactlab.motor.geometry import ContactGeometry
from contactlab.results.netcdf import cf_attributes
from contactlab.results.provenance import code_attributes
from contactlab.trajectory import Ending
from contactlab.variables import CONTACT_MODE, CONTACTS, SERIES, Variable

PIECE: Final = 500
"""Impacts that are integrated between two checks for Ctrl-C."""

FASTEST: Final = 299_792_458.0
"""Speed of a body [m/s] at most: that of light."""

LADDER: Final = 1.0
"""Longest step [s] from which each impact begins to look for its own."""


def _body() -> tuple[Plant, Propagator]:
    """Return a free body over a plate, and its step responses, both set for each impact."""
    plant = new_record(plant_record(MODES, TONES))
    plant["mode_count"], plant["geometry"] = 2, ContactGeometry(WAY, WAY, 0.0).numbers
    return plant, Workspace().propagator(plant, LADDER, LADDER, False)


class _Integration:
    """A law bound for impacts u_n, u_t [m/s], D_nn, D_nt, D_tt [1/kg], shape (impact, 5).

    With `once` the law is checked for its first parameters alone. The body is the scratch of one run at a
    time.
    """

    def __init__(
        self, law: ContactLaw, tolerance: float | None, body: tuple[Plant, Propagator], *, once: bool = False
    ) -> None:
        check_law(law)
        rigid = isinstance(law, MultiplierLaw)
        check_tolerance(tolerance, f"{law.name} answers an impact at once" if rigid else "")
        law = law.on_rotor(WAY)
        parameters, row, bound, errors = take_in(law, once)
        tolerance = DEFAULT_TOLERANCE if tolerance is None else tolerance
        self.ready = Prepared(law, LADDER, LADDER, tolerance, False, *body, bound, parameters, row, errors)

    def run(self, contacts: Array, history: int = 0) -> tuple[Any, Any, Run]:
        """Return records of `OUTCOME`, as many of `MOMENT` for each as `history`, and the last run."""
        ready = self.ready
        outcomes, histories = np.zeros(len(contacts), OUTCOME), np.zeros((len(contacts), history), MOMENT)
        states: Any = np.zeros(2, STATE)
        states[0] = fresh_state()
        # The last impact has left that of its own.
        ready.propagator["rule"]["longest"] = LADDER
        ready.set_up(states[0], LADDER)
        run = ready.run_of(states[1])
        states[0]["phase"] = PRESSED
        # With room for one contact the loop ends when that is over.
        states[0]["contact_count"] = run.step["contacts"].size - 2
        motions = np.zeros((1, 2, 2))
        records = ready.records(history + 2 if history else 0, run)
        silent = records.series[:0]
        # The impulses of a rigid law take no time.
        size = len(contacts) if isinstance(ready.law, MultiplierLaw) else PIECE
        for i in range(0, len(contacts), size):
            some = slice(i, i + size)
            impacts = ImpactBatch(contacts[some], outcomes[some], histories[some], silent)
            ready.advance(run, states, motions, records, 0, impacts)
        return outcomes, histories, run

    def explain(self, contact: Array) -> tuple[Ending, str]:
        """Return ending and reason of an impact without numbers."""
        law = self.ready.law
        outcomes, _, run = self.run(contact[None])
        if not isinstance(law, MultiplierLaw):
            longest = float(run.propagator.rule.longest)
            return self.ready._replace(contact_step=longest).explain(run)
        rate, slip, nn, nt, _ = contact
        where = f"a gap rate of {rate:.6g} m/s and a slip of {slip:.6g} m/s"
        if outcomes[0]["ending"] != INCONSISTENT:
            return Ending.DIVERGED, (
                f"The law has no finite impulse for an impact at {where}; correct it, or its parameters."
            )
        critical = nn / abs(nt) if nt else np.inf
        if law.friction_limit < critical:
            return Ending.INCONSISTENT, (
                f"The law has no normal impulse that stops {where}; check the law: an approach needs one."
            )
        return Ending.INCONSISTENT, (
            f"Painleve's paradox at {where}: the friction coefficient {law.friction_limit:.6g} is not below "
            f"the critical {critical:.6g}, D_nn/|D_nt|, so that the friction of the slip presses the bodies "
            "together more than the normal impulse parts them. Lower it, or take a law that may stick or a "
            "compliant one."
        )


SYMMETRY: Final = 1e-9
"""Largest |D_nt - D_tn| over sqrt(D_nn D_tt) that is round-off."""

DEFINITE: Final = 1e-12
"""Least D_nn D_tt - D_nt^2 over D_nn D_tt: below it round-off decides whether D is positive definite."""

ROUND_OFF: Final = 1e-9
"""Relative gain of energy that is round-off."""

_IMPACT, _PAIR, _SPEED = ("impact",), ("impact", "direction"), ("speed",)
_MATRIX: Final = ("impact", "direction", "other_direction")
_RECORD: Final = ("impact", "record")
_OF_CONTACT: Final = ("duration", "stick_duration", "peak_normal_force", "max_penetration")
_KNOWN: Final = {variable.name: variable for variable in (*CONTACTS, *SERIES)}


def _along(name: str, dims: tuple[str, ...]) -> Variable:
    """Return a quantity of runs along other dimensions."""
    known = _KNOWN[name]
    return Variable(name, dims, known.units, known.symbol, known.long_name)


VARIABLES: Final = (
    Variable("delassus", _MATRIX, "kg-1", "D", "Delassus matrix G M^-1 G'"),
    Variable("velocity_before", _PAIR, "m s-1", "u-", "gap rate and slip before the impact"),
    Variable("velocity_after", _PAIR, "m s-1", "u+", "gap rate and slip after the impact"),
    Variable("impulse", _PAIR, "N s", "p", "normal impulse and friction impulse"),
    Variable("mode", _IMPACT, "1", "m", "contact mode at the end of the impact", flags=CONTACT_MODE.flags),
    *(_along(name, _IMPACT) for name in _OF_CONTACT),
    Variable(
        "energy_loss",
        _IMPACT,
        "J",
        "W",
        "kinetic energy (u-' D^-1 u- - u+' D^-1 u+) / 2 that the impact took",
    ),
    Variable(
        "energy_ratio",
        _IMPACT,
        "1",
        "T+/T-",
        "kinetic energy u' D^-1 u / 2 after the impact over that before; above one the law created energy",
    ),
    Variable("released", _IMPACT, "1", "", "whether the bodies have parted again"),
    Variable("status", _IMPACT, "1", "", "how the impact ended", flags=tuple(e.name.lower() for e in Ending)),
    Variable("reason", _IMPACT, "1", "", "why there are no numbers"),
)
HISTORY: Final = (
    Variable("time", _RECORD, "s", "t", "time since the touch-down"),
    *(_along(name, _RECORD) for name in ("normal_force", "friction_force", "gap")),
)

NORMAL: Final = {
    variable.name: variable
    for variable in (
        Variable("restitution", _SPEED, "1", "e", "speed of separation over that of approach"),
        Variable("contact_time", _SPEED, "s", "t_c", "time from touch-down to release"),
        Variable("peak_force", _SPEED, "N", "N_max", "largest normal force"),
        Variable("penetration", _SPEED, "m", "d_max", "largest penetration"),
    )
}
"""What a normal impact, one without slip, is measured by."""


@final
class Impacts:
    """Impacts to be evaluated under many laws, as by a fit; the arguments are checked once.

    Args:
        delassus: D [1/kg], shape (2, 2), or (impact, 2, 2); symmetric, positive definite.
        velocity_before: gap rate and slip [m/s], shape (2,), or (impact, 2); every gap rate negative.

    Raises:
        TypeError, ValueError: what is given is none of that; the message is a sentence.
    """

    def __init__(self, delassus: ArrayLike, velocity_before: ArrayLike) -> None:
        matrices = _numbers("The Delassus matrix", delassus, (2, 2), "1/kg")
        rates = _numbers("The velocity before", velocity_before, (2,), "m/s")
        counts = {len(matrices), len(rates)} - {1}
        if len(counts) > 1:
            raise ValueError(
                f"There are {len(matrices)} Delassus matrices and {len(rates)} velocities before; give as "
                "many of both, or one for all."
            )
        count = counts.pop() if counts else 1
        if not count:
            raise ValueError("There is no impact among those given; give one at least.")
        _check(matrices, rates)
        self.contacts: Array = np.empty((count, 5))
        self.contacts[:, :2] = rates
        self.contacts[:, 2:] = matrices.reshape(-1, 4)[:, [0, 1, 3]]
        self._body = _body()

    @property
    def energy(self) -> Array:
        """Kinetic energy before the impacts, u' D^-1 u / 2 [J]."""
        rate, slip, nn, nt, tt = self.contacts.T
        return np.asarray(0.5 * (tt * rate**2 - 2.0 * nt * rate * slip + nn * slip**2) / (nn * tt - nt * nt))

    def outcomes(self, law: ContactLaw, tolerance: float | None = None) -> Any:
        """Return records of `OUTCOME`; a law is checked for the first of its parameters alone."""
        return _Integration(law, tolerance, self._body, once=True).run(self.contacts)[0]

    def velocities_after(self, law: ContactLaw, tolerance: float | None = None) -> Array:
        """Return gap rates and slips after the impacts [m/s], shape (impact, 2), see `velocities_after`."""
        outcomes = self.outcomes(law, tolerance)
        return np.column_stack([outcomes["normal_rate"], outcomes["slip"]])

    def dataset(self, law: ContactLaw, *, tolerance: float | None = None, history: int = 0) -> xarray.Dataset:
        """Return all that is known of the impacts, see `impact`."""
        check_kind("The number of records", history, int)
        if history < 0:
            raise ValueError(f"The history has {history} records; it must have one at least, or 0 for none.")
        if history and isinstance(law, MultiplierLaw):
            raise ValueError(
                f"A history of {history} records is requested, but {law.name} is rigid: its impact is an "
                "impulse, which has none. Leave the history out, or take a compliant law."
            )
        integration = _Integration(law, tolerance, self._body)
        outcomes, histories, _ = integration.run(self.contacts, history)
        endings = np.full(len(outcomes), Ending.COMPLETE, np.int8)
        reasons = [""] * len(outcomes)
        # The first impact of each ending; the others refer to it.
        first: dict[int, tuple[int, Ending]] = {}
        for i in np.flatnonzero(outcomes["ending"] != RUNNING).tolist():
            code = int(outcomes["ending"][i])
            if code in first:
                reasons[i] = f"As impact {first[code][0]}."
            else:
                ending, reasons[i] = integration.explain(self.contacts[i])
                first[code] = i, ending
            endings[i] = first[code][1]
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
            "energy_loss": (loss := -0.5 * (impulse * (before + after)).sum(axis=1)),
            "energy_ratio": (ratio := 1.0 - loss / self.energy),
            "released": outcomes["released"] != 0,
            "status": endings,
            "reason": np.array(reasons),
        }
        values |= {name: outcomes[name].copy() for name in _OF_CONTACT}
        if history:
            values |= {each.name: histories[each.name].copy() for each in HISTORY}
        directions = np.array(["normal", "tangential"])
        kept = [variable for variable in (*VARIABLES, *HISTORY) if variable.name in values]
        dataset = xarray.Dataset(
            {v.name: (v.dims, values[v.name], cf_attributes(v)) for v in kept},
            coords={"direction": directions, "other_direction": directions},
            attrs={
                **code_attributes(),
                "title": f"Impacts under the contact law {law.title}",
                "law": law.name,
                "law_parameters": json.dumps(law.describe()),
                "message": _created(law, ratio),
            },
        )
        # Truth values and text have no unit.
        for name in ("released", "reason"):
            del dataset[name].attrs["units"], dataset[name].attrs["symbol"]
        return dataset


@checked_arguments(tolerance="1")
def impact(
    law: ContactLaw,
    delassus: ArrayLike,
    velocity_before: ArrayLike,
    *,
    tolerance: float | None = None,
    history: int = 0,
) -> xarray.Dataset:
    """Compute the outcome of impacts under a law, one or many at once.

    A rigid law is evaluated once for each impact. Under a compliant one the engine integrates the relative
    motion of two bodies that are joined by that matrix and by nothing else, from the touch-down on a flat
    contact until they part. Where they do not (a pull that holds them, a law that dissipates all), the
    integration ends after 100 times as long as the law's force needs to stop the approach; `released` is
    False then, and the velocity after is the one at that time.

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
        [N], max_penetration [m], energy_loss [J], energy_ratio [1], released, status, reason; with a history
        time, normal_force, friction_force and gap besides, shape (impact, record). A rigid law's duration
        and penetration are zero, and its peak force, which is infinite, NaN. Where a law creates energy, the
        ratio is above one and the attribute `message` says so.

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


def delassus_of(mass: float) -> Array:
    """Return D of a point mass [kg] on a plate [1/kg], shape (2, 2)."""
    check_kind("mass", mass, float)
    if not 0.0 < mass < np.inf:
        raise ValueError(f"mass is {mass} kg; it must be greater than 0 kg and finite.")
    return np.eye(2) / mass


def normal_quantities(
    law: ContactLaw, delassus: ArrayLike, speed: ArrayLike, tolerance: float | None = None
) -> dict[str, Array]:
    """Return the quantities of `NORMAL` of impacts without slip, each of shape (speed,).

    Args:
        law: of either family.
        delassus: D [1/kg], shape (2, 2).
        speed: of the approach [m/s], positive, shape (speed,).
        tolerance: as of `impact`.

    Returns:
        SI; restitution and contact time are NaN where the bodies do not part, the peak force of a rigid law,
        whose contact takes no time, is NaN.
    """
    speeds = _numbers("The speed", speed, (), "m/s")
    for wrong in speeds[speeds <= 0.0][:1]:
        raise ValueError(f"The speed has {wrong:g} m/s among its numbers; it must be greater than 0.")
    impacts = Impacts(delassus, np.column_stack([-speeds, np.zeros_like(speeds)]))
    outcomes = impacts.outcomes(law, tolerance)
    parted = np.where(outcomes["released"] != 0, 1.0, np.nan)
    return {
        "restitution": parted * outcomes["normal_rate"] / speeds,
        "contact_time": parted * outcomes["duration"],
        "peak_force": outcomes["peak_normal_force"].copy(),
        "penetration": outcomes["max_penetration"].copy(),
    }


@checked_arguments(mass="kg", tolerance="1")
def normal_impact(
    law: ContactLaw, speed: ArrayLike, *, mass: float, tolerance: float | None = None
) -> xarray.Dataset:
    """Tabulate a law's restitution, contact time, peak force and penetration over the speed of the approach.

    They are those of a body on a plate, or of two with the reduced mass, that meet without slip.
    `contactlab.identify` is the reverse.

    Args:
        law: of either family.
        speed: of the approach [m/s], positive; one, or shape (speed,).
        mass: of the body, or m_1 m_2/(m_1 + m_2) [kg].
        tolerance: as of `contactlab.impact`.

    Returns:
        A dataset over speed: restitution [1], contact_time [s], peak_force [N], penetration [m], as of
        `normal_quantities`.

    Raises:
        TypeError, ValueError: an argument of another kind or out of range; the message is a sentence.

    Example:
        >>> import contactlab as cl
        >>> ball = cl.normal_impact(cl.HertzPenalty(), ["0.1 m/s", "0.2 m/s"], mass="2 g")
        >>> ball.contact_time.values.round(9)
        array([4.2463e-05, 3.6966e-05])
    """
    speeds = _numbers("The speed", speed, (), "m/s")
    quantities = normal_quantities(law, delassus_of(mass), speeds, tolerance)
    attributes = {"units": "m s-1", "long_name": "speed of the approach", "symbol": "v"}
    return xarray.Dataset(
        {name: (v.dims, quantities[name], cf_attributes(v)) for name, v in NORMAL.items()},
        {"speed": ("speed", speeds, attributes)},
        {
            **code_attributes(),
            "title": f"Normal impacts under the contact law {law.title}",
            "law": law.name,
            "law_parameters": json.dumps(law.describe()),
            "mass": mass,
        },
    )


def velocities_after(
    law: ContactLaw, delassus: ArrayLike, velocity_before: ArrayLike, tolerance: float | None = None
) -> Array:
    """Return what `impact` says of the velocities after, shape (impact, 2) [m/s], and nothing else.

    Arguments, errors and numbers are those of `impact`, NaN where the law gives none. A law is
    checked for consistency for the first of its parameters only, so that other parameters cost nothing but
    their answers. To ask about the same impacts many times, see `Impacts`.
    """
    return Impacts(delassus, velocity_before).velocities_after(law, tolerance)


def _created(law: ContactLaw, ratio: Array) -> str:
    """Return in which impacts a law created energy, as a sentence; empty where it did not."""
    gains = np.flatnonzero(ratio > 1.0 + ROUND_OFF)
    if not gains.size:
        return ""
    most = int(gains[np.argmax(ratio[gains])])
    return (
        f"{law.name} creates energy in {gains.size} of {ratio.size} impacts: after impact {most} the kinetic "
        f"energy is {ratio[most]:.4g} times that before, which no passive bodies can have."
    )


def _numbers(name: str, values: ArrayLike, shape: tuple[int, ...], unit: str) -> Array:
    """Return the numbers of one or many impacts with the impact as first axis."""
    array = as_array(name, values, unit)
    array = array[None] if array.ndim <= len(shape) else array
    check_shape(name, array, (-1, *shape), f"(impact, ...), in {unit}")
    return array


def _check(matrices: Array, rates: Array) -> None:
    """Raise a ValueError for the first impact without an approach or a positive definite Delassus matrix."""
    nn, nt, tn, tt = matrices.reshape(-1, 4).T
    size = nn * tt
    for faulty, fault in (
        (nn <= 0.0, "D_nn must be positive"),
        (tt <= 0.0, "D_tt must be positive"),
        (np.abs(nt - tn) > SYMMETRY * np.sqrt(np.abs(size)), "it must be symmetric, D = G M^-1 G'"),
        (size - nt * nt <= DEFINITE * size, "it must be positive definite, D_nn D_tt > D_nt^2"),
    ):
        for i in np.flatnonzero(faulty)[:1]:
            raise ValueError(
                f"Impact {i}, counted from 0, has the Delassus matrix {matrices[i].tolist()}; {fault}."
            )
    for i, j in np.argwhere(np.abs(rates) > FASTEST)[:1]:
        raise ValueError(
            f"Impact {i}, counted from 0, has a velocity of {rates[i, j]:.6g} m/s before; it must be at most "
            f"{FASTEST:.6g} m/s, that of light."
        )
    for i in np.flatnonzero(rates[:, 0] >= 0.0)[:1]:
        raise ValueError(
            f"Impact {i}, counted from 0, has a gap rate of {rates[i, 0]:.6g} m/s before; it must be "
            "negative, as the bodies approach. Change the sign if yours is positive on approach."
        )
