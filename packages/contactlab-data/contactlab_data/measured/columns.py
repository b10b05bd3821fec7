"""Columns of a file of measured impacts, and their reduction to velocities of the contact in SI.

A file has velocities in any coordinates before and after each impact, mass matrix and contact Jacobian; or
gap rate and slip, and the Delassus matrix. Names contain coordinates: `before_x`, `mass_x`, `normal_angle`.
"""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import combinations_with_replacement
from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.motor.table import MeasurementError, Table, refuse
from contactlab.parameter import from_cf
from contactlab.quantity import UnitError, factor
from contactlab.suggestion import excerpt
from contactlab_data.measured.bodies import BodyImpacts, sign_note
from contactlab_data.measured.impacts import MeasuredImpacts, odd_energies, squared_norm
from contactlab_data.measured.series import MEASURABLE

CONTACT: Final = ("gap_rate", "slip")
"""Coordinates of a file with velocities of the contact."""

PASSES_THROUGH: Final = 0.05
"""Share of the approach with which bodies may leave into each other, median: errors of a plastic impact."""

_CHECKED: Final = "checked"


@final
class Column(NamedTuple):
    """A kind of columns.

    Args:
        form: the name, with `{}` for each coordinate.
        units: SI, in the notation of the CF conventions, by the number of coordinates that are angles.
        meaning: a few words.
    """

    form: str
    units: tuple[str, ...]
    meaning: str

    def names(self, *coordinates: str) -> tuple[str, ...]:
        """Return the names for some coordinates; a pair may come in either order."""
        return tuple(dict.fromkeys((self.form.format(*coordinates), self.form.format(*coordinates[::-1]))))


_VELOCITY: Final = ("m s-1", "rad s-1")
_SQUARE: Final = ("m2 s-2", "m rad s-2", "rad2 s-2")

BEFORE: Final = Column("before_{}", _VELOCITY, "velocity before the impact")
AFTER: Final = Column("after_{}", _VELOCITY, "velocity after the impact")
MASS: Final = Column("mass_{}", ("kg", "kg m2"), "mass or moment of inertia")
COUPLING: Final = Column("mass_{}_{}", ("kg", "kg m", "kg m2"), "element of the mass matrix")
NORMAL: Final = Column("normal_{}", ("1", "m rad-1"), "gap rate for a unit velocity")
TANGENTIAL: Final = Column("tangential_{}", ("1", "m rad-1"), "slip for a unit velocity")
DELASSUS: Final = (
    Column("delassus_nn", ("kg-1",), "gap rate for a normal impulse of 1 N s"),
    Column("delassus_nt", ("kg-1",), "gap rate for a tangential impulse of 1 N s"),
    Column("delassus_tt", ("kg-1",), "slip for a tangential impulse of 1 N s"),
)
ERROR_BEFORE: Final = Column("error_before_{}", _VELOCITY, "standard deviation of the velocity before")
ERROR_AFTER: Final = Column("error_after_{}", _VELOCITY, "standard deviation of the velocity after")
COVARIANCE_BEFORE: Final = Column("covariance_before_{}_{}", _SQUARE, "covariance of the velocities before")
COVARIANCE_AFTER: Final = Column("covariance_after_{}_{}", _SQUARE, "covariance of the velocities after")
KINETIC_ENERGY: Final = Column("kinetic_energy", ("J",), "of the whole body before the impact")
OUTSIDE: Final = Column("outside_energy", ("J",), "of the part of the jump that no impulse makes")
FLAG: Final = Column("flag", ("1",), "not 0: the impact is left out")
IMPACT: Final = Column("impact", ("1",), "number of the impact")
MEASUREMENT: Final = Column("measurement", ("1",), "label of the measurement that the impact repeats")
LEFT_OUT: Final = Column("left_out", ("1",), "number of impacts left out before")

BODY_COLUMNS: Final = (BEFORE, AFTER, MASS, COUPLING, NORMAL, TANGENTIAL)
CONTACT_COLUMNS: Final = (BEFORE, AFTER, *DELASSUS, KINETIC_ENERGY, OUTSIDE)
OTHER_COLUMNS: Final = (
    *(ERROR_BEFORE, ERROR_AFTER, COVARIANCE_BEFORE, COVARIANCE_AFTER),
    *(FLAG, IMPACT, MEASUREMENT, LEFT_OUT),
)


