"""The figure of a data sheet: torque, output power and efficiency over velocity, all laws together."""

from pathlib import Path
from typing import Any, Final

import matplotlib
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.style import context

from contactlab.plot.style import STYLE
from contactlab.results.files import whole_file

SIZE: Final = (5.2, 5.4)  # inches; the words are still read where a phone makes it its own width
DASHES: Final = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
MARKERS: Final = "os^Dv"
"""Lines and points of the laws in turn, so that a print without colours tells them apart."""

THIN: Final = {"color": "0.5", "linewidth": 0.6, "zorder": 0}

METADATA: Final[Any] = {"pdf": {"CreationDate": None}, "png": {"Software": None}}
"""Without dates and versions the same sheet gives the same bytes."""


def save(data: xarray.Dataset, folder: Path) -> Path:
    """Write sheet.png and sheet.pdf into a folder, and give the PNG."""
    with context(STYLE):
        figure = draw(data)
        for kind, metadata in METADATA.items():
            with whole_file(folder / f"sheet.{kind}") as partial:
                figure.savefig(partial, format=kind, metadata=metadata)
    return folder / "sheet.png"


def draw(data: xarray.Dataset) -> Figure:
    """Draw torque, output power and efficiency over the velocity in the motor's sense.

    Belts are points, open where the motion has no orbit, with their errors; a cross is the free rotor.
    """
    figure = Figure(figsize=SIZE, layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    for i, label in enumerate(data["law"].values):
        law = data.sel(law=label)
        for axes, (name, scale) in zip(panels, _DRAWN, strict=True):
            _draw_law(axes, law, name, scale, i, str(label))
    torque, power, efficiency = panels
    torque.set_ylabel("torque, braking load (mN m)")
    power.set_ylabel("output power (mW)")
    efficiency.set_ylabel("efficiency (%)")
    efficiency.set_xlabel("velocity in the motor's sense (rad/s)")
    for axes in panels:
        axes.axhline(0.0, **THIN)
        axes.axvline(0.0, **THIN)
    power.set_ylim(bottom=-0.25 * max(power.get_ylim()[1], 0.0))
    efficiency.set_ylim(bottom=0.0)
    figure.align_ylabels()
    handles, labels = torque.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 3))
    return figure


_DRAWN: Final = (("torque", 1e3), ("output_power", 1e3), ("electrical_efficiency", 1e2))


def _draw_law(axes: Axes, law: xarray.Dataset, name: str, scale: float, number: int, label: str) -> None:
    """Draw a quantity of one law over the velocity."""
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    colour, marker = colours[number % len(colours)], MARKERS[number % len(MARKERS)]
    kind, velocity = law["kind"].values, law["velocity"].values
    value, error = scale * law[name].values, scale * law[f"{name}_error"].values
    on_belt = (law["role"].values != "no load") & (kind != "")
    dashes = DASHES[number % len(DASHES)]
    axes.plot(velocity[on_belt], value[on_belt], color=colour, linestyle=dashes)
    closed = kind == "periodic"
    for which, face in ((on_belt & closed, colour), (on_belt & ~closed, "white")):
        style = {"linestyle": "", "marker": marker, "color": colour, "markerfacecolor": face}
        finite = np.where(np.isfinite(error), error, 0.0)
        axes.errorbar(velocity[which], value[which], finite[which], elinewidth=0.8, capsize=2.0, **style)
    free = law["role"].values == "no load"
    if name == "torque":
        axes.plot(velocity[free], value[free], marker="x", color=colour, markersize=6.0, linestyle="")
        line = {"color": colour, "linestyle": dashes, "marker": marker}
        axes.plot([], [], label=label, **line)
