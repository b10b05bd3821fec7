"""Columns of a file of measured impacts; names contain coordinates: `before_x`, `mass_x`, `normal_angle`.

A file has velocities in any coordinates before and after each impact, mass matrix and contact Jacobian; or
gap rate and slip, and the Delassus matrix.
"""

import re
from collections.abc import Mapping
from itertools import combinations_with_replacement
from typing import Final, NamedTuple, final

CONTACT: Final = ("gap_rate", "slip")
"""Coordinates of a file with velocities of the contact."""

COORDINATE: Final = re.compile(r"[^\W\d]\w*")
"""Name of a coordinate."""


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

    @property
    def coordinates(self) -> int:
        """Number of coordinates in the name."""
        return self.form.count("{}")

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
        for several in combinations_with_replacement(angles, column.coordinates):
            if column is not COUPLING or several[0] != several[1]:
                units = column.units[sum(angles[each] for each in several)]
                result |= dict.fromkeys(column.names(*several), units)
    return result
