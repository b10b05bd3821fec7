"""Figures of steady states, of branches of periodic orbits, and of basins of attraction."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any, Final

import matplotlib
import numpy as np
import xarray
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from contactlab.estimate import Estimate
from contactlab.plot.overview import draw_normal, explain_shades, shade
from contactlab.plot.recording import handy_unit, law_named_in, recording_of, steps
from contactlab.plot.style import COLOURS, DASHES
from contactlab.results.summary import prefixed_unit
from contactlab.studies.figures import THIN, drawing, explain, legend_above

CLOSED: Final = 1e-15
"""Gap that is none [m]."""

ROUND_OFF: Final = 1e-9
"""Relative change of a series that is round-off."""


def draw_steady(tree: xarray.DataTree) -> Figure:
    """Draw a steady state over one orbit, or over one period of a motion that has none."""
    run, about, state = recording_of(tree), tree["steady"].attrs, tree["steady"].to_dataset()
    velocity = Estimate(float(state["rotor_velocity"]), float(state["rotor_velocity_error"]))
    series, (unit, scale) = run.series, run.unit
    time = run.time / scale
    figure = Figure(figsize=(7.1, 6.2), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplot_mosaic(
        [["path", "multipliers"], ["velocity", "velocity"], ["gap", "gap"], ["force", "force"]],
        height_ratios=(1.7, 1, 1, 1),
    )
    figure.suptitle(
        f"{run.law}: {about['kind']}, rotor velocity {velocity.text('±')} rad/s",
        x=0.01, ha="left", fontsize=9,
    )  # fmt: skip
    _draw_path(panels["path"], tree)
    if "multiplier" in state.dims:
        _draw_multipliers(panels["multipliers"], state)
    else:
        _draw_stroboscopic_samples(panels["multipliers"], state)
    below = {name: panels[name] for name in ("velocity", "gap", "force")}
    # The gap of a rigid contact is zero but for round-off.
    gap = np.where(np.abs(series["gap"]) < CLOSED, 0.0, series["gap"])
    gap_unit, gap_scale = prefixed_unit(float(np.abs(gap).max()) or 1e-6, "m", smallest=0.1)
    below["velocity"].plot(time, series["rotor_velocity"], color="black")
    # That of an orbit is a bound of every difference.
    known = velocity.error if "multiplier" in state.dims else 0.0
    _widen(below["velocity"], series["rotor_velocity"], known)
    if "belt" in about:
        # The contact changes a prescribed velocity by round-off only.
        below["velocity"].set_ylim(about["belt"] - 1.0, about["belt"] + 1.0)
    below["velocity"].set_ylabel("rotor velocity\n(rad/s)")
    below["gap"].plot(time, gap / gap_scale, color="black")
    _widen(below["gap"], gap / gap_scale)
    below["gap"].axhline(0.0, color="0.35", linewidth=0.6)
    below["gap"].set_ylabel(f"gap ({gap_unit})")
    if draw_normal(below["force"], run, 0.0) is None:
        below["force"].set_ylabel("force on the tip (N)")
        friction = steps(time, series["friction_force"][1:])
        below["force"].plot(*friction, color=COLOURS["fault"], linestyle=DASHES[1])
        below["force"].autoscale(axis="y")
        below["force"].legend(
            below["force"].lines, ("normal", "friction"),
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1,
        )  # fmt: skip
    else:
        below["force"].set_ylabel("lasting normal\nforce (N)")
    below["force"].set_xlabel(f"time ({unit}), from phase {about['phase']:.3g} of the drive's period on")
    for name, axes in below.items():
        if name != "force":
            shade(axes, run, 0.0)
        axes.set_xlim(time[0], time[-1])
        axes.tick_params(labelbottom=axes is below["force"])
    explain_shades(below["velocity"], 1.03)
    figure.align_ylabels([*below.values()])
    return figure


def _widen(axes: Axes, values: np.ndarray, error: float = 0.0) -> None:
    """Draw what changes by round-off only, or less than its error, as a constant."""
    middle = 0.5 * float(values.max() + values.min())
    if np.ptp(values) <= max(ROUND_OFF * abs(middle), error):
        size = abs(middle) if abs(middle) > error else 1.0
        axes.set_ylim(middle - 0.5 * size, middle + 0.5 * size)


def _draw_path(axes: Axes, tree: xarray.DataTree) -> None:
    """Draw the way of the tip end, in colour where it touches."""
    series = tree.to_dataset()
    x, y = series["tip_tangential_displacement"].values, series["tip_normal_displacement"].values
    unit, scale = prefixed_unit(max(np.ptp(x), np.ptp(y)), "m", smallest=0.1)
    axes.plot(x / scale, y / scale, color="black")
    for value, mode in ((1, "slip"), (2, "stick")):
        inside = series["contact_mode"].values == value
        axes.plot(
            np.where(inside, x, np.nan) / scale, np.where(inside, y, np.nan) / scale,
            ".-", color=COLOURS[mode], linewidth=1.8, markersize=2.5,
        )  # fmt: skip
    axes.set_aspect("equal", "datalim")
    axes.set_xlabel(f"tangential displacement ({unit})")
    axes.set_ylabel(f"normal displacement ({unit})")
    axes.set_title("path of the tip end", loc="left")


def _draw_multipliers(axes: Axes, state: xarray.Dataset) -> None:
    """Draw the Floquet multipliers in the unit circle."""
    circle = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 361))
    real, imag = state["multiplier_real"].values, state["multiplier_imag"].values
    axes.plot(circle.real, circle.imag, color="0.5", linewidth=0.8)
    axes.axhline(0.0, color="0.85", linewidth=0.6, zorder=0)
    axes.axvline(0.0, color="0.85", linewidth=0.6, zorder=0)
    axes.plot(real, imag, "o", color="#0072B2", markersize=4)
    axes.set_aspect("equal", "datalim")
    axes.set_xlabel("real part")
    axes.set_ylabel("imaginary part")
    axes.set_title(f"Floquet multipliers, largest {np.hypot(real[0], imag[0]):.5g}", loc="left")


def _draw_stroboscopic_samples(axes: Axes, state: xarray.Dataset) -> None:
    """Draw slip and rotor velocity of a motion without an orbit, sampled once a period."""
    slip, rotor = (state[f"stroboscopic_{name}"].values for name in ("slip_velocity", "rotor_velocity"))
    axes.plot(slip, rotor, ".", color="black", markersize=1.5)
    axes.set_xlabel("slip velocity (m/s)")
    axes.set_ylabel("rotor velocity (rad/s)")
    axes.set_title(f"stroboscopic samples of {slip.size} periods", loc="left")


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

MARKS: Final = "os^Dv*PX"
"""Markers of the basins in turn."""

MOST_MARKED: Final = 12
"""Starts along each coordinate that have a marker."""

UNKNOWN: Final = "0.75"
"""Colour of starts whose attractor is not known."""

SPREAD: Final = 5.0
"""Ratio of largest multipliers from which on their axis is logarithmic."""


def draw_branch(data: xarray.Dataset) -> Figure:
    """Draw mean rotor velocity and largest multiplier over the parameter, events marked."""
    figure, (upper, lower) = drawing(2, 1, 4.0, sharex=True, height_ratios=(2.0, 1.0))
    # A velocity that is given says nothing.
    if "belt" in (data.attrs["parameter"], *data.attrs):
        shown, meaning = "torque", "mean torque (N m)"
        if data[shown].isnull().all():
            # A flat contact has no lever.
            shown, meaning = "friction_force", "mean friction force (N)"
    else:
        shown, meaning = "rotor_velocity", "mean rotor velocity (rad/s)"
    draw_curve(upper, data, shown)
    draw_curve(lower, data, "largest_multiplier")
    upper.set_ylabel(meaning)
    lower.set_ylabel("largest multiplier")
    lower.axhline(1.0, **THIN)
    if float(data.largest_multiplier.max()) > SPREAD:
        lower.set_yscale("log")
    lower.set_xlabel(data.attrs["parameter"] + _in_brackets(data["value"]))
    return legend_above(figure, upper, _title(data))


def draw_response(branches: Sequence[xarray.Dataset], linear: xarray.Dataset) -> Figure:
    """Draw amplitude and phase of branches over the parameter, and those of the free motor."""
    figure, (upper, lower) = drawing(2, 1, 4.4, sharex=True, height_ratios=(2.0, 1.0))
    cycle = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    # One unit for all that an axis shows.
    scales = {
        name: handy_unit([each[name].values for each in branches], branches[0][name].attrs["units"])
        for name in ("value", "amplitude")
    } | {"phase": ("degrees", np.pi / 180.0)}
    order = np.argsort(linear["value"].values)
    for axes, name in ((upper, "amplitude"), (lower, "phase")):
        for number, branch in enumerate(branches):
            shown = branch.assign({each: branch[each] / scale for each, (_, scale) in scales.items()})
            for each in ("value", "amplitude", "phase"):
                # What is drawn is in its unit already.
                shown[each].attrs["units"] = "1"
            draw_curve(axes, shown, name, branch.attrs["label"], cycle[number % len(cycle)])
        places, values = ((linear[each].values / scales[each][1])[order] for each in ("value", name))
        axes.plot(places, values, ":", color="0.4", label="without contact", zorder=0)
    limits = [branch["amplitude"].max() / scales["amplitude"][1] for branch in branches]
    # Without contact the resonance may be ten times as high.
    upper.set_ylim(0.0, 1.25 * float(max(limits)))
    quantity = branches[0].attrs["quantity"].replace("_", " ")
    upper.set_ylabel(f"amplitude of the\n{quantity} ({scales['amplitude'][0]})")
    lower.set_ylabel("phase (degrees)")
    lower.set_xlabel(f"{branches[0].attrs['parameter']} ({scales['value'][0]})")
    return legend_above(figure, upper)


def _title(data: xarray.Dataset) -> str:
    """Return law and subject of a dataset."""
    subject = str(data.attrs["title"]).partition(", ")[0]
    belt = f", rotor held at {data.attrs['belt']:.4g} rad/s" if "belt" in data.attrs else ""
    return f"{law_named_in(data.attrs)}: {subject[0].lower()}{subject[1:]}{belt}"


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
    cycle = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    count = data.sizes["attractor"]
    colours = [cycle[i % len(cycle)] for i in range(count)]
    axes.pcolormesh(
        x.values / _unit(x)[1],
        y.values / _unit(y)[1],
        labels.values.T,
        cmap=ListedColormap([UNKNOWN, *colours]),
        vmin=-1.5,
        vmax=count - 0.5,
        shading="nearest",
        rasterized=True,
    )
    for set_label, each in ((axes.set_xlabel, x), (axes.set_ylabel, y)):
        set_label(each.attrs["long_name"] + _in_brackets(each))
    handles: list[Artist] = []
    for i in range(count):
        # Markers of some starts distinguish the basins without colours.
        marker = {"marker": MARKS[i % len(MARKS)], "markersize": 4.0, "linestyle": ""}
        edge = {"color": "black", "markerfacecolor": colours[i], "markeredgewidth": 0.7}
        places = np.argwhere(labels.values == i)
        places = places[(places % np.maximum(np.array(labels.shape) // MOST_MARKED, 1) == 0).all(axis=1)]
        at = (each.values[place] / _unit(each)[1] for each, place in zip((x, y), places.T, strict=True))
        (line,) = axes.plot(*at, label=_label(data.isel(attractor=i)), **marker, **edge)
        handles.append(line)
    if int(data.attrs["unresolved"]):
        share = int(data.attrs["unresolved"]) / labels.size
        handles.append(Patch(color=UNKNOWN, label=f"{100.0 * share:.3g} %: not known"))
    explain(figure, handles, [handle.get_label() for handle in handles], _title(data), ncols=1)
    return figure


def _label(attractor: xarray.Dataset) -> str:
    """Return share, kind and velocity of an attractor."""
    kind, share = str(attractor["kind"].values), 100.0 * float(attractor["share"])
    velocity = Estimate(float(attractor["velocity"]), float(attractor["velocity_error"]))
    if int(attractor["neutral"]):
        return (
            f"{share:.3g} %: {kind}, any rotor velocity{'' if kind == 'without contact' else ' in a range'}"
        )
    return f"{share:.3g} %: {kind}, rotor velocity {velocity.text('±')} rad/s"


def _unit(values: xarray.DataArray) -> tuple[str, float]:
    """Return the unit in which values are read best, empty for numbers, and its size in SI."""
    return handy_unit([values.values], values.attrs["units"])


def _in_brackets(values: xarray.DataArray) -> str:
    """Return the unit of values as it stands at an axis."""
    unit, _ = _unit(values)
    return f" ({unit})" if unit else ""
