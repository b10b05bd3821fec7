"""Numbers of a law from what is known of it: restitutions, contact times, forces, materials.

A normal impact of a law, computed by the engine as any other, has a restitution, a contact time, a peak force
and a penetration at each speed. The numbers of the law that meet required values are solved for by least
squares of the logarithms, log(q / q_required), in the unit cube of the numbers' ranges: no formula of a law
is used, so that every law is identified alike, a user's own too.

Which numbers are solved for follows from the law: as many as the quantities determine, and of those that
do the first in the order of its fields. What no quantity determines stays as it is, and is named.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, compress
from math import exp, expm1, inf, isfinite, isnan, pi, sqrt, tan
from typing import Annotated, Any, Final, Self, final

import numpy as np
import pandas
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.checks import check_kind, checked_arguments
from contactlab.engine.arguments import check_law
from contactlab.impacts import FASTEST, NORMAL, delassus_of, normal_quantities
from contactlab.laws import ContactLaw, MultiplierLaw
from contactlab.parameter import from_cf, positive
from contactlab.quantity import UnitError, to_si
from contactlab_data.inference.free_parameters import (
    FreeParameter,
    free_parameters,
    from_cube,
    to_cube,
    with_values,
)
from contactlab_data.inference.least_squares import best_fit
from contactlab_data.inference.materials import Materials, effective_modulus

IMPACT_TOLERANCE: Final = 1e-11
"""Tolerance of the compliant impacts that are solved for."""

EXACT: Final = 1e-6
"""Largest |log(q / q_required)| that is agreement, unless a caller admits more."""

REACH: Final = 1e6
"""Factor, up and down, in which a positive number without upper bound is searched: a range of a fit, which is
a prior, is narrower."""

POINTS: Final = 9
"""Values of a number over its range at which its effects are looked for."""

EFFECT: Final = 1e-5
"""Least change of log q over the range of a number that is an effect of it; impacts err by some 1e-11."""

STEP: Final = 1e-5
"""Step of finite differences in the unit cube."""

SINGULAR: Final = 1e-5
"""Singular value, over the largest, below which quantities do not determine a combination of numbers."""

LOOKS: Final = 32
"""Points from the best of which a search begins, if one from the law's own values fails."""

RADII: Final = ("R", "m"), ("R'", "m"), ("R''", "m")
"""Symbols and units of the numbers that a radius sets."""

Required = float | str | tuple[float | str, float | str] | list[Any]
"""Value and speed of a quantity, "0.8 @ 0.5 m/s" or (0.8, 0.5), or a list of such."""


@final
@dataclass(frozen=True)
class Datum:
    """A quantity that a law must have in a normal impact.

    >>> Datum("contact_time", "50 us", "0.1 m/s")
    Datum(quantity='contact_time', value=5e-05, speed=0.1)

    Args:
        quantity: a key of `contactlab.impacts.NORMAL`.
        value: greater than 0, a restitution at most 1; SI, or a text with a unit.
        speed: of the approach, greater than 0 and at most that of light [m/s], or a text with a unit.
    """

    quantity: str
    value: float
    speed: float

    def __post_init__(self) -> None:
        if self.quantity not in NORMAL:
            raise ValueError(f"quantity is '{self.quantity}'; it must be one of {', '.join(NORMAL)}.")
        highest = 1.0 if self.quantity == "restitution" else inf
        for name, label, unit, most in (
            ("value", self.quantity, self.unit, highest),
            ("speed", f"speed of {self.quantity}", "m/s", FASTEST),
        ):
            x = getattr(self, name)
            try:
                number = to_si(x.strip(), unit) if isinstance(x, str) else x
            except UnitError as error:
                raise UnitError(f"{label} is '{x}', {error}.") from error
            check_kind(label, number, float)
            if not (0.0 < number <= most and isfinite(number)):
                bound = "" if most == inf else f" and at most {most:g}"
                raise ValueError(f"{label} is {number:g}; it must be greater than 0{bound}.")
            object.__setattr__(self, name, float(number))

    @classmethod
    def each(cls, quantity: str, required: Required) -> Iterator[Self]:
        """Yield what is required of a quantity; see `Required`."""
        for item in required if isinstance(required, list) else [required]:
            pair: Any = tuple(item.split("@")) if isinstance(item, str) else item
            if not (isinstance(pair, tuple) and len(pair) == 2):
                raise ValueError(
                    f"{quantity} is {item!r}; it must have a value and the speed of the impact, as "
                    "'0.8 @ 0.5 m/s' or (0.8, 0.5), or be a list of such."
                )
            yield cls(quantity, *pair)

    @property
    def unit(self) -> str:
        """The unit of the value, as configurations write it."""
        return from_cf(NORMAL[self.quantity].units)

    def __str__(self) -> str:
        return f"{self.quantity}={self.value}@{self.speed}"

    def measured(self, law: ContactLaw, delassus: Array) -> float:
        """Return the quantity of a law's normal impact; NaN where the bodies do not part."""
        return float(_measured(law, [self], delassus)[0])


