"""The traces below the scene of an animation, over which its cursor moves."""

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from contactlab.plot.animation_data import Film
from contactlab.plot.overview import COLOURS
from contactlab.plot.overview_data import COLUMNS, drawable, envelope
from contactlab.results.summary import prefixed, prefixed_unit

MODES: Final = ("free", "slip", "stick")
COLOUR: Final = ("#707070", COLOURS["slip"], COLOURS["stick"])
"""Of the contact modes free, slip and stick."""

_SHADE: Final = (0.0, 0.35, 0.45)
"""Opacity."""


def draw_traces(figure: Figure, film: Film) -> list[Axes]:
    """Draw normal force and rotor velocity with the contact modes shaded.

    Args:
        figure: its lower third is drawn into.
        film: what is shown.

    Returns:
        The axes, force first.
    """
    unit, scale = prefixed_unit(film.end - film.start, "s")
    rows = figure.add_gridspec(2, 1, left=0.115, right=0.975, top=0.345, bottom=0.085, hspace=0.2)
    force = figure.add_subplot(rows[0])
    velocity = figure.add_subplot(rows[1], sharex=force)
    root, time = film.run.root, film.run.time
    # The records around the edges let the lines reach them.
    first = max(int(np.searchsorted(time, film.start, side="right")) - 1, 0)
    part = slice(first, int(np.searchsorted(time, film.end)) + 1)
    edges = (time[part] - film.start) / scale
    # Means over the record intervals, so steps.
    steps = np.repeat(drawable(root["normal_force"].values)[part][1:], 2)
    force.plot(*envelope(np.repeat(edges, 2)[1:-1], steps), color="black")
    velocity.plot(*envelope(edges, drawable(root["rotor_velocity"].values)[part]), color="black")
    for mode, times in film.contact_spans().items():
        widths = np.maximum(times[:, 1] - times[:, 0], (film.end - film.start) / COLUMNS)
        bars = np.column_stack((times[:, 0] - film.start, widths)) / scale
        for axes in (force, velocity):
            axes.broken_barh(
                [(left, width) for left, width in bars],
                (0.0, 1.0),
                transform=axes.get_xaxis_transform(),
                color=COLOUR[MODES.index(mode)],
                alpha=_SHADE[MODES.index(mode)],
                linewidth=0.0,
                zorder=0,
            )
    force.set_xlim(0.0, (film.end - film.start) / scale)
    if not np.nanmax(np.abs(steps), initial=0.0) > 0.0:
        force.set_ylim(0.0, 1.0)
    force.set_ylabel("normal\nforce (N)")
    velocity.set_ylabel("rotor\n(rad/s)")
    velocity.set_xlabel(f"time since {prefixed(film.start, 's')} ({unit})")
    force.tick_params(labelbottom=False)
    for axes in (force, velocity):
        axes.locator_params(axis="y", nbins=4)
    figure.align_ylabels([force, velocity])
    force.legend(
        handles=[
            Patch(facecolor=COLOUR[mode], alpha=_SHADE[mode], label=MODES[mode], linewidth=0.0)
            for mode in (1, 2)
        ],
        loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2, borderpad=0.0, borderaxespad=0.0,
    )  # fmt: skip
    return [force, velocity]
