"""Figures of branches of periodic orbits, and of basins of attraction."""

from itertools import groupby
from typing import Any, Final

import matplotlib
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from contactlab.estimate import Estimate
from contactlab.parameter import from_cf
from contactlab.results.summary import prefixed_unit
from contactlab.studies.figures import THIN, drawing

MARKERS: Final = {
    "fold": "s",
    "branching": "P",
    "period_doubling": "D",
    "neimark_sacker": "o",
    "grazing": "v",
}
"""Of the events of a branch, by name."""

LINES: Final = {True: "-", False: "--"}
"""Of stable and unstable orbits."""

UNKNOWN: Final = "0.75"
"""Colour of starts whose attractor is not known."""

SPREAD: Final = 5.0
"""Ratio of largest multipliers from which on their axis is logarithmic."""


def draw_branch(data: xarray.Dataset) -> Figure:
    """Draw mean rotor velocity and largest multiplier over the parameter, events marked."""
    figure, (upper, lower) = drawing(2, 1, 4.0, sharex=True, height_ratios=(2.0, 1.0))
    # A velocity that is given says nothing.
    shown = "torque" if "belt" in (data.attrs["parameter"], *data.attrs) else "rotor_velocity"
    draw_curve(upper, data, shown)
    draw_curve(lower, data, "largest_multiplier")
    upper.set_ylabel({"torque": "mean torque (N m)"}.get(shown, "mean rotor velocity (rad/s)"))
    lower.set_ylabel("largest multiplier")
    lower.axhline(1.0, **THIN)
    if float(data.largest_multiplier.max()) > SPREAD:
        lower.set_yscale("log")
    lower.set_xlabel(data.attrs["parameter"] + _in_brackets(data["value"]))
    figure.legend(*upper.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def draw_curve(axes: Axes, data: xarray.Dataset, name: str, law: str = "", colour: str = "C0") -> None:
    """Draw a quantity of a branch, solid where it is stable and dashed elsewhere, with its events.

    Where a law is named its line is called so, and is the only one that is.
    """
    value, quantity = data["value"].values / _unit(data["value"])[1], data[name].values
    stable = data["stable"].values.astype(bool)
    labels = {True: law or "stable", False: "" if law else "unstable"}
    for kind, points in groupby(range(1, stable.size), lambda i: bool(stable[i])):
        stretch = [*points]
        # It begins at the point before, so that solid and dashed lines meet.
        there = slice(stretch[0] - 1, stretch[-1] + 1)
        axes.plot(value[there], quantity[there], LINES[kind], color=colour, label=labels.pop(kind, ""))
    for number, event in enumerate(data["mark"].attrs["flag_meanings"].split()):
        where = data["mark"].values == number
        if event in MARKERS and where.any():
            label = "" if law else event.replace("_", " ")
            style: dict[str, Any] = {"color": colour if law else "black", "markerfacecolor": "white"}
            axes.plot(value[where], quantity[where], MARKERS[event], label=label, zorder=3, **style)


def draw_basins(data: xarray.Dataset) -> Figure:
    """Draw to which attractor starts go, over both of their coordinates."""
    figure, (axes,) = drawing(1, 1, 4.2)
    labels = data["label"]
    x, y = (data[name] for name in labels.dims)
    colours = [UNKNOWN, *matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]]
    count = data.sizes["attractor"]
    chosen = [colours[0], *(colours[1 + i % (len(colours) - 1)] for i in range(count))]
    axes.pcolormesh(
        x.values / _unit(x)[1],
        y.values / _unit(y)[1],
        labels.values.T,
        cmap=ListedColormap(chosen),
        vmin=-1.5,
        vmax=count - 0.5,
        shading="nearest",
        rasterized=True,
    )
    for set_label, each in ((axes.set_xlabel, x), (axes.set_ylabel, y)):
        set_label(each.attrs["long_name"] + _in_brackets(each))
    handles = [Patch(color=chosen[1 + i], label=_label(data.isel(attractor=i))) for i in range(count)]
    if int(data.attrs["unresolved"]):
        share = int(data.attrs["unresolved"]) / labels.size
        handles.append(Patch(color=UNKNOWN, label=f"{100.0 * share:.3g} %: not known"))
    figure.legend(handles=handles, loc="outside upper center", ncols=1)
    return figure


def _label(attractor: xarray.Dataset) -> str:
    """Return share, kind and velocity of an attractor."""
    kind, share = str(attractor["kind"].values), 100.0 * float(attractor["share"])
    velocity = Estimate(float(attractor["velocity"]), float(attractor["velocity_error"]))
    if int(attractor["neutral"]):
        return f"{share:.3g} %: {kind}, any velocity{'' if kind == 'without contact' else ' in a range'}"
    return f"{share:.3g} %: {kind}, {velocity.text('±')} rad/s"


def _unit(values: xarray.DataArray) -> tuple[str, float]:
    """Return the unit in which values are read best, empty for numbers, and its size in SI."""
    units = values.attrs["units"]
    if units.isalpha():
        return prefixed_unit(float(np.abs(values).max()), units)
    return ("" if units == "1" else from_cf(units)), 1.0


def _in_brackets(values: xarray.DataArray) -> str:
    """Return the unit of values as it stands at an axis."""
    unit, _ = _unit(values)
    return f" ({unit})" if unit else ""
