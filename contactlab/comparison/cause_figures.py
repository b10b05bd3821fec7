"""Two pictures of settled motors: what moves their numbers beside the law, and the shares of the variance."""

from textwrap import fill
from typing import Final

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.arrays import Array
from contactlab.comparison.canvas import LONGEST_LABEL, THIN, drawing, legend_above, style
from contactlab.comparison.causes import CAUSES, NOT_KNOWN, NUMERICAL
from contactlab.comparison.weighing import CLEAR, sample_count, unclear
from contactlab.metrics import METRICS, needed

TITLES: Final = {
    "rotor_velocity": "settled rotor velocity",
    "peak_force": "peak force",
    "stick_share": "stick, share of contact",
    "friction_share": "friction, share of drive work",
}
WIDE: Final = 30.0  # ratio of values beyond which an axis is logarithmic
STEP: Final = 0.17  # between the bars of a law, laws being one apart


def draw_causes(data: xarray.Dataset) -> Figure:
    """Draw every quantity of every law, and how far each cause moves it.

    A bar as long as marks are apart is of a cause that may explain their difference.
    """
    count = data.sizes["law"]
    figure, axes = drawing(2, 2, 1.7 + 2 * 0.62 * count, sharey=True)
    for panel, key in zip(axes, data["quantity"].values, strict=True):
        _draw_quantity(panel, data, str(key))
    labels = [fill(str(label), LONGEST_LABEL // 2) for label in data["law"].values]
    axes[0].set_yticks(np.arange(count), labels)
    axes[0].set_ylim(count - 0.5, -0.5)
    return legend_above(figure, axes[0])


def _draw_quantity(panel: Axes, data: xarray.Dataset, key: str) -> None:
    value = data["value"].sel(metric=key).values
    ends = np.stack([data[name].sel(quantity=key).values for name in ("least", "greatest")])
    known = np.isfinite(value)
    if _spans_decades(value[known], ends):
        panel.set_xscale("log")
    for number, cause in enumerate(CAUSES):
        low, high = value - ends[0, :, number], ends[1, :, number] - value
        if cause == NUMERICAL:
            low, high = CLEAR * low, CLEAR * high
        if key == "stick_share":
            # A part of the contact is at least none and at most all of it.
            low, high = np.minimum(low, value), np.minimum(high, 1.0 - value)
        if panel.get_xscale() == "log":
            # A bar that ends at nothing has no place on the axis.
            low = np.minimum(low, 0.9 * value)
        place = np.arange(value.size) + STEP * (number - 0.5 * (len(CAUSES) - 1))
        colour = style(number)["color"]
        words = f"{CLEAR:g} x {cause}" if cause == NUMERICAL else cause
        here = np.isfinite(low) & np.isfinite(high) & known
        bars = {"linestyle": "none", "color": colour, "capsize": 2.5, "elinewidth": 1.8, "label": words}
        panel.errorbar(value[here], place[here], xerr=[low[here], high[here]], **bars)
        for x, y in zip(value[~here & known], place[~here & known], strict=True):
            note = {"color": colour, "fontsize": 7, "va": "center"}
            panel.annotate("?", (x, y), (8, 0), textcoords="offset points", **note)
    panel.plot(value[known], np.flatnonzero(known), "D", color="black", markersize=3.5)
    for x in value[known]:
        panel.axvline(x, **THIN)
    unit = METRICS[key].bracketed.replace("[", "(").replace("]", ")")
    # A run taken as recorded may not have settled.
    title = TITLES[key].removeprefix("settled ") if NOT_KNOWN in data["kind"].values else TITLES[key]
    panel.set_xlabel(f"{title}{unit}")
    panel.margins(x=0.08)


def _spans_decades(values: Array, ends: Array) -> bool:
    """Tell whether positive values with their bars want a logarithmic axis."""
    reached = np.append(ends[ends > 0.0], values)
    return bool(values.size and np.all(values > 0.0) and reached.max() > WIDE * reached.min())


def draw_shares(data: xarray.Dataset) -> Figure:
    """Draw the shares of the factors in the variance of the settled velocity, with their intervals."""
    needed("total_order" in data)
    here = data.sel(quantity="rotor_velocity")
    total, first = here["total_order"].values, here["first_order"].values
    needed(np.isfinite(total).all())
    order = np.argsort(-total[:, 0], kind="stable")
    figure, (axes,) = drawing(1, 1, 0.9 + 0.36 * order.size)
    place, count = np.arange(order.size), sample_count(data)
    for rows, offset, words, number in ((total, -0.18, "with others", 0), (first, 0.18, "alone", 1)):
        known = ~np.array([unclear(*row[1:]) for row in rows[order]])
        share, low, high = rows[order][known].T
        colour = style(number)["color"]
        axes.barh(place[known] + offset, share, height=0.34, color=colour, label=words)
        reach = [share - np.minimum(low, share), np.maximum(high, share) - share]
        axes.errorbar(share, place[known] + offset, xerr=reach, fmt="none", color="black", capsize=2)
        for y in place[~known] + offset:
            axes.text(0.01, y, f"{words}: {count} samples do not tell", va="center", color=colour, fontsize=7)
    # Estimates and their intervals reach beyond what a share can be, by at most their width.
    left, right = axes.get_xlim()
    axes.set_xlim(min(left, 0.0), max(right, 1.0))
    axes.set_yticks(place, here["factor"].values[order])
    axes.invert_yaxis()
    axes.set_xlabel("share of the variance of the settled rotor velocity")
    return legend_above(figure, axes)
