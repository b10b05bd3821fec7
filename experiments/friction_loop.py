"""A friction loop of a tribometer: which law predicts the cycles that it has not seen?

    python experiments/friction_loop.py [path=FILE] [output=DIR]

The file has `time`, `slip` of the load point, `normal` and `friction_force`, as docs/gallery/tribometer.csv,
which `tribometer.py` makes from the published record.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Any, Final

import numpy as np
import xarray
from dependencies import ROOT
from experiment import Experiment, main
from fitted_laws import Candidate, Chosen, Track, fitted, ratio_to, rms, rubbing
from matplotlib.figure import Figure
from matplotlib.style import context
from numpy.typing import NDArray

import contactlab as cl
from contactlab.arrays import Array
from contactlab.plot.style import STYLE
from contactlab.studies.study import option
from contactlab_data.measured.files import read_measurements
from contactlab_data.measured.series import MeasuredSeries

SHIPPED: Final = ROOT / "docs" / "gallery" / "tribometer.csv"

FITTED: Final = 5
"""Cycles that laws are fitted to. The one before them is none of these: laws begin undeformed."""

ALIKE: Final = 0.1
"""Relative difference of two mean squares that are called alike."""

FRAME: Final = ((2e4,), 1e3, 1e7)
"""Starts and bounds of a frame's stiffness [N/m]."""

RESTS: Final = 0.5e-6
"""Way below which the load point rests [m]: no law here knows time, so that rows at rest are left out."""

REFERENCE: Final = "coulomb, frame"

OWN: Final = (
    Candidate("coulomb", lambda p: rubbing(cl.Coulomb(p[0])), [[0.4]], [0.05], [2.0]),
    Candidate(
        "mindlin",
        lambda p: cl.Composed(cl.Linear(1e6), friction=cl.Mindlin(p[0], stiffness_ratio=p[1])),
        [[0.4, 0.1]],
        [0.05, 1e-4],
        [2.0, 1e3],
    ),
    Candidate(
        "dahl", lambda p: rubbing(cl.Dahl(p[0], rest_stiffness=p[1])), [[0.4, 1e4]], [0.05, 1e2], [2.0, 1e8]
    ),
    Candidate(
        "iwan", lambda p: rubbing(cl.Iwan(p[0], full_slip=p[1])), [[0.4, 1e-4]], [0.05, 1e-7], [2.0, 1e-3]
    ),
    Candidate(
        "bouc_wen",
        lambda p: rubbing(cl.BoucWen(p[0], yield_displacement=p[1], exponent=p[2])),
        [[0.4, 6e-5, 2.0]],
        [0.05, 1e-8, 1.0],
        [2.0, 1e-3, 20.0],
    ),
)
"""Laws on the path of the load point."""

SOFTER: Final = {"mindlin": 10.0, "dahl": 10.0, "iwan": 0.1, "bouc_wen": 0.1}
"""Factor of the second number where a frame yields beside the law: it is stiffer than without."""


def framed(own: Candidate) -> Candidate:
    """Return a law behind a frame."""
    starts = [[*start] for start in own.starts]
    for start in starts:
        start[1:2] = [x * SOFTER[own.name] for x in start[1:2]]
    tried, low, high = FRAME
    starts = [[*start, stiffness] for start in starts for stiffness in (*tried, 2.5 * tried[0])]
    return replace(own, starts=starts, low=[*own.low, low], high=[*own.high, high], framed=True)


CANDIDATES: Final = (*OWN, *map(framed, OWN))


def label(candidate: Candidate) -> str:
    """Return the name of a law, and whether it stands behind a frame."""
    return f"{candidate.name}, frame" if candidate.framed else candidate.name


def moving(slip: Array) -> NDArray[np.int64]:
    """Return the rows at which the load point has moved since the row before that is returned."""
    kept = [0]
    for n in range(1, slip.size):
        if abs(slip[n] - slip[kept[-1]]) > RESTS:
            kept.append(n)
    return np.array(kept)


def cycle_of(time: Array, slip: Array) -> NDArray[np.int64]:
    """Return the cycle of each sample: a new one begins where the load point passes the middle upwards."""
    middle = 0.5 * (slip.min() + slip.max())
    ups = time[1:][(slip[:-1] < middle) & (slip[1:] >= middle)]
    return np.searchsorted(ups, time, side="right")


def seen_in(cycle: NDArray[np.int64]) -> Chosen:
    """Return whether laws are fitted to each row."""
    return np.asarray((cycle >= 1) & (cycle <= FITTED))


def unseen_in(cycle: NDArray[np.int64]) -> Chosen:
    """Return whether each row is predicted; the last cycle is cut off."""
    return np.asarray((cycle > FITTED) & (cycle < cycle.max()))


