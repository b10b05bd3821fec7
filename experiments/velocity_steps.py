"""Velocity steps of rock friction: does a law's state carry over to another normal stress?

    python experiments/velocity_steps.py path=p446s7tr005l [output=DIR]

The file is example/p446s7tr005l of github.com/PennStateRockandSedimentMechanics/xlook: a head, then whole
columns of big-endian numbers: sample period, load point, shear load, thickness and normal load. Units, zeros
and the intervals in which a sensor was moved are those of example/p446_r there.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
import xarray
from experiment import Experiment, main
from fitted_laws import Candidate, Track, fitted, ratio_to, rubbing
from matplotlib.figure import Figure
from matplotlib.style import context
from numpy.typing import NDArray
from scipy.signal import medfilt

import contactlab as cl
from contactlab.arrays import Array
from contactlab.plot.style import STYLE
from contactlab.studies.study import option

HEAD, COUNT_AT, COLUMNS = 1380, 20, 5
"""Bytes of the head, place of the number of rows in it, and columns."""

PERIOD, POINT, SHEAR, NORMAL = 1e-4, 0.0992635e-6, 1.582041375e3, 3.291765576e2
"""Units of the columns [s, m, Pa, Pa]."""

FIRST_SLIP, FIRST_LOAD = 521, 12
"""Rows at which the load point and shear stress are zero, and the normal stress."""

MOVED: Final = (
    (2217, 2431),
    (4449, 4663),
    (39659, 40018),
    (77606, 77852),
    (113627, 114109),
    (148009, 148307),
)
"""Rows between which the sensor of the load point was moved."""

WINDOWS: Final = {"15 MPa": (4408.0, 5588.0), "20 MPa": (5908.0, 7088.0)}
"""Times of the velocity steps at each normal stress [s]. At 5 MPa friction jumps between the steps, and at
10 MPa the load was taken off in a step."""

BIN: Final = 4e-6
"""Way of the load point over which friction is averaged [m]."""

SPEEDS: Final = np.array([1.0, 3.0, 10.0, 30.0, 100.0, 300.0]) * 1e-6
"""Speeds between which the load point steps [m/s]; each step's own speed is that of its ends."""

RUN_IN: Final = 1e-4
"""Way that is left out at the start [m]."""

FRICTION, SPEED = 0.58, 1e-5
"""Friction coefficient and speed [m/s] at the start; what the former is off by is in the trend."""

CALIBRATED: Final = 1e11
"""Stiffness of the apparatus by its calibration, `ec` of p446_r: 0.1 MPa/um [Pa/m]."""

STIFFNESS: Final = ((3e10, 2e11), 1e9, 1e13)
"""Starts and bounds of the stiffness of the frame per area [Pa/m]."""

REFERENCE, AGEING = "no state", "rate_and_state"


def _of_state(name: str, friction: Callable[..., cl.Friction]) -> Candidate:
    """Return a law of rate and state behind a frame, in steady sliding at the start."""

    def law(p: Array) -> cl.ContactLaw:
        own: dict[str, Any] = {"direct_effect": p[0], "evolution_effect": p[1], "renewal_distance": p[2]}
        return rubbing(
            friction(
                friction_coefficient=FRICTION, reference_velocity=SPEED, fresh_age=float(p[2]) / SPEED, **own
            )
        )

    tried, low, high = STIFFNESS
    starts = [[6e-3, 5e-3, 4e-5, stiffness] for stiffness in tried]
    return Candidate(name, law, starts, [1e-6, 1e-6, 1e-7, low], [0.1, 0.1, 1e-2, high], True)


def _without_state(p: Array) -> cl.ContactLaw:
    """Return a law whose friction is that of the present speed."""
    return rubbing(
        cl.RateAndState(
            friction_coefficient=FRICTION, direct_effect=p[0], evolution_effect=0.0, reference_velocity=SPEED
        )
    )


CANDIDATES: Final = (
    Candidate(
        REFERENCE,
        _without_state,
        [[1e-3, stiffness] for stiffness in STIFFNESS[0]],
        [1e-6, STIFFNESS[1]],
        [0.1, STIFFNESS[2]],
        True,
    ),
    _of_state("rate_and_state", cl.RateAndState),
    _of_state("ruina", cl.Ruina),
    _of_state("perrin_rice_zheng", cl.PerrinRiceZheng),
    _of_state("nagata", cl.Nagata),
)
"""Laws behind the stiffness of the apparatus."""


class Record(NamedTuple):
    """A run of the apparatus: time [s], load point [m], shear and normal stress [Pa]."""

    time: Array
    point: Array
    shear: Array
    normal: Array


class Steps(NamedTuple):
    """Velocity steps: friction over the way, a track of them, and the mean normal stress [Pa]."""

    way: Array
    friction: Array
    track: Track
    normal: float


