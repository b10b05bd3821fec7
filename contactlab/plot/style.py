"""How every picture looks: one style, from which the overview and the animation say where they differ."""

from typing import Any, Final

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
    "lines.linewidth": 1.1,
    "lines.markersize": 3.5,
    "figure.dpi": 110,
    "savefig.dpi": 220,
    "savefig.bbox": "tight",
    "pdf.fonttype": 42,
    "svg.hashsalt": "contactlab",
}
"""Of matplotlib: for a journal, two columns wide and readable in print."""
