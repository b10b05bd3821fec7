"""Findings and tables of a comparison: some five sentences for any number of laws."""

from collections.abc import Iterator
from itertools import combinations, product
from math import floor, isfinite, log10
from typing import Any, Final

import numpy as np
import pandas
import xarray

from contactlab.estimate import Estimate
from contactlab.metrics import FAIL, INVARIANTS, METRICS, NOT_APPLICABLE, REPORTED, VERDICTS, brief
from contactlab.studies.compare.paired import (
    AGREED,
    ALONE,
    AMONG,
    EQUAL,
    GREATER,
    INCONCLUSIVE,
    LESS,
    NONE,
    OUTCOMES,
    TOGETHER,
    VARIES,
    VERDICTS as ORDERS,
    bins_of,
    least_draws,
    looks_up_to,
    power,
)
from contactlab.studies.compare.pairs import WITHOUT_EFFECT
from contactlab.studies.compare.repeats import not_stated
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

NEARLY_ALL: Final = 0.95
"""Share of the motors with one order of which the page states how often it is seen."""

DECOUPLED: Final = 1e-9
"""D_nt over sqrt(D_nn D_tt) below which a normal impulse leaves the slip as it is."""

MOST_PAIRS: Final = 30
"""Rows of the table of pairs beyond which it is one of reference."""


def findings(data: xarray.Dataset) -> list[str]:
    """Return classes and orders of the laws, what limits the comparison, and failed thresholds."""
    notes = " ".join(str(data.attrs["notes"]).splitlines())
    limits = str(data.attrs.get("limits", "")).splitlines()
    if "limits" not in data.attrs:
        sentences = _of_transients(data)
    elif "order" in data and data.sizes["law"] > 1:
        sentences = _of_pairs(data)
    else:
        sentences = _of_velocities(data)
    return [*filter(None, [*sentences, *limits, _thresholds(data), notes])]


def ends(values: Any, laws: Any, unit: str, digits: int = 3) -> str:
    """Return the smallest and the largest value with their laws."""
    return f"{values[0]:.{digits}g} ({laws[0]}) to {values[-1]:.{digits}g}{unit} ({laws[-1]})"


def _of_velocities(data: xarray.Dataset) -> Iterator[str]:
    """Yield the settled velocity of one law, or the range of several of which nothing else is known."""
    here = data.sel(metric="rotor_velocity").dropna("law", subset=["value"]).sortby("value")
    values = here["value"].values
    if values.size == 1:
        velocity = Estimate(float(values[0]), float(here["numerical_error"][0]))
        yield f"Settled rotor velocity: {velocity.text()} rad/s."
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
    sizes = np.nan_to_num(velocity["relative_size"].values).max(axis=-1)
    # One pair stands for all: the two laws that are farthest apart, in whatever sense.
    a, b = sorted(map(int, np.unravel_index(int(sizes.argmax()), sizes.shape))) if sizes.any() else (0, 1)
    here = velocity.isel(law=a, other_law=b, cell=0)
    at = f" at {points[0]}" if len(points) > 1 else ""
    drawn = f"In the motors drawn{at} ({population(data)})"
    if not draws:
        yield "Nothing was drawn: the motor counts as exactly known, and no order of laws is stated."
    elif len(pairs) > 1:
        count = {kind: [*whole.values()].count(kind) for kind in KINDS}
        where = f"{drawn}, at each of {len(points)} operating points" if at else drawn
        kinds = listed([f"{n} {kind}" for kind, n in count.items() if n])
        yield f"{where}: of {len(pairs)} pairs {kinds}."
        drawn = "Farthest apart"
    if draws:
        yield f"{_outcomes(data, here, drawn)} {_power(data)}"
    yield _size(here)
    if draws:
        yield from _turns(here)
        yield from _idle(data)
    if turned := [pair for pair, kind in whole.items() if kind == KINDS[3]]:
        a, b = turned[0]
        up, down = (points[list(velocity["order"].values[a, b]).index(kind)] for kind in (GREATER, LESS))
        yield f"{names[a]} is faster than {names[b]} at {up}, slower at {down}."
    spreads = dict(zip(names, velocity["spread"].max("cell").values.tolist(), strict=True))
    yield not_stated("order", spreads, "settled velocity", data.attrs["margin"])
    yield from _alike(data)


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
    fixed = [data.attrs.get("not_varied", ""), data.attrs.get("held", "")]
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


