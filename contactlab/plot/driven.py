"""The picture of a law on a prescribed path: forces over the path, over time, and what the law remembers."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from contactlab.arrays import Array
from contactlab.plot.overview import DENSE, shade, shade_keys
from contactlab.plot.recording import Recording, drawable, envelope, handy_unit, recording_of
from contactlab.plot.style import DASHES, line_style
from contactlab.results.netcdf import Groups, groups_of
from contactlab.results.summary import prefixed, prefixed_unit
from contactlab.variables import INTERNAL

if TYPE_CHECKING:
    import xarray

SAME = 1e-9
"""Relative change of a gap or force that is none."""

ZERO: Final[Any] = {"color": "0.8", "linewidth": 0.6, "zorder": 0}
"""Line of no force, to which an axis of forces reaches: round-off of a constant one is not what is drawn."""

MOST_NAMED = 6
"""Internal variables with a name in the picture."""


def draw_driven(run: "xarray.DataTree | Groups", label: str = "") -> Figure:
    """Draw a run on a prescribed path: forces over the path and over time, and what the law remembers.

    Of a law without internal variables the fourth panel has work and losses.

    Args:
        run: the run.
        label: what stands for the law's name.
    """
    groups = groups_of(run)
    whole = recording_of(groups)
    remembered = {
        str(v.attrs["symbol"]): v
        for name, v in groups["/"].variables.items()
        if str(name).startswith(INTERNAL)
    }
    with rc_context(DENSE):
        figure = Figure(figsize=(7.1, 4.6), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(2, 2)
        _draw_normal(axes[0, 0], whole)
        _draw_friction(axes[0, 1], whole)
        _draw_forces(axes[1, 0], whole)
        if remembered:
            _draw_memory(axes[1, 1], whole, remembered)
        else:
            _draw_losses(axes[1, 1], whole)
        ended = "" if whole.attributes["complete"] else f" \u2013 {whole.attributes['ending']}"
        span = prefixed(whole.end - whole.start, "s")
        figure.suptitle(f"{label or whole.law} on a prescribed path of {span}{ended}", fontsize=9)
    return figure


def _between(values: Array) -> Array:
    """Return a series at the middles of the record intervals, over which the forces are means."""
    return 0.5 * (values[1:] + values[:-1])


def _draw_normal(axes: Axes, run: Recording) -> None:
    """Draw the normal force over the penetration; over time where that does not change."""
    force, gap = drawable(run.series["normal_force"][1:]), run.series["gap"]
    if np.ptp(gap) > SAME * np.abs(gap).max():
        unit, scale = prefixed_unit(float(np.abs(gap).max()), "m")
        axes.plot(-_between(drawable(gap)) / scale, force, color="black")
        axes.set_xlabel(f"penetration ({unit})")
    else:
        axes.plot(_between(run.time) / run.unit[1], force, color="black")
        axes.set_xlabel(f"time ({run.unit[0]})")
    axes.axhline(0.0, **ZERO)
    axes.set_ylabel("normal force (N)")


def _draw_friction(axes: Axes, run: Recording) -> None:
    """Draw the friction over the way, a loop where that goes to and fro."""
    way = drawable(run.series["tip_tangential_displacement"])
    unit, scale = prefixed_unit(float(np.abs(way).max()), "m")
    axes.axhline(0.0, **ZERO)
    axes.plot(_between(way) / scale, drawable(run.series["friction_force"][1:]), color="black")
    axes.set_xlabel(f"displacement along the surface ({unit})")
    axes.set_ylabel("friction force (N)")


def _draw_forces(axes: Axes, run: Recording) -> None:
    """Draw both forces over time, on shades of slip and stick."""
    time = (_between(run.time) - run.start) / run.unit[1]
    shade(axes, run, run.start)
    axes.plot(*envelope(time, drawable(run.series["normal_force"][1:])), color="black", label="normal force")
    friction = drawable(run.series["friction_force"][1:])
    axes.plot(*envelope(time, friction), color="black", linestyle=DASHES[1], label="friction force")
    axes.set_xlabel(f"time ({run.unit[0]})")
    axes.set_ylabel("force (N)")
    _explain(axes, [*axes.get_lines(), *shade_keys()])


def _draw_memory(axes: Axes, run: Recording, remembered: Mapping[str, Any]) -> None:
    """Draw internal variables over time, each over its largest value where there are several."""
    time, several = (run.time - run.start) / run.unit[1], len(remembered) > 1
    for number, (name, variable) in enumerate(remembered.items()):
        most = float(np.nanmax(np.abs(drawable(variable.values))))
        unit, scale = handy_unit([most], str(variable.attrs["units"]))
        size = (most or 1.0) if several else scale
        label = f"{name}, up to {most / scale:.3g} {unit}".rstrip()
        axes.plot(*envelope(time, drawable(variable.values) / size), label=label, **line_style(number))
        if not several:
            axes.set_ylabel(f"internal variable {name}" + (f" ({unit})" if unit else ""))
    if several:
        axes.set_ylabel("internal variables over their largest")
        _explain(axes, axes.get_lines()[:MOST_NAMED])
        if len(remembered) > MOST_NAMED:
            axes.set_title(f"the first {MOST_NAMED} of {len(remembered)} are named", fontsize=7)
    axes.set_xlabel(f"time ({run.unit[0]})")


def _explain(axes: Axes, handles: Sequence[Artist]) -> None:
    """Put the legend over a panel, where it covers nothing."""
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=2,
        borderpad=0.1,
        borderaxespad=0.1,
    )


def _draw_losses(axes: Axes, run: Recording) -> None:
    """Draw work and losses over time."""
    time = (run.time - run.start) / run.unit[1]
    names = {
        "drive_work": "work of the path",
        "friction_loss": "friction loss",
        "contact_loss": "contact loss",
    }
    most = max(float(np.abs(run.series[name]).max()) for name in names)
    unit, scale = prefixed_unit(most, "J")
    for number, (name, label) in enumerate(names.items()):
        line = envelope(time, drawable(run.series[name]) / scale)
        # The work is what the losses take: theirs are thinner lines on it.
        axes.plot(*line, label=label, linewidth=1.0 if number else 2.4, **line_style(number))
    _explain(axes, axes.get_lines())
    axes.set_xlabel(f"time ({run.unit[0]})")
    axes.set_ylabel(f"energy ({unit})")
