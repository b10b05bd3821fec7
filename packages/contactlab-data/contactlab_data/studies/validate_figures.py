"""Figures of a validation: errors, paired differences, residuals, and a map of the impacts."""

from itertools import cycle, product
from typing import Final, NamedTuple

import numpy as np
import xarray
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from contactlab.arrays import Array
from contactlab.plot.style import COLOURS, line_style
from contactlab.studies.figures import THIN, drawing, legend_above
from contactlab_data.inference.cross_validation import BASELINE, COMPLIANT, FLOOR, RIGID, floors_in, laws_in

MOST_NUMBERED: Final = 12
"""Largest number of impacts labelled in the map, and of laws whose differences are written large."""

NEGLIGIBLE: Final = 1e-3
"""Share of the least error of a law below which a floor is not drawn."""

CROSSES: Final = "x+1234|"
"""Marks of the reasons for which breaks are no impacts, in turn."""

MOST_TRACKS: Final = 3
"""Largest number of tracks in a picture."""

BINS: Final = 8
FEWEST: Final = 10
"""Impacts in a bin, if there are several bins."""

MARKS: Final = {RIGID: ("o", "C0"), COMPLIANT: ("s", "C1"), BASELINE: ("x", "0.3")}
"""Mark and colour of a kind."""


def draw_errors(data: xarray.Dataset) -> Figure:
    """Draw the held-out error of every law with its interval, beside baselines and floors."""
    shown = data.isel(law=data["kind"].values != FLOOR)
    labels = [str(label) for label in shown["law"].values]
    figure, (axes,) = drawing(1, 1, 0.9 + 0.19 * len(labels))
    for kind, (mark, colour) in MARKS.items():
        places = np.flatnonzero(shown["kind"].values == kind)
        errors = shown["prediction_error"].values[places]
        low, high = shown["prediction_error_interval"].values[places].T
        reach = np.abs([errors - low, high - errors])
        bars = {"linestyle": "", "marker": mark, "color": colour, "label": f"{kind}, 95 %", "capsize": 2.0}
        if places.size:
            axes.errorbar(errors, places, xerr=reach, markersize=2.5, elinewidth=0.9, **bars)
    floors = floors_in(data)
    # Where velocities of the contact are all that was measured, an impulse makes any of them.
    least = NEGLIGIBLE * float(shown["prediction_error"].min())
    for floor in floors["law"].values[floors["prediction_error"].values > least]:
        here = data.sel(law=floor)
        axes.axvspan(*here["prediction_error_interval"].values, color="0.85", zorder=0)
        axes.axvline(float(here["prediction_error"]), **THIN)
        if floor == floors["law"].values[0]:
            text = "floor: best admissible impulse of each impact "
            at = float(here["prediction_error"]), len(labels) - 0.5
            axes.annotate(text, at, (4, 0), textcoords="offset points", va="center", fontsize=7)
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels), -0.7)
    axes.set(xscale="log", xlabel="held-out prediction error,\nin parts of the velocity before the impact")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter("{x:.2g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    return legend_above(figure, axes)


def draw_differences(data: xarray.Dataset) -> Figure:
    """Draw by how much the law of a row is worse than that of a column; grey where not distinguishable.

    What is above the diagonal is the same with the other sign, and left out.
    """
    laws = laws_in(data)
    labels = [str(label) for label in laws["law"].values]
    apart = laws["difference"].sel(other=labels).values
    low, high = np.moveaxis(laws["difference_interval"].sel(other=labels).values, -1, 0)
    parted = (low > 0.0) | (high < 0.0)
    figure, (axes,) = drawing(1, 1, max(1.9, 0.21 * len(labels)) + 1.3)
    below = np.tri(len(labels), k=-1, dtype=bool)
    scale = np.max(np.abs(apart[below & parted]), initial=1e-9)
    # Of differences that span decades all are to be seen.
    colour = np.where(below & parted, np.sqrt(np.abs(apart) / scale), np.nan)
    axes.imshow(colour, cmap="Reds", vmin=0.0, vmax=1.6, aspect="auto")
    size = 5 if len(labels) > MOST_NUMBERED else 6.5
    for i, j in zip(*np.nonzero(below), strict=True):
        text = f"{1e3 * apart[i, j]:.0f}" if apart[i, j] >= 0.01 else f"{1e3 * apart[i, j]:.1f}"
        shade = "black" if parted[i, j] else "0.6"
        axes.text(j, i, text, ha="center", va="center", fontsize=size, color=shade)
    axes.set_xticks(range(len(labels)), labels, rotation=90)
    axes.set_yticks(range(len(labels)), labels)
    axes.tick_params(length=0.0)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_title(
        "held-out error of the row less that of the column, in thousandths of\n"
        "the velocity before the impact; without colour: not distinguishable",
        loc="right",
    )
    return figure


def draw_residuals(data: xarray.Dataset) -> Figure:
    """Draw medians and quartiles of residuals over incidence, approach and slip velocity."""
    laws = laws_in(data)
    # The best of the first four groups.
    _, firsts = np.unique(laws["group"].values, return_index=True)
    chosen = [str(laws["law"].values[place]) for place in firsts[:4]]
    across = abscissas(data)
    figure, panels = drawing(3, 3, 5.2, sharex="col", sharey="row")
    for number, law in enumerate(chosen):
        for row, (name, missed) in enumerate(residuals_of(data, law).items()):
            for column, (axis, x) in enumerate(across.items()):
                axes = panels[3 * row + column]
                result = binned(x, missed)
                axes.plot(result.at, result.median, label=f"{law}, median", **line_style(number))
                if number == 0:
                    band = {"color": line_style(number)["color"], "alpha": 0.15, "linewidth": 0.0}
                    axes.fill_between(result.at, result.low, result.high, label=f"{law}, quartiles", **band)
                if column == 0:
                    axes.set_ylabel(name)
                if row == 2:
                    axes.set_xlabel(axis)
                if row:
                    axes.axhline(0.0, **THIN)
    return legend_above(figure, panels[0])


def draw_impacts(data: xarray.Dataset) -> Figure:
    """Draw the impacts over slip and approach, with the least error under any law, the unexplained named."""
    laws = laws_in(data)
    least = laws["error"].values.min(axis=0)
    rate, slip = data["velocity_before"].values.T
    figure, (axes,) = drawing(1, 1, 3.6)
    top = float(np.quantile(least, 0.99))
    dots = axes.scatter(slip, -rate, c=least, s=7.0, cmap="viridis", vmin=0.0, vmax=top, linewidth=0.0)
    figure.colorbar(
        dots, ax=axes, label="least error under any law,\nin parts of the velocity before", extend="max"
    )
    odd = np.flatnonzero(data["unexplained"].values)
    if odd.size:
        label = f"no law explains: {odd.size} of {rate.size}"
        ring = {"s": 26.0, "facecolor": "none", "edgecolor": COLOURS["fault"], "linewidth": 0.9}
        axes.scatter(slip[odd], -rate[odd], label=label, **ring)
        named: list[tuple[float, float]] = []
        spread = np.ptp(slip), np.ptp(rate)
        for place in odd[np.argsort(-least[odd])][:MOST_NUMBERED]:
            at = float(slip[place]), float(-rate[place])
            # Numbers that would lie on each other are none.
            if any(abs(at[0] - x) < 0.08 * spread[0] and abs(at[1] - y) < 0.04 * spread[1] for x, y in named):
                continue
            named.append(at)
            text = str(data["impact"].values[place])
            axes.annotate(text, at, (3, 3), textcoords="offset points", fontsize=6)
        legend_above(figure, axes)
    axes.set(xlabel="slip velocity before the impact (m/s)", ylabel="approach velocity (m/s)")
    return figure


def draw_tracks(data: xarray.Dataset) -> Figure:
    """Draw positions, fitted flights and breaks of the first tracks over time, with the reasons in words.

    Args:
        data: as of `contactlab_data.measured.tracks`.
    """
    labels = np.unique(data["sample_track"].values)[:MOST_TRACKS]
    coordinates = [str(name) for name in data["coordinate"].values]
    figure, panels = drawing(
        len(coordinates), len(labels), 0.8 + 1.3 * len(coordinates), sharex="col", sharey="row"
    )
    reasons = data["reason"].values
    numbers = {reason: np.flatnonzero(reasons == reason) for reason in dict.fromkeys(reasons)}
    for (row, name), (column, label) in product(enumerate(coordinates), enumerate(labels)):
        axes, here = panels[row * len(labels) + column], data.sel(coordinate=name)
        own = here.isel(sample=here["sample_track"].values == label)
        axes.plot(
            own["sample_time"], own["sample_position"], ".", color="0.6", markersize=2, label="position"
        )
        axes.plot(own["sample_time"], own["flight_position"], color="C0", linewidth=0.9, label="flight")
        for marker, (reason, places) in zip(cycle(CROSSES), numbers.items()):
            shown = here.isel({"break": [x for x in places if here["break_track"].values[x] == label]})
            mark = (
                {"marker": marker, "color": COLOURS["fault"]} if reason else {"marker": "o", "color": "black"}
            )
            text = f"{reason}: {', '.join(map(str, places + 1))}" if reason else "impact"
            axes.plot(shown["break_time"], shown["break_position"], linestyle="", label=text, **mark)
        if column == 0:
            axes.set_ylabel(f"{name} ({'rad' if name == 'angle' else 'm'})")
            if name == "y" and data.attrs["gravity"] < 0.0:
                # In a picture y points downwards.
                axes.invert_yaxis()
        if row == len(coordinates) - 1:
            axes.set_xlabel("time (s)")
        if row == 0 and len(labels) > 1:
            axes.set_title(f"track {label:g}")
    return legend_above(figure, panels[0])


class Binned(NamedTuple):
    """Medians and quartiles in bins of equal numbers, at the medians of the abscissa."""

    at: Array
    median: Array
    low: Array
    high: Array


def abscissas(data: xarray.Dataset) -> dict[str, Array]:
    """Return quantities of the impacts before, shape (impact,), by the label of an axis."""
    rate, slip = data["velocity_before"].values.T
    return {
        "incidence (°)": np.degrees(np.arctan2(np.abs(slip), -rate)),
        "approach velocity (m/s)": -rate,
        "slip velocity (m/s)": np.abs(slip),
    }


def residuals_of(data: xarray.Dataset, law: str) -> dict[str, Array]:
    """Return error and residuals (measured less predicted), shape (impact,), by the label of an axis.

    The residual of the slip velocity is positive along the slip before the impact.
    """
    missed = data["velocity_after"].values - data["predicted_velocity"].sel(law=law).values
    along = np.sign(data["velocity_before"].values[:, 1])
    return {
        "error": data["error"].sel(law=law).values,
        "gap rate residual (m/s)": missed[:, 0],
        "slip residual (m/s)": missed[:, 1] * along,
    }


def binned(x: Array, y: Array) -> Binned:
    """Bin one quantity by another."""
    count = int(np.clip(x.size // FEWEST, 1, BINS))
    parts = np.array_split(np.argsort(x, kind="stable"), count)
    low, median, high = np.array([np.quantile(y[part], [0.25, 0.5, 0.75]) for part in parts]).T
    return Binned(np.array([np.median(x[part]) for part in parts]), median, low, high)
