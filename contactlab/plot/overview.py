"""The overview of a run: rotor velocity, path of the tip end, and gap and force of the last drive periods.

Only matplotlib's objects are used, so that nothing of a caller's own figures or settings changes.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from contactlab.arrays import Array
from contactlab.plot.recording import COLUMNS, Recording, drawable, envelope, extent, recording_of, steps
from contactlab.plot.style import COLOURS, STYLE
from contactlab.results.files import whole_file
from contactlab.results.netcdf import Groups, groups_of, reached_end, settling_in
from contactlab.results.summary import prefixed, prefixed_unit
from contactlab.settling.verdict import INCONCLUSIVE, Settling

if TYPE_CHECKING:
    import xarray

DENSE: Final[dict[Any, Any]] = STYLE | {
    "figure.dpi": 300,
    "savefig.dpi": 300,
    "savefig.bbox": None,
    "text.usetex": False,
    "font.family": "DejaVu Sans",
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "xtick.major.pad": 4.5,
    "ytick.major.width": 0.6,
    "lines.linewidth": 0.9,
    "patch.linewidth": 0.9,
}
"""The style of pictures with several panels close to each other."""

SHADE: Final = {"slip": 0.4, "stick": 0.55}
"""Opacity; stick is the darker one in a black and white print too."""

PERIODS: Final = 3
"""Drive periods at the end of a run that are shown in detail."""

HARDLY: Final = 1e-3
"""Change of a velocity, in parts of it, that is drawn as none."""

OVERTOPPED: Final = 1.5
"""Height of an axis of forces over the largest, beside whose impulses it stands."""

_SIZE: Final = (7.1, 5.9)
"""Inches; the width of two columns of a journal."""


def overview(run: "xarray.DataTree | Groups", path: Path) -> None:
    """Draw a run, complete or not, and write the picture as PNG.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    figure = draw_overview(run)
    with rc_context(DENSE), whole_file(path) as partial:
        # Without the default metadata the picture does not depend on matplotlib's version string.
        figure.savefig(partial, format="png", metadata={"Software": None}, pil_kwargs={"compress_level": 1})


def draw_overview(run: "xarray.DataTree | Groups") -> Figure:
    """Draw a run, complete or not, into the axes velocity, path, gap and force.

    Of a rigid law the impulses of its impacts have an axis of their own beside that of the force.
    """
    groups = groups_of(run)
    whole = recording_of(groups)
    window = whole.between(whole.end - PERIODS * whole.period, whole.end)
    with rc_context(DENSE):
        figure = Figure(figsize=_SIZE)
        FigureCanvasAgg(figure)
        rows = figure.add_gridspec(
            2, 1, height_ratios=(1, 1.45), left=0.095, right=0.985 if whole.impacts is None else 0.925,
            top=0.925, bottom=0.075,
            hspace=0.29,
        )  # fmt: skip
        top = rows[0].subgridspec(1, 2, width_ratios=(1.55, 1), wspace=0.25)
        velocity, path = figure.add_subplot(top[0]), figure.add_subplot(top[1])
        below = rows[1].subgridspec(2, 1, hspace=0.17)
        gap = figure.add_subplot(below[0])
        force = figure.add_subplot(below[1], sharex=gap)
        _draw_title(figure, whole)
        _draw_velocity(velocity, whole)
        _draw_steady(velocity, settling_in(groups))
        _draw_path(path, window)
        _draw_gap(gap, window)
        _draw_force(force, window)
        for letter, axes in zip("abcd", (velocity, path, gap, force), strict=True):
            # Left of the axis, because a power of ten may stand over it.
            axes.annotate(
                letter, (0.0, 1.0), (-16.0, 5.0), "axes fraction", "offset points",
                fontweight="bold",
            )  # fmt: skip
        figure.align_ylabels([velocity, gap, force])
    return figure


def shade(axes: Axes, run: Recording, origin: float) -> None:
    """Shade the times of slip and of stick in a panel whose time is zero at the origin [s]."""
    for mode, times in run.spans().items():
        # A contact that is shorter than a pixel must still be seen.
        width = np.maximum(times[:, 1] - times[:, 0], (run.end - run.start) / COLUMNS)
        axes.broken_barh(
            [(a, b) for a, b in np.column_stack((times[:, 0] - origin, width)) / run.unit[1]],
            (0.0, 1.0),
            transform=axes.get_xaxis_transform(),
            color=COLOURS[mode],
            alpha=SHADE[mode],
            linewidth=0.0,
            label=mode,
            zorder=0,
        )


def shade_keys() -> list[Patch]:
    """Return the entries of the shades in a legend."""
    return [
        Patch(facecolor=COLOURS[mode], linewidth=0.0, alpha=opacity, label=mode)
        for mode, opacity in SHADE.items()
    ]


