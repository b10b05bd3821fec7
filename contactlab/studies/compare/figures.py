"""Figures of a comparison: laws over draws and operating points, pairs, contact, paths, energy, phases."""

import re
from collections.abc import Callable
from contextlib import suppress
from itertools import permutations
from textwrap import fill
from typing import Any, Final, NamedTuple

import matplotlib
import numpy as np
import xarray
from matplotlib.figure import Figure

from contactlab.arrays import Array
from contactlab.metrics import NotApplicableError, needed
from contactlab.plot.recording import drawable, envelope, handy_unit
from contactlab.plot.style import HATCHES, line_style
from contactlab.results.summary import prefixed_unit
from contactlab.studies.compare.paired import ALONE, binomial_interval, bins_of
from contactlab.studies.compare.scorecard import CONTACTS, ENERGY_TERMS
from contactlab.studies.figures import LONGEST_LABEL, NOTE, THIN, WIDTH, drawing, legend_above

CAPTIONS: Final = {
    "differences": "Difference of two laws over the larger of both, as configured (diamond) and in the "
    "motors drawn: a point a motor, a bar from 5 to 95 %. In the grey band they are practically equal. Speed "
    "and torque count in the sense in which the motor turns.",
    "turning": "Where the order in speed turns: share of the motors with each outcome, with 95 % intervals, "
    "over the factor that turns it, of the pair that a factor turns most.",
    "contact_force": "Normal force and friction of one contact, means over the record intervals. Peaks of "
    "rigid impacts, which grow without bound as the step falls, are off scale.",
    "pairs": "Difference in speed of row and column over the larger, without its sign: median over draws, "
    "the largest of the operating points. The outcome of most motors: > the row is greater, < less, = equal "
    "within the margin, 0 without a steady state; ~ it varies; ? inconclusive. Several signs are those of "
    "several operating points. Grey: no difference is known.",
    "operating_points": "Settled velocity as configured over the operating points; below, the paired "
    "difference from the first law, median and 5 to 95 % of the draws.",
    "rotor_velocity": "Rotor velocity.",
    "tip_trajectory": "Path of the tip in the last two drive periods.",
    "energy_flow": "Destination of the work of the drive.",
    "phase_portrait": "Mean gap rate and slip velocity over the gap in the last two drive periods.",
}
"""Captions of the figures, in their order."""

MOST_ROWS: Final = 12
"""Laws in a table of pairs whose columns have names; those of more have numbers."""

SIGNS: Final = "><=0~?"
"""Orders of two laws, in the order of `contactlab.studies.compare.paired.VERDICTS`."""

PERIODS: Final = 2.0
"""Drive periods at the end of a motion that paths and phase portraits show."""

MARGIN: Final = 0.1
"""Time before touch-down and after release that is shown, in durations of the contact."""

SCARCE: Final = 5
"""Number of records of a contact below which it is not shown."""

APART: Final = 0.1
"""Flight that separates two contacts [drive periods]: impacts in a row are one contact."""

IMPACT: Final = 0.1
"""Share of a contact after which the impact of a rigid law is over."""


def draw_all(data: xarray.DataTree) -> dict[str, Figure]:
    """Return every figure for which there are numbers."""
    card = data.to_dataset()
    motions = [child.to_dataset(inherit=False) for child in data.children.values()]
    every: dict[str, tuple[Callable[[Any], Figure], Any]] = {
        "differences": (draw_differences, card),
        "turning": (draw_turning, card),
        "contact_force": (draw_contact, motions),
        "pairs": (draw_pairs, card),
        "operating_points": (draw_operating_points, card),
        "rotor_velocity": (draw_velocities, [] if "limits" in card.attrs else motions),
        "tip_trajectory": (draw_paths, motions),
        "energy_flow": (draw_energy, card),
        "phase_portrait": (draw_phases, motions),
    }
    figures = {}
    for name, (draw, subject) in every.items():
        with suppress(NotApplicableError):
            figures[name] = draw(subject)
            # The caption of the page.
            figures[name].set_label(CAPTIONS[name])
    return figures


