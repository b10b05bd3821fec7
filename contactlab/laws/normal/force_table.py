"""A normal force from a table of force over approach, as another program or a measurement has it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, final

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.declaration import Coefficient
from contactlab.laws.memory import dependent
from contactlab.motor.table import MeasurementError, keep, kept, read_table, refuse
from contactlab.parameter import Parameter, positive

Spline = Literal["cubic", "monotone"]

SPHERE = 1e-5 * np.linspace(0.0, 1.0, 64) ** (8.0 / 3.0)
"""Approach in the rows of the table without a file [m]: closer at the touch, where d^1.5 is no polynomial."""

ROUND_OFF = 1e-12
"""Part of the largest force by which a spline may be off its rows."""

LEAST_SIZE = 64
"""Rows that a kernel receives at least; they double, so that tables of most lengths have one machine code."""


@inner_kernel
def last_row_above(depth, depths):
    """Return the last row of a table that a depth [m] has reached."""
    row, beyond = 0, len(depths)
    while beyond - row > 1:
        middle = (row + beyond) // 2
        if depths[middle] <= depth:
            row = middle
        else:
            beyond = middle
    return row


@final
@dataclass(frozen=True)
class ForceTable(NormalForce):
    """A cubic spline T through a table of force over approach, whether that rises or not.

    The file has the columns approach, from 0 on, and force, with units or without; x = d/d_0 and the force
    are scaled by d_0 and f_0, of a table in metres and newtons 1 m and 1 N. The cubic spline has a smooth
    stiffness, and errs by the fourth power of the distance of the rows; a table is refused between whose
    rows it would fall, or pull, where the rows do not. The monotone one (Fritsch and Butland 1984) takes
    every table, has no extremum between two rows, and errs by the third power; its stiffness has kinks at
    the rows, where no step ends, so that runs need more steps.

    V is the integral of the spline, so that N = dV/dd to round-off, and an impact without damping conserves
    m v^2/2 + V whether the force rises or not; a force that falls may have two more depths of the same load,
    between which a pressed contact snaps. Beyond its last row, behind which the rows say nothing, the
    force goes on along its tangent there: compare `max_penetration` with the end of the table. A first force
    below 0 is a pull that begins and ends with the contact, as of `dmt`.
    """

    name = "table"
    equation = "N = f_0 T(d/d_0), V = f_0 d_0 int_0^(d/d_0) T dx"
    source = "de Boor (1978); Fritsch and Butland (1984), SIAM J. Sci. Stat. Comput. 5, 300"
    validity = "depths up to the last row"

    file: Annotated[
        str | None, Parameter("", "1", "table of force over approach", hint="null is N = 1e10 N/m^1.5 d^1.5.")
    ] = None
    digest: Annotated[
        str | None, Parameter("", "1", "digest of the file", hint="null takes the file as it is.")
    ] = None
    spline: Annotated[Spline, Parameter("", "1", "cubic, or monotone between the rows")] = "cubic"
    approach_unit: Annotated[float, positive("d_0", "m", "unit of the table's approach")] = 1.0
    force_unit: Annotated[float, positive("f_0", "N", "unit of the table's force")] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.file is None and self.digest is not None:
            raise ValueError(f"{self.name}: digest is '{self.digest}'; it must be None without a file.")
        content = None if self.file is None else self.content()
        # Beside the fields, so that it goes along to other processes.
        object.__setattr__(self, "_content", content)
        # Listings need no spline of the table without a file.
        if content is not None:
            try:
                pieces_of(content, self.spline)
            except MeasurementError as error:
                raise ValueError(f"{self.name}: file is '{self.file}': {error}") from None

    def content(self) -> bytes:
        """Return the content of the file, or of its digest where that is known, and complete the digest."""
        if (known := kept(self.digest)) is not None:
            return known
        try:
            content = Path(str(self.file)).read_bytes()
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise ValueError(
                f"{self.name}: file is '{self.file}', which cannot be read ({reason}); it must be a file."
            ) from None
        digest = keep(content)
        if self.digest not in (None, digest):
            raise ValueError(
                f"{self.name}: digest is '{self.digest}'; it must be '{digest}', that of its file, or None."
            )
        object.__setattr__(self, "digest", digest)
        return content

    @property
    def rows(self) -> tuple[Array, Array]:
        """Approach [m] and force [N] of the rows."""
        own: Any = self
        approach, force = rows_of(own._content)
        return self.approach_unit * approach, self.force_unit * force

    @dependent
    def allows_tension(self) -> bool:
        """Whether a row pulls."""
        return bool(self.rows[1].min() < 0.0)

    @dependent
    def rises(self) -> bool:
        """Whether the force grows with the depth where it presses."""
        own: Any = self
        force = extremes_of(pieces_of(own._content, self.spline))
        return not falls(force[force >= 0.0])

    @dependent
    def smooth_stiffness(self) -> bool:
        """Whether it is the cubic spline."""
        return self.spline == "cubic"

    @dependent
    def convergence_order(self) -> float:
        """Less where no step ends at the kinks of the stiffness."""
        return 1.0 if self.spline == "cubic" else 0.7

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return depth, energy, force and its derivatives over their factorials at the rows, in SI."""
        own: Any = self
        spline = pieces_of(own._content, self.spline)
        last, derivatives = spline.x[-1], self.approach_unit ** np.arange(-1.0, 4.0)[:, None]
        # Behind the last row a piece of no curvature; rows are filled up by it.
        behind = [[spline(last)], [spline(last, 1)], [0.0], [0.0]]
        values = np.vstack([spline.antiderivative()(spline.x), np.append(spline.c[::-1], behind, axis=1)])
        values = np.vstack([self.approach_unit * spline.x, self.force_unit * values / derivatives])
        size = max(LEAST_SIZE, 1 << (spline.x.size - 1).bit_length())
        values = np.pad(values, ((0, 0), (0, size - spline.x.size)), mode="edge")
        names = ("depths", "energies", "forces", "stiffnesses", "slopes", "bends")
        return {name: tuple(row.tolist()) for name, row in zip(names, values, strict=True)}

    @staticmethod
    @kernel
    def elastic(depth, depths, energies, forces, stiffnesses, slopes, bends):
        i = last_row_above(depth, depths)
        s, force, stiffness, slope, bend = depth - depths[i], forces[i], stiffnesses[i], slopes[i], bends[i]
        return (
            force + s * (stiffness + s * (slope + s * bend)),
            energies[i] + s * (force + s * (stiffness / 2.0 + s * (slope / 3.0 + s * bend / 4.0))),
            stiffness + s * (2.0 * slope + s * 3.0 * bend),
            2.0 * slope + 6.0 * s * bend,
        )