def _measured(law: ContactLaw, data: Sequence[Datum], delassus: Array) -> Array:
    """Return the quantities of the data under a law, shape (datum,)."""
    tolerance = None if isinstance(law, MultiplierLaw) else IMPACT_TOLERANCE
    every = normal_quantities(law, delassus, [datum.speed for datum in data], tolerance)
    return np.array([every[datum.quantity][i] for i, datum in enumerate(data)])


@final
@dataclass(frozen=True, eq=False)
class Requirements:
    """Data that a law is to meet by its free numbers.

    Args:
        law: with the values of what is not free.
        data: at least one.
        delassus: D of the bodies [1/kg], shape (2, 2).
        free: the numbers that may be solved for, in their ranges.
        tolerance: largest |log(q / q_required)| that is agreement.
    """

    law: ContactLaw
    data: tuple[Datum, ...]
    delassus: Array
    free: tuple[FreeParameter, ...]
    tolerance: float = EXACT

    def misses(self, free: Sequence[FreeParameter], values: Sequence[float] | Array) -> Array:
        """Return log(q / q_required) with some numbers changed, shape (datum,); NaN or infinite without q."""
        try:
            changed = with_values(self.law, free, values)
        except ValueError:
            return np.full(len(self.data), np.nan)
        required = np.array([datum.value for datum in self.data])
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.log(_measured(changed, self.data, self.delassus) / required))

    def start(self, free: Sequence[FreeParameter]) -> Array:
        """Return the law's own values of some numbers [SI]."""
        every = self.law.describe()
        return np.array([every[item.name] for item in free])

    def scan(self) -> Array:
        """Return `misses` over the range of each number by itself, shape (number, point, datum)."""
        shares = np.linspace(0.0, 1.0, POINTS)
        scanned = [[self.misses([x], [x.from_unit(share)]) for share in shares] for x in self.free]
        return np.array(scanned).reshape(len(self.free), POINTS, len(self.data))

    def slopes(self, free: Sequence[FreeParameter], values: Array) -> Array:
        """Return derivatives of `misses` in the unit cube, shape (datum, number)."""
        columns = []
        for i, share in enumerate(to_cube(free, values)):
            ends = max(share - STEP, 0.0), min(share + STEP, 1.0)
            low, high = ([*values[:i], free[i].from_unit(x), *values[i + 1 :]] for x in ends)
            columns.append((self.misses(free, high) - self.misses(free, low)) / (ends[1] - ends[0]))
        return np.array(columns).T.reshape(len(self.data), len(free))

    def met(self, scanned: Array) -> tuple[tuple[FreeParameter, ...], Array] | None:
        """Return the numbers that the data determine, and their values [SI]; None if nothing meets the data.

        The most numbers whose effects on the data are independent; of several such sets the first, in the
        order of the law's fields.

        Args:
            scanned: that of `scan`.
        """
        effects = effects_of(scanned)
        able = [i for i in range(len(self.free)) if effects[i].any()]
        reached = effects.any(axis=0)
        if not np.all(np.abs(self.misses((), ())[~reached]) <= self.tolerance):
            return None
        for count in range(min(len(able), int(reached.sum())), 0, -1):
            solved = False
            for chosen in combinations(able, count):
                free = tuple(self.free[i] for i in chosen)
                if not np.array_equal(effects[[*chosen]].any(axis=0), reached):
                    continue
                if (values := self._solved(free)) is None:
                    continue
                solved, slopes = True, self.slopes(free, values)
                sizes = np.linalg.svd(slopes, compute_uv=False) if np.isfinite(slopes).all() else np.zeros(1)
                if sizes[-1] > SINGULAR * sizes[0]:
                    return free, self._polished(free, values, slopes)
            if not solved:
                # What more numbers do not meet, fewer of them do not.
                return None
        return None if reached.any() else ((), np.empty(0))

    def _solved(self, free: Sequence[FreeParameter]) -> Array | None:
        """Return values with which some numbers meet the data [SI], or None; searched from the law's own.

        A number with the symbol e is tried at the required restitution first.
        """
        required = [datum.value for datum in self.data if datum.quantity == "restitution"][:1]
        stated = [
            required[0] if required and item.parameter.symbol == "e" else own
            for item, own in zip(free, self.start(free), strict=True)
        ]
        if np.all(np.abs(self.misses(free, stated)) <= self.tolerance):
            return np.array(stated)
        for begin in (self.start(free), None):
            try:
                best = best_fit(partial(self.misses, free), free, 1, 0, looks=LOOKS, begin=begin, step=STEP)
            except ValueError:
                # The law is finite at none of the points.
                continue
            if np.all(np.abs(self.misses(free, best.values)) <= self.tolerance):
                return best.values
        return None

    def _polished(self, free: Sequence[FreeParameter], values: Array, slopes: Array) -> Array:
        """Return values after a step of Gauss and Newton, to an end of a range too: a search stays inside."""
        misses = self.misses(free, values)
        shares = to_cube(free, values) - np.linalg.pinv(slopes) @ misses
        nearer = from_cube(free, np.clip(shares, 0.0, 1.0))
        return nearer if np.linalg.norm(self.misses(free, nearer)) < np.linalg.norm(misses) else values


