"""Findings of a comparison: which differences between laws are effects of the law.

A difference is an effect of the law if it exceeds the largest change that any other cause makes of either
law's value, and `CLEAR` times the numerical errors of both.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from math import inf, isfinite
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.metrics import FAIL, METRICS, NOT_APPLICABLE, PASS, VERDICTS, Metric
from contactlab.studies.compare_draws import BASIS
from contactlab.studies.compare_measured import nearest_laws
from contactlab.studies.compare_scorecard import (
    CAUSES,
    EVERY,
    NOT_KNOWN,
    NUMERICAL,
    PARAMETERS,
    START,
    listed,
)

CLEAR: Final = 3.0
"""Numerical errors that a difference between laws must exceed."""

WIDEST: Final = 0.3
"""Width of a 95 % interval beyond which a share is inconclusive: half of the variance could be a fifth of it
or four fifths."""

TRANSIENT: Final = ("final_rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics of transients whose differences are reported."""

NAMES: Final = {
    NUMERICAL: "the numerical error",
    BASIS: "the basis",
    PARAMETERS: "the parameters",
    START: "the start",
}


@final
@dataclass(frozen=True)
class Difference:
    """Difference of two laws in one quantity, and the largest change that each cause makes of either value.

    Args:
        metric: the quantity.
        laws: their labels, that of the smaller value first.
        values: in the same order, SI.
        effects: largest change by cause, for the numerical errors `CLEAR` times their sum; NaN if unknown.
        parameters: those drawn, as a text.
        diverging: laws whose value does not converge.
        recorded: laws whose value is that of the run as recorded, which may not have settled.
        fixed: parameters that were not varied, with their laws.
    """

    metric: Metric
    laws: tuple[str, str]
    values: tuple[float, float]
    effects: Mapping[str, float]
    parameters: str = ""
    diverging: tuple[str, ...] = ()
    recorded: tuple[str, ...] = ()
    fixed: str = ""

    @property
    def size(self) -> float:
        """The difference."""
        return self.values[1] - self.values[0]

    @property
    def unknown(self) -> list[str]:
        """Causes whose effect is not known."""
        return [cause for cause in CAUSES if not isfinite(self.effects[cause])]

    @property
    def possible(self) -> list[str]:
        """Causes that may explain the difference, the largest first."""
        return [cause for cause in self._largest_first if self.effects[cause] >= self.size]

    @property
    def _largest_first(self) -> list[str]:
        return sorted(CAUSES, key=lambda cause: -self.effects[cause])

    @property
    def due_to_law(self) -> bool:
        """Whether the difference exceeds the effects of all other causes."""
        return self.size > 0.0 and not self.unknown and not self.possible

    def __str__(self) -> str:
        name = _capital(self.metric.brief)
        if self.metric.key == "rotor_velocity":
            settled = f"Rotor velocity ({listed(self.recorded)} as recorded)"
            name = settled if self.recorded else "Settled rotor velocity"
        if self.size == 0.0:
            return f"{name}: {self.values[0]:.3g}{self.metric.unit} with every law."
        return (
            f"{name}: {ends(self.values, self.laws, self.metric.unit)}, {self.size:.2g} apart. {self.verdict}"
        )

    @property
    def verdict(self) -> str:
        """Whether the difference is an effect of the law, and what else may explain it."""
        if self.diverging:
            return (
                f"With {listed(self.diverging)} it does not converge: its numerical error exceeds its value."
            )
        if len(self.unknown) == len(CAUSES):
            return "No other cause was computed, so an effect of the law is not shown."
        if self.due_to_law:
            causes = listed([*map(self._with_effect, self._largest_first)])
            return f"It is an effect of the law: every other cause has a smaller effect, {causes}." + (
                f" Not varied: {self.fixed}." if self.fixed else ""
            )
        parts = []
        if self.possible:
            parts.append(f"may be {' or '.join(map(self._with_effect, self.possible))}")
        if self.unknown:
            names = listed([NAMES[cause] for cause in self.unknown])
            parts.append(f"was not compared with the effect of {names}")
        return f"It {', and '.join(parts)}, so an effect of the law is not shown."

    def _with_effect(self, cause: str) -> str:
        """Return the name of a cause with its effect."""
        name, effect = NAMES[cause], self.effects[cause]
        if cause == NUMERICAL:
            return f"{name} ({CLEAR:g} times {effect / CLEAR:.2g})"
        if cause == PARAMETERS and self.parameters:
            name = f"{self.parameters} within {'their ranges' if ' and ' in self.parameters else 'its range'}"
        return f"{name} ({effect:.2g})"


