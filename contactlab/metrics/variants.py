"""How a law's answers depend on what is known least: the basis of the resonator and the friction."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

from contactlab.metrics.measure import Measure
from contactlab.metrics.metric import Metric
from contactlab.metrics.record import Record, needed
from contactlab.metrics.response import mean_velocity, peak_force, total_impulse


@final
@dataclass(frozen=True)
class Variants:
    """A run and runs of the same law with one thing changed.

    Args:
        base: the run.
        basis: with another basis of the resonator; None where there is none.
        friction: with another friction coefficient; None where there is none.
        friction_change: relative change of the coefficient.
    """

    base: Record
    basis: Record | None = None
    friction: Record | None = None
    friction_change: float = 0.0

    def of_basis(self, value: Callable[[Record], float]) -> float:
        """(x_basis - x) / x."""
        return self._change(self.basis, value)

    def of_friction(self, value: Callable[[Record], float]) -> float:
        """((x_friction - x) / x) / ((mu_friction - mu) / mu)."""
        needed(self.friction_change != 0.0)
        return self._change(self.friction, value) / self.friction_change

    def _change(self, variant: Record | None, value: Callable[[Record], float]) -> float:
        needed(variant is not None)
        assert variant is not None
        before = value(self.base)
        needed(before != 0.0)
        return (value(variant) - before) / before


_ANSWERS: Final = (
    ("rotor_velocity", "Omega", "mean rotor velocity", mean_velocity),
    ("peak_force", "N_max", "peak normal force", peak_force),
    ("total_impulse", "sum p_n", "sum of the normal impulses", total_impulse),
)


def _of_basis(
    key: str, symbol: str, words: str, value: Callable[[Record], float]
) -> Measure[Variants]:
    metric = Metric(
        f"{key}_by_basis",
        f"d {symbol} / {symbol}",
        "1",
        f"relative change of the {words} with the basis",
    )
    return Measure(metric, lambda variants: variants.of_basis(value))


def _of_friction(
    key: str, symbol: str, words: str, value: Callable[[Record], float]
) -> Measure[Variants]:
    metric = Metric(
        f"{key}_by_friction",
        f"(d {symbol} / {symbol}) / (d mu / mu)",
        "1",
        f"relative change of the {words} over that of the friction coefficient",
    )
    return Measure(metric, lambda variants: variants.of_friction(value))


MEASURES: Final[tuple[Measure[Variants], ...]] = (
    *(_of_basis(*answer) for answer in _ANSWERS),
    *(_of_friction(*answer) for answer in _ANSWERS),
)
"""Sensitivities."""
