"""A data sheet in words and numbers, for terminal and page alike."""

from collections.abc import Iterator, Sequence
from math import floor, log10
from typing import Final, NamedTuple

import numpy as np
import xarray

from contactlab.parameter import from_cf
from contactlab.results.summary import prefixed_unit

BALANCE: Final = {
    "active_power": "electrical input",
    "output_power": "mechanical output",
    "damping_power": "damping",
    "friction_power": "friction",
    "contact_power": "contact",
    "dielectric_power": "dielectric",
    "balance": "left over",
}
"""Where the electrical input goes, and the words of each part."""

WITHOUT_PREFIX: Final = ("rad/s", "1", "1/m", "V A")
"""Units that are read as they are."""


DIGITS: Final = 5
"""Of a number, at most."""


class Cell(NamedTuple):
    """A number and its error as texts; empty where there is none."""

    number: str
    error: str

    def __str__(self) -> str:
        return f"{self.number} +- {self.error}" if self.error else self.number


class Row(NamedTuple):
    """A quantity, its unit if it has one, and its cells."""

    name: str
    unit: str
    meaning: str
    cells: list[Cell]

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


def columns(law: xarray.Dataset) -> list[int]:
    """Give the places of the points that have a role, in the order of their velocities."""
    return [i for i, role in enumerate(law["role"].values) if role]


def motion_row(law: xarray.Dataset, places: Sequence[int]) -> Row:
    """Give the row of what motion was found at some points."""
    return Row(
        "motion", "", "kind of the steady motion", [Cell(str(law["kind"].values[i]), "") for i in places]
    )


def rows(law: xarray.Dataset, names: Sequence[str], places: Sequence[int]) -> list[Row]:
    """Give rows of quantities at some points of a law, each in a unit of handy size."""
    return [
        _row(law[name], law[name].values[[*places]], law[f"{name}_error"].values[[*places]]) for name in names
    ]


def motor_rows(data: xarray.Dataset) -> list[Row]:
    """Give a row for each number of the motor, a cell a law."""
    names = [str(name) for name in data if data[name].dims == ("law",) and f"{name}_error" in data]
    return [_row(data[name], data[name].values, data[f"{name}_error"].values) for name in names]


def _row(said: xarray.DataArray, values: np.ndarray, errors: np.ndarray) -> Row:
    unit, scale = from_cf(said.attrs["units"]), 1.0
    largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    if unit not in WITHOUT_PREFIX and largest:
        unit, scale = prefixed_unit(largest, unit)
    cells = [_cell(float(v) / scale, float(e) / scale) for v, e in zip(values, errors, strict=True)]
    name, unit = str(said.name).replace("_", " "), "" if unit == "1" else unit.replace("µ", "u")
    return Row(name, unit, str(said.attrs["long_name"]), cells)


def _cell(value: float, error: float) -> Cell:
    if np.isnan(value):
        return Cell("-", "")
    if np.isinf(value):
        return Cell("never", "")
    if np.isinf(error):
        return Cell("no limit", "")
    if error == 0.0:
        return Cell(f"{value:.{DIGITS}g}", "")
    # As many digits as are known, and no more than are read.
    decimals = min(-floor(log10(error)), DIGITS - 1 - (floor(log10(abs(value))) if value else 0))
    known = round(value, decimals)
    fixed = f"{known:.{max(decimals, 0)}f}" if decimals < 2 * DIGITS and abs(known) < 1e5 else f"{known:.2g}"
    return Cell(fixed if known else "0", _short(error))


def _short(error: float) -> str:
    return f"{error:.0f}" if 1.0 <= error < 1e4 else f"{error:.1g}"


def sentences(data: xarray.Dataset) -> list[str]:
    """Say what the numbers alone do not: sense, loads, what is odd; once for all laws that share it."""
    said: dict[str, list[str]] = {}
    for label in map(str, data["law"].values):
        for sentence in _said_of(data.sel(law=label)):
            said.setdefault(sentence, []).append(label)
    return [f"{', '.join(labels)}: {sentence}" for sentence, labels in said.items()]