def effects_of(scanned: Array) -> NDArray[np.bool_]:
    """Return whether each number has an effect on each datum, shape (number, datum)."""
    finite = np.isfinite(scanned)
    spread = np.where(finite, scanned, -inf).max(axis=1) - np.where(finite, scanned, inf).min(axis=1)
    return np.asarray(finite.any(axis=1) & (spread > EFFECT))


def searched(law: ContactLaw, names: Sequence[str] | None = None) -> tuple[FreeParameter, ...]:
    """Return numbers of a law, None are all, each in the range in which it is searched.

    Raises:
        ValueError: the law has no such number.
    """
    own, result = law.describe(), []
    for item in free_parameters(law, None if names is None else dict.fromkeys(names)):
        value, declared = own[item.name], item.parameter
        low, high = max(declared.above, declared.at_least), min(declared.below, declared.at_most)
        if low == 0.0 < value and high == inf:
            item = replace(item, low=value / REACH, high=value * REACH, logarithmic=True)
        result.append(item)
    return tuple(result)


def calibrated(law: ContactLaw, datum: Datum, delassus: Array) -> dict[str, float]:
    """Return the numbers of a law that bring it to a datum, by name [SI]; D [1/kg] of shape (2, 2).

    They are mass and speed of a restitution, where the law states its own for them, and the first number
    that meets the datum then. Empty where none does in the range of a fit, as to a restitution under a law
    without loss.
    """
    mass = 1.0 / float(delassus[0, 0]) if datum.quantity == "restitution" else None
    impact = _impact_numbers(law, [datum], mass)
    set_first = {name: value for name, (value, _) in impact.items()}
    for name, value in set_first.items():
        law = law.changed(name, value)
    free = tuple(item for item in free_parameters(law) if item.name not in set_first)
    required = Requirements(law, (datum,), delassus, free)
    met = required.met(required.scan())
    return set_first | {met[0][0].name: float(met[1][0])} if met and met[0] else {}


