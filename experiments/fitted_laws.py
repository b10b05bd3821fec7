"""Laws fitted to measured friction on a path, or behind the frame of the apparatus, by least squares."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

import contactlab as cl
from contactlab.arrays import Array
from contactlab.driving import Frame, LawOnPath
from contactlab.studies.compare.bootstrap import mean_intervals

HARD: Final = 1e18
"""Stiffness of a normal force that yields by nothing [N/m]: only friction counts."""

UNSOLVED: Final = 10.0
"""Residual where a law has no motion behind a frame, over the largest measured force."""


Chosen = NDArray[np.bool_]
"""Whether instants count."""


def rubbing(friction: cl.Friction, viscous: float | None = None) -> cl.Composed:
    """Return a law of friction under a prescribed normal force."""
    return cl.Composed(cl.Linear(HARD), friction=friction, viscous_friction=viscous)


@dataclass(frozen=True)
class Candidate:
    """A law with free numbers.

    Args:
        name: of the law.
        law: returns it with its numbers.
        starts: numbers from which a search begins, and with `framed` the frame's stiffness [N/m] behind them.
        low, high: bounds of these, positive where the logarithm is searched.
        framed: whether the path is that of the load point of a frame.
    """

    name: str
    law: Callable[[Array], cl.ContactLaw]
    starts: Sequence[Sequence[float]]
    low: Sequence[float]
    high: Sequence[float]
    framed: bool = False

    @property
    def free(self) -> int:
        """How many numbers are fitted."""
        return len(self.low)


@dataclass(frozen=True)
class Track:
    """Measured friction.

    Args:
        time: of the samples of the path, which lines join [s].
        slip: displacement of the surface or of the load point [m].
        normal: normal force [N].
        instants: times at which friction was measured [s].
        friction: against the slip [N].
        nuisance: columns that the apparatus adds to any prediction, each with a free factor, shape (instant,
            column): the zero of a load cell, a trend.
        force: of the frame at the start [N].
        ready: the last law and frame stiffness, with their loop: making it takes longer than running it.
    """

    time: Array
    slip: Array
    normal: Array | float
    instants: Array
    friction: Array
    nuisance: Array
    force: float = 0.0
    ready: dict[tuple[str, float | None], LawOnPath] = field(default_factory=dict, init=False)

    def predicted(self, candidate: Candidate, numbers: Array) -> Array:
        """Return the friction of a law at the instants [N]; NaN where it has no motion."""
        law = candidate.law(numbers)
        key = (candidate.name, float(numbers[-1]) if candidate.framed else None)
        if key not in self.ready:
            self.ready.clear()
            self.ready[key] = LawOnPath(
                law,
                self.time,
                normal=self.normal,
                slip=self.slip,
                degree=1,
                frame=None if key[1] is None else Frame(key[1], force=self.force),
                instants=self.instants,
            )
        self.ready[key].run(law)
        return np.array(self.ready[key].path.forces[:, 1])

    def with_nuisance(self, predicted: Array, chosen: Chosen) -> Array:
        """Return a prediction with the columns that the apparatus adds, fitted to chosen instants."""
        there = np.isfinite(predicted)
        known = chosen & there
        factors = np.linalg.lstsq(self.nuisance[known], (self.friction - predicted)[known])[0]
        bad = UNSOLVED * np.abs(self.friction).max()
        return np.asarray(np.where(there, predicted + self.nuisance @ factors, bad))


def fitted(candidate: Candidate, track: Track, chosen: Chosen) -> Array:
    """Return the numbers of a law that fit the friction at chosen instants best, of all starts."""
    low, high = np.asarray(candidate.low), np.asarray(candidate.high)
    even = low > 0.0

    def numbers(x: Array) -> Array:
        return np.where(even, np.exp(np.where(even, x, 0.0)), x)

    def scaled(y: Sequence[float] | Array) -> Array:
        return np.where(even, np.log(np.where(even, y, 1.0)), y)

    def misses(x: Array) -> Array:
        predicted = track.with_nuisance(track.predicted(candidate, numbers(x)), chosen)
        return np.asarray((predicted - track.friction)[chosen])

    best = min(
        (
            least_squares(misses, scaled(start), bounds=(scaled(low), scaled(high)), diff_step=1e-4)
            for start in candidate.starts
        ),
        key=lambda result: float(result.cost),
    )
    return numbers(best.x)


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def ratio_to(square: Array, reference: Array, blocks: NDArray[np.int64] | None = None) -> dict[str, float]:
    """Return the mean of squared errors over that of another law of the same data, with its interval at 95 %.

    The interval is that of the mean difference over blocks: cycles, speeds, or velocity steps.
    """
    made = mean_intervals((square - reference)[:, None], 0, blocks=blocks)
    size = float(reference.mean())
    low, high = map(float, 1.0 + made.interval[0] / size)
    return {"ratio": 1.0 + float(made.mean[0]) / size, "low": low, "high": high}
