"""What the columns of a table stand for: coordinates, flags, and each column in SI or a fault."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config.quantity import UnitError, factor
from contactlab.measured import columns
from contactlab.measured.columns import CONTACT, COORDINATE, Column, is_flag, known_names
from contactlab.measured.faults import MeasurementError
from contactlab.measured.table import Table
from contactlab.parameter import from_cf


@final
@dataclass(frozen=True, eq=False)
class Reading:
    """A table whose names are known.

    Args:
        angles: the coordinates by name, and whether each is an angle.
        contact: whether these are of the contact itself.
        units: of every name.
        chosen: the rows that no flag marks, shape (row,).
    """

    table: Table
    angles: Mapping[str, bool]
    contact: bool
    units: Mapping[str, str]
    chosen: np.ndarray

    @classmethod
    def of(cls, table: Table) -> "Reading":
        """Find coordinates, units and flags; refuse names that are none."""
        angles = _coordinates(table)
        delassus = [name for name in table.values if name.startswith("delassus_")]
        contact = bool(delassus) or set(angles) <= set(CONTACT)
        if contact and not set(angles) <= set(CONTACT):
            raise MeasurementError(
                f"it has '{delassus[0]}', and velocities of {', '.join(angles)}; with a Delassus matrix "
                "these must be of gap_rate and slip. Give masses and Jacobian instead, or before_gap_rate "
                "and before_slip."
            )
        bodily = [name for name in table.values if name.startswith(("mass_", "normal_", "tangential_"))]
        if contact and bodily:
            raise MeasurementError(
                f"it has '{bodily[0]}' beside velocities of the contact; these come with a Delassus matrix "
                "and no masses. Leave it out, or name the coordinates otherwise than gap_rate and slip."
            )
        if contact:
            # Both directions, in their order, whatever that of the columns: one that lacks is asked for.
            slips = "slip" in angles or "gap_rate" not in angles
            angles = dict.fromkeys(CONTACT if slips else CONTACT[:1], False)
        units = known_names(angles, contact=contact)
        flags = [name for name in table.values if is_flag(name)]
        table.refuse_unknown(units, flags)
        chosen = ~table.flagged(flags)
        if not chosen.any():
            if not chosen.size:
                raise MeasurementError("it has no impacts; there must be at least one. Write a row for each.")
            raise MeasurementError(
                f"it has {chosen.size} impacts, of which the flags leave none; there must be at least one."
            )
        return cls(table, angles, contact, units, chosen)

    @property
    def places(self) -> list[str]:
        """Where each chosen row is in the file."""
        return [self.table.places[row] for row in np.flatnonzero(self.chosen)]

    @property
    def sign_of_normal(self) -> str:
        """What to reverse where the normal points the wrong way, in words."""
        return "the gap rates" if self.contact else "the columns normal_NAME"

    def has(self, column: Column, *coordinates: str) -> str | None:
        """Give the name of a column where the file has it; it has it once."""
        found = [name for name in column.names(*coordinates) if name in self.table.values]
        if len(found) > 1:
            raise MeasurementError(f"it has {' and '.join(found)}, which are the same; one will do.")
        return found[0] if found else None

    def column(self, column: Column, *coordinates: str) -> Array:
        """Give a column that must be there, in SI, shape (impact,)."""
        name = self.has(column, *coordinates)
        if name is None:
            missing = column.form.format(*coordinates)
            example = self.table.example(missing, self.units[missing])
            raise MeasurementError(
                f"{missing} is missing ({column.meaning}); it must be given, for each impact or once for "
                f"all. Write {example}."
            )
        given = self.table.numbers(name, self.units[name], self.chosen)
        return np.array(np.broadcast_to(given, int(self.chosen.sum())))

    def option(self, column: Column, *coordinates: str) -> Array | None:
        """Give a column that need not be there, or None."""
        return self.column(column, *coordinates) if self.has(column, *coordinates) else None

    def columns(self, column: Column) -> Array:
        """Give a column of every coordinate, shape (impact, coordinate)."""
        return np.stack([self.column(column, name) for name in self.angles], axis=1)

    def matrix(self, diagonal: Array, column: Column) -> Array:
        """Give symmetric matrices, shape (impact, coordinate, coordinate), from their diagonals."""
        names, made = list(self.angles), np.zeros((*diagonal.shape, diagonal.shape[1]))
        for i, name in enumerate(names):
            made[:, i, i] = diagonal[:, i]
            for j in range(i):
                element = self.option(column, names[j], name)
                if element is not None:
                    made[:, i, j] = made[:, j, i] = element
        return made

    def covariance(self) -> Array | None:
        """Give the covariance of the jump's error, shape (impact, coordinate, coordinate), or None."""
        after = self._errors(columns.ERROR_AFTER, columns.COVARIANCE_AFTER)
        before = self._errors(columns.ERROR_BEFORE, columns.COVARIANCE_BEFORE)
        if after is None and before is not None:
            raise MeasurementError(
                "it has errors of the velocities before and none of those after; these must be given too, as "
                "error_after_NAME. Give them, 0 where they are exact."
            )
        return after if after is None or before is None else after + before

    def _errors(self, error: Column, covariance: Column) -> Array | None:
        names = list(self.angles)
        pairs = [(p, q) for p in names for q in names]
        if not any(self.has(error, p) for p in names) and not any(self.has(covariance, *pq) for pq in pairs):
            return None
        diagonal = []
        for name in names:
            deviation, variance = self.option(error, name), self.option(covariance, name, name)
            one, other = error.form.format(name), covariance.form.format(name, name)
            if deviation is not None and variance is not None:
                raise MeasurementError(f"it has {one} and {other}, which say the same; one will do.")
            if deviation is None and variance is None:
                raise MeasurementError(
                    f"{one} is missing; where errors are given, each coordinate must have its own. Give it, "
                    "0 where the velocity is exact."
                )
            if deviation is not None and deviation.min() < 0.0:
                place = self.places[int(np.argmin(deviation))]
                raise MeasurementError(
                    f"{one} is {deviation.min():g} in {place}; a standard deviation must not be negative. "
                    "Correct it."
                )
            # One of the two is there.
            diagonal.append(self.column(covariance, name, name) if deviation is None else deviation**2)
        made = self.matrix(np.stack(diagonal, axis=1), covariance)
        values = np.linalg.eigvalsh(made)
        if (bad := values[:, 0] < -1e-9 * values[:, -1]).any():
            first = int(np.argmax(bad))
            raise MeasurementError(
                f"the covariance of {self.places[first]} is {made[first].tolist()}, which has a negative "
                "eigenvalue; no errors can have it. Correct the columns "
                f"{covariance.form.format('NAME', 'OTHER')}."
            )
        return made

    def number(self) -> NDArray[np.int64]:
        """Give the number of every impact in the file."""
        given = self.option(columns.IMPACT)
        if given is None:
            return np.flatnonzero(self.chosen) + 1
        whole = given.astype(np.int64)
        if (bad := whole != given).any():
            first = int(np.argmax(bad))
            raise MeasurementError(
                f"impact is {given[first]:g} in {self.places[first]}; it must be a whole number."
            )
        values, counts = np.unique(whole, return_counts=True)
        if (counts > 1).any():
            raise MeasurementError(
                f"impact is {values[np.argmax(counts)]} in {counts.max()} rows; each must have its own "
                "number."
            )
        return whole

    def left_out(self) -> int:
        """Give how many impacts the file says that it does not have."""
        given = self.option(columns.LEFT_OUT)
        return 0 if given is None else int(given[0])


