"""Figures of `law_contrasts`, drawn from its recorded numbers: of pages, and of a journal's width."""

from collections.abc import Callable, Iterable, Mapping
from math import inf, nan
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from contrast_map import BAR
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.arrays import Array
from contactlab.plot.style import DASHES

Numbers = Mapping[str, Any]

WIDTH: Final = 6.3
"""Width of a text column of A4 [inch]."""

LEAST: Final = 1e-12
"""Least contrast that is drawn; a smaller one is drawn here."""

SPEED: Final = "rotor_velocity"

LAW, NULL, TURNED = "C0", "0.6", "C1"
"""Colours of contrasts of laws, of null contrasts, and of motors that turn."""


def array(values: Iterable[Any]) -> Array:
    """Return recorded numbers as an array: infinite where a motor turns, NaN where none is recorded."""
    return np.array([nan if x is None else inf if isinstance(x, str) else float(x) for x in values])


def is_null(contrast: str) -> bool:
    """Return whether a contrast changes nothing that is physics."""
    return contrast.startswith("null")


def cloud(axes: Axes, values: Array, row: float, colour: str) -> None:
    """Draw sizes of a row as points, with their median; one of a motor that turns has no place."""
    shown = np.maximum(values[np.isfinite(values)], LEAST)
    if shown.size:
        middle = max(np.median(values[~np.isnan(values)]), LEAST)
        # Places between rows are even, whatever the size.
        height = row + 0.6 * (np.modf(np.arange(shown.size) * 0.6180339887)[0] - 0.5)
        axes.plot(shown, height, ".", color=colour, markersize=2.5, alpha=0.6, markeredgewidth=0.0)
        axes.plot(2 * [middle], [row - 0.4, row + 0.4], color="black", linewidth=1.2)


def rows(axes: Axes, labels: Iterable[str]) -> None:
    """Name the rows of an axis, the first one on top."""
    named = [*labels]
    axes.set_yticks(range(len(named)), named)
    axes.set_ylim(len(named) - 0.4, -0.6)


def sizes(numbers: Numbers) -> Figure:
    """Draw |ln| of the ratio of speeds by contrast and motor, with medians and motors that turn."""
    own = numbers["size"][SPEED]
    figure, axes = plt.subplots(figsize=(WIDTH, 0.27 * len(own) + 0.7), layout="constrained")
    for row, (name, values) in enumerate(own.items()):
        each = array(values)
        cloud(axes, each, row, NULL if is_null(name) else LAW)
        if turned := int(np.isinf(each).sum()):
            axes.text(
                1.01, row, f"{turned} turned", color=TURNED, va="center", transform=axes.get_yaxis_transform()
            )
    rows(axes, own)
    axes.set_xscale("log")
    axes.set_xlabel(f"|ln of the ratio of speeds| in each of {numbers['motors']} motors (1)")
    return figure


def knowledge(numbers: Numbers) -> Figure:
    """Draw the share of motors in which a contrast exceeds multiples of the half-width of the prediction."""
    contrasts = {name: array(x) for name, x in numbers["size"][SPEED].items() if not is_null(name)}
    figure, axes = plt.subplots(
        2, 4, figsize=(WIDTH, 3.6), sharex=True, sharey=True, layout="constrained", squeeze=True
    )
    legend = axes.flat[len(contrasts)]
    legend.axis("off")
    for panel, (name, size) in zip(axes.flat, contrasts.items(), strict=False):
        for dash, (level, widths) in zip(DASHES, numbers["half-width"].items(), strict=False):
            ratio = size / array(widths)
            ratio = np.sort(np.clip(ratio[~np.isnan(ratio)], 1e-3, 1e3))
            if ratio.size:
                share = 1.0 - np.arange(ratio.size + 1) / ratio.size
                panel.step([1e-3, *ratio], share, where="post", label=level, linestyle=dash)
        panel.axvline(1.0, color="0.5", linewidth=0.6)
        panel.set_title(name if len(name) < 20 else name.replace(" or ", "\nor "))
        panel.set_xscale("log")
        panel.set_xlim(1e-3, 1e3)
        panel.set_ylim(0.0, 1.02)
    legend.legend(
        *axes.flat[0].get_legend_handles_labels(), loc="center", title="what is known\nof the motor"
    )
    figure.supxlabel("contrast over the half-width of the prediction (1)", fontsize=8)
    figure.supylabel(f"share of {numbers['motors']} motors beyond (1)", fontsize=8)
    return figure


def explained(numbers: Numbers) -> Figure:
    """Draw R^2 of the map in motors that it has not seen, with 95 % intervals and the bar."""
    names = [name for name in numbers["size"][SPEED] if not is_null(name)]
    figure, axes = plt.subplots(figsize=(WIDTH, 0.3 * len(names) + 0.8), layout="constrained")
    for shift, colour, (quantity, judged) in zip(
        (-0.15, 0.15), ("C0", "C1"), numbers["map"].items(), strict=True
    ):
        drawn = [(names.index(name) + shift, own) for name, own in judged.items()]
        axes.errorbar(
            [own["r2"] for _, own in drawn],
            [row for row, _ in drawn],
            xerr=np.abs([[own["r2"] - own[end] for _, own in drawn] for end in ("low", "high")]),
            fmt="o",
            color=colour,
            label=quantity.replace("_", " "),
        )
    if not numbers["map"][SPEED]:
        text = f"no map is judged yet: {numbers['motors']} motors have run"
        axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes)
    axes.axvline(BAR, color="0.5", linewidth=0.6)
    rows(axes, names)
    axes.set_xlim(-0.5, 1.0)
    axes.set_xlabel("$R^2$ in motors that the map has not seen (1)")
    axes.legend(loc="lower right")
    return figure


FIGURES: Final[dict[str, Callable[[Numbers], Figure]]] = {
    "": sizes,
    "_knowledge": knowledge,
    "_map": explained,
}
"""Figures by what follows the name of the experiment in their files."""
