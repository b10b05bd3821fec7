"""The picture of a law on a prescribed path: forces over the path, over time, and what the law remembers."""

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from contactlab.arrays import Array
from contactlab.plot.overview import DENSE, explain_shades, shade
from contactlab.plot.recording import Recording, drawable, envelope, recording_of
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


def draw_driven(run: "xarray.DataTree | Groups") -> Figure:
    """Draw a run on a prescribed path into the axes normal, friction, time and, of a law with any, memory."""
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
            sizes = {f"{name} ({v.attrs['units']})": v.values for name, v in remembered.items()}
            _draw_memory(axes[1, 1], whole, sizes)
        else:
            _draw_losses(axes[1, 1], whole)
        ended = "" if whole.attributes["complete"] else f" \u2013 {whole.attributes['ending']}"
        law, span = whole.attributes["law"], prefixed(whole.end - whole.start, "s")
        figure.suptitle(f"{law} on a prescribed path of {span}{ended}", fontsize=9)
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
    axes.set_ylabel("friction (N)")


def _draw_forces(axes: Axes, run: Recording) -> None:
    """Draw both forces over time, on shades of slip and stick."""
    time = (_between(run.time) - run.start) / run.unit[1]
    shade(axes, run, run.start)
    axes.plot(*envelope(time, drawable(run.series["normal_force"][1:])), color="black", label="normal force")
    friction = drawable(run.series["friction_force"][1:])
    axes.plot(*envelope(time, friction), color="black", linestyle=(0, (4, 1.5)), label="friction")
    axes.set_xlabel(f"time ({run.unit[0]})")
    axes.set_ylabel("force (N)")
    lines = axes.legend(
        handles=axes.get_lines(), loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.0
    )
    explain_shades(axes, 1.0)
    axes.add_artist(lines)


def _draw_memory(axes: Axes, run: Recording, remembered: dict[str, Array]) -> None:
    """Draw internal variables over time, each over its largest value where there are several."""
    time, several = (run.time - run.start) / run.unit[1], len(remembered) > 1
    for name, values in remembered.items():
        most = float(np.abs(values).max()) if several else 1.0
        label = name if len(remembered) <= MOST_NAMED else None
        axes.plot(*envelope(time, drawable(values / most if most else values)), label=label)
    first, *_ = remembered
    axes.set_ylabel("internal variables over their largest" if several else first)
    if several and len(remembered) <= MOST_NAMED:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)
    axes.set_xlabel(f"time ({run.unit[0]})")


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
    for name, label in names.items():
        axes.plot(*envelope(time, drawable(run.series[name]) / scale), label=label)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)
    axes.set_xlabel(f"time ({run.unit[0]})")
    axes.set_ylabel(f"energy ({unit})")
