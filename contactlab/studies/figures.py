"""Size, line styles and legend of the figures that show several laws, and their forces on a path."""

from collections.abc import Mapping
from math import ceil
from textwrap import fill
from typing import TYPE_CHECKING, Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.plot.driven import ZERO
from contactlab.plot.recording import handy_unit
from contactlab.plot.style import line_style

if TYPE_CHECKING:
    import xarray

WIDTH: Final = 5.2
"""Width of a figure [in]; the text is legible where a phone scales it to its own width."""

LINE: Final = 0.13
"""Height of a line of a legend [in]."""

SINGLE_LINE: Final = 45
"""Characters of all labels that fit in a single line."""

LONGEST_TITLE: Final = 75
"""Characters in a line of a title."""

LONGEST_LABEL: Final = 30
"""Characters in a line of a label."""

THIN: Final[Any] = {"color": "0.5", "linewidth": 0.6, "zorder": 0}
"""Style of a reference line."""

NOTE: Final[Any] = {"ha": "right", "fontsize": 7}
"""Style of a short text at the right end of a reference line."""


def drawing(rows: int, columns: int, height: float, **arguments: Any) -> tuple[Figure, Any]:
    """Return a figure of a height [in] and its panels."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **arguments).ravel()


def explain(figure: Figure, handles: Any, labels: Any, title: str = "", **arguments: Any) -> None:
    """Put a legend with these entries over the panels, and over it the title of the figure."""
    title = fill(title, LONGEST_TITLE)
    # A layout has room for the legend outside of the panels, and for a title of the figure in the same place.
    figure.set_figheight(figure.get_figheight() + LINE * len(title.splitlines()))
    figure.legend(
        handles, labels, loc="outside upper center", title=title or None, title_fontsize=8, **arguments
    )


def captioned(figure: Figure, caption: str) -> Figure:
    """Return a figure with the caption that it has on the page."""
    figure.set_label(caption)
    return figure


def legend_above(figure: Figure, axes: Axes, title: str = "", **arguments: Any) -> Figure:
    """Put the legend above the panels, where it covers nothing, below the figure's title if there is one."""
    handles, labels = axes.get_legend_handles_labels()
    if not labels:
        return figure
    columns = min(len(labels), 3 if max(map(len, labels)) < LONGEST_LABEL else 2)
    columns = len(labels) if sum(map(len, labels)) < SINGLE_LINE else columns
    labels = [fill(label, LONGEST_LABEL) for label in labels]
    # The panels keep their size, however many laws there are.
    lines = ceil(len(labels) / columns) * max(label.count("\n") + 1 for label in labels)
    figure.set_figheight(figure.get_figheight() + LINE * (lines - 1))
    explain(figure, handles, labels, ncols=columns, title=title, **arguments)
    figure.align_ylabels()
    return figure


def draw_paths(runs: Mapping[str, "xarray.DataTree"], measured: "xarray.Dataset | None") -> Figure:
    """Draw the forces of laws on one path over the way, and over time, beside measured ones."""
    figure, panels = drawing(2, 2, 3.9)
    names = "tip_tangential_displacement", "time"
    (long, way_scale), (late, time_scale) = (
        handy_unit([run.to_dataset()[x].values for run in runs.values()], unit)
        for x, unit in zip(names, "ms", strict=True)
    )
    for row, name in zip((panels[:2], panels[2:]), ("normal_force", "friction_force"), strict=True):
        for number, (label, run) in enumerate(runs.items()):
            root = run.to_dataset()
            way, time = (root[x].values for x in names)
            # Forces are means between the records.
            middle = [0.5 * (values[1:] + values[:-1]) for values in (way, time)]
            for axes, places, scale in zip(row, middle, (way_scale, time_scale), strict=True):
                axes.plot(places / scale, root[name].values[1:], label=label, **line_style(number))
        if measured is not None and name in measured:
            since = measured["time"].values - measured["time"].values[0]
            shown = measured["slip"].values / way_scale, since / time_scale
            for axes, places in zip(row, shown, strict=True):
                axes.plot(places, measured[name], ".", color="black", markersize=1.5, label="measured")
        for axes in row:
            axes.axhline(0.0, **ZERO)
        row[0].set_ylabel(f"{name.replace('_', ' ')} (N)")
    panels[2].set_xlabel(f"displacement along the surface ({long})")
    panels[3].set_xlabel(f"time ({late})")
    return legend_above(figure, panels[2])
