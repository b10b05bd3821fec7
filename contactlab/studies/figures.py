"""What the pictures of a comparison share: width, look of a law, legend above the panels."""

from textwrap import fill
from typing import Any, Final

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

WIDTH: Final = 5.2  # inches; the words are still read where a phone makes it its own width
LINE: Final = 0.13  # height of a line of a legend [in]
ONE_LINE: Final = 45  # letters of all labels that stand in one line
LONGEST_LABEL: Final = 30  # letters in a line of a label

DASHES: Final = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
"""Lines of the laws in turn, so that a print without colours tells them apart."""

THIN: Final[Any] = {"color": "0.5", "linewidth": 0.6, "zorder": 0}  # of a line to go by
NOTE: Final[Any] = {"ha": "right", "fontsize": 7}  # of a few words at the right end of such a line


def drawing(rows: int, columns: int, height: float, **arguments: Any) -> tuple[Figure, Any]:
    """Make a figure and its panels."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **arguments).ravel()


def style(number: int) -> dict[str, Any]:
    """Give colour and line of a law."""
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    return {"color": colours[number % len(colours)], "linestyle": DASHES[number % len(DASHES)]}


def legend_above(figure: Figure, axes: Axes, **arguments: Any) -> Figure:
    """Put the legend above the panels, where it covers nothing."""
    handles, labels = axes.get_legend_handles_labels()
    columns = min(len(labels), 3 if max(map(len, labels)) < LONGEST_LABEL else 2)
    columns = len(labels) if sum(map(len, labels)) < ONE_LINE else columns
    labels = [fill(label, LONGEST_LABEL) for label in labels]
    # The panels keep their size, however many laws there are.
    lines = -(-len(labels) // columns) * max(label.count("\n") + 1 for label in labels)
    figure.set_figheight(figure.get_figheight() + LINE * (lines - 1))
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, **arguments)
    figure.align_ylabels()
    return figure
