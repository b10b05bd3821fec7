"""The pictures of a comparison: one contact, paths, rotor velocities, energy flow, phase portraits."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import matplotlib
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.style import context

from contactlab.comparison import curves
from contactlab.comparison.arrays import holds, series
from contactlab.comparison.energy import ENERGY_TERMS
from contactlab.comparison.reruns import Refined
from contactlab.plot.overview_data import drawable, envelope
from contactlab.plot.style import STYLE
from contactlab.results.files import whole_file
from contactlab.results.summary import prefixed_unit

WIDTH: Final = 5.2
"""Inches; the words are still read where a phone makes it its own width."""

DASHES: Final = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
"""Lines of the laws in turn, so that a print without colours tells them apart."""


MOST_SPIKES: Final = 3
"""Peaks off the scale that are named one by one."""

LONGEST_LABEL: Final = 30
"""Letters in a line of a label."""


LINE: Final = 0.13
"""Height of a line of a legend [in]."""


def draw_all(laws: Sequence[Refined], data: xarray.Dataset) -> dict[str, Figure]:
    """Every figure that the runs have the numbers for, by its file name."""
    with context(STYLE):
        drawn = {
            "contact_force": draw_contact(laws),
            "tip_trajectory": draw_paths(laws),
            "rotor_velocity": draw_velocities(laws),
            "energy_flow": draw_energy(data),
            "phase_portrait": draw_phases(laws),
        }
    return {name: figure for name, figure in drawn.items() if figure is not None}


def write_all(figures: dict[str, Figure], folder: Path) -> None:
    """Write every figure as PNG and PDF."""
    # Without dates and versions the same runs give the same bytes.
    kinds: dict[str, dict[str, Any]] = {"png": {"Software": None}, "pdf": {"CreationDate": None}}
    with context(STYLE):
        for name, figure in figures.items():
            for kind, metadata in kinds.items():
                with whole_file(folder / f"{name}.{kind}") as partial:
                    figure.savefig(partial, format=kind, metadata=metadata)


def _figure(rows: int, columns: int, height: float, **arguments: Any) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **arguments)


def _style(number: int) -> dict[str, Any]:
    """Colour and line of a law."""
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    return {"color": colours[number % len(colours)], "linestyle": DASHES[number % len(DASHES)]}


def _legend(figure: Figure, axes: Axes, **arguments: Any) -> None:
    """Above the panels, where it covers nothing."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        columns = 3 if max(map(len, labels)) < LONGEST_LABEL else 2
        labels = [fill(label, LONGEST_LABEL) for label in labels]
        # The panels keep their size, however many laws there are.
        lines = -(-len(labels) // columns) * max(label.count("\n") + 1 for label in labels)
        figure.set_figheight(figure.get_figheight() + LINE * (lines - 1))
        figure.legend(
            handles,
            labels,
            loc="outside upper center",
            ncols=min(len(labels), columns),
            **arguments,
        )


def draw_contact(laws: Sequence[Refined]) -> Figure | None:
    """Normal force over one contact, friction below."""
    found = curves.one_contact_each(laws)
    if not found:
        return None
    contacts = [(i, laws[i], contact) for i, contact in found]
    top = curves.ceiling([contact for _, _, contact in contacts])
    figure, panels = _figure(2, 1, 4.0, sharex=True)
    above, below = panels[:, 0]
    unit, scale = prefixed_unit(max(c.duration for _, _, c in contacts), "s")
    spikes: list[tuple[int, str, float]] = []
    for i, law, contact in contacts:
        time = contact.time / scale
        above.plot(time, contact.normal, label=law.run.label, **_style(i))
        below.plot(time, contact.friction, **_style(i))
        if contact.peak > top > 0.0:
            spikes.append((i, law.run.label, contact.peak))
    lines = _off_scale(above, spikes)
    if top > 0.0:
        above.set_ylim(-0.04 * top, top * (1.0 + 0.1 * lines))
    _limit_friction(below, [contact for _, _, contact in contacts])
    above.set_ylabel("normal force (N)")
    below.set_ylabel("friction force (N)")
    below.set_xlabel(f"time from touch-down ({unit})")
    below.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    figure.align_ylabels()
    _legend(figure, above)
    return figure


def _off_scale(axes: Axes, spikes: list[tuple[int, str, float]]) -> int:
    """Name the peaks that are not drawn out; gives the number of lines it takes."""
    said = [(f"{label}: peak {peak:.4g} N, off scale", i) for i, label, peak in spikes]
    if len(spikes) > MOST_SPIKES:
        peaks = [peak for _, _, peak in spikes]
        said = [
            (f"peaks of {len(peaks)} laws, {min(peaks):.4g} to {max(peaks):.4g} N, off scale", -1)
        ]
    for line, (words, number) in enumerate(said):
        axes.annotate(
            words, (0.99, 0.97 - 0.085 * line), xycoords="axes fraction", ha="right", va="top",
            fontsize=7, color=_style(number)["color"] if number >= 0 else "black",
        )  # fmt: skip
    return len(said)


def _limit_friction(axes: Axes, contacts: list[curves.Contact]) -> None:
    """Room for the friction after the impact: a spike is cut, as that of the normal force."""
    bodies = [c.friction[c.time > curves.IMPACT * c.duration] for c in contacts]
    top = max(float(np.max(body, initial=0.0)) for body in bodies)
    bottom = min(float(np.min(body, initial=0.0)) for body in bodies)
    room = 0.2 * (top - bottom)
    if room > 0.0:
        axes.set_ylim(bottom - room, top + room)


def draw_paths(laws: Sequence[Refined]) -> Figure | None:
    """Path of the tip in the last drive periods."""
    names = ("tip_tangential_displacement", "tip_normal_displacement")
    drawn = [(i, law) for i, law in enumerate(laws) if holds(law.best, *names)]
    if not drawn:
        return None
    figure, panels = _figure(1, 1, 3.1)
    axes = panels[0, 0]
    for i, law in drawn:
        x, y = (drawable(curves.last_periods(law)[name].values) * 1e6 for name in names)
        axes.plot(x, y, label=law.run.label, **_style(i))
    clearance = dict(drawn[0][1].run.configuration.get("contact") or {}).get("clearance")
    if clearance is not None:
        axes.axhline(1e6 * clearance, color="0.5", linewidth=0.6, zorder=0)
        axes.annotate(
            "rotor", (1.0, 1e6 * clearance), (-2.0, 2.0), ("axes fraction", "data"), "offset points",
            ha="right", fontsize=7, color="0.35",
        )  # fmt: skip
    axes.set_xlabel("tangential displacement of the tip (\u00b5m)")
    axes.set_ylabel("normal displacement (\u00b5m)")
    _legend(figure, axes)
    return figure


def draw_velocities(laws: Sequence[Refined]) -> Figure | None:
    """Rotor velocity over the run; below it how far laws differ, against the error of each."""
    drawn = [(i, law) for i, law in enumerate(laws) if holds(law.best, "rotor_velocity")]
    if not drawn:
        return None
    errors = {i: law.error(curves.velocity) for i, law in drawn}
    known = any(np.isfinite(error).all() for error in errors.values())
    figure, panels = _figure(1 + known, 1, 2.5 + 1.6 * known, sharex=True)
    axes = panels[0, 0]
    unit, scale = prefixed_unit(float(series(laws[0].best, "time")[-1]), "s")
    for i, law in drawn:
        time, values = series(law.best, "time") / scale, drawable(curves.velocity(law.best))
        axes.plot(*envelope(time, values), label=law.run.label, **_style(i))
        if np.isfinite(errors[i]).all():
            axes.fill_between(
                time, values - errors[i], values + errors[i], color=_style(i)["color"], alpha=0.3,
                linewidth=0.0,
            )  # fmt: skip
            # What is zero has no place on a logarithmic axis.
            error = curves.smoothed(law, errors[i])
            error = np.where(error > 0.0, error, np.nan)
            panels[1, 0].plot(*envelope(time, error), **_style(i))
    if known:
        _draw_range(panels[1, 0], [law for _, law in drawn], scale)
    panels[-1, 0].set_xlabel(f"time ({unit})")
    axes.set_ylabel("rotor velocity (rad/s)")
    figure.align_ylabels()
    _legend(figure, axes)
    return figure


def _draw_range(axes: Axes, laws: list[Refined], scale: float) -> None:
    """How far the laws are apart, on the axis of their errors."""
    time = series(laws[0].best, "time")
    values = [np.interp(time, series(law.best, "time"), curves.velocity(law.best)) for law in laws]
    apart = curves.smoothed(laws[0], np.ptp(values, axis=0))
    if len(laws) > 1 and np.any(apart > 0.0):
        line = envelope(time / scale, np.where(apart > 0.0, apart, np.nan))
        axes.plot(*line, color="black", linewidth=1.4)
        axes.annotate(
            "range of the laws", (1.0, apart[-1]), (-2.0, -9.0), ("axes fraction", "data"),
            "offset points", ha="right", fontsize=7,
        )  # fmt: skip
    axes.set_yscale("log")
    axes.set_ylabel("numerical error (rad/s)")


def draw_energy(data: xarray.Dataset) -> Figure | None:
    """Where the work of the drive has gone, a bar a law; what is given back stands below zero."""
    energy = data["energy"].transpose("law", "term").values
    shown = np.isfinite(energy).all(axis=1)
    if not shown.any():
        return None
    energy, work = energy[shown], data["drive_work"].values[shown]
    labels = data["law"].values[shown]
    unit, scale = prefixed_unit(float(np.max(np.abs(work))), "J")
    figure, panels = _figure(1, 1, 1.2 + 0.42 * len(labels))
    axes = panels[0, 0]
    place = np.arange(len(labels))
    up, down = np.zeros(len(labels)), np.zeros(len(labels))
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    for number, (term, words) in enumerate(ENERGY_TERMS.items()):
        part = energy[:, number] / scale
        left = np.where(part >= 0.0, up, down + part)
        if np.any(np.abs(part) > 1e-3 * np.abs(work) / scale):
            axes.barh(
                place, np.abs(part), left=left, height=0.62, label=words, color=colours[number],
                edgecolor="white", linewidth=0.5, gid=term,
            )  # fmt: skip
        up += np.maximum(part, 0.0)
        down += np.minimum(part, 0.0)
    axes.plot(
        work / scale, place, linestyle="", marker="|", markersize=16.0, markeredgewidth=1.4,
        color="black", label="work of the drive",
    )  # fmt: skip
    axes.set_yticks(place, [fill(str(label), LONGEST_LABEL) for label in labels])
    axes.invert_yaxis()
    axes.set_xlabel(f"energy from the start to the end ({unit})")
    _legend(figure, axes, markerscale=0.45)
    return figure


def draw_phases(laws: Sequence[Refined]) -> Figure | None:
    """Gap rate and slip over the gap in the last drive periods."""
    names = ("gap", "slip_velocity")
    drawn = [(i, law) for i, law in enumerate(laws) if holds(law.best, *names)]
    if not drawn:
        return None
    figure, panels = _figure(1, 2, 2.7)
    normal, tangential = panels[0]
    for i, law in drawn:
        window = curves.last_periods(law)
        gap, rate = curves.gap_rate(window)
        slip = drawable(window["slip_velocity"].values)
        normal.plot(1e6 * drawable(gap), drawable(rate), label=law.run.label, **_style(i))
        tangential.plot(1e6 * drawable(window["gap"].values), slip, **_style(i))
    for axes in (normal, tangential):
        axes.axvline(0.0, color="0.5", linewidth=0.6, zorder=0)
        axes.set_xlabel("gap (\u00b5m)")
    tangential.axhline(0.0, color="0.5", linewidth=0.6, zorder=0)
    normal.set_ylabel("gap rate (m/s)")
    tangential.set_ylabel("slip velocity (m/s)")
    _legend(figure, normal)
    return figure
