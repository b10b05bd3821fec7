"""Measured impacts from a table: columns in SI without flagged rows, reduced to contact velocities."""

from contextlib import suppress
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config.quantity import UnitError, factor
from contactlab.measured import columns as names
from contactlab.measured.bodies import BodyImpacts
from contactlab.measured.checks import check_approach, check_positive, check_signs, odd_energies
from contactlab.measured.columns import CONTACT, COORDINATE, Column, known_names
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.table import MeasurementError, Table
from contactlab.parameter import from_cf

_CHECKED: Final = "checked"


def impacts_of(table: Table, title: str) -> MeasuredImpacts:
    """Return the impacts of a table; the title is the default one.

    Raises:
        MeasurementError: a column is missing, unknown or in a wrong unit, or the impacts contradict
        mechanics.
    """
    columns, texts = _Columns(table), table.texts
    keep = texts.get("jacobian")
    if keep is not None and (columns.contact or keep.strip() != _CHECKED):
        raise MeasurementError(
            f"'jacobian' is '{keep}'; it must be '{_CHECKED}', beside a Jacobian, or absent."
        )
    notes = texts["note"].split("\n") if "note" in texts else []
    before, after = columns.all_of(names.BEFORE), columns.all_of(names.AFTER)
    covariance, bodies = columns.covariance(), None
    if columns.contact:
        delassus = columns.delassus()
    else:
        mass = columns.matrix(columns.all_of(names.MASS), names.COUPLING)
        check_positive(mass, "mass matrix", columns.places, np.nextafter(0.0, 1.0))
        normal = columns.all_of(names.NORMAL)
        if len(columns.angles) == 1:
            square = normal[:, :, None] ** 2
            covariance = None if covariance is None else square * covariance
            before, after, delassus = before * normal, after * normal, square / mass
        else:
            tangential = columns.all_of(names.TANGENTIAL)
            bodies = BodyImpacts(before, after, mass, normal, tangential, covariance)
            before, after = bodies.contact(before), bodies.contact(after)
            delassus, covariance = bodies.delassus(), bodies.contact_covariance()
    if before.shape[1] == 1:
        nothing = np.zeros_like(before)
        before, after, delassus = (
            np.hstack([before, nothing]),
            np.hstack([after, nothing]),
            delassus * np.eye(2),
        )
        covariance = None if covariance is None else covariance * np.diag([1.0, 0.0])
        notes.append("The data have no tangential direction: the slip is zero.")
    check_positive(delassus, "Delassus matrix", columns.places, 1e-9)
    if bodies is not None:
        notes += check_signs(bodies, columns.angles, keep=keep is not None)
    check_approach(before[:, 0], after[:, 0], columns.places)
    notes += odd_energies(before, after, delassus)
    if bodies is not None:
        kinetic, outside = bodies.energy(bodies.before), bodies.outside()
    else:
        least = 0.5 * np.einsum("ni,ni->n", before, np.linalg.solve(delassus, before[..., None])[..., 0])
        kinetic = least if (stated := columns.option(names.KINETIC_ENERGY)) is None else stated
        outside = np.zeros_like(least) if (stated := columns.option(names.OUTSIDE)) is None else stated
        too_small = {"kinetic_energy": kinetic < least * (1.0 - 1e-9), "outside_energy": outside < 0.0}
        for name, bad in too_small.items():
            if bad.any():
                raise MeasurementError(
                    f"{name} is too small in {columns.places[int(np.argmax(bad))]}; the kinetic energy must "
                    "be at "
                    "least that of the contact, and the energy outside not negative."
                )
    left_out, number = columns.option(names.LEFT_OUT), columns.whole(names.IMPACT)
    if number is not None and np.unique(number).size < number.size:
        raise MeasurementError("impact is the same in two rows; each impact must have a number of its own.")
    return MeasuredImpacts(
        delassus,
        before,
        after,
        kinetic,
        outside,
        covariance,
        texts.get("title", title),
        texts.get("source", ""),
        texts.get("licence", ""),
        len(table.places) - columns.rows.size + (0 if left_out is None else int(left_out[0])),
        columns.rows + 1 if number is None else number,
        # A file that was written from impacts has its notes already.
        tuple(dict.fromkeys(notes)),
        columns.whole(names.MEASUREMENT),
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
        delassus = any(name.startswith("delassus_") for name in table.names)
        self.contact = delassus or set(angles) <= set(CONTACT)
        if self.contact:
            if others := set(angles) - set(CONTACT):
                raise MeasurementError(
                    f"it has a Delassus matrix and velocities of {', '.join(others)}; these must be "
                    "gap_rate and "
                    "slip, or masses and a Jacobian be given."
                )
            slips = "slip" in angles or "gap_rate" not in angles
            angles = dict.fromkeys(CONTACT if slips else CONTACT[:1], False)
        self.table, self.angles = table, angles
        self.units = known_names(angles, contact=self.contact)
        flags = [n for n in table.names if n == names.FLAG.form or n.startswith(f"{names.FLAG.form}_")]
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
                "for all "
                "impacts."
            )
        return values

    def all_of(self, column: Column) -> Array:
        """Return a column of every coordinate, shape (impact, coordinate)."""
        return np.stack([self.column(column, name) for name in self.angles], axis=1)

    def matrix(self, diagonal: Array, column: Column) -> Array:
        """Return symmetric matrices, shape (impact, coordinate, coordinate), from their diagonals."""
        coordinates, result = list(self.angles), np.zeros((*diagonal.shape, diagonal.shape[1]))
        for i, name in enumerate(coordinates):
            result[:, i, i] = diagonal[:, i]
            for j in range(i):
                if (element := self.option(column, coordinates[j], name)) is not None:
                    result[:, i, j] = result[:, j, i] = element
        return result

    def delassus(self) -> Array:
        """Return the Delassus matrices of contact velocities, shape (impact, direction, direction)."""
        nn, nt, tt = names.DELASSUS
        normal = self.column(nn)
        if len(self.angles) == 1:
            return normal[:, None, None]
        coupling = np.zeros_like(normal) if (stated := self.option(nt)) is None else stated
        return np.stack([normal, coupling, coupling, self.column(tt)], axis=1).reshape(-1, 2, 2)

    def covariance(self) -> Array | None:
        """Return the covariance of the jump's error, shape (impact, coordinate, coordinate)."""
        after = self._errors(names.ERROR_AFTER, names.COVARIANCE_AFTER)
        before = self._errors(names.ERROR_BEFORE, names.COVARIANCE_BEFORE)
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
        check_positive(result, f"covariance {covariance.form.format('NAME', 'OTHER')}", self.places, -1e-9)
        return result

    def whole(self, column: Column) -> NDArray[np.int64] | None:
        """Return an optional column of whole numbers, shape (impact,)."""
        values = self.option(column)
        if values is None:
            return None
        result = values.astype(np.int64)
        if (bad := result != values).any():
            first = int(np.argmax(bad))
            raise MeasurementError(
                f"{column.form} is {values[first]:g} in {self.places[first]}; it must be a whole number."
            )
        return result


def _coordinates(table: Table) -> dict[str, bool]:
    """Return the coordinates whose velocities a table has, and whether each is an angle, by the units."""
    result: dict[str, bool] = {}
    for column in (names.BEFORE, names.AFTER):
        start = column.form.format("")
        for name in table.names:
            coordinate = name.removeprefix(start)
            if name.startswith(start) and COORDINATE.fullmatch(coordinate) and coordinate not in result:
                result[coordinate] = _is_angle(table, name)
    if not result:
        raise MeasurementError(
            f"it has no velocities of impacts, only {', '.join(table.names) or 'no columns'}; it must have "
            "before_NAME and after_NAME for each coordinate. See docs/measured_data.md."
        )
    return result


def _is_angle(table: Table, name: str) -> bool:
    """Return whether the velocity of a coordinate is in rad/s, not in m/s."""
    expected = [from_cf(units) for units in names.BEFORE.units]
    for angle, units in enumerate(expected):
        with suppress(UnitError):
            if table.unit(name):
                factor(table.unit(name), units)
                return bool(angle)
    raise MeasurementError(
        f"{name} is in '{table.unit(name)}'; it must be in {expected[0]}, or in {expected[1]} for an angle."
    )