def ends(values: Any, laws: Any, unit: str, digits: int = 3) -> str:
    """Return the smallest and the largest value with their laws."""
    return f"{values[0]:.{digits}g} ({laws[0]}) to {values[1]:.{digits}g}{unit} ({laws[1]})"


def largest_differences(data: xarray.Dataset) -> list[Difference]:
    """Return the difference of the outermost laws in each quantity that two of them have."""
    result = []
    for key in map(str, data["quantity"].values):
        values = data["value"].sel(metric=key).dropna("law")
        if values.size > 1:
            result.append(_difference(data, key, str(values.idxmin().item()), str(values.idxmax().item())))
    return result


def all_differences(data: xarray.Dataset, key: str = "rotor_velocity") -> list[Difference]:
    """Return the differences of all pairs of laws that have a quantity."""
    values = data["value"].sel(metric=key).dropna("law")
    laws = values.sortby(values)["law"].values
    return [_difference(data, key, str(a), str(b)) for a, b in combinations(laws, 2)]


def _difference(data: xarray.Dataset, key: str, low: str, high: str) -> Difference:
    # All have the same value if the smallest is the largest: then any other law is the second.
    both = data.sel(law=[low, high])
    values, of_quantity = both["value"].sel(metric=key).values, both.sel(quantity=key)
    changes = np.maximum(
        of_quantity["greatest"].values - values[:, None], values[:, None] - of_quantity["least"].values
    )
    # What is not known of one law is not known of both.
    effects = dict(zip(CAUSES, changes.max(axis=0).tolist(), strict=True))
    errors = changes[:, CAUSES.index(NUMERICAL)]
    effects[NUMERICAL] = CLEAR * float(errors.sum())
    diverging = tuple(law for law, x, e in zip((low, high), values, errors, strict=True) if e > abs(x) > 0.0)
    ranges = ", ".join(filter(None, map(str, both["varied"].values))).split(", ")
    names = [*dict.fromkeys(part.split(" +-")[0] for part in ranges if part)]
    return Difference(
        METRICS[key],
        (low, high),
        (float(values[0]), float(values[1])),
        effects,
        f"the {listed(names)}" if names else "",
        diverging if effects[NUMERICAL] >= float(values[1] - values[0]) else (),
        tuple(law for law, kind in zip((low, high), both["kind"].values, strict=True) if kind == NOT_KNOWN),
        _not_varied(both),
    )


def _not_varied(data: xarray.Dataset) -> str:
    laws = zip(data["law"].values, data["not_varied"].values, strict=True)
    return listed([f"{names} of {law}" for law, names in laws if names])


def findings(data: xarray.Dataset) -> list[str]:
    """Return what limits the comparison, the differences with their causes, and failed thresholds."""
    first = data.attrs.get("first", "").splitlines()
    differences = _of_settled(data) if "cause" in data.dims else _of_transients(data)
    notes = str(data.attrs["notes"]).splitlines()
    return [*filter(None, [*first, *differences, *nearest_laws(data), *_thresholds(data), *notes])]


def _of_settled(data: xarray.Dataset) -> Iterator[str]:
    velocity, *others = [*map(str, largest_differences(data))] or [""]
    yield velocity
    yield _on_other_basis(data)
    pairs = all_differences(data)
    widest = max((pair.size for pair in pairs), default=0.0)
    for pair in pairs:
        if pair.size < widest:
            yield f"Between {listed(pair.laws)}: {pair.size:.2g} rad/s apart. {pair.verdict}"
    yield from others
    if fixed := _not_varied(data):
        yield f"Not varied: {fixed}. The option range=law.NAME=SHARE varies a parameter."
    yield shares_sentence(data)


