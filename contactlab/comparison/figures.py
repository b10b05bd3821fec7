"""The pictures of a comparison: one contact, paths, rotor velocities, energy flow, phase portraits."""

from collections.abc import Sequence
from contextlib import suppress
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
from contactlab.comparison.reruns import Refined
from contactlab.comparison.scorecard import ENERGY_TERMS
from contactlab.metrics import NotApplicableError
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

IMPACT: Final = 0.1
"""Share of a contact in which a rigid law's impact is over."""

THIN: Final = {"linewidth": 0.6, "zorder": 0}
"""Of a line to go by."""

# Without dates and versions the same runs give the same bytes.
METADATA: Final[dict[str, dict[str, Any]]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None},
}


def draw_all(laws: Sequence[Refined], data: xarray.Dataset, folder: Path) -> list[Path]:
    """Write every figure that the runs have the numbers for, as PNG and PDF; gives the PNGs."""
    with context(STYLE):
        figures = {
            "contact_force": draw_contact(laws),
            "tip_trajectory": draw_paths(laws),
            "rotor_velocity": draw_velocities(laws),
            "energy_flow": draw_energy(data),
            "phase_portrait": draw_phases(laws),
        }
        drawn = {name: figure for name, figure in figures.items() if figure is not None}
        for name, figure in drawn.items():
            for kind, metadata in METADATA.items():
                with whole_file(folder / f"{name}.{kind}") as partial:
                    figure.savefig(partial, format=kind, metadata=metadata)
    return [folder / f"{name}.png" for name in drawn]


def _figure(rows: int, columns: int, height: float, **arguments: Any) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **arguments).ravel()


def _colour(number: int) -> Any:
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    return colours[number % len(colours)]


def _style(number: int) -> dict[str, Any]:
    """Give colour and line of a law."""
    return {"color": _colour(number), "linestyle": DASHES[number % len(DASHES)]}


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
    contacts = list(found.values())
    # An impact of a rigid law is a spike as high as the record interval is short, beside which all other
    # forces would be a line at zero: the axes hold what each law exerts after it.
    after = [contact.forces[:, contact.time > IMPACT * contact.duration] for contact in contacts]
    normal, friction = np.concatenate([np.zeros((2, 1)), *after], axis=1)
    top = 1.5 * float(normal.max())
    figure, (above, below) = _figure(2, 1, 4.0, sharex=True)
    unit, scale = prefixed_unit(max(contact.duration for contact in contacts), "s")
    spikes = []
    for i, contact in found.items():
        time, label = contact.time / scale, laws[i].run.label
        above.plot(time, contact.forces[0], label=label, **_style(i))
        below.plot(time, contact.forces[1], **_style(i))
        if contact.peak > top > 0.0:
            spikes.append((f"{label}: peak {contact.peak:.4g} N, off scale", _colour(i)))
    if len(spikes) > MOST_SPIKES:
        peaks = [contact.peak for contact in contacts if contact.peak > top]
        span = f"{min(peaks):.4g} to {max(peaks):.4g} N"
        spikes = [(f"peaks of {len(peaks)} laws, {span}, off scale", "black")]
    for line, (words, colour) in enumerate(spikes):
        above.annotate(
            words, (0.99, 0.97 - 0.085 * line), xycoords="axes fraction", ha="right", va="top",
            fontsize=7, color=colour,
        )  # fmt: skip
    if top > 0.0:
        above.set_ylim(-0.04 * top, top * (1.0 + 0.1 * len(spikes)))
    room = 0.2 * float(np.ptp(friction))
    if room > 0.0:
        below.set_ylim(friction.min() - room, friction.max() + room)
    above.set_ylabel("normal force (N)")
    below.set(xlabel=f"time from touch-down ({unit})", ylabel="friction force (N)")
    below.axhline(0.0, color="0.7", **THIN)
    return _legend(figure, above)


def draw_paths(laws: Sequence[Refined]) -> Figure | None:
    """Draw the path of the tip in the last drive periods."""
    names = ("tip_tangential_displacement", "tip_normal_displacement")
    drawn = _holding(laws, *names)
    if not drawn:
        return None
    figure, (axes,) = _figure(1, 1, 3.1)
    for i, law in drawn:
        span = curves.last_periods(law)
        x, y = (drawable(law.best.columns[name][span]) * 1e6 for name in names)
        axes.plot(x, y, label=law.run.label, **_style(i))
    with suppress(NotApplicableError):
        clearance = 1e6 * drawn[0][1].run.setting("contact", "clearance")
        axes.axhline(clearance, color="0.5", **THIN)
        _remark(axes, "rotor", clearance, 2.0, "0.35")
    axes.set_xlabel("tangential displacement of the tip (\u00b5m)")
    axes.set_ylabel("normal displacement (\u00b5m)")
    return _legend(figure, axes)


