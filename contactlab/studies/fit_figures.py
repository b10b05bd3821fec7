"""The pictures of a fit: the posterior of every pair of parameters, and the data beside what is predicted."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.style import context

from contactlab.arrays import Array
from contactlab.inference.result import ENDS, Answer
from contactlab.plot.style import COLOURS, STYLE
from contactlab.results.files import whole_file

WIDTH: Final = 5.2  # inches; the words are still read where a phone makes it its own width
CELL: Final = 1.15  # height of a row of the corner plot [in]
BINS: Final = 24
MOST: Final = 8  # parameters that a corner plot can show
FEW: Final = 150  # impacts whose intervals are drawn one by one
SHARES: Final = (0.9, 0.5)  # of the posterior inside its lines

METADATA: Final[Any] = {"pdf": {"CreationDate": None}, "png": {"Software": None}}
"""Without dates and versions the same fit gives the same bytes."""

_BAND: Final[Any] = {"color": COLOURS["stick"], "alpha": 0.3, "linewidth": 0.0}
_TRUTH: Final[Any] = {"color": COLOURS["fault"], "linewidth": 0.9}


def save(answer: Answer, folder: Path, ending: str) -> list[Path]:
    """Write corner plot and predictions, PNG and PDF, into a folder, and give the PNG files."""
    written = []
    for name, draw in {"corner": corner, "predictions": predictions}.items():
        with context(STYLE):
            figure = draw(answer)
            for kind, metadata in METADATA.items():
                with whole_file(folder / f"{name}{ending}.{kind}") as partial:
                    figure.savefig(partial, format=kind, metadata=metadata)
        written.append(folder / f"{name}{ending}.png")
    return written


def corner(answer: Answer) -> Figure:
    """Draw the posterior of each parameter, and of each pair; the truth as a line where it is known."""
    rows = answer.rows()[:MOST]
    weights, columns = np.exp(answer.posterior.log_weight), answer.posterior.samples.T
    count = len(rows)
    figure = Figure(figsize=(WIDTH, max(CELL * count, 2.2) + 0.5), layout="constrained")
    panels = figure.subplots(count, count, squeeze=False)
    spans = [_span(row.low, row.high) for row in rows]
    for i, row in enumerate(rows):
        for j in range(count):
            axes: Axes = panels[i, j]
            if j > i:
                axes.set_axis_off()
                continue
            if i == j:
                axes.hist(columns[i], bins=BINS, range=spans[i], weights=weights, color="0.75")
                axes.set_yticks([])
                axes.spines["left"].set_visible(False)
            else:
                _pair(axes, columns[j], columns[i], weights, (spans[j], spans[i]))
            _mark(axes, rows[j].truth, row.truth if i != j else np.nan)
            axes.set_xlim(spans[j])
            axes.locator_params(axis="x", nbins=2)
            if i != j:
                axes.set_ylim(spans[i])
                axes.locator_params(axis="y", nbins=3)
            _label(axes, rows[j], row, bottom=i == count - 1, left=j == 0 and i > 0)
    figure.align_labels()
    return figure


def _span(low: float, high: float) -> tuple[float, float]:
    width = (high - low) or abs(high) or 1.0
    return low - 0.6 * width, high + 0.6 * width


def _pair(axes: Axes, x: Array, y: Array, weights: Array, spans: Any) -> None:
    """Draw the lines inside which shares of a posterior lie, of a histogram."""
    counts, across, up = np.histogram2d(x, y, BINS, spans, weights=weights)
    # A histogram's noise is no feature of the posterior.
    smooth = np.array([0.25, 0.5, 0.25])
    for axis in (0, 1, 0, 1):
        counts = np.apply_along_axis(np.convolve, axis, counts, smooth, mode="same")
    falling = np.sort(counts.ravel())[::-1]
    inside = np.cumsum(falling) / falling.sum()
    levels = [float(falling[np.searchsorted(inside, share)]) for share in SHARES]
    middle = [0.5 * (edges[1:] + edges[:-1]) for edges in (across, up)]
    if levels[0] < levels[1] < counts.max():
        axes.contourf(*middle, counts.T, [*levels, counts.max()], colors=["0.8", "0.55"])
    else:
        axes.pcolormesh(across, up, counts.T, cmap="Greys", rasterized=True)


def _mark(axes: Axes, across: float, up: float) -> None:
    if not np.isnan(across):
        axes.axvline(across, **_TRUTH)
    if not np.isnan(up):
        axes.axhline(up, **_TRUTH)


def _label(axes: Axes, below: Any, beside: Any, *, bottom: bool, left: bool) -> None:
    for row, wanted, name in ((below, bottom, "x"), (beside, left, "y")):
        words = row.name.replace(".", ".\n").replace("_", " ")
        unit = "" if row.unit == "1" else f"\n({row.unit})"
        if name == "x":
            axes.tick_params(axis="x", labelbottom=wanted)
        else:
            axes.tick_params(axis="y", labelleft=wanted)
        getattr(axes, f"{name}axis").get_offset_text().set_visible(wanted)
        if wanted:
            getattr(axes, f"set_{name}label")(f"{words}{unit}", fontsize=6)


def predictions(answer: Answer) -> Figure:
    """Draw the data and the 90 % band of what the posterior predicts of them."""
    if "time" in answer.model.coordinates:
        return _over_time(answer)
    return _of_impacts(answer)


def _over_time(answer: Answer) -> Figure:
    """Draw each series with its band, and below what is left of it without the median."""
    data, time = answer.model.data, 1e3 * answer.model.coordinates["time"]
    figure = Figure(figsize=(WIDTH, 2.6 * len(data) + 0.3), layout="constrained")
    panels = figure.subplots(2 * len(data), 1, sharex=True, height_ratios=[2, 1] * len(data))
    for one, upper, lower in zip(data, panels[::2], panels[1::2], strict=True):
        low, high = np.quantile(answer.replicas[one.name], ENDS, axis=0)
        middle = np.median(answer.predictions[one.name], axis=0)
        for axes, level in ((upper, 0.0), (lower, middle)):
            axes.fill_between(time, low - level, high - level, label="90 % of the predictions", **_BAND)
            axes.plot(time, one.values - level, ".", color="black", markersize=1.5, label="measured")
        upper.plot(time, middle, color=COLOURS["stick"], linewidth=0.7, label="median, without noise")
        unit = one.units.replace(" s-1", "/s")
        upper.set_ylabel(f"{one.name.replace('_', ' ')}\n({unit})")
        lower.set_ylabel(f"less the\nmedian ({unit})")
    panels[0].legend(loc="best")
    panels[-1].set_xlabel("time (ms)")
    figure.align_ylabels()
    return figure


def _of_impacts(answer: Answer) -> Figure:
    """Draw predicted over measured velocities, one panel a direction, with 90 % intervals."""
    (one,) = answer.model.data
    low, high = np.quantile(answer.replicas[one.name], ENDS, axis=0)
    middle = np.median(answer.predictions[one.name], axis=0)
    figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
    for k, (axes, name) in enumerate(zip(figure.subplots(1, 2), ("gap rate", "slip"), strict=True)):
        measured = one.values[:, k]
        ends = [float(f(np.concatenate([measured, middle[:, k]]))) for f in (np.min, np.max)]
        axes.plot(ends, ends, color="0.5", linewidth=0.6, zorder=0)
        if measured.size > FEW:
            axes.plot(measured, middle[:, k], ".", markersize=2, alpha=0.4, color=COLOURS["stick"])
            # An interval of middling length stands for all.
            half = 0.5 * float(np.median(high[:, k] - low[:, k]))
            for sign in (-1.0, 1.0):
                line = [end + sign * half for end in ends]
                axes.plot(ends, line, color="0.5", linewidth=0.6, linestyle=(0, (5, 1.5)), zorder=0)
        else:
            errors = np.maximum([middle[:, k] - low[:, k], high[:, k] - middle[:, k]], 0.0)
            style: Any = {"fmt": "o", "markersize": 2, "elinewidth": 0.4, "color": COLOURS["stick"]}
            axes.errorbar(measured, middle[:, k], errors, **style)
        axes.set_xlabel(f"{name} after the impact, measured (m/s)")
        axes.set_ylabel("predicted (m/s)")
    return figure