def _said_of(law: xarray.Dataset) -> Iterator[str]:
    if not law["no_load_velocity"] > 0.0:
        reasons = sorted({str(reason) for reason in law["reason"].values} - {""})
        if reasons:
            yield f"the free rotor has no steady state to characterise. {' '.join(reasons)}"
            return
        kinds = ", ".join(sorted({str(kind) for kind in law["kind"].values} - {""}))
        yield f"the free rotor does not turn ({kinds}); there is no curve to draw."
        return
    sign, minus = ("positive", "") if law["sense"] > 0.0 else ("negative", "-")
    yield (
        f"the motor turns in the {sign} sense of the model. Velocity and torque are given in the motor's "
        "sense, in which a load that brakes is positive: a load of M here is rotor.load_torque="
        f"{minus}M in the model, and the other sign drives the motor on."
    )
    friction, output = law["friction_power"].values, law["output_power"].values
    driving = (output > 0.0) & (friction < -law["friction_power_error"].values)
    if driving.any():
        worst = int(np.argmin(np.where(driving, friction, np.inf)))
        yield (
            f"friction is no loss but gives {-1e3 * friction[worst]:.3g} mW where the output is "
            f"{1e3 * output[worst]:.3g} mW, at {law['velocity'].values[worst]:.3g} rad/s: the friction "
            "impulse of this law reverses the slip. No motor does this; power and efficiency owe it to that."
        )
    if np.isinf(law["peak_force_error"].values).any():
        yield (
            "the peak force has no limit as the step falls: a rigid impact has an impulse and no force, and "
            "nothing follows for a tip's strength."
        )
    for kind in sorted({str(kind) for kind in law["kind"].values} - {"periodic", ""}):
        where = ", ".join(f"{v:.3g}" for v in law["velocity"].values[law["kind"].values == kind])
        yield f"the motion is {kind} at {where} rad/s; numbers are means over a long run there."
    apart = abs(float(law["no_load_velocity"] - law["curve_root"]))
    free = law.isel(point=int(np.flatnonzero(law["role"].values == "no load")[0]))
    known = float(free["velocity_ripple"] + law["no_load_velocity_error"] + law["curve_root_error"])
    if apart > known:
        yield (
            f"the free rotor's velocity and the root of the curve differ by {apart:.2g} rad/s, more than "
            f"ripple and errors, {known:.2g} rad/s: on a belt the motor comes to another motion."
        )
    if np.isinf(law["stop_time"]):
        share = float(law["coasting_velocity"] / law["no_load_velocity"])
        yield (
            f"switched off, the tip leaves the rotor, which coasts on at {share:.1%} of its velocity: "
            "nothing brakes it (rotor.damping is 0)."
        )
    if law["holding_torque"] == 0.0:
        yield "without drive the tip does not press on the rotor: nothing holds it."


def as_text(data: xarray.Dataset) -> str:
    """Write the sheet for a terminal."""
    names = [str(name) for name in data if data[name].dims == ("law", "point") and f"{name}_error" in data]
    lines = [*_table("", [str(label) for label in data["law"].values], motor_rows(data))]
    for label in data["law"].values:
        law = data.sel(law=label)
        places = columns(law)
        roles = [str(law["role"].values[place]) for place in places]
        body = [motion_row(law, places), *rows(law, names, places)]
        lines += ["", *_table(str(label), roles, body)]
    return "\n".join([*lines, "", *sentences(data)])


def _table(title: str, heads: Sequence[str], body: Sequence[Row]) -> Iterator[str]:
    table = [[title, *heads], *([row.label, *map(str, row.cells)] for row in body)]
    first, *widths = (max(map(len, column)) for column in zip(*table, strict=True))
    for name, *cells in table:
        yield "  ".join([name.ljust(first), *(c.rjust(w) for c, w in zip(cells, widths, strict=True))])
