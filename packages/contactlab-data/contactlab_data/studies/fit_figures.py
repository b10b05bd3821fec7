"""Figures of a fit: the posterior of every pair of parameters, and the data beside their predictions."""

from typing import Any, Final

import numpy as np
import xarray
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import ScalarFormatter

from contactlab.arrays import Array
from contactlab.parameter import from_cf
from contactlab.plot.recording import handy_unit
from contactlab.plot.style import COLOURS, DASHES
from contactlab.studies.figures import drawing, explain, legend_above
from contactlab.studies.tables import unit_for
from contactlab_data.inference.evidence import misfits
from contactlab_data.inference.fit import ENDS

CELL: Final = 1.15  # height of a row of the corner plot [in]
BINS: Final = 24
MOST: Final = 8  # parameters of a corner plot
FEW: Final = 150  # impacts with individual intervals
SHARES: Final = (0.9, 0.5)  # of the posterior inside its regions
INSIDE: Final = ("0.8", "0.55")  # greys of these
MARGINAL: Final = "0.65"  # grey of the density of one parameter

_BAND: Final[Any] = {"color": COLOURS["stick"], "alpha": 0.3, "linewidth": 0.0}
_TRUTH: Final[Any] = {"color": COLOURS["fault"], "linewidth": 0.9, "linestyle": DASHES[1]}


def draw_corner(fit: xarray.DataTree) -> Figure:
    """Draw the posterior of each parameter and pair: 50 % and 90 % regions, the truth as dashed lines."""
    samples = fit["weighted_samples"].to_dataset()
    weights, columns = np.exp(samples["log_weight"].values), samples["value"].values.T
    summary = fit["summary"].to_dataset()
    heads, scales = _heads(summary)
    columns = columns / scales[:, None]
    low, high, truth = (summary[name].values / scales for name in ("low", "high", "truth"))
    width = np.where(high > low, high - low, np.where(high != 0.0, np.abs(high), 1.0))
    spans = [*zip((low - 0.6 * width).tolist(), (high + 0.6 * width).tolist(), strict=True)]
    count = min(len(heads), MOST)
    figure, panels = drawing(count, count, max(CELL * count, 2.2) + 0.5)
    for place, axes in enumerate(panels):
        i, j = divmod(place, count)
        if j > i:
            axes.set_axis_off()
            continue
        if i == j:
            axes.hist(columns[i], bins=BINS, range=spans[i], weights=weights, color=MARGINAL)
            axes.set_yticks([])
            axes.spines["left"].set_visible(False)
        else:
            _pair(axes, columns[j], columns[i], weights, (spans[j], spans[i]))
        for line, at in ((axes.axvline, truth[j]), (axes.axhline, truth[i] if i != j else np.nan)):
            if not np.isnan(at):
                line(at, **_TRUTH)
        axes.set_xlim(spans[j])
        axes.locator_params(axis="x", nbins=2)
        if i != j:
            axes.set_ylim(spans[i])
            axes.locator_params(axis="y", nbins=3)
        bottom, left = i == count - 1, j == 0 and i > 0
        axes.tick_params(labelbottom=bottom, labelleft=left)
        for axis, head, labelled in ((axes.xaxis, heads[j], bottom), (axes.yaxis, heads[i], left)):
            # A tick is a number that is read as it stands.
            if isinstance(formatter := axis.get_major_formatter(), ScalarFormatter):
                formatter.set_useOffset(False)
                formatter.set_scientific(False)
            if labelled:
                axis.set_label_text(head, fontsize=6)
    figure.align_labels()
    keys = _keys(count, truth[:count])
    explain(figure, keys, [key.get_label() for key in keys], f"posterior of {law_in(fit)}", ncols=len(keys))
    return figure


def _keys(count: int, truth: Array) -> list[Artist]:
    """Return the entries of the legend of a corner plot of some parameters."""
    keys: list[Artist] = [Patch(facecolor=MARGINAL, label="density")]
    if count > 1:
        regions = zip(INSIDE, SHARES, strict=True)
        keys += [Patch(facecolor=grey, label=f"{100.0 * share:g} % inside") for grey, share in regions]
    if not np.isnan(truth).all():
        keys.append(Line2D([], [], label="truth", **_TRUTH))
    return keys