def _impact_numbers(
    law: ContactLaw, data: Sequence[Datum], mass: float | None
) -> dict[str, tuple[float, str]]:
    """Return mass and speed of the impacts for which a law states its restitution [SI], with their sources.

    A dashpot has its restitution at one mass, most have it at one speed, others down to a least speed:
    numbers with the symbols m, v and v_min. Restitutions at several speeds state none, nor does one that the
    law does not admit: at another speed it may have it.
    """
    required = {datum.speed: datum.value for datum in data if datum.quantity == "restitution"}
    speeds = [*required] if all(_admits(law, value) for value in required.values()) else []
    result = dict[str, tuple[float, str]]()
    for name, value, declared in law.effective():
        match (declared.symbol, declared.units) if declared else None:
            case ("m", "kg") if mass is not None:
                result[name] = mass, "mass"
            case ("v", "m s-1") if len(speeds) == 1:
                result[name] = min(speeds), "restitution"
            case ("v_min", "m s-1") if speeds and min(speeds) < value:
                result[name] = min(speeds), "restitution"
    return result


def _admits(law: ContactLaw, restitution: float) -> bool:
    """Return whether a law admits a restitution as its number e, if it has one."""
    try:
        for name, _, declared in law.effective():
            if declared is not None and declared.symbol == "e":
                law.changed(name, restitution)
    except ValueError:
        return False
    return True


