"""How the errors of a law hang on the impact: incidence, approach speed, slip."""

from typing import Final, NamedTuple

import numpy as np
import xarray

from contactlab.arrays import Array

BINS: Final = 8
FEWEST: Final = 10
"""Impacts in a bin, as long as there is more than one."""


class Binned(NamedTuple):
    """Medians and quartiles in bins of equal numbers, at the medians of what they are binned by."""

    at: Array
    median: Array
    low: Array
    high: Array


def abscissas(data: xarray.Dataset) -> dict[str, Array]:
    """Give what the impacts differ by, shape (impact,), by the words of an axis."""
    rate, slip = data["velocity_before"].values.T
    return {
        "incidence (°)": np.degrees(np.arctan2(np.abs(slip), -rate)),
        "approach (m/s)": -rate,
        "slip (m/s)": np.abs(slip),
    }


def residuals_of(data: xarray.Dataset, law: str) -> dict[str, Array]:
    """Give what a law misses, shape (impact,), by the words of an axis.

    The gap rate after it is measured less predicted; the slip too, with the sign that is positive along the
    slip before the impact.
    """
    missed = data["velocity_after"].values - data["predicted_velocity"].sel(law=law).values
    along = np.sign(data["velocity_before"].values[:, 1])
    return {
        "error": data["error"].sel(law=law).values,
        "gap rate missed (m/s)": missed[:, 0],
        "slip missed (m/s)": missed[:, 1] * along,
    }


def binned(x: Array, y: Array) -> Binned:
    """Bin one quantity by another."""
    count = int(np.clip(x.size // FEWEST, 1, BINS))
    parts = np.array_split(np.argsort(x, kind="stable"), count)
    low, median, high = np.array([np.quantile(y[part], [0.25, 0.5, 0.75]) for part in parts]).T
    return Binned(np.array([np.median(x[part]) for part in parts]), median, low, high)