def explain_shades(axes: Axes, height: float) -> None:
    """Put the legend of the shades over the right end of a panel, at a height in parts of it."""
    axes.legend(
        handles=shade_keys(), loc="lower right", bbox_to_anchor=(1.0, height), ncols=2, borderpad=0.0,
        borderaxespad=0.0,
    )  # fmt: skip


def _draw_title(figure: Figure, run: Recording) -> None:
    """Draw one factual line over the picture."""
    attributes, count = run.attributes, run.contacts["start_time"].size
    # Plus nothing: a rotor at rest has no sign.
    time, velocity = float(np.ptp(run.time)), float(run.series["rotor_velocity"][-1]) + 0.0
    contacts = "1 contact" if count == 1 else f"{count or 'no'} contacts"
    speed = f"{velocity:.4g}".replace("-", "\u2212")
    text = f"{run.law}: {contacts} in {prefixed(time, 's')}, "
    text += f"rotor velocity {speed} rad/s at the end"
    colour = "black"
    if not attributes["complete"]:
        ending, colour = attributes["ending"], COLOURS["fault"]
        text += f" \u2013 {ending if reached_end(attributes) else f'incomplete: {ending}'}"
    figure.text(0.012, 0.985, text, va="top", fontsize=9, color=colour)


def _draw_velocity(axes: Axes, run: Recording) -> None:
    """Draw the rotor's velocity over the whole run."""
    time, (unit, scale) = run.time, run.unit
    values = drawable(run.series["rotor_velocity"])
    line = envelope(time / scale, values)
    keep_ticks_short(axes, values)
    axes.plot(*line, color="black", marker="o" if time.size == 1 else "", markersize=2.5)
    if time.size > 1:
        axes.set_xlim(time[0] / scale, time[-1] / scale)
    axes.set_xlabel(f"time ({unit})")
    axes.set_ylabel("rotor velocity (rad/s)")


def keep_ticks_short(axes: Axes, values: Array) -> None:
    """Draw what hardly changes as a constant: its change lies behind more digits than a tick has room for."""
    middle, width = extent(values)
    if middle and width <= HARDLY * abs(middle):
        axes.set_ylim(middle - 0.5 * abs(middle), middle + 0.5 * abs(middle))


def _draw_steady(axes: Axes, settling: Settling) -> None:
    """Draw the estimated velocity of the steady state with its error, and say whether the run came there."""
    names = settling.short.replace("-", "\u2212").replace("+\u2212", "\u00b1")
    axes.set_title(names, loc="right", y=1.0, fontsize=7, pad=4)
    if settling.verdict == INCONCLUSIVE:
        return
    low, high = axes.get_ylim()
    room = 0.04 * (high - low)
    axes.axhspan(
        settling.velocity - settling.error, settling.velocity + settling.error,
        color=COLOURS["rotor"], linewidth=0.0, zorder=0,
    )  # fmt: skip
    axes.axhline(settling.velocity, color="0.35", linewidth=0.6, linestyle=(0, (6, 4)))
    # A wide band shall not press the run together.
    axes.set_ylim(min(low, settling.velocity - room), max(high, settling.velocity + room))


def _draw_path(axes: Axes, window: Recording) -> None:
    """Draw the path of the tip end and the rotor's surface, both from the tip end's place at rest.

    The rotor is (0, clearance + R) + R (sin, -cos) in the axes of the contact at rest.
    """
    series, surface = window.series, window.clearance
    x, y = map(drawable, window.path)
    # A distant rotor would shrink the path to a dot.
    size = max(extent(x)[1], extent(y)[1])
    near = size == 0.0 or abs(surface - extent(y)[0]) <= 4.0 * size

    unit, scale = prefixed_unit(max(size, surface if near else 0.0), "m", smallest=0.1)
    axes.plot(x / scale, y / scale, **_line(window))
    for value, mode in ((1, "slip"), (2, "stick")):
        inside = np.where(series["contact_mode"] == value, y, np.nan)
        style = _line(window) | {"color": COLOURS[mode], "linewidth": 1.6}
        axes.plot(x / scale, inside / scale, **style)
    title = "path of the tip end"
    if near:
        # Some depth of the rotor is shown over everything, with room for its name.
        depth = max(surface, float(np.nanmax(y, initial=surface))) + 0.12 * (size or surface)
        _set_equal_limits(axes, x / scale, np.append(y, depth) / scale)
        _draw_rotor(axes, surface / scale, window.radius / scale)
        axes.text(0.03, 0.96, "rotor", transform=axes.transAxes, va="top", fontsize=7)
    else:
        _set_equal_limits(axes, x / scale, y / scale)
        title += f", rotor at {prefixed(surface, 'm')}"
    axes.set_title(title, loc="right", y=1.0, fontsize=7, pad=4)
    axes.locator_params(nbins=6)
    axes.set_xlabel(f"tangential displacement ({unit})")
    moves = np.any(series.get("rotor_normal_displacement", 0.0))
    label = "relative normal\ndisplacement" if moves else "normal displacement"
    axes.set_ylabel(f"{label} ({unit})")