def known_names(angles: Mapping[str, bool], *, contact: bool) -> dict[str, str]:
    """Return all names of columns besides flags, with their units.

    Args:
        angles: whether each coordinate is an angle, by name.
        contact: whether the velocities are those of the contact.
    """
    columns = [*(CONTACT_COLUMNS if contact else BODY_COLUMNS), *OTHER_COLUMNS]
    if len(angles) == 1:
        # A single direction, which is the normal one.
        columns = [column for column in columns if column not in (TANGENTIAL, *DELASSUS[1:])]
    result: dict[str, str] = {}
    for column in columns:
        for several in combinations_with_replacement(angles, column.form.count("{}")):
            if column is not COUPLING or several[0] != several[1]:
                units = column.units[sum(angles[each] for each in several)]
                result |= dict.fromkeys(column.names(*several), units)
    return result


def impacts_of(table: Table, title: str) -> MeasuredImpacts:
    """Return the impacts of a table; the title is the default one.

    Raises:
        MeasurementError: a column is missing, unknown or in a wrong unit, or the impacts contradict
        mechanics.
    """
    columns, texts = _Columns(table), table.texts
    places, keep = columns.places, jacobian_is_checked(texts, applies=not columns.contact)
    notes = texts["note"].split("\n") if "note" in texts else []
    before, after, covariance = columns.all_of(BEFORE), columns.all_of(AFTER), columns.covariance()
    bodies = None
    if columns.contact:
        delassus = columns.delassus()
    else:
        mass = columns.matrix(columns.all_of(MASS), COUPLING)
        _check_positive(mass, "mass matrix", places, np.nextafter(0.0, 1.0))
        normal = columns.all_of(NORMAL)
        if len(columns.angles) == 1:
            square = normal[:, :, None] ** 2
            covariance = None if covariance is None else square * covariance
            before, after, delassus = before * normal, after * normal, square / mass
        else:
            turning = [place for place, is_angle in enumerate(columns.angles.values()) if is_angle]
            rotation = turning[0] if len(turning) == 1 and len(columns.angles) == 3 else None
            tangential = columns.all_of(TANGENTIAL)
            bodies = BodyImpacts(before, after, mass, normal, tangential, covariance, rotation)
            before, after = bodies.contact(before), bodies.contact(after)
            delassus, covariance = bodies.delassus(), bodies.contact_covariance()
    if before.shape[1] == 1:
        before, after = (np.hstack([x, np.zeros_like(x)]) for x in (before, after))
        delassus = delassus * np.eye(2)
        covariance = None if covariance is None else covariance * np.diag([1.0, 0.0])
        notes.append("The data have no tangential direction: the slip is zero.")
    _check_positive(delassus, "Delassus matrix", places, 1e-9)
    if bodies is not None and len(columns.angles) > 2:
        notes.append(sign_note(bodies, columns.angles, keep=keep))
    _check_approach(before[:, 0], after[:, 0], places)
    notes += odd_energies(before, after, delassus)
    if bodies is not None:
        kinetic, outside = bodies.energy(bodies.before), bodies.outside()
    else:
        least = 0.5 * squared_norm(delassus, before)
        kinetic = least if (stated := columns.option(KINETIC_ENERGY)) is None else stated
        outside = np.zeros_like(least) if (stated := columns.option(OUTSIDE)) is None else stated
        refuse(
            kinetic < least * (1.0 - 1e-9),
            lambda at: (
                f"kinetic_energy in {places[at]} is {kinetic[at]:g} J; that of the contact is greater."
            ),
        )
        refuse(outside < 0.0, lambda at: f"outside_energy is negative in {places[at]}.")
    left_out, number = columns.option(LEFT_OUT), columns.whole(IMPACT)
    if number is not None and np.unique(number).size < number.size:
        raise MeasurementError("impact is the same in two rows; each impact must have a number of its own.")
    return MeasuredImpacts(
        delassus=delassus,
        velocity_before=before,
        velocity_after=after,
        kinetic_energy=kinetic,
        outside=outside,
        covariance=covariance,
        title=texts.get("title", title),
        source=texts.get("source", ""),
        licence=texts.get("licence", ""),
        left_out=len(table.places) - columns.rows.size + (0 if left_out is None else int(left_out[0])),
        number=columns.rows + 1 if number is None else number,
        # A file that was written from impacts has its notes already.
        notes=tuple(dict.fromkeys(notes)),
        measurement=columns.whole(MEASUREMENT),
        bodies=bodies,
    )


