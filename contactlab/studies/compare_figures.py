"""Figures of a comparison: effects of causes, shares, contact, paths, velocities, energy, phase portraits."""

from collections.abc import Callable
from contextlib import suppress
from textwrap import fill
from typing import Any, Final, NamedTuple

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.ndimage import median_filter

from contactlab.arrays import Array
from contactlab.metrics import METRICS, NotApplicableError, needed
from contactlab.plot.recording import drawable, envelope
from contactlab.results.summary import prefixed_unit
from contactlab.studies.compare_causes import CLEAR, sample_count, unclear
from contactlab.studies.compare_scorecard import CAUSES, CONTACTS, ENERGY_TERMS, NOT_KNOWN, NUMERICAL
from contactlab.studies.figures import LONGEST_LABEL, NOTE, THIN, drawing, legend_above, style

CAPTIONS: Final = {
    "settled_quantities": "Diamonds are the motor with every law, bars the effect of each cause: one as long "
    "as diamonds are apart may explain their difference. A question mark is a cause that is not known.",
    "variance_shares": "Shares of law, parameters, basis and step in the variance of the settled rotor "
    "velocity over all draws, with 95 % intervals.",
    "rotor_velocity": "Rotor velocity, with its numerical error as a band that may be thinner than the line. "
    "Below: range of the laws, in black, and numerical error of each, as medians over a drive period.",
    "contact_force": "Normal force and friction of one contact, means over the record intervals. Peaks of "
    "rigid impacts, which grow without bound as the step falls, are off scale.",
    "tip_trajectory": "Path of the tip in the last two drive periods.",
    "energy_flow": "Destination of the work of the drive.",
    "phase_portrait": "Mean gap rate and slip velocity over the gap in the last two drive periods.",
}
"""Captions of the figures, in their order."""

TITLES: Final = {
    "rotor_velocity": "settled rotor velocity",
    "peak_force": "peak force",
    "stick_share": "stick, share of contact",
    "friction_share": "friction, share of drive work",
}
DECADES: Final = 30.0
"""Ratio of values beyond which an axis is logarithmic."""

OFFSET: Final = 0.17
"""Distance of the bars of a law; that of the laws is 1."""

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
        "settled_quantities": (draw_causes, card),
        "variance_shares": (draw_shares, card),
        "rotor_velocity": (draw_velocities, motions),
        "contact_force": (draw_contact, motions),
        "tip_trajectory": (draw_paths, motions),
        "energy_flow": (draw_energy, card),
        "phase_portrait": (draw_phases, motions),
    }
    other = {"rotor_velocity"} if "cause" in card.dims else {"settled_quantities", "variance_shares"}
    figures = {}
    for name in [name for name in every if name not in other]:
        draw, subject = every[name]
        with suppress(NotApplicableError):
            figures[name] = draw(subject)
            # The caption of the page.
            figures[name].set_label(CAPTIONS[name])
    return figures


def draw_causes(data: xarray.Dataset) -> Figure:
    """Draw every quantity of every law, and the effect of each cause."""
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
    reached = np.append(ends[ends > 0.0], value[known])
    if known.any() and np.all(value[known] > 0.0) and reached.max() > DECADES * reached.min():
        panel.set_xscale("log")
    for number, cause in enumerate(CAUSES):
        low, high = value - ends[0, :, number], ends[1, :, number] - value
        if cause == NUMERICAL:
            low, high = CLEAR * low, CLEAR * high
        if key == "stick_share":
            # A share of the contact is between none and all of it.
            low, high = np.minimum(low, value), np.minimum(high, 1.0 - value)
        if panel.get_xscale() == "log":
            # Zero has no place on the axis.
            low = np.minimum(low, 0.9 * value)
        place = np.arange(value.size) + OFFSET * (number - 0.5 * (len(CAUSES) - 1))
        colour = style(number)["color"]
        label = f"{CLEAR:g} x {cause}" if cause == NUMERICAL else cause
        here = np.isfinite(low) & np.isfinite(high) & known
        bars = {"linestyle": "none", "color": colour, "capsize": 2.5, "elinewidth": 1.8, "label": label}
        panel.errorbar(value[here], place[here], xerr=[low[here], high[here]], **bars)
        for x, y in zip(value[~here & known], place[~here & known], strict=True):
            note = {"color": colour, "fontsize": 7, "va": "center"}
            panel.annotate("?", (x, y), (8, 0), textcoords="offset points", **note)
    panel.plot(value[known], np.flatnonzero(known), "D", color="black", markersize=3.5)
    for x in value[known]:
        panel.axvline(x, **THIN)
    unit = METRICS[key].bracketed.replace("[", "(").replace("]", ")")
    # A run as recorded may not have settled.
    title = TITLES[key].removeprefix("settled ") if NOT_KNOWN in data["kind"].values else TITLES[key]
    panel.set_xlabel(f"{title}{unit}")
    panel.margins(x=0.08)