def read_record(path: Path) -> Record:
    """Return a record with its units, zeros and moves of the sensor corrected.

    Raises:
        ValueError: the file is shorter than its head states.
    """
    content = path.read_bytes()
    count = int.from_bytes(content[COUNT_AT : COUNT_AT + 4], "big")
    if len(content) < HEAD + 4 * COLUMNS * count or not count:
        raise ValueError(f"{path} has {len(content)} bytes, which are no {count} rows of {COLUMNS} columns.")
    columns = np.frombuffer(content, ">f4", COLUMNS * count, HEAD).astype(float).reshape(COLUMNS, count)
    time, point, shear = PERIOD * columns[0], POINT * columns[1], SHEAR * columns[2]
    normal = NORMAL * columns[4]
    for begin, end in MOVED:
        if end < count:
            point[end:] -= point[end] - point[begin]
            point[begin:end] = point[begin]
    return Record(
        np.cumsum(time), point - point[FIRST_SLIP], shear - shear[FIRST_SLIP], normal - normal[FIRST_LOAD]
    )


def steps_of(record: Record, begin: float, end: float) -> Steps:
    """Return the velocity steps between two times [s], friction averaged over the way."""
    here = (record.time > begin) & (record.time < end)
    point = np.maximum.accumulate(record.point[here])
    first = np.flatnonzero(np.diff(((point - point[0]) // BIN).astype(int), prepend=-1))
    counts = np.diff(np.append(first, point.size))
    time, way, friction = (
        np.add.reduceat(x, first) / counts
        for x in (record.time[here], point, record.shear[here] / record.normal[here])
    )
    time, way, normal = time - time[0], way - way[0], float(record.normal[here].mean())
    speed = medfilt(np.diff(way) / np.diff(time), 9)
    nearest = np.abs(np.log(speed[:, None] / SPEEDS)).argmin(axis=1)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(nearest)) + 1, [time.size - 1]])
    trend = np.stack([np.ones(way.size), way / way[-1]], axis=1)
    # Stresses over the normal stress: a force is a friction coefficient.
    track = Track(time[edges], way[edges], 1.0, time, -friction, trend, force=FRICTION)
    return Steps(way, friction, track, normal)


def step_of(steps: Steps) -> Array:
    """Return the velocity step that each average belongs to, from 0; -1 where the run-in is left out."""
    step = np.searchsorted(steps.track.time[1:-1], steps.track.instants, side="right")
    step -= step[steps.way > RUN_IN][0]
    return np.where(steps.way > RUN_IN, step, -1).astype(float)


def at_stress(candidate: Candidate, normal: float) -> Candidate:
    """Return a law whose frame has its stiffness per area over a normal stress [Pa]."""
    starts = [[*start[:-1], start[-1] / normal] for start in candidate.starts]
    low, high = ([*bounds[:-1], bounds[-1] / normal] for bounds in (candidate.low, candidate.high))
    return Candidate(candidate.name, candidate.law, starts, low, high, candidate.framed)


