"""Findings and tables of a comparison: some five sentences for any number of laws."""

from collections.abc import Iterator
from itertools import combinations, product
from math import ceil, floor, isfinite, log, log10
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
    NONE,
    OUTCOMES,
    VARIES,
    VERDICTS as ORDERS,
    bins_of,
    looks_up_to,
)
from contactlab.inference.repeats import not_stated
from contactlab.metrics import FAIL, INVARIANTS, METRICS, NOT_APPLICABLE, REPORTED, VERDICTS, brief
from contactlab.studies.compare.scorecard import listed
from contactlab.studies.tables import UNIT, AtMost, table

TRANSIENT: Final = ("final_rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics of transients whose differences are reported."""

DIGITS: Final = 3
"""Digits of a metric: what is uncertain of a motor moves the third."""

ENDS: Final = {"low": "_low", "median": "", "high": "_high"}
"""Quantiles of the population that are shown, by their heads."""

NO_RESULT: Final = "without a steady state that is known well enough"
"""An outcome in words."""

MOST_PAIRS: Final = 30
"""Rows of the table of pairs beyond which it is one of reference."""


def findings(data: xarray.Dataset) -> list[str]:
    """Return what limits the comparison, classes and orders of the laws, and failed thresholds."""
    notes = " ".join(str(data.attrs["notes"]).splitlines())
    limits = str(data.attrs.get("limits", "")).splitlines()
    if "limits" not in data.attrs:
        sentences = _of_transients(data)
    elif "order" in data and data.sizes["law"] > 1:
        sentences = _of_pairs(data)
    else:
        sentences = _of_velocities(data)
    return [*filter(None, [*limits, *sentences, _thresholds(data), notes])]


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
    """Yield the orders in the motors drawn; size, factor and reversal of a difference; what has no order."""
    names, points = (list(map(str, data[x].values)) for x in ("law", "cell"))
    draws, velocity = data.sizes["draw"], data.sel(quantity="rotor_velocity")
    pairs = [*combinations(range(len(names)), 2)]
    whole = {pair: _over_grid(velocity["order"].values[pair]) for pair in pairs}
    sizes = np.nan_to_num(np.abs(velocity["relative_difference"].values).max(axis=-1))
    # One pair stands for all: the two laws that are farthest apart.
    a, b = sorted(map(int, np.unravel_index(int(sizes.argmax()), sizes.shape))) if sizes.any() else (0, 1)
    here = velocity.isel(law=a, other_law=b, cell=0)
    at = f" at {points[0]}" if len(points) > 1 else ""
    drawn = f"In the motors drawn{at} ({population(data)})"
    if not draws:
        yield "Nothing was drawn: the motor counts as exactly known, and no order of laws is stated."
    elif len(pairs) > 1:
        count = {kind: [*whole.values()].count(kind) for kind in KINDS}
        tests, looks = 2 * data["order"].isel(law=0, other_law=0).size * len(pairs), len(looks_up_to(draws))
        least = ceil(log((1.0 - LEVEL) / looks / tests) / log(AGREED))
        few = f" {draws} draws can show no order: it takes {least} at least." if draws < least else ""
        where = f"{drawn}, at each of {len(points)} operating points" if at else drawn
        kinds = listed([f"{n} {kind}" for kind, n in count.items() if n])
        yield f"{where}: of {len(pairs)} pairs {kinds}.{few}"
        drawn = "Farthest apart"
    if draws:
        yield _outcomes(data, here, drawn)
    yield _size(here)
    if draws:
        yield from _turns(here)
    if turned := [pair for pair, kind in whole.items() if kind == KINDS[3]]:
        a, b = turned[0]
        up, down = (points[list(velocity["order"].values[a, b]).index(kind)] for kind in (GREATER, LESS))
        yield f"{names[a]} is faster than {names[b]} at {up}, slower at {down}."
    spreads = dict(zip(names, velocity["spread"].max("cell").values.tolist(), strict=True))
    yield not_stated("order", spreads, "settled velocity", data.attrs["margin"])
    yield from _by_symmetry(data)


KINDS: Final = (
    "have one order in most motors",
    "are practically equal in most",
    "have no steady state in most",
    "reverse their order between operating points",
    "have an order that varies with what is drawn",
    "are inconclusive",
)
"""What a pair of laws is over all operating points."""


def _over_grid(order: Any) -> str:
    """Return the order of a pair over all operating points, one of `KINDS`."""
    kinds = set(order.tolist())
    ordered, equal, without, turned, varies, unknown = KINDS
    if {GREATER, LESS} <= kinds:
        return turned
    if len(kinds) == 1 and kinds & {EQUAL, NONE}:
        return equal if EQUAL in kinds else without
    if not kinds & {VARIES, INCONCLUSIVE}:
        return ordered if kinds <= {GREATER, LESS} else varies
    return varies if VARIES in kinds else unknown


def population(data: xarray.Dataset) -> str:
    """Return what the motors drawn differ in, and what they have as configured."""
    fixed = [data.attrs.get("not_varied", ""), "load, preload, tip and dimensions"]
    return f"{listed(list(data['prior'].values))}; as configured: {'; '.join(filter(None, fixed))}"


def _percent(data: xarray.Dataset) -> str:
    return f"{100.0 * data.attrs['margin']:.3g} %"


def _outcomes(data: xarray.Dataset, here: xarray.Dataset, drawn: str) -> str:
    """Return the outcomes of one pair in the motors drawn."""
    first, second = str(here["law"].item()), str(here["other_law"].item())
    times = [int((here["outcome"] == kind).sum()) for kind in range(len(OUTCOMES))]
    beyond = f"by more than {_percent(data)}"
    texts = f"faster {beyond}", f"slower {beyond}", f"equal within {_percent(data)}", NO_RESULT
    parts = [f"{text} in {number}" for text, number in zip(texts, times, strict=True) if number]
    most = f"that of at least {100 * AGREED:.0f} % of such motors"
    verdict = {
        VARIES: f"none of them is {most}",
        INCONCLUSIVE: f"inconclusive, as none is shown to be {most}",
    }
    which = int(np.argmax(times))
    low, high = (float(here[f"outcome_{end}"][which]) for end in ("low", "high"))
    return (
        f"{drawn}, {first} is, against {second}, {listed(parts)} of {sum(times)}. "
        f"The most frequent outcome has a probability of {low:.2f} to {high:.2f}: "
        f"{verdict.get(int(here['order']), f'it is {most}')}."
    )


def _size(here: xarray.Dataset) -> str:
    """Return the relative difference in speed of one pair."""
    low, middle, high, configured, other = (
        100.0 * float(here[f"relative_{name}"])
        for name in (*(f"difference{end}" for end in ENDS.values()), "nominal", "other")
    )
    width = high - low
    # The decimals that the width carries to its second digit.
    digits = max(1 - floor(log10(width)), 0) if width > 0.0 and isfinite(width) else 0
    text = f"{configured:+.{digits}f} % as configured"
    text += f" and {other:+.{digits}f} % on the other basis" if isfinite(other) else ""
    if isfinite(low):
        ends = f"{low:+.{digits}f} to {high:+.{digits}f} in nine of ten"
        text = f"{middle:+.{digits}f} % in the median motor ({ends}), {text}"
    return f"The difference in speed, in the sense in which the motor turns and over the larger, is {text}."


def _turns(here: xarray.Dataset) -> Iterator[str]:
    """Yield the factor that the outcome of one pair goes with."""
    shares, chance = here["factor_share"], float(here["chance_share"])
    if not shares.notnull().any():
        return
    number = int(shares.values.argmax())
    name, share = str(here["factor"].values[number]), float(shares[number])
    if share <= chance:
        yield f"What turns the outcome is not seen: no factor's share in it exceeds chance ({chance:.2f})."
        return
    values, outcome = here["drawn"].isel(factor=number).values, here["outcome"].values
    bins = bins_of(values)
    parts = [
        f"{(outcome[bins == n] == GREATER).sum()} and {(outcome[bins == n] == LESS).sum()} of "
        f"{(bins == n).sum()} up to {values[bins == n].max():.2g}"
        for n in range(int(bins.max()) + 1)
    ]
    yield (
        f"The outcome turns with the {name}, whose share in it is {share:.2f} (by chance {chance:.2f}): "
        f"faster and slower are {listed(parts)}."
    )


def _by_symmetry(data: xarray.Dataset) -> Iterator[str]:
    """Yield the reason why rigid laws that differ in impacts alone cannot differ in this motor."""
    group = data["law"].values[(data["rigid"] == 1) & (data["normal_tangential_coupling"] < 1e-9)]
    if len(group) > 1:
        yield (
            "The normal impulse of an impact does not change the slip in this motor (D_nt = 0): laws that "
            f"differ in that alone are one, among {listed(group.tolist())}."
        )


def _of_transients(data: xarray.Dataset) -> Iterator[str]:
    """Yield the differences of recorded runs."""
    for key in TRANSIENT:
        here, metric = data.sel(metric=key).dropna("law", subset=["value"]).sortby("value"), METRICS[key]
        values, laws = here["value"].values, here["law"].values
        if values.size > 1:
            same = f"{values[0]:.4g}{metric.unit} with every law"
            text = ends(values, laws, metric.unit, 4) if np.ptp(values) > 0.0 else same
            name = brief(metric.meaning)
            yield f"{name[0].upper()}{name[1:]}: {text}."


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


def tables(data: xarray.Dataset) -> dict[str, pandas.DataFrame]:
    """Return pairs of laws, plausibility, motion, where to measure, and the metrics."""
    every: dict[str, pandas.DataFrame] = {}
    if "order" in data and data.sizes["law"] > 1:
        every["pairs"] = _pairs(data)
    keys = list(map(str, data["metric"].values))
    judges = dict(zip(keys, data["judges_law"].values.astype(bool), strict=True))
    parts = {
        "invariants": [key for key in keys if key in INVARIANTS],
        "plausibility": [key for key in keys if judges[key] and key not in INVARIANTS],
        "motion": [key for key in keys if not judges[key]],
    }
    every |= {name: _scorecard(data, name, some) for name, some in parts.items()}
    names = {
        "metric": "metric",
        "symbol": "symbol",
        "meaning": "meaning",
        UNIT: "units",
        "must be": "threshold",
    }
    names |= {"reason": "reason", "beyond it": "conclusion", "source": "metric_source"}
    columns = {head: data[name].values for head, name in names.items()}
    every["metrics"] = table(columns, caption="Definitions of the metrics")
    every["metrics"].attrs["reference"] = True
    return every


def _scorecard(data: xarray.Dataset, name: str, keys: list[str]) -> pandas.DataFrame:
    """Return a row for each metric that a law has: value, error and verdict of each law."""
    rows, judged = [], name != "motion"
    for key in keys:
        here = data.sel(metric=key)
        if not here["value"].notnull().any():
            continue
        row: dict[str, Any] = {"metric": brief(str(here["meaning"].item())), UNIT: str(here["units"].item())}
        if judged:
            row["must be"] = AtMost.of_text(str(here["threshold"].item()))
        for law in map(str, data["law"].values):
            cell = here.sel(law=law)
            row[law] = Estimate(float(cell["value"]), float(cell["numerical_error"]))
            if judged:
                verdict = VERDICTS[int(cell["verdict"])]
                row[f"{law}: verdict"] = "" if verdict == REPORTED else verdict
        if name == "plausibility":
            row["reason"] = str(here["reason"].item())
        rows.append(row | {"key": key})
    frame = table(rows, caption=name.capitalize())
    frame.attrs |= {"digits": DIGITS, "reference": judged}
    return frame


def _pairs(data: xarray.Dataset) -> pandas.DataFrame:
    """Return a row for each quantity, operating point and pair of laws."""
    rows, outcomes = [], list(map(str, data["outcome_kind"].values))
    size = {f"{end} (%)": f"relative_difference{name}" for end, name in ENDS.items()}
    quantities, cells = range(data.sizes["quantity"]), range(data.sizes["cell"])
    for quantity, cell, (a, b) in product(quantities, cells, combinations(range(data.sizes["law"]), 2)):
        pair = data.isel(quantity=quantity, cell=cell, law=a, other_law=b)
        rows.append(
            {
                "quantity": str(pair["quantity"].item()).replace("_", " "),
                **({"at": str(pair["cell"].item())} if data.sizes["cell"] > 1 else {}),
                "law": str(pair["law"].item()),
                "against": str(pair["other_law"].item()),
                "order": ORDERS[int(pair["order"])],
                **{head: 100.0 * float(pair[name]) for head, name in size.items()},
                **{word: int((pair["outcome"] == kind).sum()) for kind, word in enumerate(outcomes)},
            }
        )
    caption = (
        f"Pairs of laws in {data.sizes['draw']} motors drawn: median, 5 and 95 % of the difference over "
        f"the larger, numbers of motors by outcome against the margin of {_percent(data)}"
    )
    frame = table(rows, caption=caption)
    frame.attrs |= {"digits": DIGITS, "reference": len(rows) > MOST_PAIRS}
    return frame