def few_draws(samples: int, claims: int) -> str:
    """Return the sentence on draws that can show no order, of so many claims; empty of enough of them."""
    least = least_draws(claims, len(looks_up_to(samples)))
    return f"{samples} draws can show no order: it takes {least} at least." if samples < least else ""


def _power(data: xarray.Dataset) -> str:
    """Return how often the draws show an order that nearly all motors have."""
    samples, laws = int(data.attrs["samples"]), data.sizes["law"]
    claims = laws * (laws - 1) * data.sizes["cell"] * data.sizes["quantity"]
    return few_draws(samples, claims) or (
        f"Up to {samples} draws show an order that holds in {100 * NEARLY_ALL:.0f} of 100 motors with a "
        f"probability of {power(samples, claims, NEARLY_ALL):.2f}."
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
    text = f"{configured:+z.{digits}f} % as configured"
    text += f" and {other:+z.{digits}f} % on the other basis" if isfinite(other) else ""
    if isfinite(low):
        ends = f"{low:+z.{digits}f} to {high:+z.{digits}f} in nine of ten"
        size = f"; {100.0 * float(here['relative_size']):.{digits}f} % without its sign"
        text = f"{middle:+z.{digits}f} % in the median motor ({ends}{size}), {text}"
    return f"The difference in speed, in the sense in which the motor turns and over the larger, is {text}."


def _turns(here: xarray.Dataset) -> Iterator[str]:
    """Yield the factors that the outcome of one pair goes with."""
    shares, chance = here["factor_share"].values, float(here["chance_share"])
    if not np.isfinite(shares).any():
        return
    names, roles = here["factor"].values, here["factor_role"].values
    some = [int(n) for n in np.argsort(-shares, kind="stable") if roles[n]]
    several = listed([f"the {names[n]} ({shares[n]:.2f})" for n in some])
    if not some:
        yield (
            f"What turns the outcome is not seen: no factor's share in it exceeds chance ({chance:.2f}), nor "
            f"that of two together ({float(here['joint_chance_share']):.2f})."
        )
    elif roles[some[0]] == TOGETHER:
        joint = here["joint_share"].values
        a, b = np.unravel_index(int(np.nanargmax(joint)), joint.shape)
        yield (
            f"The outcome turns with no factor by itself (by chance {chance:.2f}), but with the {names[a]} "
            f"and the {names[b]} together, by the halves of both: their share in it is {joint[a, b]:.2f} "
            f"(by chance {float(here['joint_chance_share']):.2f})."
        )
    elif roles[some[0]] == AMONG:
        resamples = (
            f"the largest one is the same in {100.0 * float(here['leading_share']):.0f} % of resamples"
        )
        yield (
            f"The shares in the outcome of {several} exceed chance ({chance:.2f}), but which one is the "
            f"largest these draws do not show: {resamples}."
        )
    else:
        values, outcome = here["drawn"].isel(factor=some[0]).values, here["outcome"].values
        bins = bins_of(values)
        parts = [
            f"{(outcome[bins == n] == GREATER).sum()} and {(outcome[bins == n] == LESS).sum()} of "
            f"{(bins == n).sum()} up to {values[bins == n].max():.2g}"
            for n in range(int(bins.max()) + 1)
        ]
        yield (
            f"The outcome turns with the {names[some[0]]}, whose share in it is {shares[some[0]]:.2f} (by "
            f"chance {chance:.2f}): faster and slower are {listed(parts)}."
        )


def _idle(data: xarray.Dataset) -> Iterator[str]:
    """Yield the factors that change nothing in the motor as configured."""
    effect = data["effect"].max("law", skipna=False)
    if idle := list(map(str, data["moved_factor"].values[(effect < WITHOUT_EFFECT).values])):
        yield f"Without effect on any law in the motor as configured: {listed(idle)}."


def _alike(data: xarray.Dataset) -> Iterator[str]:
    """Yield the laws that have the same values in all motors, with the reason that symmetry has."""
    names = list(map(str, data["law"].values))
    apart = np.abs(
        np.concatenate([data["relative_drawn"].values, data["relative_nominal"].values[..., None]], -1)
    )
    known = np.isfinite(np.concatenate([data["drawn_value"].values, data["nominal"].values], axis=2))
    alike = [
        [
            bool(
                np.nanmax(apart[a, b], initial=0.0) == 0.0 and (known[a] == known[b]).all() and known[a].any()
            )
            for b in range(len(names))
        ]
        for a in range(len(names))
    ]
    groups = {tuple(np.flatnonzero(row).tolist()) for row in alike}
    # Some decoupled rigid laws differ in the slip that an impact leaves alone.
    decoupled = (data["rigid"].values == 1) & (data["normal_tangential_coupling"].values < DECOUPLED)
    for group in sorted(groups):
        if len(group) > 1:
            why = ": the normal impulse of an impact leaves the slip as it is (D_nt = 0)"
            yield (
                f"One law in all these motors, to nine digits, are {listed([names[n] for n in group])}"
                f"{why if decoupled[list(group)].all() else ''}."
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
    """Return pairs of laws, what turns them, plausibility, motion, and the metrics."""
    every: dict[str, pandas.DataFrame] = {}
    if "order" in data and data.sizes["law"] > 1:
        every["pairs"] = _pairs(data)
        if data["factor_share"].notnull().any():
            every["turning"] = _turning(data)
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


def _turning(data: xarray.Dataset) -> pandas.DataFrame:
    """Return a row for each quantity, operating point and pair of laws that has several outcomes."""
    rows, names = [], data["factor"].values
    quantities, cells = range(data.sizes["quantity"]), range(data.sizes["cell"])
    for quantity, cell, (a, b) in product(quantities, cells, combinations(range(data.sizes["law"]), 2)):
        pair = data.isel(quantity=quantity, cell=cell, law=a, other_law=b)
        shares, roles = pair["factor_share"].values, pair["factor_role"].values
        if not np.isfinite(shares).any():
            continue
        order = np.argsort(-shares, kind="stable")
        some = [str(names[n]) for n in order if roles[n]]
        word = {ALONE: "", AMONG: " or ", TOGETHER: " with "}.get(int(roles.max()), "")
        rows.append(
            {
                "quantity": str(pair["quantity"].item()).replace("_", " "),
                **({"at": str(pair["cell"].item())} if data.sizes["cell"] > 1 else {}),
                "law": str(pair["law"].item()),
                "against": str(pair["other_law"].item()),
                "order": ORDERS[int(pair["order"])],
                "turns with": word.join(some),
                "largest share": float(shares[order[0]]),
                "next": float(shares[order[1]]) if len(order) > 1 else np.nan,
                "of two": float(np.nanmax(pair["joint_share"].values)),
                "largest in all": float(np.nanmax(pair["total_share"].values)),
            }
        )
    chance, joint = (float(data[name]) for name in ("chance_share", "joint_chance_share"))
    caption = (
        "What turns the outcome of pairs: factors whose share in it exceeds chance, of one by itself "
        f"({chance:.2f}) or of the interaction of two ({joint:.2f}), which holds for all pairs here; the "
        "largest share, the next one, that of an interaction, and that of a factor with its interactions"
    )
    frame = table(rows, caption=caption)
    frame.attrs |= {"digits": 2, "reference": len(rows) > MOST_PAIRS}
    return frame
