"""Findings and tables of a comparison: ten sentences at most for any number of laws."""

from collections.abc import Iterator
from itertools import combinations, product
from math import ceil, floor, inf, isfinite, log, log10
from typing import Any, Final

import numpy as np
import pandas
import xarray

from contactlab.estimate import Estimate
from contactlab.inference.bootstrap import LEVEL
from contactlab.inference.paired import (
    AGREED,
    EQUAL,
    GREATER,
    INCONCLUSIVE,
    LESS,
    VARIES,
    VERDICTS as ORDERS,
    looks_up_to,
)
from contactlab.metrics import FAIL, INVARIANTS, METRICS, NOT_APPLICABLE, REPORTED, VERDICTS
from contactlab.studies.compare.pairs import CLEAR, MARGIN
from contactlab.studies.compare.scorecard import listed
from contactlab.studies.tables import UNIT, table

TRANSIENT: Final = ("final_rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics of transients whose differences are reported."""

TYPICAL_ERROR: Final = 0.03
"""Error of a measurement for which the best place to measure is named."""

STRONG: Final = 3.0
"""Log Bayes factor of strong evidence."""

MOST_PAIRS: Final = 30
"""Rows of the table of pairs beyond which it is one of reference."""


def findings(data: xarray.Dataset) -> list[str]:
    """Return what limits the comparison, classes and orders of the laws, and failed thresholds."""
    notes = str(data.attrs["notes"]).splitlines()
    limits = str(data.attrs.get("limits", "")).splitlines()
    if "limits" not in data.attrs:
        sentences = _of_transients(data)
    elif "order" in data and data.sizes["law"] > 1:
        sentences = _of_pairs(data)
    else:
        sentences = _of_velocities(data)
    return [*filter(None, [*limits, *sentences, _thresholds(data), " ".join(notes)])]


def ends(values: Any, laws: Any, unit: str, digits: int = 3) -> str:
    """Return the smallest and the largest value with their laws."""
    return f"{values[0]:.{digits}g} ({laws[0]}) to {values[-1]:.{digits}g}{unit} ({laws[-1]})"


def _of_velocities(data: xarray.Dataset) -> Iterator[str]:
    """Yield the settled velocity of one law, or the range of several of which nothing else is known."""
    here = data.sel(metric="rotor_velocity").dropna("law", subset=["value"]).sortby("value")
    values = here["value"].values
    if values.size == 1:
        velocity = Estimate(float(values[0]), float(here["numerical_error"][0]))
        text = velocity.text() if isfinite(velocity.error) else f"{velocity.value:.5g}"
        yield f"Settled rotor velocity: {text} rad/s."
    elif values.size:
        yield (
            f"Settled rotor velocity: {ends(values, here['law'].values, ' rad/s')}; neither numerical "
            "error nor what is uncertain of the motor was computed, so that no order of the laws is shown."
        )


def _of_pairs(data: xarray.Dataset) -> Iterator[str]:
    """Yield what was drawn, classes, orders, the operating grid, and where to measure."""
    names, points = (list(map(str, data[x].values)) for x in ("law", "cell"))
    draws = data.sizes["draw"]
    velocity = data.sel(quantity="rotor_velocity")
    fixed = data.attrs.get("not_varied", "")
    where = f" at each of {len(points)} operating points" if len(points) > 1 else ""
    yield (
        f"{draws} motors were drawn{where}, each under every law: {listed(list(data['prior'].values))}."
        + (f" Not varied: {fixed}." if fixed else "")
        if draws
        else "Nothing was drawn: the motor counts as exactly known, and no order of laws is shown."
    )
    yield from _classes(data, names)
    pairs = [*combinations(range(len(names)), 2)]
    whole = {pair: _over_grid(velocity["order"].values[pair]) for pair in pairs}
    if len(pairs) == 1:
        yield from _pair(velocity, 0, 1)
    else:
        count = {
            kind: [*whole.values()].count(kind) for kind in ("one", "equal", "reversed", "varies", "open")
        }
        tests, looks = len(pairs) * len(points), len(looks_up_to(draws))
        least = ceil(log((1.0 - LEVEL) / looks / tests) / log(AGREED))
        yield (
            f"Of {len(pairs)} pairs {count['one']} have one order of settled velocities in at least "
            f"{100 * AGREED:.0f} % of the motors{where}, {count['equal']} are equal, in {count['reversed']} "
            f"it reverses between operating points, in {count['varies']} it varies with what is drawn, and "
            f"{count['open']} are inconclusive (95 % for all pairs, Holm)."
            f"{f' {draws} draws can show no order: it takes {least} at least.' if draws < least else ''}"
        )
        sizes = np.abs(velocity["difference"].values).max(axis=-1)
        # One pair stands for its classes: the two laws that are farthest apart.
        if np.isfinite(sizes).any():
            first, second = np.unravel_index(int(np.nanargmax(sizes)), sizes.shape)
            yield from _pair(velocity, *sorted((int(first), int(second))))
    if reversed_pairs := [pair for pair, kind in whole.items() if kind == "reversed"]:
        difference = velocity["difference"].values
        a, b = max(
            reversed_pairs, key=lambda pair: float(np.nanmax(difference[pair]) * -np.nanmin(difference[pair]))
        )
        order = velocity["order"].values[a, b]
        up, down = (points[int(np.flatnonzero(order == kind)[0])] for kind in (GREATER, LESS))
        yield (
            f"{names[a]} has the greater velocity than {names[b]} at {up}, the smaller at {down}: no order "
            "holds for the motor as such."
        )
    if draws:
        yield from _best_measurement(data, points)


def _over_grid(order: Any) -> str:
    """Return the order of a pair over all operating points."""
    kinds = set(order.tolist())
    if {GREATER, LESS} <= kinds:
        return "reversed"
    if kinds == {EQUAL}:
        return "equal"
    if not kinds & {VARIES, INCONCLUSIVE}:
        return "one"
    return "varies" if VARIES in kinds else "open"


def _classes(data: xarray.Dataset, names: list[str]) -> Iterator[str]:
    """Yield the laws that are equal, with the reason where there is one."""
    number = data["class"].sel(quantity="rotor_velocity").values
    parts = []
    for each in np.unique(number):
        group = [names[i] for i in np.flatnonzero(number == each)]
        coupling = data["normal_tangential_coupling"].sel(law=group)
        reason = (
            " (by symmetry: an impact's normal impulse does not change the slip, D_nt = "
            f"{float(coupling.max()):.1g} of sqrt(D_nn D_tt))"
        )
        symmetric = bool((coupling < 1e-9).all() and data["rigid"].sel(law=group).all())
        parts += [f"{listed(group)}{reason if symmetric else ''}"] if len(group) > 1 else []
    if parts:
        yield (
            f"Equal in the settled velocity, within {CLEAR:g} numerical errors or {100.0 * MARGIN:g} % of "
            f"the velocity: {'; '.join(parts)}."
        )


def _pair(velocity: xarray.Dataset, a: int, b: int) -> Iterator[str]:
    """Yield size and sign of the difference of one pair, at the first operating point."""
    here = velocity.isel(law=a, other_law=b, cell=0)
    first, second = (str(velocity["law"].values[i]) for i in (a, b))
    at = f" at {velocity['cell'].values[0]}" if velocity.sizes["cell"] > 1 else ""
    head = f"{first} less {second}{at}: {float(here['difference']):.3g} rad/s"
    error = f"numerical error of the difference {float(here['difference_error']):.1g} rad/s"
    if not velocity.sizes["draw"]:
        yield f"{head}, {error}."
        return
    most = int(np.argmax(np.nan_to_num(here["sign_share"].values)))
    drawn = velocity["drawn_value"].isel(cell=0, law=[a, b]).values
    count = int(np.isfinite(drawn).all(axis=0).sum())
    parts = [
        f"{float(mean):.3g} +- {float(deviation):.2g} {'on the other basis' if n else 'as configured'}"
        for n, (mean, deviation) in enumerate(
            zip(here["basis_mean"].values, here["basis_deviation"].values, strict=True)
        )
        if isfinite(mean)
    ]
    share, low, high = (float(here[f"sign_{name}"][most]) for name in ("share", "low", "high"))
    sign = {"+": "positive", "-": "negative", "0": "none"}[str(velocity["sign"].values[most])]
    verdict = {
        GREATER: "the order is the laws'",
        LESS: "the order is the laws'",
        EQUAL: "the two are equal",
        VARIES: "the order depends on what is drawn",
        INCONCLUSIVE: "whether the order is the laws' is inconclusive",
    }[int(here["order"])]
    correlation = np.nan_to_num(np.abs(here["rank_correlation"].values))
    strongest = here["rank_correlation"].isel(factor=int(correlation.argmax()))
    follows = (
        f" Its size follows {strongest['factor'].item()} most (rank correlation {float(strongest):.2f})."
    )
    yield (
        f"{head} ({'; '.join(parts)}; {error}); the sign is {sign} in {round(share * count)} of {count} "
        f"draws, probability {low:.2f} to {high:.2f}: {verdict}.{follows if correlation.any() else ''}"
    )


def _best_measurement(data: xarray.Dataset, points: list[str]) -> Iterator[str]:
    """Yield the quantity and operating point that distinguishes laws best."""
    middle = median_factors(data).sel(measurement_error=TYPICAL_ERROR)
    if not middle.notnull().any():
        return
    place = middle.fillna(-inf).argmax(["cell", "quantity"])
    cell, quantity = int(place["cell"]), int(place["quantity"])
    at = f" at {points[cell]}" if len(points) > 1 else ""
    factor, name = float(middle[cell, quantity]), data["quantity_name"].values[quantity]
    yield (
        f"Of the quantities compared, one measurement of the {name}{at} with {100 * TYPICAL_ERROR:g} % error "
        f"distinguishes two laws best: its expected log Bayes factor is {rounded_down(factor)} for the "
        f"median pair ({'strong' if factor >= STRONG else 'weak'} evidence)."
    )


def median_factors(data: xarray.Dataset) -> xarray.DataArray:
    """Return the log Bayes factor of one measurement for the median pair of laws that are not equal."""
    return data["log_bayes_factor"].where(data["order"] != EQUAL).median(["law", "other_law"])


def _of_transients(data: xarray.Dataset) -> Iterator[str]:
    """Yield the differences of recorded runs."""
    for key in TRANSIENT:
        here, metric = data.sel(metric=key).dropna("law", subset=["value"]).sortby("value"), METRICS[key]
        values, laws = here["value"].values, here["law"].values
        if values.size > 1:
            same = f"{values[0]:.4g}{metric.unit} with every law"
            text = ends(values, laws, metric.unit, 4) if np.ptp(values) > 0.0 else same
            yield f"{metric.brief[0].upper()}{metric.brief[1:]}: {text}."


def _thresholds(data: xarray.Dataset) -> str:
    """Return the invariants and the thresholds of plausibility that laws fail, in one sentence each."""
    invariant = np.array([key in INVARIANTS for key in data["metric"].values])
    judged = data.isel(metric=np.flatnonzero(data["judges_law"].values.astype(bool) & ~invariant))
    applied = (judged["verdict"] != VERDICTS.index(NOT_APPLICABLE)).sum("metric").values
    number = " to ".join(dict.fromkeys(map(str, (applied.min(), applied.max()))))
    broken = _failed(data.isel(metric=np.flatnonzero(invariant)))
    return (
        f"Invariants: {broken + ': solver or file are wrong' if broken else 'all hold'}. "
        f"Of {judged.sizes['metric']} thresholds of plausibility {number} apply to a law; "
        f"{_failed(judged) or 'none is failed'}. That is judged in this motion alone."
    )


def _failed(judged: xarray.Dataset) -> str:
    """Return the laws with the metrics that they fail; empty where none does."""
    fails = judged["verdict"].values == VERDICTS.index(FAIL)
    failures = {
        law: judged["metric"].values[row].tolist()
        for law, row in zip(judged["law"].values, fails, strict=True)
    }
    return "; ".join(f"{law} fails {listed(keys)}" for law, keys in failures.items() if keys)


def rounded_down(value: float) -> str:
    """Write a number to three digits that reach no threshold which the number is below."""
    digit = 10.0 ** (floor(log10(abs(value))) - 2) if value else 1.0
    shown = round(value, 12 - floor(log10(digit))) if value else 0.0
    return f"{digit * floor(shown / digit * (1.0 + 1e-12)):.3g}"


def tables(data: xarray.Dataset) -> dict[str, pandas.DataFrame]:
    """Return scorecard, pairs of laws, where to measure, and the metrics."""
    every = {"scorecard": _scorecard(data)}
    if "order" in data:
        every["pairs"] = _pairs(data)
        if data.sizes["draw"] and data.sizes["law"] > 1:
            every["where_to_measure"] = _where_to_measure(data)
    names = {"metric": "metric", "symbol": "symbol", "meaning": "meaning", "must be": "threshold"}
    names |= {"reason": "reason", "beyond it": "conclusion", "source": "metric_source"}
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
    places = product(range(data.sizes["quantity"]), range(data.sizes["cell"]))
    for (quantity, cell), (a, b) in product(places, combinations(range(data.sizes["law"]), 2)):
        pair = data.isel(quantity=quantity, cell=cell, law=a, other_law=b)
        most = int(np.argmax(np.nan_to_num(pair["sign_share"].values)))
        known = {
            "difference": pair["difference"],
            "5 %": pair["difference_low"],
            "95 %": pair["difference_high"],
            "numerical error": pair["difference_error"],
        }
        numbers = {name: Estimate(float(x), np.nan) for name, x in known.items()}
        bases = {
            str(basis): Estimate(*map(float, each))
            for basis, *each in zip(
                data["basis"].values, pair["basis_mean"].values, pair["basis_deviation"].values, strict=True
            )
        }
        rows.append(
            {
                "quantity": str(pair["quantity"].item()).replace("_", " "),
                UNIT: str(pair["quantity_units"].item()),
                **({"at": str(pair["cell"].item())} if data.sizes["cell"] > 1 else {}),
                "law": str(pair["law"].item()),
                "less": str(pair["other_law"].item()),
                "order": ORDERS[int(pair["order"])],
                **numbers,
                **bases,
                "sign": str(data["sign"].values[most]),
                "share of draws": float(pair["sign_share"][most]),
                "at least": float(pair["sign_low"][most]),
                "p": float(pair["p_value"]),
            }
        )
    caption = (
        f"Differences of pairs of laws over {data.sizes['draw']} draws that serve all laws: median, 5 and "
        "95 %, mean and deviation on each basis, most frequent sign with the lower end of its 95 % interval, "
        "and p-value of no order, corrected for all pairs"
    )
    frame = table(rows, caption=caption)
    frame.attrs["reference"] = len(rows) > MOST_PAIRS
    return frame


def _where_to_measure(data: xarray.Dataset) -> pandas.DataFrame:
    """Return expected log Bayes factors by quantity and operating point, of the median and nearest pair."""
    rows = []
    factors = data["log_bayes_factor"].where(data["order"] != EQUAL)
    for quantity, cell in product(map(str, data["quantity"].values), range(data.sizes["cell"])):
        here = factors.sel(quantity=quantity).isel(cell=cell)
        at = str(data["cell"].values[cell]) or "as configured"
        row: dict[str, Any] = {"quantity": quantity.replace("_", " "), "at": at}
        for error in data["measurement_error"].values:
            each = here.sel(measurement_error=error)
            row[f"{100.0 * error:g} %, median pair"] = float(each.median())
            row[f"{100.0 * error:g} %, nearest pair"] = float(each.min())
        rows.append(row)
    return table(rows, caption="Expected log Bayes factor of one measurement by its error; 3 is strong")
