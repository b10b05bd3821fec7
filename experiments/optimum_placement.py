"""Where the patches would have to lie for f2/f1 = 2 with little coupling to the third shape.

Along the curve f2(start, end) = 2 f1(start, end) the coupling |Gamma_31| is followed; the trade-off with
|Gamma_11| and |Gamma_21| is what a designer has to choose from.
"""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from scipy.optimize import brentq
from tqdm import tqdm
from variations import placed

import contactlab as cl

SHORTEST = 1e-3
"""Shortest patch [m]."""


def _numbers(setup: cl.Setup, start: float, end: float) -> tuple[float, np.ndarray]:
    """f2/f1 and the first three couplings of the first patch set [N/V]."""
    modes = placed(setup, float(start), float(end))
    ratio = modes.natural_frequency[1] / modes.natural_frequency[0]
    return float(ratio), modes.shape_coupling[:3, 0]


def _curve(setup: cl.Setup, places: np.ndarray, ratio: np.ndarray) -> np.ndarray:
    """Placements (start, end) of ratio two, every crossing of every row of the map refined."""
    result = []
    for i, start in enumerate(places):
        for j in np.flatnonzero((ratio[i, :-1] - 2.0) * (ratio[i, 1:] - 2.0) < 0.0):

            def miss(end: float, start: float = start) -> float:
                return _numbers(setup, start, end)[0] - 2.0

            result.append((start, brentq(miss, places[j], places[j + 1], xtol=1e-9)))
    return np.array(result).reshape(-1, 2)


def best(data: xarray.Dataset) -> xarray.Dataset:
    """Least |Gamma_31| of those that drive both modes half as well as placement 1 the first."""
    weaker = np.abs(data.curve_coupling.sel(shape=[1, 2])).min("shape")
    strong = data.where(weaker >= 0.5 * 0.01558, drop=True)
    return strong.isel(point=int(np.argmin(np.abs(strong.curve_coupling.sel(shape=3).values))))


class OptimumPlacement(Experiment):
    """Which placements of the patches have a ratio of two of the natural frequencies?"""

    says = (
        "Two placements are compared, with f2/f1 of 2.67 and 1.71, and a ratio of two is said to be "
        "within reach by moving the patches further; no such placement is given."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """A map of ratio and couplings, and the curve on which the ratio is two."""
        half = 0.5 * setup.configuration["resonator"]["length"]
        places = np.linspace(0.0, half, 20 if self.short else 96)
        ratio = np.full((places.size, places.size), np.nan)
        coupling = np.full((places.size, places.size, 3), np.nan)
        for i, start in enumerate(tqdm(places, unit=" rows", disable=None)):
            for j, end in enumerate(places):
                if end - start >= SHORTEST:
                    ratio[i, j], coupling[i, j] = _numbers(setup, start, end)
        curve = _curve(setup, places, ratio)
        numbers = [_numbers(setup, start, end) for start, end in curve]
        return xarray.Dataset(
            {
                "frequency_ratio": (("start", "end"), ratio, {"units": "1"}),
                "coupling": (("start", "end", "shape"), coupling, {"units": "N V-1"}),
                "curve": (("point", "edge"), curve, {"units": "m", "long_name": "placements of ratio 2"}),
                "curve_ratio": ("point", [r for r, _ in numbers], {"units": "1"}),
                "curve_coupling": (("point", "shape"), [g for _, g in numbers], {"units": "N V-1"}),
            },
            coords={
                "start": ("start", places, {"units": "m"}),
                "end": ("end", places, {"units": "m"}),
                "shape": [1, 2, 3],
            },
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """The ten placements of ratio two with the least |Gamma_31|, and the chosen one."""
        order = np.argsort(np.abs(data.curve_coupling.sel(shape=3).values))[:10]
        points = [*(data.isel(point=int(k)) for k in order), best(data)]
        return [
            {
                "start [mm]": 1e3 * float(point.curve[0]),
                "end [mm]": 1e3 * float(point.curve[1]),
                "f2/f1": float(point.curve_ratio),
                **{f"Gamma_{i}1 [N/V]": float(point.curve_coupling.sel(shape=i)) for i in (1, 2, 3)},
            }
            for point in points
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """The map with the curve, and the trade-off along it."""
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained")
        mesh = left.pcolormesh(
            1e3 * data.end, 1e3 * data.start, data.frequency_ratio, cmap="viridis", vmin=1.5, vmax=3.0
        )
        figure.colorbar(mesh, ax=left, label="$f_2/f_1$")
        left.plot(1e3 * data.curve[:, 1], 1e3 * data.curve[:, 0], "w.", markersize=3)
        chosen = best(data)
        left.plot(1e3 * chosen.curve[1], 1e3 * chosen.curve[0], "r*", markersize=9)
        left.set_xlabel("end of the patch (mm)")
        left.set_ylabel("start of the patch (mm)")
        weaker = np.abs(data.curve_coupling.sel(shape=[1, 2])).min("shape")
        right.plot(1e3 * np.abs(data.curve_coupling.sel(shape=3)), 1e3 * weaker, "o", markersize=3)
        right.plot(
            1e3 * abs(float(chosen.curve_coupling.sel(shape=3))),
            1e3 * float(np.abs(chosen.curve_coupling.sel(shape=[1, 2])).min()),
            "r*",
            markersize=9,
        )
        right.set_xlabel(r"$|\Gamma_{31}|$ (mN/V)")
        right.set_ylabel(r"weaker of $|\Gamma_{11}|$, $|\Gamma_{21}|$ (mN/V)")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """The placement that is recommended and what it costs."""
        point = best(data)
        first, second, third = (float(point.curve_coupling.sel(shape=i)) for i in (1, 2, 3))
        along = np.abs(data.curve_coupling)
        least = along.isel(point=int(along.sel(shape=3).values.argmin()))
        sentence = (
            f"Patches from {1e3 * float(point.curve[0]):.2f} to "
            f"{1e3 * float(point.curve[1]):.2f} mm have f2/f1 = {float(point.curve_ratio):.4f} with "
            f"couplings of {first:.4f}, {second:.4f} and {third:.4f} N/V. Along the curve |Gamma_31| is "
            f"{float(least.sel(shape=3)):.1e} N/V at least, where |Gamma_11| and |Gamma_21| are "
            f"{float(least.sel(shape=1)):.4f} and {float(least.sel(shape=2)):.4f} N/V."
        )
        return sentence, abs(float(point.curve_ratio) - 2.0) < 1e-3


if __name__ == "__main__":
    main(__file__)