def _coordinates(table: Table) -> dict[str, bool]:
    """Find the coordinates whose velocities a table has, and which of them are angles, by their units."""
    found: dict[str, bool] = {}
    for column in (columns.BEFORE, columns.AFTER):
        start = column.form.format("")
        for name in table.values:
            coordinate = name.removeprefix(start)
            if name.startswith(start) and COORDINATE.fullmatch(coordinate) and coordinate not in found:
                found[coordinate] = _is_angle(table, name)
    if not found and "time" in table.values:
        raise MeasurementError(
            "it has time and no velocities before and after impacts: it is a series, and impacts are needed "
            "here. `contactlab fit` takes series, as netCDF or CSV with time [s] and any series of a motor "
            "over it; see docs/fitting.md."
        )
    if not found:
        raise MeasurementError(
            f"it has no velocities, only {', '.join(map(repr, table.values)) or 'no columns'}; it must have "
            f"{table.how.format(name='before_NAME', unit='m/s')} and after_NAME for each coordinate. See "
            "docs/measured_data.md."
        )
    return found


def _is_angle(table: Table, name: str) -> bool:
    given, kinds = table.units[name], [from_cf(units) for units in columns.BEFORE.units]
    for angle, unit in enumerate(kinds):
        with suppress(UnitError):
            if given is not None and given.strip():
                factor(given.strip(), unit)
                return bool(angle)
    told = f"is in '{given}', which is no velocity" if given and given.strip() else "has no unit"
    raise MeasurementError(
        f"{name} {told}; it must be in one like {kinds[0]}, or {kinds[1]} where {name.partition('_')[2]} is "
        f"an angle. Write {' or '.join(table.example(name, units) for units in columns.BEFORE.units)}."
    )