def draw_differences(data: xarray.Dataset) -> Figure:
    """Draw relative differences over the draws: every quantity of two laws, the speed of several."""
    needed("order" in data and data.sizes["law"] > 1 and data.sizes["draw"])
    here = data.isel(cell=0)
    if data.sizes["law"] == 2:
        pairs = here.isel(law=0, other_law=1)
        labels = [str(name).replace("_", " ") for name in data["quantity"].values]
        about = f"{pairs['law'].item()} less {pairs['other_law'].item()}"
    else:
        pairs = here.sel(quantity="rotor_velocity").isel(law=0, other_law=slice(1, None))
        labels = [fill(str(law), LONGEST_LABEL) for law in pairs["other_law"].values]
        about = f"speed of {pairs['law'].item()} less that of"
    figure, axes, place = _bars(labels, 1.0 + 0.34 * len(labels))
    margin = 100.0 * data.attrs["margin"]
    axes.axvspan(-margin, margin, color="0.9", zorder=0, label="practically equal")
    axes.axvline(0.0, **THIN)
    values, colour = 100.0 * pairs["relative_drawn"].values, line_style(0)["color"]
    # Points of a row lie apart, in the order of the draws.
    apart = np.linspace(-0.3, 0.3, values.shape[-1])
    for row, here_drawn in zip(place, values, strict=True):
        point = {"marker": ".", "markersize": 2.5, "alpha": 0.6, "color": colour, "linestyle": ""}
        axes.plot(here_drawn, row + apart, label="" if row else "motors drawn", **point)
    low, high = (100.0 * pairs[f"relative_difference_{end}"].values for end in ("low", "high"))
    axes.hlines(place, low, high, color=colour, linewidth=4.0, alpha=0.35, label="5 to 95 % of these")
    configured = {"marker": "D", "markersize": 3.5, "color": "black", "linestyle": ""}
    axes.plot(100.0 * pairs["relative_nominal"].values, place, label="as configured", **configured)
    axes.set_xlabel(fill(f"{about}, over the larger (%)", 60))
    return legend_above(figure, axes)


def draw_turning(data: xarray.Dataset) -> Figure:
    """Draw the probabilities of the outcomes in speed over the factor that turns them."""
    needed("order" in data and data.sizes["law"] > 1 and data.sizes["draw"])
    here = data.sel(quantity="rotor_velocity")
    shares = here["factor_share"].where(here["factor_role"] == ALONE)
    needed(bool(shares.notnull().any()))
    # Of several pairs and points, the one whose outcome a factor determines most.
    largest = {name: int(place) for name, place in shares.argmax(...).items()}
    here = here.isel(largest)
    values, bins = here["drawn"].values, bins_of(here["drawn"].values)
    figure, (axes,) = drawing(1, 1, 2.6)
    middle = [float(np.median(values[bins == n])) for n in range(bins.max() + 1)]
    count = np.bincount(bins)
    for kind, word in enumerate(map(str, data["outcome_kind"].values)):
        times = np.bincount(bins, here["outcome"].values == kind)
        if times.any():
            ends = np.abs(np.array(binomial_interval(times, count)) - times / count)
            look = {"marker": "o", "markersize": 3.5, "capsize": 2.5, **line_style(kind)}
            axes.errorbar(middle, times / count, ends, label=word, **look)
    axes.set(ylim=(-0.03, 1.03), ylabel="share of motors", xlabel=str(here["prior"].item()))
    if here["logarithmic"]:
        axes.set_xscale("log")
    at = f" at {here['cell'].item()}" if data.sizes["cell"] > 1 else ""
    title = f"speed of {here['law'].item()} against {here['other_law'].item()}{at}"
    axes.set_title(fill(title, 70), fontsize=8)
    return legend_above(figure, axes)