def _draw_rotor(axes: Axes, surface: float, radius: float) -> None:
    """Draw the part of the rotor that lies within the limits of a panel, in the panel's unit."""
    angle = np.arcsin(np.clip(np.linspace(*axes.get_xlim(), 101) / radius, -1.0, 1.0))
    x, y = radius * np.sin(angle), surface + 2.0 * radius * np.sin(0.5 * angle) ** 2
    top = np.maximum(y, axes.get_ylim()[1])
    axes.fill_between(x, y, top, color=COLOURS["rotor"], linewidth=0.0, zorder=0)
    axes.plot(x, y, color="0.35", linewidth=0.6, scalex=False, scaley=False)


def _draw_gap(axes: Axes, window: Recording) -> None:
    """Draw the gap over the last drive periods, and the legend of the shades."""
    time = (window.series["time"] - window.end) / window.unit[1]
    gap = drawable(window.series["gap"])
    unit, scale = prefixed_unit(float(np.nanmax(np.abs(gap), initial=0.0)), "m", smallest=0.1)
    shade(axes, window, window.end)
    axes.axhline(0.0, color="0.35", linewidth=0.6)
    axes.plot(*envelope(time, gap / scale), **_line(window))
    axes.set_ylabel(f"gap ({unit})")
    axes.tick_params(labelbottom=False)
    if window.contacts["start_time"].size:
        explain_shades(axes, 1.03)


def draw_normal(axes: Axes, run: Recording, origin: float) -> Axes | None:
    """Draw the normal force, and return the axes of the impulses of impacts, None of a compliant law.

    The force is a mean over each record interval, so that steps are drawn. An impact takes no time: its force
    has no height, and its impulse is a wide stem behind the line of the force, which it overtops.
    """
    _, scale = run.unit
    edges = (run.series["time"] - origin) / scale
    force = run.series["lasting_force"][1:]
    axes.plot(*steps(edges, force), color="black")
    if run.start < run.end:
        axes.set_xlim((run.start - origin) / scale, (run.end - origin) / scale)
    if run.impacts is None:
        shade(axes, run, origin)
        _reach_over(axes, force)
        return None
    times, impulses = run.impacts
    beside, colour = axes.twinx(), COLOURS["impact"]
    # The force is drawn over the stems, and these over the shades.
    axes.set_zorder(beside.get_zorder() + 1.0)
    axes.patch.set_visible(False)
    shade(beside, run, origin)
    _reach_over(axes, force, OVERTOPPED)
    name, size = prefixed_unit(float(np.max(impulses, initial=0.0)) or 1.0, "N s")
    # Of those in one pixel the largest hides the others.
    order = np.argsort(impulses)[-4 * COLUMNS :]
    at = (times[order] - origin) / scale
    heights = impulses[order] / size
    beside.vlines(at, 0.0, heights, color=colour, linewidth=2.4)
    beside.plot(at, heights, linestyle="none", marker="o", markersize=4.0, color=colour)
    _reach_over(beside, heights)
    beside.spines["right"].set_visible(True)
    beside.tick_params(axis="y", colors=colour)
    beside.set_ylabel(f"impulse, dots ({name})", color=colour)
    return beside


def _reach_over(axes: Axes, values: Array, reach: float = 1.08) -> None:
    """Let an axis reach from zero, or from below what pulls, to over the largest of some values."""
    known = drawable(values)
    least, largest = np.nanmin(known, initial=0.0), np.nanmax(known, initial=0.0)
    axes.set_ylim(1.08 * least, reach * largest if largest > 0.0 else 1.0)


def _draw_force(axes: Axes, window: Recording) -> None:
    """Draw the normal force over the last drive periods."""
    draw_normal(axes, window, window.end)
    if not window.contacts["start_time"].size:
        axes.text(0.5, 0.5, "no contact", transform=axes.transAxes, ha="center", color="0.35")
    axes.set_xlabel(f"time relative to the end of the run ({window.unit[0]})")
    axes.set_ylabel("normal force (N)" if window.impacts is None else "lasting force (N)")


def _line(window: Recording) -> dict[str, Any]:
    """Return how a motion is drawn: as a line, or as points where a line would invent it."""
    if window.coarse:
        return {"color": "black", "linestyle": "none", "marker": "o", "markersize": 2.5}
    return {"color": "black"}


def _set_equal_limits(axes: Axes, x: Array, y: Array) -> None:
    """Set limits around points with the same scale both ways, without changing the panel's shape."""
    width, height = np.multiply(axes.get_position().size, _SIZE)
    box = width / height
    (across, wide), (up, high) = extent(x), extent(y)
    half = 0.56 * max(wide / box, high) or 1.0
    axes.set_xlim(across - half * box, across + half * box)
    axes.set_ylim(up - half, up + half)
