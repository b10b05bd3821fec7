"""A data sheet in words and numbers, for terminal and page alike."""

from collections.abc import Iterator, Sequence
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


class Cell(NamedTuple):
    """A number and its error as texts; empty where there is none."""

    number: str
    error: str

    def __str__(self) -> str:
        return f"{self.number} +- {self.error}" if self.error else self.number


class Row(NamedTuple):
    """A quantity and its cells."""

    name: str
    meaning: str
    cells: list[Cell]


def columns(law: xarray.Dataset) -> list[int]:
    """Give the places of the points that have a role, in the order of their velocities."""
    return [i for i, role in enumerate(law["role"].values) if role]


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
    # A fraction of a joule a metre has the prefix of the joule.
    cells = [_cell(float(v) / scale, float(e) / scale) for v, e in zip(values, errors, strict=True)]
    label = "" if unit == "1" else f" ({unit.replace('µ', 'u')})"
    return Row(f"{str(said.name).replace('_', ' ')}{label}", str(said.attrs["long_name"]), cells)


def _cell(value: float, error: float) -> Cell:
    if np.isnan(value):
        return Cell("-", "")
    if np.isinf(value):
        return Cell("never", "")
    if np.isinf(error):
        return Cell(f"{value:.4g}", "no limit")
    if error == 0.0:
        return Cell(f"{value:.5g}", "")
    return Cell(f"{value:.5g}", f"{error:.1g}")


def sentences(data: xarray.Dataset) -> Iterator[str]:
    """Say what the numbers alone do not: sense, loads, what is odd about a law."""
    for label in data["law"].values:
        law = data.sel(law=label)
        if not law["no_load_velocity"] > 0.0:
            kinds = sorted({str(kind) for kind in law["kind"].values} - {""})
            yield f"{label}: the free rotor does not turn ({', '.join(kinds)}); there is no curve to draw."
            continue
        sign = "positive" if law["sense"] > 0.0 else "negative"
        yield (
            f"{label}: the motor turns in the {sign} sense of the model. Velocity and torque are given in this "
            f"sense: a load that brakes is positive here, and in the model rotor.load_torque="
            f"{'' if law['sense'] > 0.0 else '-'}M; one that drives the motor has the other sign."
        )
        yield from _oddities(str(label), law)


def _oddities(label: str, law: xarray.Dataset) -> Iterator[str]:
    friction, output = law["friction_power"].values, law["output_power"].values
    driving = (output > 0.0) & (friction < -law["friction_power_error"].values)
    if driving.any():
        worst = int(np.argmin(np.where(driving, friction, np.inf)))
        yield (
            f"{label}: friction is no loss but gives {-1e3 * friction[worst]:.3g} mW of the output of "
            f"{1e3 * output[worst]:.3g} mW at {law['velocity'].values[worst]:.3g} rad/s: the law's friction "
            "impulse reverses the slip. No motor does this; power and efficiency owe it to the law."
        )
    if np.isinf(law["peak_force_error"].values).any():
        yield (
            f"{label}: the peak force has no limit as the step falls, as a rigid impact has an impulse and no "
            "force; it is no load of a tip."
        )
    odd = {str(kind) for kind in law["kind"].values} - {"periodic", ""}
    for kind in sorted(odd):
        which = law["velocity"].values[law["kind"].values == kind]
        where = ", ".join(f"{v:.3g}" for v in which)
        yield f"{label}: {kind} at {where} rad/s, where numbers are means over a long run."
    if np.isinf(law["stop_time"]):
        share = float(law["coasting_velocity"] / law["no_load_velocity"])
        yield (
            f"{label}: switched off, the tip leaves the rotor, which coasts at {share:.1%} of its velocity: "
            "nothing brakes it (rotor.damping=0)."
        )
    if law["holding_torque"] == 0.0:
        yield f"{label}: without drive the tip does not press on the rotor, so that nothing holds it."


def as_text(data: xarray.Dataset) -> str:
    """Write the sheet for a terminal."""
    lines: list[str] = []
    names = [str(name) for name in data if data[name].dims == ("law", "point") and f"{name}_error" in data]
    lines += _table("", [str(label) for label in data["law"].values], motor_rows(data))
    for label in data["law"].values:
        law = data.sel(law=label)
        places = columns(law)
        roles = [str(law["role"].values[place]) for place in places]
        lines += ["", *_table(str(label), roles, rows(law, names, places))]
    return "\n".join([*lines, "", *sentences(data)])


def _table(title: str, heads: Sequence[str], body: Sequence[Row]) -> list[str]:
    table = [[title, *heads], *([row.name, *map(str, row.cells)] for row in body)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [
        "  ".join(
            [line[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(line[1:], widths[1:], strict=True))]
        )
        for line in table
    ]