def jacobian_is_checked(texts: Mapping[str, str], *, applies: bool) -> bool:
    """Return whether the texts of a file state that its Jacobian is right.

    Raises:
        MeasurementError: they state something else, or there is no Jacobian.
    """
    keep = texts.get("jacobian")
    if keep is not None and not (applies and keep.strip() == _CHECKED):
        raise MeasurementError(
            f"'jacobian' is '{keep}'; it must be '{_CHECKED}', beside a Jacobian, or absent."
        )
    return keep is not None


def _check_positive(matrices: Array, name: str, places: Sequence[str], least: float) -> None:
    """Refuse symmetric matrices with an eigenvalue below a share of the largest, negative if semidefinite."""
    values = np.linalg.eigvalsh(matrices)
    refuse(
        (values[:, 0] < least * values[:, -1]) | ((least > 0.0) & (values[:, 0] <= 0.0)),
        lambda at: (
            f"the {name} of {places[at]} is {matrices[at].tolist()}; it must be positive "
            f"{'semi' if least < 0.0 else ''}definite."
        ),
    )


def _check_approach(before: Array, after: Array, places: Sequence[str]) -> None:
    """Refuse gap rates [m/s] of bodies that do not approach, or that pass through each other."""
    leaving = before >= 0.0
    count = int(leaving.sum())
    way_out = (
        "reverse the normal columns or the gap rates, or exchange before and after"
        if 2 * count > before.size
        else "correct these impacts, or mark them in the column 'flag'"
    )
    refuse(
        leaving,
        lambda at: (
            f"the gap rate before the impact is {before[at]:.4g} m/s in {places[at]}; it must be negative, "
            f"and is not in {count} of {before.size} impacts: {way_out}."
        ),
    )
    passing = float(np.median(after / before))
    if passing > PASSES_THROUGH:
        raise MeasurementError(
            f"the gap rate after the impact is {passing:.3g} times that before it (median), so that the "
            "bodies pass through each other; it must be positive. Correct the sign of the after columns."
        )


