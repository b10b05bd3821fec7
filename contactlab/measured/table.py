"""What a file of measurements holds before anything is made of it: columns with units, and words."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config.quantity import UnitError, factor
from contactlab.measured.columns import WORDS
from contactlab.measured.faults import MeasurementError
from contactlab.parameter import from_cf
from contactlab.suggestion import suggestion

_TRUTHS: Final = {"": 0.0, "false": 0.0, "no": 0.0, "true": 1.0, "yes": 1.0}
"""What a flag may be beside a number."""


LARGEST: Final = 1e60
"""What numbers are below, so that their squares are numbers too."""


@final
@dataclass(frozen=True, eq=False)
class Table:
    """Columns as a file has them.

    Args:
        values: by name; shape () for what is the same for all, else (row,). Texts where the file has texts.
        units: by name, as written; None where none is.
        places: where each row is in the file, for sentences: "line 7".
        words: title, source and the like.
        how: how a column is written with its unit, for sentences, "before_x [m/s]".
    """

    values: Mapping[str, np.ndarray]
    units: Mapping[str, str | None]
    places: tuple[str, ...]
    words: Mapping[str, str] = field(default_factory=dict)
    how: str = "{name} [{unit}]"

    def example(self, name: str, units: str) -> str:
        """Give how a column is written in SI, for sentences."""
        return name if units == "1" else self.how.format(name=name, unit=from_cf(units))

    def factor(self, name: str, units: str) -> float:
        """Give what the numbers of a column are multiplied by to be in SI; a fault where they cannot."""
        given, wanted = self.units[name], from_cf(units)
        if given is None or (not given.strip() and units != "1"):
            if units == "1":
                return 1.0
            raise MeasurementError(
                f"{name} has no unit; it must have one like {wanted}. Write {self.example(name, units)}."
            )
        try:
            return float(factor(given.strip() or "1", wanted))
        except UnitError as error:
            raise MeasurementError(
                f"{name} is in '{given}'; it must be in a unit of the same kind as {wanted}. Correct its "
                "unit, or its numbers."
            ) from error

    def numbers(self, name: str, units: str, chosen: Array | None = None) -> Array:
        """Give the chosen rows of a column in SI, shape (row,) or (); a fault where one is no number."""
        values, scale = self.values[name], self.factor(name, units)
        rows = np.arange(len(self.places)) if chosen is None else np.flatnonzero(chosen)
        given = values[rows] if values.ndim else values
        found = _as_numbers(given)
        if (bad := ~(np.abs(found) < LARGEST)).any():
            first = int(np.argmax(bad))
            place = f" in {self.places[rows[first]]}" if values.ndim else ""
            cell = np.atleast_1d(given)[first]
            told = "is empty" if cell == "" else f"is '{cell}', which is no number that can be measured"
            leave = "leave the row out" if chosen is None else "flag the impact in the column 'flag'"
            way_out = f" Complete it, or {leave}." if values.ndim else ""
            raise MeasurementError(f"{name} {told}{place}; it must be a number.{way_out}")
        return found if scale == 1.0 else found * scale

    def flagged(self, names: Iterable[str]) -> np.ndarray:
        """Tell which rows any flag marks, shape (row,); a fault where one is neither number nor truth."""
        marked = np.zeros(len(self.places), dtype=bool)
        for name in names:
            values = self.values[name]
            if values.dtype.kind in "OU":
                values = np.array([_TRUTHS.get(str(one).strip().lower(), one) for one in values.ravel()])
            found = _as_numbers(values)
            # A table's library writes an empty cell as NaN.
            empty = values.dtype.kind == "f"
            if (bad := ~np.isfinite(found)).any() and not empty:
                first = int(np.argmax(bad))
                raise MeasurementError(
                    f"{name} is '{values.ravel()[first]}' in {self.places[first]}; a flag must be 0 or empty "
                    "for a good impact and another number for one that is left out."
                )
            marked |= np.nan_to_num(found) != 0.0
        return marked

    def refuse_unknown(self, known: Iterable[str], flags: Iterable[str]) -> None:
        """Refuse names that are none of a file's: one that is misspelt would vanish without a word."""
        names = [*known, *flags, *WORDS]
        unknown = [name for name in self.values if name not in names]
        if unknown:
            first = unknown[0]
            several = f" and {len(unknown) - 1} more" if len(unknown) > 1 else ""
            parts = sorted(first.split("_"))
            turned = [name for name in names if sorted(name.split("_")) == parts]
            meant = suggestion(turned[0] if turned else first, names, "See docs/measured_data.md for all.")
            raise MeasurementError(
                f"'{first}'{several} is not the name of a column; a misspelt one would be lost. {meant} "
                "Leave out what is none, or put it into words after '# note:'."
            )


def _as_numbers(values: np.ndarray) -> Array:
    """Give numbers as float64, NaN for what is none."""
    if values.dtype.kind in "biuf":
        return values.astype(np.float64)
    found = [_number(one) for one in values.ravel()]
    return np.array(found, dtype=np.float64).reshape(values.shape)


def _number(cell: object) -> float:
    try:
        # Python reads 1_000, which no table means.
        return np.nan if "_" in str(cell) else float(str(cell))
    except ValueError:
        return np.nan
