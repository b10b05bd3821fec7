"""A difference between laws held against all that could explain it: what is the law's, and what is not shown.

A difference is due to the law where it is larger than the largest change that any other cause makes of
either law's value, and than `CLEAR` times the numerical errors of both. What was not tried may explain it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from math import isfinite
from typing import Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.comparison.causes import ATTRACTORS, BASIS, CAUSES, NOT_KNOWN, NUMERICAL, PARAMETERS, listed
from contactlab.metrics import METRICS, Metric

CLEAR: Final = 3.0  # numerical errors beyond which a difference is one between the laws
WIDEST: Final = 0.3
"""Width of a 95 % interval of a share beyond which the share is not shown: the half of a variance could not
be told from a fifth or four fifths."""


@final
@dataclass(frozen=True)
class Weighed:
    """One quantity of two laws: how far they are apart, and how far each cause moves either.

    Args:
        metric: the quantity.
        laws: their labels, that of the smaller value first.
        values: in the same order, SI.
        weights: by cause, that of the numerical errors `CLEAR` times their sum; NaN where it is not known.
        parameters: what was drawn of them, in words.
        lost: laws whose value does not converge.
        recorded: laws whose value is that of the run as recorded, which may not have settled.
        fixed: parameters that were not varied, by law.
    """

    metric: Metric
    laws: tuple[str, str]
    values: tuple[float, float]
    weights: dict[str, float]
    parameters: str
    lost: tuple[str, ...]
    recorded: tuple[str, ...] = ()
    fixed: Mapping[str, str] = field(default_factory=dict)

    @property
    def apart(self) -> float:
        """Difference of the two."""
        return self.values[1] - self.values[0]

    @property
    def unknown(self) -> list[str]:
        """Causes whose weight is not known."""
        return [cause for cause in CAUSES if not isfinite(self.weights[cause])]

    @property
    def possible(self) -> list[str]:
        """Causes that could explain the difference, the largest first."""
        found = [cause for cause in CAUSES if self.weights[cause] >= self.apart]
        return sorted(found, key=lambda cause: -self.weights[cause])

    @property
    def due_to_law(self) -> bool:
        """Whether the difference stands above everything else."""
        return self.apart > 0.0 and not self.unknown and not self.possible

    def __str__(self) -> str:
        name, unit = self.metric.brief[0].upper() + self.metric.brief[1:], self.metric.unit
        if self.metric.key == "rotor_velocity":
            name = f"{'Rotor' if self.recorded else 'Settled rotor'} velocity"
            name += f" ({listed(self.recorded)} as recorded)" if self.recorded else ""
        (low, high), (one, other) = self.laws, self.values
        if self.apart == 0.0:
            return f"{name}: {one:.3g}{unit} with every law."
        said = f"{name}: {one:.3g} ({low}) to {other:.3g}{unit} ({high}), {self.apart:.2g} apart."
        return f"{said} {self.verdict}"

    @property
    def verdict(self) -> str:
        """What the difference is due to, or may be."""
        if self.lost:
            return (
                f"With {listed(self.lost)} it does not converge: its numerical error is larger than itself, "
                "and no value is known."
            )
        if len(self.unknown) == len(CAUSES):
            return (
                "Nothing is known of what else could explain it, neither numerical errors nor basis, "
                "parameters and other starts, so it is not shown to be due to the law."
            )
        if self.due_to_law:
            less = sorted(CAUSES, key=lambda cause: -self.weights[cause])
            named = listed([self._named(cause) for cause in less])
            fixed = listed([f"{names} of {law}" for law, names in self.fixed.items()]) if self.fixed else ""
            but = f" Not varied: {fixed}." if fixed else ""
            return f"It is due to the law: all else moves it less, {named}.{but}"
        parts = []
        if self.possible:
            parts.append(f"may be {' or '.join(map(self._named, self.possible))}")
        if self.unknown:
            verb = "do" if len(self.unknown) > 1 or PARAMETERS in self.unknown else "does"
            parts.append(f"was not weighed against what {listed([_WORDS[c] for c in self.unknown])} {verb}")
        return f"It {', and '.join(parts)}, so it is not shown to be due to the law."

    def _named(self, cause: str) -> str:
        """Name a cause with its weight."""
        words = _WORDS[cause]
        if cause == PARAMETERS:
            several = " and " in self.parameters
            within = "within their ranges" if several else "within its range"
            words = f"{self.parameters} {within}" if self.parameters else "the parameters"
        sign = f"{CLEAR:g} times " if cause == NUMERICAL else ""
        weight = self.weights[cause] / CLEAR if cause == NUMERICAL else self.weights[cause]
        return f"{words} ({sign}{weight:.2g})"


_WORDS: Final = {
    NUMERICAL: "the numerical error",
    BASIS: "the basis",
    PARAMETERS: "the parameters",
    ATTRACTORS: "the start",
}


def weighed(data: xarray.Dataset) -> list[Weighed]:
    """Give the laws that are furthest apart, of every quantity that two of them have."""
    found = []
    for key in map(str, data["quantity"].values):
        values = data["value"].sel(metric=key)
        known = values.where(np.isfinite(values), drop=True)
        if known.size > 1:
            found.append(_pair(data, key, str(known.idxmin().item()), str(known.idxmax().item())))
    return found


def on_other_basis(data: xarray.Dataset) -> str:
    """Say how far the outermost laws are apart where their basis is the other one; empty if not known."""
    key, ends = "rotor_velocity", {}
    value = data["value"].sel(metric=key)
    for label in data["law"].values:
        here = data.sel(law=label, cause=BASIS, quantity=key)
        # One end is the value itself.
        reached = float(here["least"] + here["greatest"] - value.sel(law=label))
        if isfinite(reached):
            ends[str(label)] = reached
    if len(ends) < 2:
        return ""
    low, *_, high = sorted(ends, key=lambda label: ends[label])
    return (
        f"On the other basis: {ends[low]:.3g} ({low}) to {ends[high]:.3g} rad/s ({high}), "
        f"{ends[high] - ends[low]:.2g} apart."
    )


def pairs(data: xarray.Dataset, key: str = "rotor_velocity") -> list[Weighed]:
    """Give every two laws that have a quantity."""
    values = data["value"].sel(metric=key)
    known = values.where(np.isfinite(values), drop=True).sortby(values)
    return [_pair(data, key, str(a), str(b)) for a, b in combinations(known["law"].values, 2)]


def _pair(data: xarray.Dataset, key: str, low: str, high: str) -> Weighed:
    """Weigh one quantity of two laws."""
    # All have one value where the smallest is the largest: then any other law is the second.
    both = data.sel(law=[low, high])
    values, of_quantity = both["value"].sel(metric=key).values, both.sel(quantity=key)
    moved = np.maximum(
        of_quantity["greatest"].values - values[:, None], values[:, None] - of_quantity["least"].values
    )
    # What is not known of one law is not known of both.
    weights = dict(zip(CAUSES, moved.max(axis=0).tolist(), strict=True))
    errors = moved[:, CAUSES.index(NUMERICAL)]
    weights[NUMERICAL] = CLEAR * float(errors.sum())
    lost = tuple(law for law, x, e in zip((low, high), values, errors, strict=True) if e > abs(x) > 0.0)
    apart = float(values[1] - values[0])
    spread = (str(name) for name in both["varied"].values if name)
    names = dict.fromkeys(part.split(" +-")[0] for name in spread for part in name.split(", "))
    drawn = f"the {listed([*names])}" if names else ""
    fixed = {law: str(names) for law, names in zip((low, high), both["not_varied"].values, strict=True)}
    return Weighed(
        METRICS[key],
        (low, high),
        (float(values[0]), float(values[1])),
        weights,
        drawn,
        lost if weights[NUMERICAL] >= apart else (),
        tuple(law for law, kind in zip((low, high), both["kind"].values, strict=True) if kind == NOT_KNOWN),
        {law: names for law, names in fixed.items() if names},
    )


def shares_said(data: xarray.Dataset) -> str:
    """Say what the factors have of the variance of the settled velocity; empty where nothing was drawn."""
    if "total_order" not in data:
        return ""
    estimates = data["total_order"].sel(quantity="rotor_velocity").values
    if not np.isfinite(estimates).all():
        return "The settled rotor velocity is the same whatever is drawn, or too few motors settle."
    names, count = data["factor"].values.astype(str), sample_count(data)
    order = np.argsort(-estimates[:, 0], kind="stable")
    clear = [f"{names[i]} {written_share(*estimates[i])}" for i in order if not unclear(*estimates[i, 1:])]
    withheld = [str(names[i]) for i in order if unclear(*estimates[i, 1:])]
    parts = [f"{'; '.join(clear)}."] if clear else []
    if withheld:
        enough = samples_needed(estimates, count)
        parts.append(
            f"{count} samples do not tell the share of {listed(withheld)}; about {enough} would "
            f"(--samples {enough})."
        )
    return (
        "Shares in the variance of the settled rotor velocity, each with what it does together with others "
        f"and its 95 % interval: {' '.join(parts)}"
    )


def sample_count(data: xarray.Dataset) -> int:
    """Return the number of rows of the design from which shares were estimated."""
    return int(data.sizes["motor"]) // (int(data.sizes["factor"]) + 2)


def unclear(low: float, high: float) -> bool:
    """Return whether the interval of a share is too wide, or lies outside 0 to 1 altogether."""
    return not (high - low <= WIDEST and high >= 0.0 and low <= 1.0)


def written_share(share: float, low: float, high: float) -> str:
    """Write a share with its interval; one whose interval reaches 0 or 1 by its other end."""
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
