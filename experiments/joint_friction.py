"""Friction of a robot's joint over its speed: is there a Stribeck curve?

    python experiments/joint_friction.py path=FOLDER [output=DIR]

FOLDER is `data` of github.com/HBRS-SDP/joint-friction-model, files velocity_*readings.csv. Columns, without a
head: commanded torque, angle [rad], angular velocity [rad/s], joint torque [N m], commanded current,
current, friction torque [N m] by an observer.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import xarray
from experiment import Experiment, main
from fitted_laws import Candidate, Track, fitted, ratio_to, rubbing
from matplotlib.figure import Figure
from matplotlib.style import context

import contactlab as cl
from contactlab.arrays import Array
from contactlab.plot.style import STYLE
from contactlab.studies.study import option

VELOCITY, FRICTION, COLUMNS = 2, 6, 7

SETTLED: Final = 0.5
"""Share of each record that is left out: the joint speeds up."""

LIKE: Final = 0.1
"""Relative difference of two speeds that are called the same."""

HELD: Final = 1.0
"""Time for which the path has each speed [s]: laws of a state are steady at its end."""

BY_SPEED: Final = (0.5, 0.02)
"""Starts of viscous friction [N m s/rad] and of what grows with the logarithm of the speed [N m]."""

STATE: Final = 0.5
"""Evolution effect of the law with a state [N m]: steady friction has only the difference of both effects."""


def _stribeck(exponent: float) -> Candidate:
    """Return Stribeck's curve of an exponent, with viscous friction."""
    return Candidate(
        f"stribeck, exponent {exponent:g}, viscous",
        lambda p: rubbing(cl.Stribeck(p[0], p[1], p[2], exponent), p[3]),
        [[1.5, 1.1, 0.1, 0.5], [1.5, 1.1, 0.5, 0.5]],
        [0.1, 1.0, 0.01, 1e-3],
        [10.0, 3.0, 3.0, 10.0],
    )


def _of_state(p: Array) -> cl.RateAndState:
    """Return a law whose steady friction is p[0] + p[1] ln(v), v in rad/s."""
    return cl.RateAndState(
        friction_coefficient=p[0],
        direct_effect=STATE + p[1],
        evolution_effect=STATE,
        renewal_distance=1e-4,
        reference_velocity=1.0,
    )


CANDIDATES: Final = (
    Candidate("coulomb", lambda p: rubbing(cl.Coulomb(p[0])), [[1.5]], [0.1], [10.0]),
    Candidate(
        "coulomb, viscous",
        lambda p: rubbing(cl.Coulomb(p[0]), p[1]),
        [[1.5, BY_SPEED[0]]],
        [0.1, 1e-3],
        [10.0, 10.0],
    ),
    _stribeck(1.0),
    _stribeck(2.0),
    Candidate(
        "rate_and_state", lambda p: rubbing(_of_state(p)), [[2.0, BY_SPEED[1]]], [0.1, -0.4], [10.0, 5.0]
    ),
    Candidate(
        "rate_and_state, viscous",
        lambda p: rubbing(_of_state(p), p[2]),
        [[2.0, BY_SPEED[1], BY_SPEED[0]]],
        [0.1, -0.4, 1e-3],
        [10.0, 5.0, 10.0],
    ),
)
"""Laws of steady sliding, at an arm of 1 m under 1 N: a friction coefficient is a torque."""

PLAIN, CURVES = "coulomb, viscous", ("stribeck, exponent 1, viscous", "stribeck, exponent 2, viscous")


def read_speeds(folder: Path) -> Array:
    """Return angular velocity [rad/s], its deviation and friction [N m] of each record, shape (record, 3).

    Raises:
        ValueError: no records are there, or one has other columns.
    """
    rows = []
    for path in sorted(folder.glob("velocity_*readings.csv")):
        record = np.genfromtxt(path)
        if record.ndim != 2 or record.shape[1] != COLUMNS:
            raise ValueError(f"{path} has the shape {record.shape}; it must have {COLUMNS} columns.")
        # The last row is of the stop.
        settled = record[int(SETTLED * len(record)) : -1]
        speed = settled[:, VELOCITY]
        rows.append((speed.mean(), speed.std(), abs(settled[:, FRICTION].mean())))
    if not rows:
        raise ValueError(f"{folder} has no files velocity_*readings.csv.")
    return np.array(sorted(rows))


def track_of(speed: Array, friction: Array) -> Track:
    """Return a path that has one speed after another, and the friction measured at each."""
    time: Array = HELD * np.arange(speed.size + 1.0)
    slip: Array = np.append(0.0, HELD * np.cumsum(speed))
    # Friction against the slip is negative.
    return Track(time, slip, 1.0, time[1:], -friction, np.zeros((speed.size, 0)))


def same_speed(speed: Array, friction: Array) -> float:
    """Return the largest difference of friction at speeds that are the same but for `LIKE` [N m]."""
    near = np.diff(speed) < LIKE * speed[:-1]
    return float(np.abs(np.diff(friction))[near].max(initial=0.0))