def draw_velocities(laws: Sequence[Refined]) -> Figure | None:
    """Draw the rotor velocity over the run; below it how far laws differ, against the error of each."""
    name = "rotor_velocity"
    drawn = _holding(laws, name)
    if not drawn:
        return None
    series = {i: [run.columns[name] for _, run in law.steps] for i, law in drawn if law.steps}
    errors = {i: laws[i].error(values) for i, values in series.items()}
    smooth = {i: curves.smoothed(laws[i], e) for i, e in errors.items() if np.isfinite(e).all()}
    # A rotor at rest has no error that a logarithmic axis could show.
    judged = any(np.isfinite(error).any() for error in smooth.values())
    figure, panels = _figure(1 + judged, 1, 2.5 + 1.6 * judged, sharex=True)
    axes, last = panels[0], panels[-1]
    unit, scale = prefixed_unit(float(laws[0].best.time[-1]), "s")
    for i, law in drawn:
        time, values = law.best.time / scale, drawable(law.best.columns[name])
        axes.plot(*envelope(time, values), label=law.run.label, **_style(i))
        if judged and i in smooth:
            band = (values - errors[i], values + errors[i])
            axes.fill_between(time, *band, color=_colour(i), alpha=0.3, linewidth=0.0)
            last.plot(*envelope(time, smooth[i]), **_style(i))
    if judged:
        first = drawn[0][1]
        time = first.best.time
        each = [np.interp(time, law.best.time, law.best.columns[name]) for _, law in drawn]
        apart = curves.smoothed(first, np.ptp(each, axis=0))
        if np.isfinite(apart).any():
            last.plot(*envelope(time / scale, apart), color="black", linewidth=1.4)
            _remark(last, "range of the laws", apart[-1], -9.0)
        last.set(yscale="log", ylabel="numerical error (rad/s)")
    last.set_xlabel(f"time ({unit})")
    axes.set_ylabel("rotor velocity (rad/s)")
    return _legend(figure, axes)


def draw_energy(data: xarray.Dataset) -> Figure | None:
    """Draw where the work of the drive has gone, a bar a law; what is given back stands below zero."""
    data = data.dropna("law", subset=["energy"])
    if not data.sizes["law"]:
        return None
    work = data["drive_work"].values
    unit, scale = prefixed_unit(float(np.max(np.abs(work))), "J")
    labels = [fill(str(label), LONGEST_LABEL) for label in data["law"].values]
    figure, (axes,) = _figure(1, 1, 1.2 + 0.42 * len(labels))
    place = np.arange(len(labels))
    energy = data["energy"].transpose("term", "law").values / scale
    gained, given_back = (part.cumsum(axis=0) for part in (energy.clip(min=0), energy.clip(max=0)))
    ends = np.where(energy >= 0.0, gained, given_back)
    for number, ((term, words), part, end) in enumerate(
        zip(ENERGY_TERMS.items(), energy, ends, strict=True)
    ):
        if np.any(np.abs(part) > 1e-3 * np.abs(work) / scale):
            axes.barh(
                place, part, left=end - part, height=0.62, label=words, color=_colour(number),
                edgecolor="white", linewidth=0.5, gid=term,
            )  # fmt: skip
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
    figure, (normal, tangential) = _figure(1, 2, 2.7)
    for i, law in drawn:
        run, span = law.best, curves.last_periods(law)
        gap, slip = (drawable(run.columns[name][span]) for name in ("gap", "slip_velocity"))
        # The mean rate of every record interval, over the gap in its middle.
        rate, middle = np.diff(gap) / np.diff(run.time[span]), 0.5 * (gap[1:] + gap[:-1])
        normal.plot(1e6 * middle, drawable(rate), label=law.run.label, **_style(i))
        tangential.plot(1e6 * gap, slip, **_style(i))
    for axes, words in ((normal, "gap rate (m/s)"), (tangential, "slip velocity (m/s)")):
        axes.axvline(0.0, color="0.5", **THIN)
        axes.set(xlabel="gap (\u00b5m)", ylabel=words)
    tangential.axhline(0.0, color="0.5", **THIN)
    return _legend(figure, normal)