@dataclass(frozen=True, kw_only=True)
class VelocitySteps(Experiment):
    """Does a law of rate and state that was fitted at one normal stress predict the steps at another?"""

    says = (
        "Friction has a memory: laws with a state, fitted at one normal stress, miss less of the velocity "
        "steps at another than friction of the present speed; among themselves they are not distinguishable."
    )

    path: Annotated[str, option("file of the record")]

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """What each law predicts of the steps at one normal stress when it is fitted at another."""
        del setup
        record = read_record(Path(self.path))
        steps = {name: steps_of(record, *window) for name, window in WINDOWS.items()}
        candidates = CANDIDATES[:2] if self.short else CANDIDATES
        size = max(each.way.size for each in steps.values())

        def padded(values: Array, length: int) -> Array:
            return np.append(values, np.full(length - values.size, np.nan))

        most = max(each.free for each in candidates)
        numbers = np.full((len(candidates), len(steps), most), np.nan)
        predicted = np.full((len(candidates), len(steps), len(steps), size), np.nan)
        for i, candidate in enumerate(candidates):
            for j, seen in enumerate(steps.values()):
                best = fitted(at_stress(candidate, seen.normal), seen.track, seen.way > RUN_IN)
                best[-1] *= seen.normal
                numbers[i, j, : best.size] = best
                for k, other in enumerate(steps.values()):
                    chosen = other.way > RUN_IN
                    there = np.append(best[:-1], best[-1] / other.normal)
                    curve = -other.track.with_nuisance(other.track.predicted(candidate, there), chosen)
                    predicted[i, j, k, : curve.size] = curve
        return xarray.Dataset(
            {
                "way": (("stress", "row"), [padded(x.way, size) for x in steps.values()], {"units": "m"}),
                "friction": (("stress", "row"), [padded(x.friction, size) for x in steps.values()]),
                "predicted": (("law", "fitted", "stress", "row"), predicted),
                "numbers": (("law", "fitted", "number"), numbers),
                "step": (("stress", "row"), [padded(step_of(x), size) for x in steps.values()]),
                "free": ("law", [each.free for each in candidates]),
            },
            coords={"law": [each.name for each in candidates], "fitted": [*steps], "stress": [*steps]},
        )

    def unseen(self, data: xarray.Dataset, law: str, seen: str) -> tuple[Array, NDArray[np.int64]]:
        """Return squared errors at the stress that a law is not fitted to, and the steps that they lie in."""
        (other,) = (str(x) for x in data.stress.values if x != seen)
        here = data.sel(law=law, fitted=seen, stress=other)
        used = here.step.values >= 0
        return np.square(here.predicted - here.friction).values[used], here.step.values[used].astype(int)

    def ratio(self, data: xarray.Dataset, law: str, reference: str, seen: str) -> dict[str, float]:
        """Return the mean square of a law over that of another at the stress that both are not fitted to."""
        square, steps = self.unseen(data, law, seen)
        return ratio_to(square, self.unseen(data, reference, seen)[0], steps)

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return numbers of each law at each stress and errors; squares over those of `REFERENCE`."""
        result: list[dict[str, object]] = []
        for name in map(str, data.law.values):
            for seen in map(str, data.fitted.values):
                here = data.sel(law=name, fitted=seen, stress=seen)
                fit = np.square(here.predicted - here.friction).values[here.step.values >= 0]
                numbers = [float(x) for x in data.numbers.sel(law=name, fitted=seen).values if np.isfinite(x)]
                state = len(numbers) > 2
                result.append(
                    {
                        "law": name,
                        "fitted at": seen,
                        "direct effect": numbers[0],
                        "evolution effect": numbers[1] if state else np.nan,
                        "renewal distance [m]": numbers[2] if state else np.nan,
                        "stiffness [Pa/m]": numbers[-1],
                        "fitted": float(fit.mean()) ** 0.5,
                        "held out": float(self.unseen(data, name, seen)[0].mean()) ** 0.5,
                        **self.ratio(data, name, REFERENCE, seen),
                    }
                )
        return result

    def numbers(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return squared errors over those of `AGEING`, and what does not belong to a law."""
        own = data.to_dataset()
        return {
            "calibrated stiffness": CALIBRATED,
            "over ageing": {
                f"{law}, {seen}": self.ratio(own, law, AGEING, seen)
                for law in map(str, own.law.values)
                for seen in map(str, own.fitted.values)
                if law not in (REFERENCE, AGEING)
            },
        }

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Compare laws with a state and without, at the stress that they were not fitted to."""
        rows, parts = self.rows(data), []
        of_state = [row for row in rows if row["law"] != REFERENCE]
        for seen in map(str, data.fitted.values):
            errors = {x["law"]: 1e3 * float(str(x["held out"])) for x in rows if x["fitted at"] == seen}
            without = errors.pop(REFERENCE)
            parts.append(
                f"fitted at {seen}, laws with a state miss {min(errors.values()):.2f} to "
                f"{max(errors.values()):.2f} thousandths of the normal stress at the other, without a state "
                f"{without:.2f}"
            )
        better = all(float(str(row["high"])) < 1.0 for row in of_state)
        beside = self.numbers(xarray.DataTree(data))["over ageing"].values()
        alike = all(own["low"] <= 1.0 <= own["high"] for own in beside)
        return f"When {'; '.join(parts)}.", better and alike

    def draw(self, data: xarray.Dataset) -> Figure:
        """Friction over the way of the load point at each stress, with laws fitted at the other."""
        with context(STYLE):
            figure = Figure(figsize=(7.2, 4.6), layout="constrained")
            for ax, stress in zip(
                figure.subplots(2, 1, sharex=True), map(str, data.stress.values), strict=True
            ):
                (other,) = (str(x) for x in data.fitted.values if x != stress)
                here = data.sel(stress=stress)
                used = here.way.values > RUN_IN
                way, friction = 1e3 * here.way.values[used], here.friction.values[used]
                ax.plot(way, friction, ".", color="0.75", markersize=2.0)
                for name in map(str, data.law.values):
                    curve = here.predicted.sel(law=name, fitted=other).values[used]
                    ax.plot(way, curve, linewidth=0.8, label=name)
                low, high = np.quantile(friction, [0.002, 0.998])
                ax.set(ylabel="friction coefficient", ylim=(low - 0.003, high + 0.003))
                ax.set_title(f"steps at {stress}, laws fitted at {other}")
            ax.set(xlabel="way of the load point (mm)")
            ax.legend(loc="lower right", ncols=3)
        return figure


if __name__ == "__main__":
    main(__file__)
