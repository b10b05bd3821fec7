"""Size, line styles and legend of the figures that show several laws."""

from textwrap import fill
from typing import Any, Final

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

WIDTH: Final = 5.2
"""Width of a figure [in]; the text is legible where a phone scales it to its own width."""

LINE: Final = 0.13
"""Height of a line of a legend [in]."""

SINGLE_LINE: Final = 45
"""Characters of all labels that fit in a single line."""

LONGEST_LABEL: Final = 30
"""Characters in a line of a label."""

DASHES: Final = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
"""Line styles of the laws in turn, which distinguish them in a print without colours."""

THIN: Final[Any] = {"color": "0.5", "linewidth": 0.6, "zorder": 0}
"""Style of a reference line."""

NOTE: Final[Any] = {"ha": "right", "fontsize": 7}
"""Style of a short text at the right end of a reference line."""


def drawing(rows: int, columns: int, height: float, **arguments: Any) -> tuple[Figure, Any]:
    """Return a figure of a height [in] and its panels."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **arguments).ravel()


def style(number: int) -> dict[str, Any]:
    """Return colour and line style of a law."""
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    return {"color": colours[number % len(colours)], "linestyle": DASHES[number % len(DASHES)]}


def legend_above(figure: Figure, axes: Axes, **arguments: Any) -> Figure:
    """Put the legend above the panels, where it covers nothing."""
    handles, labels = axes.get_legend_handles_labels()
    columns = min(len(labels), 3 if max(map(len, labels)) < LONGEST_LABEL else 2)
    columns = len(labels) if sum(map(len, labels)) < SINGLE_LINE else columns
    labels = [fill(label, LONGEST_LABEL) for label in labels]
    # The panels keep their size, however many laws there are.
    lines = -(-len(labels) // columns) * max(label.count("\n") + 1 for label in labels)
    figure.set_figheight(figure.get_figheight() + LINE * (lines - 1))
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, **arguments)
    figure.align_ylabels()
    return figure
