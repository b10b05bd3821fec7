"""Findings of a comparison, ten sentences at most for any number of laws."""

from collections.abc import Iterator
from itertools import combinations
from math import ceil, floor, inf, isfinite, log, log10
from typing import Any, Final

import numpy as np
import xarray

from contactlab.estimate import Estimate
from contactlab.inference.bootstrap import LEVEL
from contactlab.inference.paired import AGREED, EQUAL, GREATER, INCONCLUSIVE, LESS, VARIES, looks_up_to
from contactlab.metrics import FAIL, INVARIANTS, METRICS, NOT_APPLICABLE, VERDICTS
from contactlab.studies.compare.measured import nearest_laws
from contactlab.studies.compare.pairs import CLEAR, MARGIN
from contactlab.studies.compare.scorecard import listed

EQUALITY: Final = f"{CLEAR:g} numerical errors or {100.0 * MARGIN:g} % of the velocity"

TRANSIENT: Final = ("final_rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics of transients whose differences are reported."""

TYPICAL_ERROR: Final = 0.03
"""Error of a measurement for which the best place to measure is named."""


def findings(data: xarray.Dataset) -> list[str]:
    """Return what limits the comparison, classes and orders of the laws, and failed thresholds."""
    notes = str(data.attrs["notes"]).splitlines()
    limits = str(data.attrs.get("limits", "")).splitlines()
    if "limits" not in data.attrs:
        sentences = [*_of_transients(data)]
    elif "order" in data and data.sizes["law"] > 1:
        sentences = [*_of_pairs(data)]
    else:
        sentences = [*_values(data)]
    every = [*limits, *sentences, *nearest_laws(data), _thresholds(data)]
    return [*filter(None, every), *([" ".join(notes)] if notes else [])]


def ends(values: Any, laws: Any, unit: str, digits: int = 3) -> str:
    """Return the smallest and the largest value with their laws."""
    return f"{values[0]:.{digits}g} ({laws[0]}) to {values[1]:.{digits}g}{unit} ({laws[1]})"


def _values(data: xarray.Dataset) -> Iterator[str]:
    """Yield the settled velocity of one law, or the range of several of which nothing else is known."""
    here = data.sel(metric="rotor_velocity").dropna("law", subset=["value"]).sortby("value")
    values, laws = here["value"].values, here["law"].values
    if values.size == 1:
        velocity = Estimate(float(values[0]), float(here["numerical_error"][0]))
        text = velocity.text() if isfinite(velocity.error) else f"{velocity.value:.5g}"
        yield f"Settled rotor velocity: {text} rad/s."
    elif values.size:
        yield (
            f"Settled rotor velocity: {ends(values[[0, -1]], laws[[0, -1]], ' rad/s')}; neither numerical "
            "error nor what is uncertain of the motor was computed, so that no order of the laws is shown."
        )


def _of_pairs(data: xarray.Dataset) -> Iterator[str]:
    """Yield what was drawn, classes, orders, the operating grid, and where to measure."""
    names, points = (list(map(str, data[x].values)) for x in ("law", "cell"))
    draws = data.sizes["draw"]
    velocity = data.sel(quantity="rotor_velocity")
    order = velocity["order"].values
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
    whole = {pair: _over_grid(order[pair]) for pair in pairs}
    if len(pairs) == 1:
        yield from _pair(data, 0, 1)
    else:
        count = {
            kind: sum(x == kind for x in whole.values())
            for kind in ("one", "equal", "reversed", "varies", "open")
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
            yield from _pair(data, *sorted((int(first), int(second))))
    if len(points) > 1:
        yield from _reversals(velocity, names, points, whole)
    if draws:
        yield from _best_measurement(data, points)


def _over_grid(order: Any) -> str:
    """Return the order of a pair over all operating points."""
    kinds = set(order.tolist())
    if {GREATER, LESS} <= kinds:
        return "reversed"
    if kinds in ({GREATER}, {LESS}):
        return "one"
    if kinds == {EQUAL}:
        return "equal"
    return "varies" if VARIES in kinds else "open" if INCONCLUSIVE in kinds else "one"


def _classes(data: xarray.Dataset, names: list[str]) -> Iterator[str]:
    """Yield the laws that are equal, with the reason where there is one."""
    number = data["class"].sel(quantity="rotor_velocity").values
    groups = [[names[i] for i in np.flatnonzero(number == each)] for each in np.unique(number)]
    groups = [group for group in groups if len(group) > 1]
    if groups:
        coupling, rigid = data["normal_tangential_coupling"], data["rigid"]
        parts = []
        for group in groups:
            here = {"law": group}
            symmetric = bool((coupling.sel(here) < 1e-9).all() and rigid.sel(here).all())
            reason = (
                " (by symmetry: an impact's normal impulse does not change the slip, D_nt = "
                f"{float(coupling.sel(here).max()):.1g} of sqrt(D_nn D_tt))"
            )
            parts.append(f"{listed(group)}{reason if symmetric else ''}")
        yield f"Equal in the settled velocity, within {EQUALITY}: {'; '.join(parts)}."


def _pair(data: xarray.Dataset, a: int, b: int) -> Iterator[str]:
    """Yield size and sign of the difference of one pair, at the first operating point."""
    here = data.sel(quantity="rotor_velocity").isel(law=a, other_law=b, cell=0)
    first, second = (str(data["law"].values[i]) for i in (a, b))
    at = f" at {data['cell'].values[0]}" if data.sizes["cell"] > 1 else ""
    head = f"{first} less {second}{at}: {float(here['difference']):.3g} rad/s"
    error = f"numerical error of the difference {float(here['difference_error']):.1g} rad/s"
    if not data.sizes["draw"]:
        yield f"{head}, {error}."
        return
    most = int(np.argmax(np.nan_to_num(here["sign_share"].values)))
    drawn = data["drawn_value"].sel(quantity="rotor_velocity").isel(cell=0, law=[a, b]).values
    count = int(np.isfinite(drawn).all(axis=0).sum())
    parts = [
        f"{float(mean):.3g} +- {float(deviation):.2g} {'on the other basis' if n else 'as configured'}"
        for n, (mean, deviation) in enumerate(
            zip(here["basis_mean"].values, here["basis_deviation"].values, strict=True)
        )
        if isfinite(mean)
    ]
    share, low, high = (float(here[f"sign_{name}"][most]) for name in ("share", "low", "high"))
    sign = {"+": "positive", "-": "negative", "0": "none"}[str(data["sign"].values[most])]
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


def _reversals(
    velocity: xarray.Dataset, names: list[str], points: list[str], whole: dict[Any, str]
) -> Iterator[str]:
    """Yield an example of an order that reverses between operating points."""
    reversed_pairs = [pair for pair, kind in whole.items() if kind == "reversed"]
    if not reversed_pairs:
        return
    difference = velocity["difference"].values
    a, b = max(
        reversed_pairs, key=lambda pair: float(np.nanmax(difference[pair]) * -np.nanmin(difference[pair]))
    )
    order = velocity["order"].values[a, b]
    up, down = (points[int(np.flatnonzero(order == kind)[0])] for kind in (GREATER, LESS))
    yield (
        f"{names[a]} has the greater velocity than {names[b]} at {up}, the smaller at {down}: no order holds "
        "for the motor as such."
    )


def _best_measurement(data: xarray.Dataset, points: list[str]) -> Iterator[str]:
    """Yield the quantity and operating point that distinguishes laws best."""
    known = data["log_bayes_factor"].sel(measurement_error=TYPICAL_ERROR)
    middle = known.where(data["order"] != EQUAL).median(["law", "other_law"])
    if not middle.notnull().any():
        return
    place = middle.fillna(-inf).argmax(["cell", "quantity"])
    cell, quantity = int(place["cell"]), int(place["quantity"])
    at = f" at {points[cell]}" if len(points) > 1 else ""
    factor, name = float(middle[cell, quantity]), data["quantity_name"].values[quantity]
    yield (
        f"Of the quantities compared, one measurement of the {name}{at} with {100 * TYPICAL_ERROR:g} % error "
        f"distinguishes two laws best: its expected log Bayes factor is {rounded_down(factor)} for the "
        f"median pair ({'strong' if factor >= 3.0 else 'weak'} evidence)."
    )


def _of_transients(data: xarray.Dataset) -> Iterator[str]:
    """Yield the differences of transients, against the numerical errors alone."""
    for key in TRANSIENT:
        here, metric = data.sel(metric=key).dropna("law", subset=["value"]), METRICS[key]
        if here.sizes["law"] < 2:
            continue
        here = here.sortby("value")
        laws, values, errors = (here[name].values for name in ("law", "value", "numerical_error"))
        name, unit, size = _capital(metric.brief), metric.unit, values[-1] - values[0]
        if size == 0.0:
            yield f"{name}: {values[0]:.4g}{unit} with every law."
            continue
        start = f"{name}: {ends(values[[0, -1]], laws[[0, -1]], unit, 4)}"
        error = float(errors[0] + errors[-1])
        ratio = size / error if error > 0.0 else inf
        diverging = laws[(errors > np.abs(values)) & (values != 0.0)].tolist()
        if not isfinite(error):
            yield f"{start}; the numerical error is not known."
        elif ratio < 1.0 and diverging:
            yield f"{start}; with {listed(diverging)} it does not converge: its error exceeds its value."
        else:
            times = rounded_down(ratio) if ratio < 1e3 else "more than 1000"
            resolved = "resolved" if ratio >= CLEAR else "barely resolved" if ratio >= 1.0 else "not resolved"
            yield (
                f"{start}; the difference of the transients, {size:.3g}{unit}, is {times} times the "
                f"numerical errors and {resolved}; effects of basis, parameters and start are not computed."
            )


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
    failures = []
    for label in map(str, judged["law"].values):
        verdicts = [VERDICTS[flag] for flag in judged.sel(law=label)["verdict"].values]
        keys = judged["metric"].values[np.equal(verdicts, FAIL)]
        if keys.size:
            failures.append(f"{label} fails {listed([str(key) for key in keys])}")
    return "; ".join(failures)


def rounded_down(value: float) -> str:
    """Write a number to three digits that reach no threshold which the number is below."""
    digit = 10.0 ** (floor(log10(abs(value))) - 2) if value else 1.0
    shown = round(value, 12 - floor(log10(digit))) if value else 0.0
    return f"{digit * floor(shown / digit * (1.0 + 1e-12)):.3g}"


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]
