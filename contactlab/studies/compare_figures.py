"""The pictures of a comparison: one contact, paths, rotor velocities, energy flow, phase portraits."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import numpy as np
import xarray
from matplotlib.figure import Figure
from matplotlib.style import context

from contactlab.comparison import curves
from contactlab.comparison.canvas import LONGEST_LABEL, NOTE, THIN, drawing, legend_above, style
from contactlab.comparison.cause_figures import draw_causes, draw_shares
from contactlab.comparison.reruns import Refined
from contactlab.comparison.scorecard import ENERGY_TERMS
from contactlab.metrics import NotApplicableError, needed
from contactlab.plot.recording import drawable, envelope
from contactlab.plot.style import STYLE
from contactlab.results.files import whole_file
from contactlab.results.summary import prefixed_unit

IMPACT: Final = 0.1  # share of a contact in which a rigid law's impact is over

# Without dates and versions the same runs give the same bytes.
METADATA: Final[Any] = {"png": {"Software": None}, "pdf": {"CreationDate": None}}


def draw_all(laws: Sequence[Refined], data: xarray.Dataset, folder: Path) -> list[Path]:
    """Write every figure that the runs have the numbers for, as PNG and PDF; gives the PNGs."""
    figures: dict[str, tuple[Callable[[Any], Figure], Any]] = {
        **(
            {"settled_quantities": (draw_causes, data), "variance_shares": (draw_shares, data)}
            if "cause" in data.dims
            else {"rotor_velocity": (draw_velocities, laws)}
        ),
        "contact_force": (draw_contact, laws),
        "tip_trajectory": (draw_paths, laws),
        "energy_flow": (draw_energy, data),
        "phase_portrait": (draw_phases, laws),
    }
    written = []
    for name, (draw, subject) in figures.items():
        with context(STYLE), suppress(NotApplicableError):
            figure = draw(subject)
            for kind, metadata in METADATA.items():
                with whole_file(folder / f"{name}.{kind}") as partial:
                    figure.savefig(partial, format=kind, metadata=metadata)
            written.append(folder / f"{name}.png")
    return written


def _holding(laws: Sequence[Refined], *names: str) -> list[tuple[int, Refined]]:
    """Give the laws that recorded some series, with their places; there is one at least."""
    holding = [(i, law) for i, law in enumerate(laws) if law.best.holds(*names)]
    needed(holding)
    return holding


def draw_contact(laws: Sequence[Refined]) -> Figure:
    """Draw the normal force over one contact, friction below."""
    found = curves.one_contact_each(laws)
    needed(found)
    # An impact of a rigid law is a spike as high as the record interval is short, beside which all other
    # forces would be a line at zero: the axes hold what each law exerts after it.
    after = [c.forces[:, c.time > IMPACT * c.duration] for c in found.values()]
    normal, friction = np.concatenate([np.zeros((2, 1)), *after], axis=1)
    top, room = 1.5 * float(normal.max()), 0.2 * float(np.ptp(friction))
    figure, (above, below) = drawing(2, 1, 4.0, sharex=True)
    unit, scale = prefixed_unit(max(contact.duration for contact in found.values()), "s")
    for i, contact in found.items():
        spike = f", peak {contact.peak:.4g}\u00a0N off scale" if contact.peak > top > 0.0 else ""
        label = laws[i].run.label + spike
        above.plot(contact.time / scale, contact.forces[0], label=label, **style(i))
        below.plot(contact.time / scale, contact.forces[1], **style(i))
    if top > 0.0:
        above.set_ylim(-0.04 * top, top)
    if room > 0.0:
        below.set_ylim(friction.min() - room, friction.max() + room)
    above.set_ylabel("normal force (N)")
    below.set(xlabel=f"time from touch-down ({unit})", ylabel="friction force (N)")
    below.axhline(0.0, **THIN)
    return legend_above(figure, above)


def draw_paths(laws: Sequence[Refined]) -> Figure:
    """Draw the path of the tip in the last drive periods."""
    names = ("tip_tangential_displacement", "tip_normal_displacement")
    drawn = _holding(laws, *names)
    figure, (axes,) = drawing(1, 1, 3.1)
    for i, law in drawn:
        span = curves.last_periods(law)
        x, y = (drawable(law.best.columns[name][span]) * 1e6 for name in names)
        axes.plot(x, y, label=law.run.label, **style(i))
    with suppress(NotApplicableError):
        clearance = 1e6 * drawn[0][1].run.setting("contact.clearance")
        axes.axhline(clearance, **THIN)
        axes.text(1.0, clearance, "rotor", transform=axes.get_yaxis_transform(), va="bottom", **NOTE)
    axes.set_xlabel("tangential displacement of the tip (\u00b5m)")
    axes.set_ylabel("normal displacement (\u00b5m)")
    return legend_above(figure, axes)


def draw_velocities(laws: Sequence[Refined]) -> Figure:
    """Draw the rotor velocity over the run; below it how far laws differ, against the error of each."""
    name = "rotor_velocity"
    drawn = _holding(laws, name)
    series = {i: [run.columns[name] for _, run in law.steps] for i, law in drawn if law.steps}
    errors = {i: laws[i].error(values) for i, values in series.items()}
    smooth = {i: curves.smoothed(laws[i], e) for i, e in errors.items() if np.isfinite(e).all()}
    # A rotor at rest has no error that a logarithmic axis could show.
    judged = any(np.isfinite(error).any() for error in smooth.values())
    figure, panels = drawing(1 + judged, 1, 2.5 + 1.6 * judged, sharex=True)
    axes, last = panels[0], panels[-1]
    unit, scale = prefixed_unit(float(laws[0].best.time[-1]), "s")
    for i, law in drawn:
        time, values = law.best.time / scale, drawable(law.best.columns[name])
        axes.plot(*envelope(time, values), label=law.run.label, **style(i))
        if judged and i in smooth:
            band = {"color": style(i)["color"], "alpha": 0.3, "linewidth": 0.0}
            axes.fill_between(time, values - errors[i], values + errors[i], **band)
            last.plot(*envelope(time, smooth[i]), **style(i))
    if judged:
        first = drawn[0][1]
        time = first.best.time
        each = [np.interp(time, law.best.time, law.best.columns[name]) for _, law in drawn]
        apart = curves.smoothed(first, np.ptp(each, axis=0))
        if np.isfinite(apart).any():
            last.plot(*envelope(time / scale, apart), color="black", linewidth=1.4)
            end, place = (1.0, apart[-1]), last.get_yaxis_transform()
            last.annotate("range of the laws", end, (-4, -6), place, "offset points", va="top", **NOTE)
        last.set(yscale="log", ylabel="numerical error (rad/s)")
    last.set_xlabel(f"time ({unit})")
    axes.set_ylabel("rotor velocity (rad/s)")
    return legend_above(figure, axes)


def draw_energy(data: xarray.Dataset) -> Figure:
    """Draw where the work of the drive has gone, a bar a law; what is given back stands below zero."""
    data = data.dropna("law", subset=["energy"])
    needed(data.sizes["law"])
    work = data["drive_work"].values
    unit, scale = prefixed_unit(float(np.max(np.abs(work))), "J")
    labels = [fill(str(label), LONGEST_LABEL) for label in data["law"].values]
    figure, (axes,) = drawing(1, 1, 1.2 + 0.42 * len(labels))
    place = np.arange(len(labels))
    energy = data["energy"].transpose("term", "law").values / scale
    gained, given_back = (part.cumsum(axis=0) for part in (energy.clip(min=0), energy.clip(max=0)))
    starts = np.where(energy >= 0.0, gained, given_back) - energy
    bar = {"height": 0.62, "edgecolor": "white", "linewidth": 0.5}
    for number, words in enumerate(ENERGY_TERMS.values()):
        part, colour = energy[number], style(number)["color"]
        if np.any(np.abs(part) > 1e-3 * np.abs(work) / scale):
            axes.barh(place, part, left=starts[number], label=words, color=colour, **bar)
    mark = {"marker": "|", "markersize": 16.0, "markeredgewidth": 1.4, "color": "black"}
    axes.plot(work / scale, place, linestyle="", label="work of the drive", **mark)
    axes.set_yticks(place, labels)
    axes.invert_yaxis()
    span = "in one drive period" if "cause" in data.dims else "from the start to the end"
    axes.set_xlabel(f"energy {span} ({unit})")
    return legend_above(figure, axes, markerscale=0.45)


def draw_phases(laws: Sequence[Refined]) -> Figure:
    """Draw gap rate and slip over the gap in the last drive periods."""
    drawn = _holding(laws, "gap", "slip_velocity")
    figure, (normal, tangential) = drawing(1, 2, 2.7)
    for i, law in drawn:
        run, span = law.best, curves.last_periods(law)
        gap, slip = (drawable(run.columns[name][span]) for name in ("gap", "slip_velocity"))
        # The mean rate of every record interval, over the gap in its middle.
        rate, middle = np.diff(gap) / np.diff(run.time[span]), 0.5 * (gap[1:] + gap[:-1])
        normal.plot(1e6 * middle, drawable(rate), label=law.run.label, **style(i))
        tangential.plot(1e6 * gap, slip, **style(i))
    for axes, words in ((normal, "gap rate (m/s)"), (tangential, "slip velocity (m/s)")):
        axes.axvline(0.0, **THIN)
        axes.set(xlabel="gap (\u00b5m)", ylabel=words)
    tangential.axhline(0.0, **THIN)
    return legend_above(figure, normal)