def draw_shares(data: xarray.Dataset) -> Figure:
    """Draw the shares of the factors in the variance of the settled velocity, with their intervals."""
    needed("total_order" in data)
    here = data.sel(quantity="rotor_velocity")
    total, first = here["total_order"].values, here["first_order"].values
    needed(np.isfinite(total).all())
    order = np.argsort(-total[:, 0], kind="stable")
    figure, axes, place = _bars(here["factor"].values[order], 0.9 + 0.36 * order.size)
    count = sample_count(data)
    for rows, offset, label, number in ((total, -0.18, "with interactions", 0), (first, 0.18, "alone", 1)):
        known = ~np.array([unclear(*row[1:]) for row in rows[order]])
        share, low, high = rows[order][known].T
        colour = style(number)["color"]
        axes.barh(place[known] + offset, share, height=0.34, color=colour, label=label)
        reach = [share - np.minimum(low, share), np.maximum(high, share) - share]
        axes.errorbar(share, place[known] + offset, xerr=reach, fmt="none", color="black", capsize=2)
        for y in place[~known] + offset:
            note = f"{label}: {count} samples are inconclusive"
            axes.text(0.01, y, note, va="center", color=colour, fontsize=7)
    # Estimates and their intervals may exceed 0 and 1, by at most their width.
    left, right = axes.get_xlim()
    axes.set_xlim(min(left, 0.0), max(right, 1.0))
    axes.set_xlabel("share of the variance of the settled rotor velocity")
    return legend_above(figure, axes)


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
    after = [c.forces[:, c.time > IMPACT * c.duration] for c in contacts.values()]
    normal, friction = np.concatenate([np.zeros((2, 1)), *after], axis=1)
    top, room = 1.5 * float(normal.max()), 0.2 * float(np.ptp(friction))
    figure, (above, below) = drawing(2, 1, 4.0, sharex=True)
    unit, scale = prefixed_unit(max(contact.duration for contact in contacts.values()), "s")
    for i, contact in contacts.items():
        spike = f", peak {contact.peak:.4g}\u00a0N off scale" if contact.peak > top > 0.0 else ""
        above.plot(contact.time / scale, contact.forces[0], label=motions[i].attrs["law"] + spike, **style(i))
        below.plot(contact.time / scale, contact.forces[1], **style(i))
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
    for i, motion in having:
        x, y = (drawable(motion[name].values[last_periods(motion)]) * 1e6 for name in names)
        axes.plot(x, y, label=motion.attrs["law"], **style(i))
    if "clearance" in having[0][1].attrs:
        clearance = 1e6 * having[0][1].attrs["clearance"]
        axes.axhline(clearance, **THIN)
        axes.text(1.0, clearance, "rotor", transform=axes.get_yaxis_transform(), va="bottom", **NOTE)
    axes.set_xlabel("tangential displacement of the tip (\u00b5m)")
    axes.set_ylabel("normal displacement (\u00b5m)")
    return legend_above(figure, axes)