def _on_other_basis(data: xarray.Dataset) -> str:
    """Return how far the outermost laws are apart on the other basis; empty if not known."""
    here = data.sel(cause=BASIS, quantity="rotor_velocity")
    # An end of the range is the value itself.
    values = here["least"] + here["greatest"] - data["value"].sel(metric="rotor_velocity")
    known = values.dropna("law")
    if known.size < 2:
        return ""
    known = known.sortby(known).isel(law=[0, -1])
    (low, high), laws = known.values.tolist(), known["law"].values
    return f"On the other basis: {ends((low, high), laws, ' rad/s')}, {high - low:.2g} apart."


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
            times = f"{ratio:.2g}" if ratio < 1e3 else "more than 1000"
            resolved = "resolved" if ratio >= CLEAR else "barely resolved" if ratio >= 1.0 else "not resolved"
            yield (
                f"{start}; the difference of the transients, {size:.3g}{unit}, is {times} times the "
                f"numerical errors and {resolved}; effects of basis, parameters and start are not computed."
            )


def _thresholds(data: xarray.Dataset) -> Iterator[str]:
    """Yield the number of thresholds that each law meets, and those that it fails."""
    judged = data.isel(metric=np.flatnonzero(data["judges_law"].values))
    parts, failures = [], []
    for label in map(str, data["law"].values):
        law = judged.sel(law=label)
        verdicts = [VERDICTS[flag] for flag in law["verdict"].values]
        met, failed, absent = (verdicts.count(verdict) for verdict in (PASS, FAIL, NOT_APPLICABLE))
        parts.append(f"{label} meets {met}, fails {failed}, and {absent} do not apply")
        for key in law["metric"].values[np.equal(verdicts, FAIL)]:
            cell, metric = law.sel(metric=key), EVERY[str(key)]
            value, error, unit = float(cell["value"]), float(cell["numerical_error"]), metric.unit
            within = abs(value - metric.bound) < error < inf
            doubt = f", within its numerical error of {error:.2g}" if within else ""
            failures.append(
                f"{label} fails {key} ({metric.brief}): {value:.4g}{unit}; it must be "
                f"{metric.threshold}{unit}{doubt}. {_capital(metric.reason)}."
            )
    yield f"Of {judged.sizes['metric']} plausibility thresholds {'; '.join(parts)}."
    yield from failures


def shares_sentence(data: xarray.Dataset) -> str:
    """Return the shares of the factors in the variance of the settled velocity; empty without draws."""
    if "total_order" not in data:
        return ""
    estimates = data["total_order"].sel(quantity="rotor_velocity").values
    if not np.isfinite(estimates).all():
        return "The settled rotor velocity does not vary over the draws, or too few motors settle."
    names, count = data["factor"].values.astype(str), sample_count(data)
    order = np.argsort(-estimates[:, 0], kind="stable")
    clear = [f"{names[i]} {written_share(*estimates[i])}" for i in order if not unclear(*estimates[i, 1:])]
    withheld = [str(names[i]) for i in order if unclear(*estimates[i, 1:])]
    parts = [f"{'; '.join(clear)}."] if clear else []
    if withheld:
        enough = samples_needed(estimates, count)
        parts.append(
            f"{count} samples are inconclusive on {listed(withheld)}; about {enough} are needed "
            f"(samples={enough})."
        )
    return (
        "Shares in the variance of the settled rotor velocity, interactions included, with 95 % intervals: "
        f"{' '.join(parts)}"
    )


def sample_count(data: xarray.Dataset) -> int:
    """Return the number of rows of the design from which shares were estimated."""
    return int(data.sizes["draw"]) // (int(data.sizes["factor"]) + 2)


def unclear(low: float, high: float) -> bool:
    """Return whether the interval of a share is too wide, or entirely outside 0 to 1."""
    return not (high - low <= WIDEST and high >= 0.0 and low <= 1.0)


def written_share(share: float, low: float, high: float) -> str:
    """Return a share with its interval; a bound if the interval reaches 0 or 1."""
    if low <= 0.0:
        return f"below {max(high, 0.01):.2f}"
    return f"above {low:.2f}" if high >= 1.0 else f"{share:.2f} ({low:.2f} to {high:.2f})"


def samples_needed(estimates: Array, count: int) -> int:
    """Return the power of two of samples that makes every interval narrow enough, as 1/sqrt(count).

    Args:
        estimates: shares with their intervals, shape (factor, 3).
        count: samples that they were estimated from.
    """
    width = float((estimates[:, 2] - estimates[:, 1]).max())
    ratio = max((width / WIDEST) ** 2, 2.0)
    return count * 1 << int(np.ceil(np.log2(ratio)))


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]