@final
@dataclass(frozen=True, eq=False)
class Identification:
    """A law with identified numbers, and where each of them comes from.

    Args:
        law: with its numbers set.
        parameters: a row for each number of the law: value [SI], unit, the quantities that it comes `from`,
            empty where it is the law's own, and the quantities on which it acts nearby.
        quantities: a row for each required quantity: speed [m/s], required and reached value [SI], and the
            relative difference between the two.
    """

    law: ContactLaw
    parameters: pandas.DataFrame
    quantities: pandas.DataFrame

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the numbers that no quantity determines."""
        return tuple(self.parameters.index[self.parameters["from"] == ""])

    def __str__(self) -> str:
        numbers = [
            f"{name} = {row['value']:.6g}{'' if row['unit'] in ('', '1') else f' {row.unit}'}"
            for name, row in self.parameters.iterrows()
            if row["from"]
        ]
        tables = [self.parameters, *([self.quantities] if len(self.quantities) else [])]
        written = [table.to_string(float_format="{:.6g}".format) for table in tables]
        head = f"{', '.join(numbers)}.\nFree: {', '.join(self.free) or 'nothing'}."
        return "\n\n".join([f"{self.law.title}: {head}", *written])


@checked_arguments(mass="kg", radius="m", friction_angle="rad")
def identify(
    law: ContactLaw,
    *,
    mass: float | None = None,
    restitution: Required | None = None,
    contact_time: Required | None = None,
    peak_force: Required | None = None,
    penetration: Required | None = None,
    materials: Materials | None = None,
    radius: float | None = None,
    friction_angle: float | None = None,
    free: Sequence[str] | None = None,
    tolerance: Annotated[float, positive("", "1", "largest difference of a quantity")] = EXACT,
) -> Identification:
    """Set the numbers of a law by measured or handbook quantities; `contactlab.normal_impact` is the reverse.

    Mass, materials, radius and angle of friction set what a law declares by symbol and unit:

        1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2,   K = 4/3 E* sqrt(R),   mu = tan(angle)

    Other numbers then meet the quantities of impacts: as many as these determine, and of those that do the
    first in the order of the law's fields. Of two values that meet a quantity it is the one to which a search
    from the law's own leads.

    Args:
        law: of either family, with its other numbers.
        mass: of the body that meets a plate, or m_1 m_2/(m_1 + m_2) of two [kg].
        restitution, contact_time, peak_force, penetration: value and speed of the impact, "0.8 @ 0.5 m/s" or
            (0.8, 0.5), or a list of such.
        materials: of the two bodies, "steel on alumina" of `contactlab_data.inference.materials`, or two of
            its `Material` with constants of your own.
        radius: relative radius R of the bodies [m], 1/R = 1/R_1 + 1/R_2.
        friction_angle: of the incline on which a body begins to slide [rad], or a text, "17 deg".
        free: names of the numbers that may change to meet the quantities of impacts; None is all others, and
            a law that states its restitution for one speed then does for that of the required one.
        tolerance: largest relative difference of a quantity from its required value.

    Raises:
        TypeError, ValueError: an argument is faulty, the law has no number for it, it cannot have the
            quantity, or quantities contradict each other; the message names them, with value and bound.

    Example:
        >>> import contactlab as cl
        >>> law = cl.Composed(damping=cl.Flores())
        >>> ball = dict(mass="2.5 g", contact_time="50 us @ 0.5 m/s", restitution="0.8 @ 0.5 m/s")
        >>> result = cl.identify(law, **ball)
        >>> result.free
        ('damping.least_speed', 'friction.friction_coefficient', 'friction.static_ratio')
        >>> f"{result.law.normal.stiffness:.4g} N/m^1.5"
        '3.974e+09 N/m^1.5'
    """
    check_law(law)
    for name, value in (("mass", mass), ("radius", radius), ("friction_angle", friction_angle)):
        _check_positive(name, value, pi / 2.0 if name == "friction_angle" else inf)
    required = {"restitution": restitution, "contact_time": contact_time}
    required |= {"peak_force": peak_force, "penetration": penetration}
    data = tuple(datum for name, x in required.items() if x is not None for datum in Datum.each(name, x))
    known = _impact_numbers(law, data if free is None else (), mass)
    known |= _known(law, materials, radius, friction_angle)
    if not (data or known):
        raise ValueError("Nothing is known; there must be a quantity of an impact, materials or an angle.")
    for name, (value, _) in known.items():
        law = law.changed(name, value)
    sources = {name: source for name, (_, source) in known.items()}
    if not data:
        return _identified(Requirements(law, (), np.eye(2), ()), sources)
    if mass is None:
        raise ValueError(f"mass is missing; {data[0].quantity} is that of an impact, and needs it.")
    names = [item.name for item in searched(law) if item.name not in known] if free is None else free
    requirements = Requirements(law, data, delassus_of(mass), searched(law, names), tolerance)
    scanned = requirements.scan()
    if (met := requirements.met(scanned)) is None:
        raise ValueError(_refusal(requirements, scanned))
    if met[0]:
        # Effects of the required values on the numbers: where the first is zero, so is the second.
        gains = np.abs(np.linalg.pinv(requirements.slopes(*met)))
        for item, gain in zip(met[0], gains, strict=True):
            sources[item.name] = _names(data, gain > SINGULAR * gain.max())
    return _identified(replace(requirements, law=with_values(law, *met)), sources)


def _check_positive(name: str, value: float | None, most: float) -> None:
    if value is not None:
        check_kind(name, value, float)
        if not 0.0 < value < most:
            raise ValueError(f"{name} is {value}; it must be greater than 0 and less than {most:g}.")


def _names(data: Sequence[Datum], chosen: NDArray[np.bool_]) -> str:
    """Return the names of the quantities of some data."""
    return ", ".join(dict.fromkeys(datum.quantity for datum in compress(data, chosen)))


def _known(
    law: ContactLaw, materials: Materials | None, radius: float | None, friction_angle: float | None
) -> dict[str, tuple[float, str]]:
    """Return the numbers of a law that follow without an impact [SI], each with what it comes from.

    Raises:
        TypeError, ValueError: what is known is faulty, or sets no number of the law.
    """
    derived: dict[tuple[str, str], tuple[float, str]] = {}
    if radius is not None:
        derived |= dict.fromkeys(RADII, (radius, "radius"))
    if friction_angle is not None:
        derived["mu", "1"] = tan(friction_angle), "friction_angle"
    if materials is not None:
        modulus = effective_modulus(materials)
        derived["E*", "Pa"] = modulus, "materials"
        if radius is not None:
            derived["K", "N m-1.5"] = 4.0 / 3.0 * modulus * sqrt(radius), "materials, radius"
    places = {name: (each.symbol, each.units) for name, _, each in law.effective() if each is not None}
    known = {name: derived[place] for name, place in places.items() if place in derived}
    used = ", ".join(source for _, source in known.values())
    arguments = {"materials": materials, "radius": radius, "friction_angle": friction_angle}
    for name, argument in arguments.items():
        if argument is not None and name not in used:
            every = ", ".join(f"{symbol} [{from_cf(units)}]" for symbol, units in places.values())
            raise ValueError(
                f"{name} sets no number of {law.title}, which has {every or 'none'}; materials set E* [Pa], "
                "a radius R [m], both together K [N/m^1.5], friction_angle mu [1]."
            )
    return known


def _identified(requirements: Requirements, sources: dict[str, str]) -> Identification:
    """Return a law with the tables of its numbers and of what it reaches."""
    law, data = requirements.law, requirements.data
    free = searched(law)
    misses = requirements.misses((), ()) if data else np.empty(0)
    slopes = requirements.slopes(free, requirements.start(free)) if data else np.empty((0, len(free)))
    acts = {x.name: _names(data, np.abs(slope) > EFFECT) for x, slope in zip(free, slopes.T, strict=True)}
    rows = [
        (name, value, declared.unit if declared else "", sources.get(name, ""), acts.get(name, ""))
        for name, value, declared in law.effective()
    ]
    quantities = [
        (x.quantity, x.unit, x.speed, x.value, x.value * exp(miss), expm1(miss))
        for x, miss in zip(data, misses, strict=True)
    ]
    parameters = pandas.DataFrame(rows, columns=["parameter", "value", "unit", "from", "acts on"])
    columns = ["quantity", "unit", "speed", "required", "reached", "residual"]
    reached = pandas.DataFrame(quantities, columns=columns).set_index("quantity")
    return Identification(law, parameters.set_index("parameter"), reached)


def _refusal(requirements: Requirements, scanned: Array) -> str:
    """Return why no numbers of a law meet the data, as sentences."""
    law, data, free = requirements.law, requirements.data, requirements.free
    names = ", ".join(item.name for item in free) or "nothing"
    effects, own = effects_of(scanned), requirements.misses((), ())
    required = " and ".join(map(str, data))
    text = f"{required} cannot be met within {requirements.tolerance:g} by {law.title} with {names} free."
    for i, datum in enumerate(data):
        known = [x for x in [*scanned[..., i].ravel(), own[i]] if not isnan(x)]
        low, high = min(known, default=inf), max(known, default=-inf)
        alone = len(data) == 1 or not effects[:, i].any()
        if alone and max(low, -high) > requirements.tolerance:
            unit = "" if datum.unit == "1" else f" {datum.unit}"
            ends = [f"{datum.value * np.exp(end):.6g}{unit}" for end in (low, high) if known]
            has = " to ".join(dict.fromkeys(ends)) or "none"
            text = f"{datum} is required; {law.title} has {has} with any of {names} changed."
            break
    return f"{text} {_bound(law, free)}".rstrip()


def _bound(law: ContactLaw, free: Sequence[FreeParameter]) -> str:
    """Return that a law refuses an end of a range, with its sentence; empty if it admits all."""
    for item in free:
        for end in (item.low, item.high):
            try:
                with_values(law, [item], [end])
            except ValueError as error:
                return f"Not all values are admitted: {error}"
    return ""