@dataclass(frozen=True, kw_only=True)
class JointFriction(Experiment):
    """Does a Stribeck curve predict the friction of a joint at speeds that it has not seen?"""

    says = (
        "The measured speeds do not show a Stribeck curve: it predicts speeds not seen no better than "
        "Coulomb's with viscous friction, by less than two records at the same speed differ."
    )

    path: Annotated[str, option("folder of the records")]

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Steady friction at each speed, and what laws fitted to the other speeds predict."""
        del setup
        speed, deviation, friction = read_speeds(Path(self.path)).T
        track, every = track_of(speed, friction), np.ones(speed.size, bool)
        grid = np.geomspace(speed[0], speed[-1], 60)
        candidates = CANDIDATES[:3] if self.short else CANDIDATES
        errors, curves = np.zeros((len(candidates), speed.size)), []
        most = max(each.free for each in candidates)
        best = []
        for row, candidate in zip(errors, candidates, strict=True):
            for n in range(speed.size):
                others = np.delete(np.arange(speed.size), n)
                seen = track_of(speed[others], friction[others])
                numbers = fitted(candidate, seen, every[others])
                row[n] = -track.predicted(candidate, numbers)[n]
            numbers = fitted(candidate, track, every)
            best.append([*numbers, *[np.nan] * (most - numbers.size)])
            curves.append(-track_of(grid, grid).predicted(candidate, numbers))
        unit = {"units": "N m"}
        return xarray.Dataset(
            {
                "friction": ("speed", friction, unit),
                "deviation": ("speed", deviation, {"units": "rad/s"}),
                "held_out": (("law", "speed"), errors, unit),
                "curve": (("law", "grid"), curves, unit),
                "numbers": (("law", "number"), best),
                "free": ("law", [each.free for each in candidates]),
            },
            coords={"law": [each.name for each in candidates], "speed": speed, "grid": grid},
            attrs={"same_speed": same_speed(speed, friction)},
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return each law's error at speeds not seen; squares over those of `PLAIN`."""
        square = np.square(data.held_out - data.friction)
        plain = square.sel(law=PLAIN)
        result: list[dict[str, object]] = []
        for name in map(str, data.law.values):
            own = square.sel(law=name).values
            result.append(
                {
                    "law": name,
                    "free numbers": int(data.free.sel(law=name)),
                    "held out [N m]": float(own.mean()) ** 0.5,
                    **ratio_to(own, plain.values),
                }
            )
        return result

    def numbers(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return what does not belong to a law."""
        own = data.to_dataset()
        speed, deviation = own.speed.values, own.deviation.values
        return {
            "same speed": float(data.attrs["same_speed"]),
            "slowest": float(speed[0]),
            "fastest": float(speed[-1]),
            "deviation of the slowest": float(deviation[0]),
            "least friction": float(own.friction.min()),
            "greatest friction": float(own.friction.max()),
        }

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Compare Stribeck's curves with viscous friction alone."""
        rows = {str(row["law"]): row for row in self.rows(data)}
        errors = {name: float(str(row["held out [N m]"])) for name, row in rows.items()}
        curves = [name for name in CURVES if name in rows]
        best = min(curves, key=lambda name: errors[name])
        better = any(float(str(rows[name]["high"])) < 1.0 for name in curves)
        gain = errors[PLAIN] - errors[best]
        sentence = (
            f"At speeds not seen {PLAIN} misses {errors[PLAIN]:.3f} N m and {best} {errors[best]:.3f} N m, "
            f"which is {'' if better else 'not '}distinguishable; two records at the same speed differ by "
            f"{data.same_speed:.3f} N m."
        )
        return sentence, not better and gain < data.same_speed

    def draw(self, data: xarray.Dataset) -> Figure:
        """Friction over speed with the laws, and the errors at speeds not seen."""
        with context(STYLE):
            figure = Figure(figsize=(7.2, 3.2), layout="constrained")
            left, right = figure.subplots(1, 2, sharex=True)
            for name in map(str, data.law.values):
                left.plot(data.grid, data.curve.sel(law=name), label=name)
                if name != "coulomb":
                    right.plot(data.speed, data.held_out.sel(law=name) - data.friction, "o-", linewidth=0.6)
                else:
                    right.plot([], [])
            left.errorbar(
                data.speed,
                data.friction,
                xerr=data.deviation,
                fmt="o",
                color="black",
                zorder=5,
                linewidth=0.6,
            )
            half = 0.5 * data.same_speed
            right.axhspan(-half, half, color="0.9", zorder=0, label="two records at the same speed")
            left.set(xscale="log", xlabel="speed (rad/s)", ylabel="friction torque (N m)", ylim=(1.2, None))
            left.set_xlim(0.7 * float(data.speed[0]), 1.4 * float(data.speed[-1]))
            right.set(xlabel="speed (rad/s)", ylabel="predicted less measured, not seen (N m)")
            left.legend(loc="upper left")
            right.legend(loc="lower left")
        return figure


if __name__ == "__main__":
    main(__file__)
