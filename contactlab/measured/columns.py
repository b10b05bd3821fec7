"""The columns of a file of measured impacts, each declared once: reader, writer, messages and page follow.

A file has the velocities of any coordinates before and after each impact, with mass matrix and contact
Jacobian; or gap rate and slip, with the Delassus matrix. A name has the coordinates in it that it is of:
`before_x`, `mass_x`, `normal_angle`. What is the same for all impacts is given once.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Final, final

from contactlab.parameter import from_cf

CONTACT: Final = ("gap_rate", "slip")
"""The coordinates of a file that has the velocities of the contact itself."""

COORDINATE: Final = re.compile(r"[^\W\d]\w*")
"""What may be the name of a coordinate."""


@final
@dataclass(frozen=True)
class Column:
    """A kind of columns.

    Args:
        form: the name, with `{}` for every coordinate that it is of.
        units: SI, in the words of the CF conventions, by how many of these coordinates are angles.
        meaning: a few words.
        needed: when a file must have it.
    """

    form: str
    units: tuple[str, ...]
    meaning: str
    needed: str = "no"

    @property
    def coordinates(self) -> int:
        """How many coordinates it is of."""
        return self.form.count("{}")

    def names(self, *coordinates: str) -> tuple[str, ...]:
        """Give the names for some coordinates: a pair may come in either order."""
        return tuple(dict.fromkeys((self.form.format(*coordinates), self.form.format(*coordinates[::-1]))))


_VELOCITY: Final = ("m s-1", "rad s-1")
_SQUARE: Final = ("m2 s-2", "m rad s-2", "rad2 s-2")
_BODIES, _CONTACT = "with body velocities", "with contact velocities"

BEFORE: Final = Column("before_{}", _VELOCITY, "velocity of a coordinate before the impact", "always")
AFTER: Final = Column("after_{}", _VELOCITY, "the same after it", "always")
MASS: Final = Column("mass_{}", ("kg", "kg m2"), "mass or moment of inertia of a coordinate", _BODIES)
COUPLING: Final = Column(
    "mass_{}_{}", ("kg", "kg m", "kg m2"), "element of the mass matrix off its diagonal; 0 where not given"
)
NORMAL: Final = Column(
    "normal_{}", ("1", "m rad-1"), "the gap rate is the sum of normal_NAME times NAME", _BODIES
)
TANGENTIAL: Final = Column(
    "tangential_{}",
    ("1", "m rad-1"),
    "the slip is the sum of tangential_NAME times NAME",
    f"{_BODIES}, see below",
)
DELASSUS: Final = (
    Column("delassus_nn", ("kg-1",), "gap rate that a normal impulse of 1 N s makes", _CONTACT),
    Column("delassus_nt", ("kg-1",), "gap rate that a tangential one makes; 0 where not given"),
    Column("delassus_tt", ("kg-1",), "slip that a tangential one makes", f"{_CONTACT}, see below"),
)
ERROR_BEFORE: Final = Column("error_before_{}", _VELOCITY, "standard deviation of the velocity before")
ERROR_AFTER: Final = Column("error_after_{}", _VELOCITY, "the same of the velocity after")
COVARIANCE_BEFORE: Final = Column(
    "covariance_before_{}_{}",
    _SQUARE,
    "covariance of the velocities before; 0 off the diagonal where not given",
)
COVARIANCE_AFTER: Final = Column("covariance_after_{}_{}", _SQUARE, "the same of the velocities after")
KINETIC_ENERGY: Final = Column(
    "kinetic_energy", ("J",), "of the whole body before; that of the contact where not given"
)
OUTSIDE: Final = Column(
    "outside_energy", ("J",), "energy of the part of the jump that no impulse makes; 0 where not given"
)
FLAG: Final = Column("flag", ("1",), "not 0: the impact is left out; also `flag_` and any word")
IMPACT: Final = Column("impact", ("1",), "its number, whole; from 1 on where not given")
REPEATED: Final = Column(
    "repeated", ("1",), "number of an impact that several rows measure: rows of one number are averaged"
)
LEFT_OUT: Final = Column("left_out", ("1",), "how many impacts were left out before the file was written")

BODY_COLUMNS: Final = (BEFORE, AFTER, MASS, COUPLING, NORMAL, TANGENTIAL)
CONTACT_COLUMNS: Final = (BEFORE, AFTER, *DELASSUS, KINETIC_ENERGY, OUTSIDE)
ERROR_COLUMNS: Final = (ERROR_BEFORE, ERROR_AFTER, COVARIANCE_BEFORE, COVARIANCE_AFTER)
OTHER_COLUMNS: Final = (FLAG, IMPACT, REPEATED, LEFT_OUT)

WORDS: Final = {
    "title": "what was measured",
    "source": "who measured it and where it is published",
    "licence": "of the data; `license` will do",
    "jacobian": "`checked` keeps a Jacobian that the reader takes for wrong",
    "note": "anything, as often as you like",
}
"""What a file says in words: a comment line in CSV, a global attribute in netCDF."""


def known_names(angles: Mapping[str, bool], *, contact: bool) -> dict[str, str]:
    """Give all names that a file may have beside its flags, and their units.

    Args:
        angles: the coordinates by name, and whether each is an angle.
        contact: whether the file has the velocities of the contact itself.
    """
    found: dict[str, str] = {}
    for column in (*(CONTACT_COLUMNS if contact else BODY_COLUMNS), *ERROR_COLUMNS, *OTHER_COLUMNS):
        for several in combinations_with_replacement(angles, column.coordinates):
            if column is COUPLING and several[0] == several[1]:
                continue
            units = column.units[sum(angles[each] for each in several)]
            found |= dict.fromkeys(column.names(*several), units)
    return found


def is_flag(name: str) -> bool:
    """Tell whether a name is that of a flag."""
    return name == FLAG.form or name.startswith(f"{FLAG.form}_")


def tables() -> str:
    """Write the columns as the tables of the documentation."""
    lines = []
    for title, columns in (
        ("Velocities of bodies", BODY_COLUMNS),
        ("Velocities of the contact", CONTACT_COLUMNS),
        ("Errors", ERROR_COLUMNS),
        ("The rest", OTHER_COLUMNS),
    ):
        lines += [f"**{title}**", "", "| column | unit | what it is | needed |", "|---|---|---|---|"]
        for column in columns:
            contact = columns is CONTACT_COLUMNS and column.coordinates
            several = [(name,) for name in CONTACT] if contact else [("NAME", "OTHER")[: column.coordinates]]
            names = " ".join(f"`{column.form.format(*each)}`" for each in several)
            units = " or ".join(from_cf(each) for each in column.units[: 1 if contact else None])
            lines.append(f"| {names} | {units} | {column.meaning} | {column.needed} |")
        lines.append("")
    lines += ["**Words**", "", "| name | what it says |", "|---|---|"]
    lines += [f"| `{name}` | {meaning} |" for name, meaning in WORDS.items()]
    return "\n".join(lines)