def law_in(fit: xarray.DataTree) -> str:
    """Return the label of the law of a fit."""
    return str(fit.attrs["title"]).removeprefix("Posterior of ")


def _heads(summary: xarray.Dataset) -> tuple[list[str], Array]:
    """Return names of numbers with handy units, and the sizes of these in SI."""
    heads, scales = list[str](), list[float]()
    largest = np.maximum(np.abs(summary["low"].values), np.abs(summary["high"].values))
    for name, size, units in zip(summary["parameter"].values, largest, summary["units"].values, strict=True):
        unit, scale = unit_for(float(size), str(units))
        heads.append(str(name).replace(".", ".\n").replace("_", " ") + (f"\n({unit})" if unit else ""))
        scales.append(scale)
    return heads, np.array(scales)


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
        axes.contourf(*middle, counts.T, [*levels, counts.max()], colors=[*INSIDE])
    else:
        axes.pcolormesh(across, up, counts.T, cmap="Greys", rasterized=True)


def sets_in(fit: xarray.DataTree) -> list[str]:
    """Return the labels of the data sets of a fit, "" of a single one."""
    return [*dict.fromkeys(str(name).rpartition(".")[0] for name in fit["observed_data"].data_vars)]


def _part(data: xarray.Dataset, label: str) -> xarray.Dataset:
    """Return what is of one data set, by its names there."""
    if not label:
        return data
    data = data[[name for name in data.data_vars if str(name).startswith(f"{label}.")]]
    names = dict.fromkeys([*data.data_vars, *data.coords, *data.dims])
    return data.rename({name: str(name).removeprefix(f"{label}.") for name in names})


def draw_predictions(fit: xarray.DataTree, label: str) -> Figure:
    """Draw one data set and the 90 % band of its predictions; of a law that does not fit it is said above."""
    data = _part(fit["observed_data"].to_dataset(), label)
    predictive = _part(fit["posterior_predictive"].to_dataset().isel(chain=0), label)
    law = law_in(fit)
    title = f"{law}: predictions" + (f" of {label}" if label else "")
    if why := misfits({law: fit}).get(law):
        title += f"; it does not fit: {why}"
    if "time" in data.dims:
        unit, scale = handy_unit([data["time"].values], "s")
        return _over(data, predictive, data["time"].values / scale, f"time ({unit})", title)
    if "row" in data.dims:
        unit, scale = handy_unit([data["z"].values], "m")
        return _over(data, predictive, data["z"].values / scale, f"z ({unit})", title, as_measured=True)
    if "point" in data.dims:
        key = str(next(iter(data.coords)))
        unit, scale = handy_unit([data[key].values], data[key].attrs["units"])
        return _over(data, predictive, data[key].values / scale, f"{key} ({unit})" if unit else key, title)
    return _of_impacts(data, predictive, title)


def draw_residuals(fit: xarray.DataTree) -> Figure:
    """Draw residuals over errors of every data set in their order, and their distribution beside N(0, 1)."""
    data = fit["residuals"].to_dataset()
    figure, panels = drawing(len(data), 2, 1.5 * len(data) + 0.3, width_ratios=[3, 1], sharey="row")
    for (name, item), axes, side in zip(data.data_vars.items(), panels[::2], panels[1::2], strict=True):
        values = item.values.ravel()
        axes.axhspan(-2.0, 2.0, label="two errors of the data", **_BAND)
        points = {"color": "black", "markersize": 1.5 if values.size > FEW else 4.0, "label": "residual"}
        axes.plot(values, ".", **points)
        axes.set_ylabel(str(name).replace(".", "\n").replace("_", " "))
        if np.isfinite(values).all():
            side.hist(values, bins=BINS, orientation="horizontal", density=True, color=MARGINAL)
        low, high = axes.get_ylim()
        place = np.linspace(low, high, 200)
        normal = np.exp(-0.5 * place**2) / np.sqrt(2.0 * np.pi)
        # It stands in the legend of the residuals.
        for panel, x, y in ((side, normal, place), (axes, [], [])):
            panel.plot(x, y, color=COLOURS["stick"], label="normal distribution")
    panels[-2].set_xlabel("residuals over errors, in the order of the data")
    panels[-1].set_xlabel("density")
    return legend_above(figure, panels[0], f"{law_in(fit)}: residuals")


