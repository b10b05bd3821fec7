"""Tables of a comparison."""

from itertools import combinations
from typing import Any

import numpy as np
import pandas
import xarray

from contactlab.estimate import Estimate
from contactlab.inference.paired import VERDICTS as ORDERS
from contactlab.metrics import REPORTED, VERDICTS
from contactlab.studies.tables import UNIT, table


def tables(data: xarray.Dataset) -> dict[str, pandas.DataFrame]:
    """Return scorecard, pairs of laws, where to measure, files of measurements, and the metrics."""
    every = {"scorecard": _scorecard(data)}
    if "order" in data:
        every["pairs"] = _pairs(data)
        if data.sizes["draw"] and data.sizes["law"] > 1:
            every["where_to_measure"] = _where_to_measure(data)
    if "measured" in data.dims:
        names = {"title": "measured", "contents": "measured_contents", "source": "measured_source"}
        names |= {"file": "measured_file", "SHA-256": "measured_digest"}
        caption = "Measurements; the errors of their rows are half of a 95 % interval by resampling"
        every["measurements"] = table({head: data[x].values for head, x in names.items()}, caption=caption)
    names = {"metric": "metric", "symbol": "symbol", "meaning": "meaning"}
    names |= {"must be": "threshold", "reason": "reason", "beyond it": "conclusion"}
    names |= {"source": "metric_source"}
    columns = {head: data[name].values for head, name in names.items()}
    every["metrics"] = table(columns, caption="Definitions of the metrics")
    every["metrics"].attrs["reference"] = True
    return every


def _scorecard(data: xarray.Dataset) -> pandas.DataFrame:
    """Return a row for each metric: value, error and verdict of each law."""
    rows = []
    for key in map(str, data["metric"].values):
        here = data.sel(metric=key)
        row: dict[str, Any] = {
            "metric": key,
            UNIT: str(here["units"].item()),
            "must be": str(here["threshold"].item()),
        }
        for law in map(str, data["law"].values):
            cell = here.sel(law=law)
            verdict = VERDICTS[int(cell["verdict"])]
            row[law] = Estimate(float(cell["value"]), float(cell["numerical_error"]))
            row[f"{law}: verdict"] = "" if verdict == REPORTED else verdict
        rows.append(row)
    return table(rows, caption="Scorecard")


def _pairs(data: xarray.Dataset) -> pandas.DataFrame:
    """Return a row for each quantity, operating point and pair of laws."""
    rows = []
    laws, cells = (list(map(str, data[name].values)) for name in ("law", "cell"))
    for quantity in map(str, data["quantity"].values):
        here = data.sel(quantity=quantity)
        for (i, cell), (a, b) in (
            (x, y) for x in enumerate(cells) for y in combinations(range(len(laws)), 2)
        ):
            pair = here.isel(cell=i, law=a, other_law=b)
            most = int(np.argmax(np.nan_to_num(pair["sign_share"].values)))
            bases = zip(pair["basis_mean"].values, pair["basis_deviation"].values, strict=True)
            row: dict[str, Any] = {
                "quantity": quantity.replace("_", " "),
                UNIT: str(here["quantity_units"].item()),
            }
            if len(cells) > 1:
                row["at"] = cell
            row |= {"law": laws[a], "less": laws[b]}
            row |= {"order": ORDERS[int(pair["order"])]}
            row["difference"] = Estimate(float(pair["difference"]), np.nan)
            row |= {"5 %": Estimate(float(pair["difference_low"]), np.nan)}
            row |= {"95 %": Estimate(float(pair["difference_high"]), np.nan)}
            for basis, each in zip(map(str, data["basis"].values), bases, strict=True):
                row[basis] = Estimate(*map(float, each))
            row["numerical error"] = Estimate(float(pair["difference_error"]), np.nan)
            row["sign"] = str(data["sign"].values[most])
            row["share of draws"] = float(pair["sign_share"][most])
            row["at least"] = float(pair["sign_low"][most])
            row["p"] = float(pair["p_value"])
            rows.append(row)
    caption = (
        f"Differences of pairs of laws over {data.sizes['draw']} draws that serve all laws: median, 5 and "
        "95 %, mean and deviation on each basis, most frequent sign with the lower end of its 95 % interval, "
        "and p-value of no order, corrected for all pairs"
    )
    frame = table(rows, caption=caption)
    frame.attrs["reference"] = len(rows) > 30
    return frame


def _where_to_measure(data: xarray.Dataset) -> pandas.DataFrame:
    """Return expected log Bayes factors by quantity and operating point, of the pair that is nearest."""
    rows = []
    factors = data["log_bayes_factor"].where(data["order"] != ORDERS.index("equal"))
    for quantity in map(str, data["quantity"].values):
        for i, cell in enumerate(map(str, data["cell"].values)):
            here = factors.sel(quantity=quantity).isel(cell=i)
            row: dict[str, Any] = {"quantity": quantity.replace("_", " "), "at": cell or "as configured"}
            for error in data["measurement_error"].values:
                each = here.sel(measurement_error=error)
                row[f"{100.0 * error:g} %, median pair"] = float(each.median())
                row[f"{100.0 * error:g} %, nearest pair"] = float(each.min())
            rows.append(row)
    return table(rows, caption="Expected log Bayes factor of one measurement by its error; 3 is strong")