@lru_cache(maxsize=16)
def rows_of(content: bytes | None) -> tuple[Array, Array]:
    """Return approach and force of a table as they stand in it, in SI where they have units.

    Args:
        content: of a file; None for a sphere after Hertz.

    Raises:
        MeasurementError: a column is missing or unknown, a cell is no number, or the rows are no law.
    """
    if content is None:
        return SPHERE, 1e10 * SPHERE**1.5
    table = read_table(content)
    table.check_names(["approach", "force"])
    columns = []
    for name, units in (("approach", "m"), ("force", "N")):
        if name not in table.names:
            raise MeasurementError(f"'{name}' is missing; there must be the columns approach, force.")
        columns.append(table.numbers(name, units if table.unit(name) else "1"))
    approach, force = columns
    if approach[0] != 0.0:
        raise MeasurementError(f"approach is {approach[0]:g} in {table.places[0]}; it must begin at 0.")
    refuse(
        np.append(False, ~(np.diff(approach) > 0.0)),
        lambda at: f"approach is {approach[at]:g} in {table.places[at]}; it must grow from row to row.",
    )
    if force[0] > 0.0:
        raise MeasurementError(
            f"force is {force[0]:g} in {table.places[0]}; it must be 0 at an approach of 0, or pull there."
        )
    if not (force.size > 1 and force[-1] > max(force[-2], 0.0)):
        raise MeasurementError(
            f"force is {force[-1]:g} in {table.places[-1]}; it must press and rise in the last of two rows "
            "or more, as it goes on behind it."
        )
    return approach, force


@lru_cache(maxsize=16)
def pieces_of(content: bytes | None, kind: Spline) -> Any:
    """Return the spline through a table, a `scipy.interpolate.PPoly`.

    Raises:
        MeasurementError: as of `rows_of`, or a cubic spline falls or pulls where the rows do not.
    """
    approach, force = rows_of(content)
    if kind == "monotone":
        return scipy.interpolate.PchipInterpolator(approach, force)
    spline = scipy.interpolate.CubicSpline(approach, force)
    mend = "give more rows there, or take spline=monotone."
    values = extremes_of(spline)
    if falls(values) and not falls(force):
        raise MeasurementError(
            f"the force rises from row to row, and falls on the spline between them; {mend}"
        )
    if force.min() >= 0.0 > values.min() + ROUND_OFF * force.max():
        raise MeasurementError(
            f"no row pulls, and the spline pulls with {-values.min():.3g} between them; {mend}"
        )
    if not spline(approach[-1], 1) > 0.0:
        raise MeasurementError(f"the spline does not rise in the last row, as it goes on behind it; {mend}")
    return spline


def extremes_of(spline: Any) -> Array:
    """Return the force at the rows of a spline and at its extrema, by rising depth."""
    turns = spline.derivative().roots(extrapolate=False)
    return np.asarray(spline(np.union1d(spline.x, turns[np.isfinite(turns)])))


def falls(force: Array) -> bool:
    """Return whether a force falls from one place to the next by more than round-off."""
    return bool((np.diff(force) < -ROUND_OFF * np.abs(force).max()).any())