def smoothed(motion: xarray.Dataset, values: Array) -> Array:
    """Return the running median over a drive period, NaN where it is not positive."""
    time = motion["time"].values
    size = int(np.searchsorted(time, time[0] + motion.attrs["period"]))
    median = median_filter(values, size=max(size, 1), mode="nearest")
    return np.where(median > 0.0, median, np.nan)


def draw_velocities(motions: Motions) -> Figure:
    """Draw the rotor velocity over the run; below it the range of the laws and the error of each."""
    name = "rotor_velocity"
    having = _with(motions, name)
    errors = {i: m[f"{name}_error"].values for i, m in having if f"{name}_error" in m}
    smooth = {i: smoothed(motions[i], error) for i, error in errors.items() if np.isfinite(error).all()}
    # A rotor at rest has no error that a logarithmic axis could show.
    below = any(np.isfinite(error).any() for error in smooth.values())
    figure, panels = drawing(1 + below, 1, 2.5 + 1.6 * below, sharex=True)
    axes, last = panels[0], panels[-1]
    first = having[0][1]
    unit, scale = prefixed_unit(float(first["time"].values[-1]), "s")
    for i, motion in having:
        time, values = np.asarray(motion["time"].values / scale), drawable(motion[name].values)
        axes.plot(*envelope(time, values), label=motion.attrs["law"], **style(i))
        if below and i in smooth:
            band = {"color": style(i)["color"], "alpha": 0.3, "linewidth": 0.0}
            axes.fill_between(time, values - errors[i], values + errors[i], **band)
            last.plot(*envelope(time, smooth[i]), **style(i))
    if below:
        time = first["time"].values
        each = [np.interp(time, motion["time"].values, motion[name].values) for _, motion in having]
        apart = smoothed(first, np.ptp(each, axis=0))
        if np.isfinite(apart).any():
            last.plot(*envelope(time / scale, apart), color="black", linewidth=1.4)
            end, place = (1.0, apart[-1]), last.get_yaxis_transform()
            last.annotate("range of the laws", end, (-4, -6), place, "offset points", va="top", **NOTE)
        last.set(yscale="log", ylabel="numerical error (rad/s)")
    last.set_xlabel(f"time ({unit})")
    axes.set_ylabel("rotor velocity (rad/s)")
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
        part, colour = energy[number], style(number)["color"]
        if np.any(np.abs(part) > 1e-3 * np.abs(work) / scale):
            axes.barh(place, part, left=starts[number], label=label, color=colour, **bar)
    mark = {"marker": "|", "markersize": 16.0, "markeredgewidth": 1.4, "color": "black"}
    axes.plot(work / scale, place, linestyle="", label="work of the drive", **mark)
    span = "in one drive period" if "cause" in data.dims else "from the start to the end"
    axes.set_xlabel(f"energy {span} ({unit})")
    return legend_above(figure, axes, markerscale=0.45)


def draw_phases(motions: Motions) -> Figure:
    """Draw gap rate and slip velocity over the gap in the last drive periods."""
    having = _with(motions, "gap", "slip_velocity")
    figure, (normal, tangential) = drawing(1, 2, 2.7)
    for i, motion in having:
        span = last_periods(motion)
        gap, slip = (drawable(motion[name].values[span]) for name in ("gap", "slip_velocity"))
        # The mean rate of every record interval, over the gap in its middle.
        rate, middle = np.diff(gap) / np.diff(motion["time"].values[span]), 0.5 * (gap[1:] + gap[:-1])
        normal.plot(1e6 * middle, drawable(rate), label=motion.attrs["law"], **style(i))
        tangential.plot(1e6 * gap, slip, **style(i))
    for axes, label in ((normal, "gap rate (m/s)"), (tangential, "slip velocity (m/s)")):
        axes.axvline(0.0, **THIN)
        axes.set(xlabel="gap (\u00b5m)", ylabel=label)
    tangential.axhline(0.0, **THIN)
    return legend_above(figure, normal)