def _over(
    data: xarray.Dataset,
    predictive: xarray.Dataset,
    place: Array,
    label: str,
    title: str,
    *,
    as_measured: bool = False,
) -> Figure:
    """Draw each quantity with its band, and below both less the median of the predictions.

    Lines join the data by their places, or as they were measured, there and back.
    """
    order = np.arange(place.size) if as_measured else np.argsort(place, kind="stable")
    place, size = place[order], 1.5 if place.size > FEW else 4.0
    count = len(data)
    figure, panels = drawing(2 * count, 1, 2.6 * count + 0.3, sharex=True, height_ratios=[2, 1] * count)
    for (name, item), upper, lower in zip(data.data_vars.items(), panels[::2], panels[1::2], strict=True):
        low, high = np.quantile(predictive[name].values, ENDS, axis=0)[:, order]
        middle = np.median(predictive[f"{name}_predicted"].values, axis=0)[order]
        for axes, level in ((upper, 0.0), (lower, middle)):
            axes.fill_between(place, low - level, high - level, label="90 % of the predictions", **_BAND)
            axes.plot(
                place, item.values[order] - level, ".", color="black", markersize=size, label="measured"
            )
        upper.plot(place, middle, color=COLOURS["stick"], linewidth=0.7, label="median, without noise")
        unit = from_cf(item.attrs["units"])
        upper.set_ylabel(f"{str(name).replace('_', ' ')}\n({unit})")
        lower.set_ylabel(f"less the\nmedian ({unit})")
    panels[-1].set_xlabel(label)
    return legend_above(figure, panels[0], title)


def _of_impacts(data: xarray.Dataset, predictive: xarray.Dataset, title: str) -> Figure:
    """Draw predicted over measured velocities, one panel a direction, with 90 % intervals.

    Of many impacts one interval, of median length, is drawn as dashed lines.
    """
    values = data["velocity_after"].values
    low, high = np.quantile(predictive["velocity_after"].values, ENDS, axis=0)
    middle = np.median(predictive["velocity_after_predicted"].values, axis=0)
    figure, panels = drawing(1, 2, 2.8)
    for k, (axes, name) in enumerate(zip(panels, ("gap rate", "slip velocity"), strict=True)):
        measured = values[:, k]
        ends = [float(f(np.concatenate([measured, middle[:, k]]))) for f in (np.min, np.max)]
        axes.plot(ends, ends, color="0.5", linewidth=0.6, zorder=0, label="predicted as measured")
        if measured.size > FEW:
            points = {"markersize": 2, "alpha": 0.4, "color": COLOURS["stick"], "label": "median"}
            axes.plot(measured, middle[:, k], ".", **points)
            half = 0.5 * float(np.median(high[:, k] - low[:, k]))
            for sign in (-1.0, 1.0):
                line = [end + sign * half for end in ends]
                label = "90 % interval, of median length" if sign > 0.0 else ""
                axes.plot(ends, line, color="0.5", linewidth=0.6, linestyle=DASHES[1], zorder=0, label=label)
        else:
            errors = np.maximum([middle[:, k] - low[:, k], high[:, k] - middle[:, k]], 0.0)
            style: Any = {"fmt": "o", "markersize": 2, "elinewidth": 0.4, "color": COLOURS["stick"]}
            axes.errorbar(measured, middle[:, k], errors, label="median, 90 % interval", **style)
        axes.set_xlabel(f"{name} after the impact, measured (m/s)")
        axes.set_ylabel("predicted (m/s)")
    return legend_above(figure, panels[0], title)