@dataclass(frozen=True, kw_only=True)
class FrictionLoop(Experiment):
    """Which law of friction predicts the cycles of a measured loop that it was not fitted to?"""

    says = (
        "The elastic part of the loop is that of the apparatus: rigid friction behind a frame predicts the "
        "cycles not seen as well as every law with a stiffness of its own."
    )

    path: Annotated[str, option("CSV file of the loop")] = str(SHIPPED)

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """The loop, what each law predicts, and its error in the cycles it has not seen.

        Raises:
            ValueError: the file is of another kind.
        """
        del setup
        series = read_measurements(self.path)
        if not (isinstance(series, MeasuredSeries) and {"slip", "normal"} <= {*series.path}):
            raise ValueError(f"{self.path} has no forces on a path; it must have slip and normal.")
        moves = moving(series.path["slip"])
        slip, normal = (series.path[name][moves] for name in ("slip", "normal"))
        friction = series.values["friction_force"][moves]
        time = np.arange(float(friction.size))
        cycle = cycle_of(time, slip)
        chosen = seen_in(cycle)

        def track(until: int) -> Track:
            some = slice(until)
            instants, constant = time[some], np.ones((time[some].size, 1))
            return Track(instants, slip[some], normal[some], instants, friction[some], constant)

        whole, seen = track(time.size), track(int(np.flatnonzero(chosen)[-1]) + 1)
        rows = []
        for candidate in CANDIDATES[:2] + CANDIDATES[5:7] if self.short else CANDIDATES:
            numbers = fitted(candidate, seen, chosen[: seen.time.size])
            predicted = whole.with_nuisance(whole.predicted(candidate, numbers), chosen)
            rows.append((candidate, numbers, predicted))
        names = [label(row[0]) for row in rows]
        most = max(row[0].free for row in rows)
        return xarray.Dataset(
            {
                "slip": ("time", slip, {"units": "m"}),
                "friction_force": ("time", friction, {"units": "N"}),
                "predicted": (("law", "time"), [row[2] for row in rows], {"units": "N"}),
                "numbers": (("law", "number"), [[*row[1], *[np.nan] * (most - row[0].free)] for row in rows]),
                "free": ("law", [row[0].free for row in rows]),
                "framed": ("law", [row[0].framed for row in rows]),
            },
            coords={"time": time, "cycle": ("time", cycle), "law": names},
            attrs={
                "force": rms(friction),
                "again": again(slip, friction, cycle),
                "unseen": int(cycle.max()) - FITTED - 1,
            },
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return numbers and errors of each law, over the force; squares over those of `REFERENCE`."""
        chosen, unseen = seen_in(data.cycle.values), unseen_in(data.cycle.values)
        square = np.square(data.predicted - data.friction_force)
        blocks = data.cycle.values[unseen] - FITTED - 1
        result: list[dict[str, object]] = []
        for name in map(str, data.law.values):
            own, reference = (square.sel(law=x).values for x in (name, REFERENCE))
            numbers = [float(x) for x in data.numbers.sel(law=name).values if np.isfinite(x)]
            result.append(
                {
                    "law": name,
                    "free numbers": int(data.free.sel(law=name)),
                    "friction coefficient": numbers[0],
                    "frame [N/m]": numbers[-1] if data.framed.sel(law=name) else np.nan,
                    "fitted": float(own[chosen].mean()) ** 0.5 / data.force,
                    "held out": float(own[unseen].mean()) ** 0.5 / data.force,
                    **ratio_to(own[unseen], reference[unseen], blocks),
                }
            )
        return result

    def numbers(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return what does not belong to a law."""
        return {name: float(data.attrs[name]) for name in ("force", "again", "unseen")}

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Compare rigid friction behind a frame with the best law."""
        rows = {str(row["law"]): row for row in self.rows(data)}
        errors = {name: 100.0 * float(str(row["held out"])) for name, row in rows.items()}
        best = min(errors, key=lambda name: errors[name])
        sentence = (
            f"Of the force, coulomb misses {errors['coulomb']:.0f} % in the cycles not seen, behind a frame "
            f"{errors[REFERENCE]:.1f} %, the best law ({best}) {errors[best]:.1f} %; the mean of the cycles "
            f"seen misses {100 * data.again / data.force:.1f} %."
        )
        return sentence, min(float(str(row["low"])) for row in rows.values()) > 1.0 - ALIKE

    def draw(self, data: xarray.Dataset) -> Figure:
        """The loop with three laws, and what each misses over the cycles."""
        with context(STYLE):
            figure = Figure(figsize=(7.2, 3.2), layout="constrained")
            left, right = figure.subplots(1, 2)
            cycle = data.isel(time=np.flatnonzero(data.cycle == FITTED + 1))
            slip = 1e6 * cycle.slip
            left.plot(slip, cycle.friction_force, "o", color="0.6", label="measured, first cycle not seen")
            for name in ("coulomb", "coulomb, frame", "dahl"):
                if name in data.law:
                    left.plot(slip, cycle.predicted.sel(law=name), label=name)
            left.set(xlabel="position of the load point (um)", ylabel="friction (N)", ylim=(-3.0, 4.2))
            left.legend(loc="upper center", ncols=2)
            square = np.square(data.predicted - data.friction_force).isel(
                time=np.flatnonzero(unseen_in(data.cycle.values))
            )
            each = np.sqrt(square.groupby("cycle").mean()) / data.force
            behind = [str(name) for name in data.law.values if data.framed.sel(law=name)]
            for name in map(str, data.law.values):
                if name not in ("coulomb", *behind):
                    right.plot(each.cycle, 100.0 * each.sel(law=name), "--", label=name)
            for name in behind:
                right.plot(each.cycle, 100.0 * each.sel(law=name), color="black", linewidth=0.7)
            right.plot([], [], color="black", label=f"{len(behind)} laws behind a frame")
            right.set(xlabel="cycle", ylabel="error (% of the force)", ylim=(0.0, None))
            right.legend(loc="lower right")
        return figure


def again(slip: Array, friction: Array, cycle: NDArray[np.int64]) -> float:
    """Return what the mean of the cycles seen misses of the others [N], over the way of the load point."""
    whole = range(1, int(cycle.max()))
    ways = [np.cumsum(np.abs(np.diff(slip[cycle == n], prepend=slip[cycle == n][0]))) for n in whole]
    grid = np.linspace(0.0, min(way[-1] for way in ways), 50)
    curves = np.array(
        [np.interp(grid, way, friction[cycle == n]) for n, way in zip(whole, ways, strict=True)]
    )
    return rms(curves[FITTED:] - curves[:FITTED].mean(axis=0))


if __name__ == "__main__":
    main(__file__)
