"""The pictures of a comparison: one contact, paths, rotor velocities, energy flow, phase portraits."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import matplotlib
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.style import context

from contactlab.arrays import Array
from contactlab.comparison import curves
from contactlab.comparison.reruns import Refined
from contactlab.comparison.scorecard import ENERGY_TERMS
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

THIN: Final = {"linewidth": 0.6, "zorder": 0}
"""Of a line to go by."""

# Without dates and versions the same runs give the same bytes.
METADATA: Final[dict[str, dict[str, Any]]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None},
}


def draw_all(laws: Sequence[Refined], data: xarray.Dataset, folder: Path) -> list[Path]:
    """Write every figure that the runs have the numbers for, as PNG and PDF; gives the PNGs."""
    written = []
    with context(STYLE):
        figures = {
            "contact_force": draw_contact(laws),
            "tip_trajectory": draw_paths(laws),
            "rotor_velocity": draw_velocities(laws),
            "energy_flow": draw_energy(data),
            "phase_portrait": draw_phases(laws),
        }
        for name, figure in figures.items():
            if figure is None:
                continue
            for kind, metadata in METADATA.items():
                with whole_file(folder / f"{name}.{kind}") as partial:
                    figure.savefig(partial, format=kind, metadata=metadata)
            written.append(folder / f"{name}.png")
    return written


def _figure(rows: int, columns: int, height: float, **arguments: Any) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **arguments)


def _style(number: int) -> dict[str, Any]:
    """Give colour and line of a law."""
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    return {"color": colours[number % len(colours)], "linestyle": DASHES[number % len(DASHES)]}


def _holding(laws: Sequence[Refined], *names: str) -> list[tuple[int, Refined]]:
    """Give the laws that recorded some series, with their places."""
    return [(i, law) for i, law in enumerate(laws) if law.best.holds(*names)]


def _legend(figure: Figure, axes: Axes, **arguments: Any) -> Figure:
    """Put the legend above the panels, where it covers nothing."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        columns = 3 if max(map(len, labels)) < LONGEST_LABEL else 2
        labels = [fill(label, LONGEST_LABEL) for label in labels]
        # The panels keep their size, however many laws there are.
        lines = -(-len(labels) // columns) * max(label.count("\n") + 1 for label in labels)
        figure.set_figheight(figure.get_figheight() + LINE * (lines - 1))
        columns = min(len(labels), columns)
        figure.legend(handles, labels, loc="outside upper center", ncols=columns, **arguments)
    figure.align_ylabels()
    return figure


def _remark(axes: Axes, words: str, height: float, lift: float, colour: str = "black") -> None:
    """Write a few words at the right end of a line across the axes."""
    axes.annotate(
        words, (1.0, height), (-2.0, lift), ("axes fraction", "data"), "offset points",
        ha="right", fontsize=7, color=colour,
    )  # fmt: skip


def draw_contact(laws: Sequence[Refined]) -> Figure | None:
    """Draw the normal force over one contact, friction below."""
    found = curves.one_contact_each(laws)
    if not found:
        return None
    contacts = [contact for _, contact in found]
    top = curves.ceiling(contacts)
    figure, panels = _figure(2, 1, 4.0, sharex=True)
    above, below = panels[:, 0]
    unit, scale = prefixed_unit(max(contact.duration for contact in contacts), "s")
    for i, contact in found:
        time = contact.time / scale
        above.plot(time, contact.normal, label=laws[i].run.label, **_style(i))
        below.plot(time, contact.friction, **_style(i))
    spikes = [(i, laws[i].run.label, c.peak) for i, c in found if c.peak > top > 0.0]
    lines = _off_scale(above, spikes)
    if top > 0.0:
        above.set_ylim(-0.04 * top, top * (1.0 + 0.1 * lines))
    # A spike of the friction is cut too.
    friction = np.concatenate([contact.after_impact(contact.friction) for contact in contacts])
    room = 0.2 * float(np.ptp(friction))
    if room > 0.0:
        below.set_ylim(friction.min() - room, friction.max() + room)
    above.set_ylabel("normal force (N)")
    below.set_ylabel("friction force (N)")
    below.set_xlabel(f"time from touch-down ({unit})")
    below.axhline(0.0, color="0.7", **THIN)
    return _legend(figure, above)


def _off_scale(axes: Axes, spikes: Sequence[tuple[int, str, float]]) -> int:
    """Name the peaks that are not drawn out; gives the number of lines it takes."""
    said = [
        (f"{label}: peak {peak:.4g} N, off scale", _style(i)["color"]) for i, label, peak in spikes
    ]
    if len(spikes) > MOST_SPIKES:
        peaks = [peak for _, _, peak in spikes]
        span = f"{min(peaks):.4g} to {max(peaks):.4g} N"
        said = [(f"peaks of {len(peaks)} laws, {span}, off scale", "black")]
    for line, (words, colour) in enumerate(said):
        axes.annotate(
            words, (0.99, 0.97 - 0.085 * line), xycoords="axes fraction", ha="right", va="top",
            fontsize=7, color=colour,
        )  # fmt: skip
    return len(said)


def draw_paths(laws: Sequence[Refined]) -> Figure | None:
    """Draw the path of the tip in the last drive periods."""
    names = ("tip_tangential_displacement", "tip_normal_displacement")
    drawn = _holding(laws, *names)
    if not drawn:
        return None
    figure, panels = _figure(1, 1, 3.1)
    axes = panels[0, 0]
    for i, law in drawn:
        span = curves.last_periods(law)
        x, y = (drawable(law.best.columns[name][span]) * 1e6 for name in names)
        axes.plot(x, y, label=law.run.label, **_style(i))
    clearance = dict(drawn[0][1].run.configuration.get("contact") or {}).get("clearance")
    if clearance is not None:
        axes.axhline(1e6 * clearance, color="0.5", **THIN)
        _remark(axes, "rotor", 1e6 * clearance, 2.0, "0.35")
    axes.set_xlabel("tangential displacement of the tip (\u00b5m)")
    axes.set_ylabel("normal displacement (\u00b5m)")
    return _legend(figure, axes)


def draw_velocities(laws: Sequence[Refined]) -> Figure | None:
    """Draw the rotor velocity over the run; below it how far laws differ, against the error of each."""
    drawn = _holding(laws, "rotor_velocity")
    if not drawn:
        return None
    errors = {i: law.error(curves.velocity) for i, law in drawn}
    errors = {i: error for i, error in errors.items() if np.isfinite(error).all()}
    figure, panels = _figure(1 + bool(errors), 1, 2.5 + 1.6 * bool(errors), sharex=True)
    axes, last = panels[0, 0], panels[-1, 0]
    unit, scale = prefixed_unit(float(laws[0].best.time[-1]), "s")
    for i, law in drawn:
        time, values = law.best.time / scale, drawable(curves.velocity(law.best))
        axes.plot(*envelope(time, values), label=law.run.label, **_style(i))
        if i in errors:
            band = (values - errors[i], values + errors[i])
            axes.fill_between(time, *band, color=_style(i)["color"], alpha=0.3, linewidth=0.0)
            error = curves.smoothed(law, errors[i])
            last.plot(*_positive(time, error), **_style(i))
    if errors:
        _draw_range(last, [law for _, law in drawn], scale)
    last.set_xlabel(f"time ({unit})")
    axes.set_ylabel("rotor velocity (rad/s)")
    return _legend(figure, axes)


def _positive(time: Array, values: Array) -> Iterable[Array]:
    """Give a line on a logarithmic axis, where what is zero has no place."""
    return envelope(time, np.where(values > 0.0, values, np.nan))


def _draw_range(axes: Axes, laws: Sequence[Refined], scale: float) -> None:
    """Draw how far the laws are apart, on the axis of their errors."""
    time = laws[0].best.time
    values = [np.interp(time, law.best.time, curves.velocity(law.best)) for law in laws]
    apart = curves.smoothed(laws[0], np.ptp(values, axis=0))
    if len(laws) > 1 and np.any(apart > 0.0):
        axes.plot(*_positive(time / scale, apart), color="black", linewidth=1.4)
        _remark(axes, "range of the laws", apart[-1], -9.0)
    axes.set_yscale("log")
    axes.set_ylabel("numerical error (rad/s)")


def draw_energy(data: xarray.Dataset) -> Figure | None:
    """Draw where the work of the drive has gone, a bar a law; what is given back stands below zero."""
    energy = data["energy"].transpose("law", "term").values
    shown = np.isfinite(energy).all(axis=1)
    if not shown.any():
        return None
    energy, work = energy[shown], data["drive_work"].values[shown]
    labels = [fill(str(label), LONGEST_LABEL) for label in data["law"].values[shown]]
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
    axes.set_yticks(place, labels)
    axes.invert_yaxis()
    axes.set_xlabel(f"energy from the start to the end ({unit})")
    return _legend(figure, axes, markerscale=0.45)


def draw_phases(laws: Sequence[Refined]) -> Figure | None:
    """Draw gap rate and slip over the gap in the last drive periods."""
    drawn = _holding(laws, "gap", "slip_velocity")
    if not drawn:
        return None
    figure, panels = _figure(1, 2, 2.7)
    normal, tangential = panels[0]
    for i, law in drawn:
        run, span = law.best, curves.last_periods(law)
        gap, slip = (drawable(run.columns[name][span]) for name in ("gap", "slip_velocity"))
        # The mean rate of every record interval, over the gap in its middle.
        rate, middle = np.diff(gap) / np.diff(run.time[span]), 0.5 * (gap[1:] + gap[:-1])
        normal.plot(1e6 * middle, drawable(rate), label=law.run.label, **_style(i))
        tangential.plot(1e6 * gap, slip, **_style(i))
    for axes in (normal, tangential):
        axes.axvline(0.0, color="0.5", **THIN)
        axes.set_xlabel("gap (\u00b5m)")
    tangential.axhline(0.0, color="0.5", **THIN)
    normal.set_ylabel("gap rate (m/s)")
    tangential.set_ylabel("slip velocity (m/s)")
    return _legend(figure, normal)
