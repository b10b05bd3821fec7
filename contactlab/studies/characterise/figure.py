"""The figure of a data sheet: torque, output power and efficiency over velocity, all laws together."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.plot.recording import handy_unit
from contactlab.plot.style import line_style
from contactlab.studies.figures import THIN, drawing, legend_above

MARKERS: Final = "os^Dv"
"""Points of the laws in turn; with the line styles 20 laws are distinct without colours."""

DRAWN: Final = {"torque": "N m", "output_power": "W", "electrical_efficiency": "%"}
"""Quantities of the panels, and their units without a prefix."""

FINE: Final = 400
"""Velocities at which lines are drawn."""


def draw(data: xarray.Dataset) -> Figure:
    """Draw torque, output power and efficiency over the velocity in the motor's sense.

    Velocities at which the rotor was held are points, open where the motion has no orbit, with their errors;
    a cross is the free rotor.
    Between belts torque and input are straight lines, and power and efficiency what follows from them.
    """
    figure, panels = drawing(3, 1, 5.4, sharex=True)
    units = [
        (unit, 1e-2) if unit == "%" else handy_unit([data[name].values], unit) for name, unit in DRAWN.items()
    ]
    for number, label in enumerate(data["law"].values):
        _draw_law(panels, data.sel(law=label), number, str(label), [scale for _, scale in units])
    torque, power, efficiency = panels
    for axes, name, (unit, _) in zip(panels, DRAWN, units, strict=True):
        axes.set_ylabel(f"{name.replace('_', ' ')} ({unit})")
    efficiency.set_xlabel("velocity in the motor's sense (rad/s)")
    for axes in panels:
        axes.axhline(0.0, **THIN)
        axes.axvline(0.0, **THIN)
    power.set_ylim(bottom=-0.25 * max(power.get_ylim()[1], 0.0))
    efficiency.set_ylim(bottom=0.0)
    note = {"fontsize": 7, "color": "0.35", "textcoords": "offset points"}
    (lower, upper), (_, right) = torque.get_ylim(), torque.get_xlim()
    torque.annotate("load brakes", (right, upper), (-2, -2), ha="right", va="top", **note)
    torque.annotate("load drives the motor on", (0.0, lower), (3, 3), **note)
    torque.annotate("load turns\nit back", (0.0, lower), (-3, 3), ha="right", **note)
    torque.plot([], [], "x", color="black", markersize=6.0, label="free rotor")
    if ((data["kind"] != "periodic") & (data["kind"] != "")).any():
        torque.plot([], [], "o", color="black", markerfacecolor="white", label="mean, no orbit")
    return legend_above(figure, torque)


def _draw_law(
    panels: Sequence[Axes], law: xarray.Dataset, number: int, label: str, scales: Sequence[float]
) -> None:
    """Draw one law into the panels of torque, power and efficiency, each in a unit of the size `scales`."""
    line, marker = {x: line_style(number)[x] for x in ("color", "linestyle")}, MARKERS[number % len(MARKERS)]
    colour = line["color"]
    on_belt = (law["role"].values != "no load") & np.isfinite(law["torque"].values)
    velocity = law["velocity"].values
    if on_belt.any():
        v, m, p = (law[n].values[on_belt] for n in ("velocity", "torque", "active_power"))
        fine = np.union1d(v, np.linspace(v[0], v[-1], FINE))
        torque = np.interp(fine, v, m)
        power = torque * fine
        motoring = np.where(power >= 0.0, power, np.nan) / np.interp(fine, v, p)
        for axes, values, scale in zip(panels, (torque, power, motoring), scales, strict=True):
            axes.plot(fine, values / scale, **line)
    closed = law["kind"].values == "periodic"
    for axes, name, scale in zip(panels, DRAWN, scales, strict=True):
        value, error = law[name].values / scale, law[f"{name}_error"].values / scale
        for which, face in ((on_belt & closed, colour), (on_belt & ~closed, "white")):
            points = {"linestyle": "", "marker": marker, "color": colour, "markerfacecolor": face}
            bars = np.where(np.isfinite(error), error, 0.0)[which]
            axes.errorbar(velocity[which], value[which], bars, elinewidth=0.8, capsize=2.0, **points)
    free = velocity[law["role"].values == "no load"]
    panels[0].plot(free, np.zeros_like(free), "x", color=colour, markersize=6.0)
    known = on_belt.any() or np.isfinite(free).any()
    panels[0].plot([], [], marker=marker, label=label if known else f"{label}, no curve", **line)