@final
class _Columns:
    """Columns of the impacts that no flag excludes.

    Attributes:
        angles: whether each coordinate is an angle, by name.
        contact: whether the velocities are those of the contact.
        rows: indices of the impacts in the table.
        places: of the impacts in the file.
    """

    def __init__(self, table: Table) -> None:
        angles = _coordinates(table)
        self.contact = set(angles) <= set(CONTACT) or any(n.startswith("delassus_") for n in table.names)
        if self.contact:
            if others := set(angles) - set(CONTACT):
                raise MeasurementError(
                    f"it has a Delassus matrix and velocities of {', '.join(others)}; these must be "
                    "gap_rate and slip, or masses and a Jacobian be given."
                )
            slips = "slip" in angles or "gap_rate" not in angles
            angles = dict.fromkeys(CONTACT if slips else CONTACT[:1], False)
        self.table, self.angles = table, angles
        self.units = known_names(angles, contact=self.contact)
        flags = [n for n in table.names if n == FLAG.form or n.startswith(f"{FLAG.form}_")]
        table.check_names([*self.units, *flags])
        self.rows = np.flatnonzero(~table.flagged(flags))
        if not self.rows.size:
            raise MeasurementError(
                f"it has {len(table.places)} impacts and none without a flag; there must be at least one."
            )
        self.places = [table.places[int(row)] for row in self.rows]

    def option(self, column: Column, *coordinates: str) -> Array | None:
        """Return an optional column in SI, shape (impact,)."""
        present = [name for name in column.names(*coordinates) if name in self.table.data.variables]
        if len(present) > 1:
            raise MeasurementError(f"{' and '.join(present)} are the same number; one must be left out.")
        return self.table.numbers(present[0], self.units[present[0]], self.rows) if present else None

    def column(self, column: Column, *coordinates: str) -> Array:
        """Return a required column in SI, shape (impact,)."""
        values = self.option(column, *coordinates)
        if values is None:
            name = column.form.format(*coordinates)
            unit = "" if self.units[name] == "1" else f" [{from_cf(self.units[name])}]"
            raise MeasurementError(
                f"{name} is missing ({column.meaning}); it must be a column, {name}{unit}, or stated once "
                "for all impacts."
            )
        return values

    def all_of(self, column: Column) -> Array:
        """Return a column of every coordinate, shape (impact, coordinate)."""
        return np.stack([self.column(column, name) for name in self.angles], axis=1)

    def matrix(self, diagonal: Array, column: Column) -> Array:
        """Return symmetric matrices, shape (impact, coordinate, coordinate), from their diagonals."""
        coordinates, result = list(self.angles), diagonal[:, :, None] * np.eye(diagonal.shape[1])
        for i, j in zip(*np.tril_indices(len(coordinates), -1), strict=True):
            if (element := self.option(column, coordinates[j], coordinates[i])) is not None:
                result[:, i, j] = result[:, j, i] = element
        return result

    def delassus(self) -> Array:
        """Return the Delassus matrices of contact velocities, shape (impact, direction, direction)."""
        nn, nt, tt = DELASSUS
        normal = self.column(nn)
        if len(self.angles) == 1:
            return normal[:, None, None]
        coupling = np.zeros_like(normal) if (stated := self.option(nt)) is None else stated
        return np.stack([normal, coupling, coupling, self.column(tt)], axis=1).reshape(-1, 2, 2)

    def covariance(self) -> Array | None:
        """Return the covariance of the jump's error, shape (impact, coordinate, coordinate)."""
        after = self._errors(ERROR_AFTER, COVARIANCE_AFTER)
        before = self._errors(ERROR_BEFORE, COVARIANCE_BEFORE)
        if after is None and before is not None:
            raise MeasurementError(
                "error_after_NAME is missing, and error_before_NAME is there; both are needed."
            )
        return after if after is None or before is None else after + before

    def _errors(self, error: Column, covariance: Column) -> Array | None:
        """Return the covariance of the velocities before or after, None without any column of it."""
        starts = tuple(column.form.partition("{")[0] for column in (error, covariance))
        if not any(name.startswith(starts) for name in self.table.names):
            return None
        diagonal = []
        for name in self.angles:
            deviation, variance = self.option(error, name), self.option(covariance, name, name)
            if (deviation is None) == (variance is None) or (deviation is not None and deviation.min() < 0.0):
                raise MeasurementError(
                    f"{error.form.format(name)} must be given where errors are, not negative, 0 for an exact "
                    f"velocity; or {covariance.form.format(name, name)} instead of it."
                )
            # One of the two is there.
            diagonal.append(self.column(covariance, name, name) if deviation is None else deviation**2)
        result = self.matrix(np.stack(diagonal, axis=1), covariance)
        _check_positive(result, f"covariance {covariance.form.format('NAME', 'OTHER')}", self.places, -1e-9)
        return result

    def whole(self, column: Column) -> NDArray[np.int64] | None:
        """Return an optional column of whole numbers, shape (impact,)."""
        if (values := self.option(column)) is None:
            return None
        refuse(
            values != np.round(values),
            lambda at: f"{column.form} is {values[at]:g} in {self.places[at]}; it must be a whole number.",
        )
        return values.astype(np.int64)


def _coordinates(table: Table) -> dict[str, bool]:
    """Return whether each coordinate whose velocities a table has is an angle, by the unit rad/s."""
    result: dict[str, bool] = {}
    expected = [from_cf(units) for units in BEFORE.units]
    for name in sorted(table.names, key=lambda each: each.startswith("after_")):
        match = re.fullmatch(r"(?:before|after)_([^\W\d]\w*)", name)
        if match is None or match[1] in result:
            continue
        for is_angle, units in enumerate(expected if table.unit(name) else ()):
            with suppress(UnitError):
                factor(table.unit(name), units)
                result[match[1]] = bool(is_angle)
        if match[1] not in result:
            raise MeasurementError(
                f"{name} is in '{excerpt(table.unit(name))}'; it must be in "
                f"{' or, for an angle, '.join(expected)}."
            )
    if not result:
        raise MeasurementError(
            f"it has {excerpt(', '.join(table.names)) or 'no columns'}; it must have before_NAME and "
            "after_NAME for each coordinate (impacts), time, x and y (tracks), time and one of "
            f"{', '.join(MEASURABLE)} (series), or rotor_velocity and keys such as rotor.load_torque "
            "(operating points). See docs/measured_data.md."
        )
    return result