def draw_pairs(data: xarray.Dataset) -> Figure:
    """Draw the size of the relative difference in speed of every pair of laws, and its order."""
    needed("order" in data and data.sizes["law"] > 2)
    here, count = data.sel(quantity="rotor_velocity"), data.sizes["law"]
    every, order = here["relative_size"].values, here["order"].values
    size = np.where(np.isnan(every).all(axis=-1), np.nan, np.nan_to_num(every).max(axis=-1))
    np.fill_diagonal(size, 0.0)
    many = count > MOST_ROWS
    figure, (axes,) = drawing(1, 1, 0.7 * WIDTH if many else 1.6 + 0.31 * count)
    # What is far below the margin has no colour.
    largest = max(float(np.nanmax(size)), data.attrs["margin"])
    blues = matplotlib.colormaps["Blues"].with_extremes(bad="0.85")
    image = axes.imshow(100.0 * size, cmap=blues, vmin=0.0, vmax=100.0 * largest)
    for a, b in permutations(range(count), 2):
        signs = "".join(dict.fromkeys(SIGNS[int(kind)] for kind in order[a, b]))
        dark = size[a, b] > 0.6 * largest
        text = {"ha": "center", "va": "center", "color": "white" if dark else "black"}
        axes.text(b, a, signs, fontsize=4 if many else 7, **text)
    if many:
        numbered = [f"{law}  {number}" for number, law in enumerate(data["law"].values, 1)]
        axes.set_yticks(np.arange(count), numbered, fontsize=4)
        axes.set_xticks(np.arange(count), np.arange(1, count + 1), fontsize=4)
    else:
        labels = [fill(str(label), LONGEST_LABEL // 2 + 6) for label in data["law"].values]
        axes.set_yticks(np.arange(count), labels)
        axes.set_xticks(np.arange(count), labels, rotation=60, ha="right", rotation_mode="anchor")
    figure.colorbar(image, label="difference over the larger (%)", shrink=0.8)
    return figure


def draw_operating_points(data: xarray.Dataset) -> Figure:
    """Draw settled velocities over the operating points, and how they differ from the first law's."""
    needed("order" in data and data.sizes["cell"] > 1)
    here, cells = data.sel(quantity="rotor_velocity"), list(map(str, data["cell"].values))
    figure, (above, below) = drawing(2, 1, 4.4, sharex=True)
    numbers = [float(x) for x in re.findall(r"^[\w.]+=([-+.\de]+)$", "\n".join(cells), re.MULTILINE)]
    single = len(numbers) == len(cells)
    order = np.argsort(numbers) if single else np.arange(len(cells))
    place = np.array(numbers)[order] if single else order
    for number, law in enumerate(map(str, data["law"].values)):
        each = here.isel(law=number, cell=order)
        steps = each["nominal"].values
        # The finest step that has a value.
        middle = np.where(np.isfinite(steps[:, -1]), steps[:, -1], steps[:, 0])
        above.plot(place, middle, label=law, **{"marker": ".", **line_style(number), "markevery": None})
        if number:
            pair = here.isel(law=number, other_law=0, cell=order)
            below.plot(place, pair["difference"], **{"marker": ".", **line_style(number), "markevery": None})
            band = {"color": line_style(number)["color"], "alpha": 0.2, "linewidth": 0.0}
            below.fill_between(place, pair["difference_low"], pair["difference_high"], **band)
    for axes in (above, below):
        axes.axhline(0.0, **THIN)
    above.set_ylabel("settled velocity (rad/s)")
    below.set_ylabel(f"less {data['law'].values[0]} (rad/s)")
    below.set_xlabel(cells[0].partition("=")[0] if single else "")
    if not single:
        below.set_xticks(place, [fill(cell, 24) for cell in cells], rotation=60, ha="right", fontsize=6)
    return legend_above(figure, above)


def _bars(labels: Any, height: float) -> tuple[Figure, Any, Any]:
    """Return a figure for horizontal bars, one for each label from the top down, and their places."""
    figure, (axes,) = drawing(1, 1, height)
    place = np.arange(len(labels))
    axes.set_yticks(place, labels)
    # A row may have a note in place of bars, which does not count for automatic limits.
    axes.set_ylim(place.size - 0.5, -0.5)
    return figure, axes, place


Motions = list[xarray.Dataset]
"""The motions of the laws; the number of a law determines its style."""


def _with(motions: Motions, *names: str) -> list[tuple[int, xarray.Dataset]]:
    """Return the motions that have some series, with their numbers; there is at least one."""
    having = [(i, motion) for i, motion in enumerate(motions) if {*names} <= motion.data_vars.keys()]
    needed(having)
    return having


def last_periods(motion: xarray.Dataset) -> slice:
    """Return the records of the last drive periods."""
    time = motion["time"].values
    first = int(np.searchsorted(time, time[-1] - PERIODS * motion.attrs["period"]))
    return slice(max(first - 1, 0), None)


class Contact(NamedTuple):
    """One contact: middles of its records from touch-down [s], their mean normal and friction force [N]."""

    time: Array
    forces: Array
    start: float
    duration: float
    peak: float


def contacts_of(motions: Motions) -> dict[int, Contact]:
    """Return the same contact of every law that recorded it, by number of the law.

    Impacts in a row, as of a rigid law with restitution, are one contact.
    """
    names = {*CONTACTS, "normal_force", "friction_force"}
    touching = {i: motion for i, motion in enumerate(motions) if names <= motion.data_vars.keys()}
    near = next((t for t in map(_last_whole_contact, touching.values()) if t is not None), None)
    if near is None:
        return {}
    rows = {i: _impacts_in_a_row(motion, near) for i, motion in touching.items()}
    length = max(duration for _, duration, _ in rows.values())
    contacts = {i: _recorded(touching[i], length, *row) for i, row in rows.items()}
    return {i: contact for i, contact in contacts.items() if contact.time.size >= SCARCE}


def _last_whole_contact(motion: xarray.Dataset) -> float | None:
    """Return the touch-down of the strongest of the last contacts that the end does not truncate [s]."""
    end, period = float(motion["time"].values[-1]), motion.attrs["period"]
    starts = motion["start_time"].values
    ends = starts + motion["duration"].values
    # The contact of the other laws, which touch at other times, must be whole as well.
    whole = np.flatnonzero((ends < end - 0.5 * period) & (starts > end - (PERIODS + 1.0) * period))
    whole = whole if whole.size else np.flatnonzero(ends < end)
    return float(starts[max(whole, key=motion["normal_impulse"].values.item)]) if whole.size else None


def _impacts_in_a_row(motion: xarray.Dataset, near: float) -> tuple[float, float, float]:
    """Return start [s], duration [s] and peak force [N] of the contact that begins nearest to a time [s]."""
    starts = motion["start_time"].values
    ends = starts + motion["duration"].values
    contact = np.append(0, np.cumsum(starts[1:] - ends[:-1] >= APART * motion.attrs["period"]))
    chosen = np.flatnonzero(contact == contact[np.argmin(np.abs(starts - near))])
    start, end = float(starts[chosen[0]]), float(ends[chosen[-1]])
    return start, end - start, float(motion["peak_normal_force"].values[chosen].max())


def _recorded(motion: xarray.Dataset, length: float, start: float, duration: float, peak: float) -> Contact:
    """Return the records of a contact, over a length of time [s]."""
    time = motion["time"].values
    earlier = np.append(time[:1], time[:-1])
    # In the interval of the touch-down the force acts after it only.
    middle = 0.5 * (np.where(time > start, np.maximum(earlier, start), earlier) + time)
    # The force jumps at touch-down: a line from the record before would be in the open gap.
    place = int(np.searchsorted(middle, start))
    since = np.insert(middle, place, start) - start
    shown = (since >= -MARGIN * length) & (since <= (1.0 + MARGIN) * length)
    both = [motion["normal_force"].values, motion["friction_force"].values]
    return Contact(since[shown], np.insert(both, place, 0.0, axis=1)[:, shown], start, duration, peak)


def draw_contact(motions: Motions) -> Figure:
    """Draw the normal force over one contact, friction below."""
    contacts = contacts_of(motions)
    needed(contacts)
    # The impact of a rigid law is a spike as high as the record interval is short: the axes show all forces
    # after it.
    lasting = [c for c in contacts.values() if c.duration > 0.0]
    after = [c.forces[:, c.time > IMPACT * c.duration] for c in lasting]
    normal, friction = np.concatenate([np.zeros((2, 1)), *after], axis=1)
    top, room = 1.5 * float(normal.max()), 0.2 * float(np.ptp(friction))
    figure, (above, below) = drawing(2, 1, 4.0, sharex=True)
    unit, scale = prefixed_unit(max(contact.duration for contact in contacts.values()), "s")
    for i, contact in contacts.items():
        off = contact.peak > top > 0.0
        peak = f"peak {contact.peak:.4g}\u00a0N" if np.isfinite(contact.peak) else "impact"
        label = motions[i].attrs["law"] + (f", {peak} off scale" if off else "")
        above.plot(contact.time / scale, contact.forces[0], label=label, **line_style(i))
        below.plot(contact.time / scale, contact.forces[1], **line_style(i))
    if top > 0.0:
        above.set_ylim(-0.04 * top, top)
    if room > 0.0:
        below.set_ylim(friction.min() - room, friction.max() + room)
    above.set_ylabel("normal force (N)")
    below.set(xlabel=f"time from touch-down ({unit})", ylabel="friction force (N)")
    below.axhline(0.0, **THIN)
    return legend_above(figure, above)


def draw_paths(motions: Motions) -> Figure:
    """Draw the path of the tip in the last drive periods."""
    names = ("tip_tangential_displacement", "tip_normal_displacement")
    having = _with(motions, *names)
    figure, (axes,) = drawing(1, 1, 3.1)
    unit, scale = handy_unit((motion[name].values for _, motion in having for name in names), "m")
    for i, motion in having:
        x, y = (drawable(motion[name].values[last_periods(motion)]) / scale for name in names)
        axes.plot(x, y, label=motion.attrs["law"], **line_style(i))
    if "clearance" in having[0][1].attrs:
        clearance = having[0][1].attrs["clearance"] / scale
        axes.axhline(clearance, **THIN)
        axes.text(1.0, clearance, "rotor", transform=axes.get_yaxis_transform(), va="bottom", **NOTE)
    axes.set_xlabel(f"tangential displacement of the tip ({unit})")
    axes.set_ylabel(f"normal displacement ({unit})")
    return legend_above(figure, axes)


def draw_velocities(motions: Motions) -> Figure:
    """Draw the rotor velocity over the run."""
    having = _with(motions, "rotor_velocity")
    unit, scale = prefixed_unit(float(having[0][1]["time"].values[-1]), "s")
    figure, (axes,) = drawing(1, 1, 2.5)
    for i, motion in having:
        time, values = motion["time"].values / scale, drawable(motion["rotor_velocity"].values)
        axes.plot(*envelope(np.asarray(time), values), label=motion.attrs["law"], **line_style(i))
    axes.set(xlabel=f"time ({unit})", ylabel="rotor velocity (rad/s)")
    return legend_above(figure, axes)


def draw_energy(data: xarray.Dataset) -> Figure:
    """Draw the destination of the work of the drive, a bar for each law; energy given back is below zero."""
    data = data.dropna("law", subset=["energy"])
    needed(data.sizes["law"])
    work = data["drive_work"].values
    unit, scale = prefixed_unit(float(np.max(np.abs(work))), "J")
    labels = [fill(str(label), LONGEST_LABEL) for label in data["law"].values]
    figure, axes, place = _bars(labels, 1.2 + 0.42 * len(labels))
    energy = data["energy"].transpose("term", "law").values / scale
    gained, returned = (part.cumsum(axis=0) for part in (energy.clip(min=0), energy.clip(max=0)))
    starts = np.where(energy >= 0.0, gained, returned) - energy
    bar = {"height": 0.62, "edgecolor": "white", "linewidth": 0.5}
    for number, label in enumerate(ENERGY_TERMS.values()):
        part, colour = energy[number], line_style(number)["color"]
        if np.any(np.abs(part) > 1e-3 * np.abs(work) / scale):
            look = {"facecolor": colour, "hatch": HATCHES[number], **bar}
            axes.barh(place, part, left=starts[number], label=label, **look)
    mark = {"marker": "|", "markersize": 16.0, "markeredgewidth": 1.4, "color": "black"}
    axes.plot(work / scale, place, linestyle="", label="work of the drive", **mark)
    span = "in one drive period" if "limits" in data.attrs else "from the start to the end"
    axes.set_xlabel(f"energy {span} ({unit})")
    return legend_above(figure, axes, markerscale=0.45)


def draw_phases(motions: Motions) -> Figure:
    """Draw gap rate and slip velocity over the gap in the last drive periods."""
    having = _with(motions, "gap", "slip_velocity")
    figure, (normal, tangential) = drawing(1, 2, 2.7)
    unit, scale = handy_unit((motion["gap"].values for _, motion in having), "m")
    for i, motion in having:
        span = last_periods(motion)
        gap, slip = (drawable(motion[name].values[span]) for name in ("gap", "slip_velocity"))
        # The mean rate of every record interval, over the gap in its middle.
        rate, middle = np.diff(gap) / np.diff(motion["time"].values[span]), 0.5 * (gap[1:] + gap[:-1])
        normal.plot(middle / scale, drawable(rate), label=motion.attrs["law"], **line_style(i))
        tangential.plot(gap / scale, slip, **line_style(i))
    for axes, label in ((normal, "gap rate (m/s)"), (tangential, "slip velocity (m/s)")):
        axes.axvline(0.0, **THIN)
        axes.set(xlabel=f"gap ({unit})", ylabel=label)
    tangential.axhline(0.0, **THIN)
    return legend_above(figure, normal)
