"""How every picture looks: one style, from which the overview and the animation say where they differ."""

from typing import Any, Final

import matplotlib

COLOURS: Final = {
    "slip": "#E69F00", "stick": "#0072B2", "rotor": "#D9D9D9", "fault": "#D55E00", "impact": "#009E73",
}  # fmt: skip
"""After Okabe and Ito, distinct for every kind of colour vision and as greys."""

STYLE: Final[dict[str, Any]] = {
    "axes.prop_cycle": 'cycler("color", '
    '["0072B2", "D55E00", "009E73", "CC79A7", "E69F00", "56B4E9", "000000"])',
    "font.size": 8,
    "font.family": "sans-serif",
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "axes.formatter.useoffset": False,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.5,
    "figure.dpi": 110,
    "savefig.dpi": 220,
    "savefig.bbox": "tight",
    "pdf.fonttype": 42,
    "svg.hashsalt": "contactlab",
}
"""Of matplotlib: for a journal, two columns wide and readable in print. A tick is read without an offset."""

DASHES: Final = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
"""Line styles of several things in turn."""

HATCHES: Final = ("", "////", "....", "xxxx", "||||", "----")
"""Hatches of several areas in turn, which distinguish them without colours."""

MARKERS: Final = ("", "o", "s", "^", "D", "v", "X")
"""Markers of lines, another one each time the line styles begin anew."""


def line_style(number: int) -> dict[str, Any]:
    """Return colour, line style and marker of one of several things; 28 are distinct without colours."""
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    result = {"color": colours[number % len(colours)], "linestyle": DASHES[number % len(DASHES)]}
    if marker := MARKERS[number // len(DASHES) % len(MARKERS)]:
        # Markers of lines that lie on each other stand apart.
        result |= {"marker": marker, "markersize": 3.0, "markevery": (0.03 + 0.017 * (number % 8), 0.16)}
    return result
