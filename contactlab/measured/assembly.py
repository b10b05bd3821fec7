"""From a table of measurements to the impacts that a contact law is asked: complete, in SI and consistent."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config.quantity import UnitError, factor
from contactlab.measured import columns
from contactlab.measured.columns import CONTACT, COORDINATE, Column, is_flag, known_names
from contactlab.measured.faults import (
    MeasurementError,
    check_approach,
    check_directions,
    check_mass,
    check_span,
    told_energies,
)
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.reduction import BodyImpacts
from contactlab.measured.table import Table
from contactlab.parameter import from_cf

_CHECKED: Final = "checked"
_ONE_DIRECTION: Final = "The data have no tangential direction: the slip is zero, and friction is not asked."


def assemble(table: Table, title: str) -> MeasuredImpacts:
    """Make measured impacts of a table; the title is for one that has none.

    Raises:
        MeasurementError: a column is missing, unknown or in a wrong unit, a number is none, or the impacts
            are none: see `contactlab.measured.faults`.
    """
    reading = _Reading.of(table)
    chosen, places = reading.chosen, reading.places
    covariance = reading.covariance()
    make = _contact_impacts if reading.contact else _body_impacts
    given = make(reading, covariance)
    one_way = given.before.shape[1] == 1
    flat = _without_slip(given) if one_way else given
    check_directions(flat.delassus, places)
    check_approach(flat.before[:, 0], flat.after[:, 0], places, reading.sign_of_normal)
    kinetic, outside = _energies(reading, flat)
    words = table.words
    notes = [*words.get("note", "").splitlines(), *given.notes, *([_ONE_DIRECTION] if one_way else [])]
    return MeasuredImpacts(
        flat.delassus,
        flat.before,
        flat.after,
        kinetic,
        outside,
        flat.covariance,
        words.get("title", title),
        words.get("source", ""),
        words.get("licence", ""),
        int((~chosen).sum()) + reading.left_out(),
        reading.number(),
        # What a file notes that was written from read impacts is found again.
        tuple(dict.fromkeys([*notes, *told_energies(flat.before, flat.after, flat.delassus)])),
    )


@final
@dataclass(frozen=True, eq=False)
class _Contact:
    """Velocities of the contact, shape (impact, direction), and what else is known by then."""

    before: Array
    after: Array
    delassus: Array
    covariance: Array | None
    kinetic: Array | None = None
    outside: Array | None = None
    notes: Sequence[str] = ()


@final
@dataclass(frozen=True, eq=False)
class _Reading:
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
    def of(cls, table: Table) -> "_Reading":
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
        units = known_names(angles, contact=contact)
        flags = [name for name in table.values if is_flag(name)]
        table.refuse_unknown(units, flags)
        chosen = ~table.flagged(flags)
        if not chosen.any():
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
            example = self.table.how.format(name=missing, unit=from_cf(self.units[missing]))
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
            if (deviation is None) == (variance is None):
                both = "is there beside" if variance is not None else "and with it"
                raise MeasurementError(
                    f"{error.form.format(name)} {both} {covariance.form.format(name, name)}"
                    f"{'' if variance is not None else ' is missing'}; where errors are given, each "
                    "coordinate must have one of the two. Give it, 0 where a velocity is exact."
                )
            if deviation is not None and deviation.min() < 0.0:
                raise MeasurementError(
                    f"{error.form.format(name)} is {deviation.min():g} in "
                    f"{self.places[int(np.argmin(deviation))]}; a standard deviation must not be negative."
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
    example = table.how.format(name=name, unit=kinds[0])
    raise MeasurementError(
        f"{name} {told}; it must be one like {kinds[0]}, or {kinds[1]} where {name.partition('_')[2]} is an "
        f"angle. Write {example}."
    )


def _body_impacts(reading: _Reading, covariance: Array | None) -> _Contact:
    names, one_way = list(reading.angles), len(reading.angles) == 1
    mass = reading.matrix(reading.columns(columns.MASS), columns.COUPLING)
    check_mass(mass, reading.places)
    before, after = reading.columns(columns.BEFORE), reading.columns(columns.AFTER)
    normal = reading.columns(columns.NORMAL)
    if one_way:
        if reading.has(columns.TANGENTIAL, names[0]):
            raise MeasurementError(
                f"tangential_{names[0]} is given, and {names[0]} is the only coordinate; a contact that "
                "slips must have two. Leave it out, or give the other coordinates."
            )
        arm = normal[:, :, None]
        return _Contact(
            before * normal,
            after * normal,
            arm**2 / mass,
            None if covariance is None else arm**2 * covariance,
            0.5 * mass[:, 0, 0] * before[:, 0] ** 2,
            np.zeros(len(before)),
        )
    bodies = BodyImpacts(before, after, mass, normal, reading.columns(columns.TANGENTIAL), covariance)
    check_directions(bodies.delassus(), reading.places)
    check_approach(
        bodies.contact(before)[:, 0], bodies.contact(after)[:, 0], reading.places, reading.sign_of_normal
    )
    keep = _keeps_jacobian(reading.table)
    notes = check_span(bodies, names, list(reading.angles.values()), keep=keep)
    return _Contact(
        bodies.contact(before),
        bodies.contact(after),
        bodies.delassus(),
        bodies.contact_covariance(),
        bodies.energy(before),
        bodies.outside(),
        notes,
    )


def _keeps_jacobian(table: Table) -> bool:
    said = table.words.get("jacobian")
    if said is not None and said.strip() != _CHECKED:
        raise MeasurementError(
            f"'jacobian' is '{said}'; it must be '{_CHECKED}' or absent. It keeps a Jacobian that the reader "
            "takes for wrong."
        )
    return said is not None


def _contact_impacts(reading: _Reading, covariance: Array | None) -> _Contact:
    nn, nt, tt = columns.DELASSUS
    one_way = list(reading.angles) == [CONTACT[0]]
    if not one_way:
        # The file may have its columns in another order; what is asked for has not.
        order = [list(reading.angles).index(name) for name in CONTACT if name in reading.angles]
        if len(order) < len(CONTACT):
            reading.column(columns.BEFORE, CONTACT[0])
        coupling = reading.option(nt)
        elements = reading.column(nn), reading.column(tt)
        coupling = np.zeros_like(elements[0]) if coupling is None else coupling
        delassus = np.stack([elements[0], coupling, coupling, elements[1]], axis=1).reshape(-1, 2, 2)
    else:
        order = [0]
        delassus = reading.column(nn)[:, None, None]
    if covariance is not None:
        covariance = covariance[:, order][:, :, order]
    return _Contact(
        reading.columns(columns.BEFORE)[:, order],
        reading.columns(columns.AFTER)[:, order],
        delassus,
        covariance,
        reading.option(columns.KINETIC_ENERGY),
        reading.option(columns.OUTSIDE),
    )


def _without_slip(given: _Contact) -> _Contact:
    """Give an impact along the normal a tangential direction in which nothing happens, of the same mass."""
    nothing = np.zeros_like(given.before)
    covariance = None
    if given.covariance is not None:
        covariance = given.covariance * np.diag([1.0, 0.0])
    return _Contact(
        np.hstack([given.before, nothing]),
        np.hstack([given.after, nothing]),
        given.delassus * np.eye(2),
        covariance,
        given.kinetic,
        given.outside,
        given.notes,
    )


def _energies(reading: _Reading, flat: _Contact) -> tuple[Array, Array]:
    """Give the kinetic energy before and the energy outside [J], shape (impact,); refuse what cannot be."""
    solved = np.linalg.solve(flat.delassus, flat.before[..., None])[..., 0]
    least = 0.5 * np.einsum("ni,ni->n", flat.before, solved)
    kinetic = least if flat.kinetic is None else flat.kinetic
    if (bad := kinetic < least * (1.0 - 1e-9)).any():
        first = int(np.argmax(bad))
        raise MeasurementError(
            f"kinetic_energy is {kinetic[first]:g} J in {reading.places[first]}; it must be at least that of "
            f"the contact, {least[first]:g} J. Correct it, or leave the column out."
        )
    outside = np.zeros_like(kinetic) if flat.outside is None else flat.outside
    if (bad := outside < 0.0).any():
        first = int(np.argmax(bad))
        raise MeasurementError(
            f"outside_energy is {outside[first]:g} J in {reading.places[first]}; it must not be negative."
        )
    return kinetic, outside
