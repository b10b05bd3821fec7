"""One operating point: the steady state on a belt or of a free rotor, all that it does, and its errors."""

from dataclasses import dataclass, field, replace
from typing import Final, final

import numpy as np

from contactlab.config import Setup
from contactlab.datasheet.measurement import UNKNOWN, Measurement, Number
from contactlab.steady_state import BrokenOffError, Converged, NotSettledError, converged
from contactlab.trajectory import Trajectory

LONGEST: Final = (480, 4000)
"""Periods of the drive after which a motion without an orbit has its means; and where it drifts by then."""

GROWS: Final = 1.5
"""Ratio of successive changes of a number that grows with every finer step, from which on it has no limit;
what goes with one over the step has a ratio of two."""

NOTABLE: Final = 0.1
"""Last of these changes over the number, below which it is one between steps and no growth."""


@final
@dataclass(frozen=True)
class Point:
    """An operating point.

    Args:
        belt: velocity at which the rotor is held [rad/s], in the model's sense; None for a free rotor.
        kind: as of `Steady`; 'periodic at some steps', or 'none' where a run breaks off.
        numbers: value and error of every name in `quantities.POINT`.
        message: why there is none.
        run: whole periods of it at the finest step.
    """

    belt: float | None
    kind: str
    numbers: dict[str, Number] = field(default_factory=dict)
    message: str = ""
    run: Trajectory | None = None

    def __getitem__(self, name: str) -> float:
        return self.numbers.get(name, UNKNOWN)[0]

    def error(self, name: str) -> float:
        """Return the error of a quantity."""
        return self.numbers.get(name, UNKNOWN)[1]

    def turned(self, sense: float) -> "Point":
        """Return the point with velocity and torque in the other sense, if that is negative."""
        signed = {name: (sense * self[name], self.error(name)) for name in ("velocity", "torque")}
        return replace(self, numbers=self.numbers and self.numbers | signed)


def operate(setup: Setup, belt: float | None = None) -> Point:
    """Find the steady state at an operating point, at three steps, and measure it at the finest.

    Args:
        setup: motor and law; its contact step or tolerance is the coarsest.
        belt: velocity at which the rotor is held [rad/s]; None for a free one.
    """
    short, long = LONGEST
    try:
        try:
            result = converged(setup, belt=belt, longest=short)
        except NotSettledError:
            result = converged(setup, belt=belt, longest=long)
        measured = [Measurement.of(each) for each in result.steps]
    except (BrokenOffError, NotSettledError) as error:
        return Point(belt, "none", message=str(error))
    levels = {id(each): item.numbers() for each, item in zip(result.steps, measured, strict=True)}
    kinds = {each.kind for each in result.steps}
    kind = result.best.kind if len(kinds) == 1 or "periodic" not in kinds else "periodic at some steps"
    names = levels[id(result.best)]
    numbers = {name: _limit(result, {key: every[name] for key, every in levels.items()}) for name in names}
    return Point(belt, kind, numbers, run=measured[-1].run)


def _limit(found: Converged, levels: dict[int, Number]) -> Number:
    """Return the finest of three numbers with its error; an infinite one where they grow without bound."""
    value, error = found.value(lambda each: levels[id(each)])
    before, last = np.diff([abs(number) for number, _ in levels.values()])
    if last > GROWS * before > 0.0 and last > NOTABLE * abs(value) + levels[id(found.best)][1]:
        return value, np.inf
    return value, error
