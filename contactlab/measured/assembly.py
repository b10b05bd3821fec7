"""From a table of measurements to the impacts that a contact law is asked: complete, in SI and consistent."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.measured import columns
from contactlab.measured.faults import (
    MeasurementError,
    check_approach,
    check_directions,
    check_mass,
    check_span,
    told_energies,
)
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.reading import Reading
from contactlab.measured.reduction import BodyImpacts
from contactlab.measured.table import Table

_CHECKED: Final = "checked"
_ONE_DIRECTION: Final = "The data have no tangential direction: the slip is zero, and friction is not asked."


def assemble(table: Table, title: str) -> MeasuredImpacts:
    """Make measured impacts of a table; the title is for one that has none.

    Raises:
        MeasurementError: a column is missing, unknown or in a wrong unit, a number is none, or the impacts
            are none: see `contactlab.measured.faults`.
    """
    reading, words = Reading.of(table), table.words
    keep = _keeps_jacobian(reading)
    given = _contact_velocities(reading) if reading.contact else _from_bodies(reading)
    notes = words.get("note", "").split("\n") if "note" in words else []
    if given.before.shape[1] == 1:
        given = _without_slip(given)
        notes.append(_ONE_DIRECTION)
    places = reading.places
    check_directions(given.delassus, places)
    if given.bodies is not None:
        names, angles = list(reading.angles), list(reading.angles.values())
        notes += check_span(given.bodies, names, angles, keep=keep)
    check_approach(given.before[:, 0], given.after[:, 0], places, reading.sign_of_normal)
    kinetic, outside = _energies(reading, given)
    notes += told_energies(given.before, given.after, given.delassus)
    impacts = MeasuredImpacts(
        given.delassus,
        given.before,
        given.after,
        kinetic,
        outside,
        given.covariance,
        words.get("title", title),
        words.get("source", ""),
        words.get("licence", ""),
        int((~reading.chosen).sum()) + reading.left_out(),
        reading.number(),
        # What is noted in a file that was written from impacts is found again.
        tuple(dict.fromkeys(notes)),
    )
    repeated = reading.option(columns.REPEATED)
    return impacts if repeated is None else _averaged(impacts, repeated)


def _averaged(impacts: MeasuredImpacts, repeated: Array) -> MeasuredImpacts:
    """Average the rows that measure the same impact; their errors are independent."""
    _, first, same, count = np.unique(repeated, return_index=True, return_inverse=True, return_counts=True)

    def mean(values: Array) -> Array:
        total = np.zeros((count.size, *values.shape[1:]))
        np.add.at(total, same, values)
        return total / count.reshape(-1, *[1] * (values.ndim - 1))

    covariance = impacts.covariance
    note = f"{len(impacts)} rows measure {count.size} impacts, and those of one impact are averaged."
    return replace(
        impacts,
        delassus=mean(impacts.delassus),
        velocity_before=mean(impacts.velocity_before),
        velocity_after=mean(impacts.velocity_after),
        kinetic_energy=mean(impacts.kinetic_energy),
        outside=mean(impacts.outside),
        covariance=None if covariance is None else mean(covariance) / count[:, None, None],
        number=impacts.number[first],
        notes=(*impacts.notes, note),
    )


@final
@dataclass(frozen=True, eq=False)
class _Contact:
    """Velocities of the contact, shape (impact, direction), and the bodies that they are from, if any."""

    before: Array
    after: Array
    delassus: Array
    covariance: Array | None
    bodies: BodyImpacts | None = None


def _from_bodies(reading: Reading) -> _Contact:
    before, after = reading.columns(columns.BEFORE), reading.columns(columns.AFTER)
    mass = reading.matrix(reading.columns(columns.MASS), columns.COUPLING)
    check_mass(mass, reading.places)
    normal, covariance = reading.columns(columns.NORMAL), reading.covariance()
    if len(reading.angles) == 1:
        _refuse_slip(reading)
        square = normal[:, :, None] ** 2
        spread = None if covariance is None else square * covariance
        return _Contact(before * normal, after * normal, square / mass, spread)
    bodies = BodyImpacts(before, after, mass, normal, reading.columns(columns.TANGENTIAL), covariance)
    return _Contact(
        bodies.contact(before), bodies.contact(after), bodies.delassus(), bodies.contact_covariance(), bodies
    )


def _refuse_slip(reading: Reading) -> None:
    name = next(iter(reading.angles))
    if reading.has(columns.TANGENTIAL, name):
        raise MeasurementError(
            f"tangential_{name} is given, and {name} is the only coordinate; a contact that slips must have "
            "two. Leave it out, or give the other coordinates."
        )


def _contact_velocities(reading: Reading) -> _Contact:
    nn, nt, tt = columns.DELASSUS
    before, after = reading.columns(columns.BEFORE), reading.columns(columns.AFTER)
    covariance, normal = reading.covariance(), reading.column(nn)
    if len(reading.angles) == 1:
        for column in (nt, tt):
            if reading.has(column):
                raise MeasurementError(
                    f"{column.form} is given, and no slip; a contact that slips must have before_slip and "
                    "after_slip. Give them, or leave it out."
                )
        return _Contact(before, after, normal[:, None, None], covariance)
    coupling, tangential = reading.option(nt), reading.column(tt)
    coupling = np.zeros_like(normal) if coupling is None else coupling
    delassus = np.stack([normal, coupling, coupling, tangential], axis=1).reshape(-1, 2, 2)
    return _Contact(before, after, delassus, covariance)


def _without_slip(given: _Contact) -> _Contact:
    """Give an impact along the normal a tangential direction in which nothing happens, of the same mass."""
    nothing = np.zeros_like(given.before)
    return _Contact(
        np.hstack([given.before, nothing]),
        np.hstack([given.after, nothing]),
        given.delassus * np.eye(2),
        None if given.covariance is None else given.covariance * np.diag([1.0, 0.0]),
    )


def _keeps_jacobian(reading: Reading) -> bool:
    said = reading.table.words.get("jacobian")
    if said is not None and reading.contact:
        raise MeasurementError("'jacobian' is given, and there is none; it must be absent. Leave it out.")
    if said is not None and said.strip() != _CHECKED:
        raise MeasurementError(f"'jacobian' is '{said}'; it must be '{_CHECKED}' or absent. Leave it out.")
    return said is not None


def _energies(reading: Reading, given: _Contact) -> tuple[Array, Array]:
    """Give the kinetic energy before and the energy outside [J], shape (impact,); refuse what cannot be."""
    if given.bodies is not None:
        return given.bodies.energy(given.bodies.before), given.bodies.outside()
    solved = np.linalg.solve(given.delassus, given.before[..., None])[..., 0]
    least = 0.5 * np.einsum("ni,ni->n", given.before, solved)
    kinetic = reading.option(columns.KINETIC_ENERGY)
    kinetic = least if kinetic is None else kinetic
    if (bad := kinetic < least * (1.0 - 1e-9)).any():
        first = int(np.argmax(bad))
        raise MeasurementError(
            f"kinetic_energy is {kinetic[first]:g} J in {reading.places[first]}; it must be at least that of "
            f"the contact, {least[first]:g} J. Correct it, or leave the column out."
        )
    outside = reading.option(columns.OUTSIDE)
    outside = np.zeros_like(least) if outside is None else outside
    if (bad := outside < 0.0).any():
        first = int(np.argmax(bad))
        raise MeasurementError(
            f"outside_energy is {outside[first]:g} J in {reading.places[first]}; it must not be negative. "
            "Correct it, or leave the column out."
        )
    return kinetic, outside
