"""Steady states of random motors three ways: by shooting, as the root of a belt's torque, by a long run.

Twenty motors are drawn around the configured one, by a seed of their own: clearance, phase, friction,
frequency, voltages, placement and inertia. Under every law the velocity without load comes from

    shooting    the periodic orbit that the motor goes to; of one without an orbit, means over a long run
    belt        the root of the mean torque over the velocity of a rotor that nothing turns
    run         a run of the configured duration, its velocity over the last period

A belt leaves out that the rotor's velocity ripples within a period: what the contact meets lies between
the orbit's smallest and largest velocity, so the root is off by no more than the ripple, max |Omega - mean|.
A run is off by what its last tenths leave of a geometric series. What shooting costs is set against the part
of the run after which its velocity stays within 1e-6 of the end's, which nobody who runs it knows beforehand.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from time import process_time
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas
import xarray
from experiment import Experiment, main, part_of
from matplotlib.figure import Figure
from scipy.optimize import brentq
from variations import changed

import contactlab as cl
from contactlab.config import compose
from contactlab.refinement import richardson
from contactlab.settling.statistics import mean_with_error
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.steady_state.period_map import period_of
from contactlab.studies.study import Part, Setups, Task

MOTORS, SEED = 20, 14

RANGES = {
    "contact.clearance": (0.5e-6, 2.5e-6),
    "drive.phase": (-np.pi, np.pi),
    "contact.friction_coefficient": (0.15, 0.5),
    "drive.voltage_1": (70.0, 130.0),
    "drive.voltage_2": (70.0, 130.0),
    "placement.start": (0.5e-3, 3e-3),
    "placement.end": (9e-3, 12e-3),
}
"""Keys and their ranges; frequency and inertia are drawn in parts of the motor's own."""

FREQUENCY, INERTIA = (0.95, 1.05), (0.5, 1.0)

LAWS: dict[str, list[str]] = {
    **{name: [f"law={name}"] for name in cl.law_names() if name != "composed"},
    "composed": ["law=composed"],
    "hunt_crossley": ["law=composed", "law/damping=hunt_crossley"],
    "lugre": ["law=composed", "law/friction=lugre"],
    "mindlin": ["law=composed", "law/friction=mindlin"],
}
"""Every registered law, and some that are composed."""

SETTLED = 1e-6
"""Relative distance of a run's velocity from its last one that counts as settled."""

BELTS = 1e-4
"""Of a belt's velocity, to which the root is found."""

CHEAPER = 10.0
"""Times that a steady state shall cost less than the run, whose length must serve the slowest motor."""

WAYS = ("shooting", "belt", "run")
UNITS = {"velocity": "rad s-1", "error": "rad s-1", "cost": "s"}

ROUND_OFF = 1e-9
"""Relative; what paths of one motor differ by for their steps."""


@dataclass(frozen=True)
class Velocity:
    """Velocity [rad/s], its error, and processor time [s]."""

    velocity: float
    error: float
    cost: float


def drawn(setup: cl.Setup) -> list[cl.Setup]:
    """The random motors."""
    rng, motors = np.random.default_rng(SEED), []
    for _ in range(MOTORS):
        keys: dict[str, object] = {key: float(rng.uniform(*ends)) for key, ends in RANGES.items()}
        keys["rotor.inertia"] = setup.motor.rotor.inertia * float(rng.uniform(*INERTIA))
        placed = changed(setup, {**keys, "drive.frequency": None})
        first = float(placed.motor.modes.natural_frequency[0])
        motors.append(changed(setup, {**keys, "drive.frequency": first * float(rng.uniform(*FREQUENCY))}))
    return motors


def under(setup: cl.Setup, law: str) -> cl.Setup:
    """The motor with another law, at that law's own steps."""
    solver = {**setup.configuration["solver"], "contact_step": None, "tolerance": None}
    return cl.build({**setup.configuration, "solver": solver, "law": compose(LAWS[law])["law"]})


def by_shooting(setup: cl.Setup) -> tuple[cl.Steady, Velocity]:
    """The steady state."""
    began = process_time()
    result = cl.steady(setup).details
    cost = process_time() - began
    velocity, error = result.velocity
    return result, Velocity(velocity, error + ROUND_OFF * abs(velocity), cost)


def by_belts(setup: cl.Setup, ripple: float) -> Velocity:
    """The root of the mean torque next to rest, on the side to which the motor turns."""
    began = process_time()
    errors: list[float] = []

    def torque(velocity: float) -> float:
        mean, error = cl.steady(setup, belt=velocity, longest=400).torque
        errors.append(error)
        return mean

    inner, sense = 0.0, float(np.sign(torque(0.0)))
    outer = 0.5 * sense
    while sense and sense * torque(outer) > 0.0:
        inner, outer = outer, 2.0 * outer
    root = brentq(torque, inner, outer, xtol=BELTS, rtol=BELTS) if sense else 0.0
    slope = (torque(1.001 * root) - torque(0.999 * root)) / (0.002 * root) if root else np.inf
    error = ripple + BELTS * (1.0 + abs(root)) + max(errors) / abs(slope)
    return Velocity(float(root), float(error), process_time() - began)


def by_run(setup: cl.Setup, settles: bool) -> tuple[Velocity, float]:
    """The run's last velocity, and the part of the run after which it stays there.

    Of a motor without an orbit, the mean over the second half.
    """
    period = period_of(setup.motor.drive)
    count = round(setup.duration / period)
    began = process_time()
    run = setup.run(duration=count * period, record_interval=period)
    cost = process_time() - began
    if not run.ending.reached_end:
        raise BrokenOffError(run.message)
    velocity = np.diff(run.series["rotor_angle"]) / np.diff(run.time)
    if not settles:
        return Velocity(*mean_with_error(velocity[count // 2 :]), cost), 1.0
    tenth = count // 10
    last = float(velocity[-1])
    error = float(richardson(velocity[[-1 - 2 * tenth, -1 - tenth, -1]], 1.0, 0.0))
    away = np.flatnonzero(np.abs(velocity - last) > SETTLED * abs(last))
    return Velocity(last, error + ROUND_OFF * abs(last), cost), float((away.max(initial=0) + 1) / count)


def judged(data: xarray.Dataset) -> xarray.Dataset:
    """Whether the ways agree, and what they cost, where a motor settles to an orbit within the run."""
    settles = np.isfinite(data.settling_time) & (data.settled_part < 1.0)
    shot = data.sel(way="shooting", drop=True)
    away = {way: np.abs(data.velocity.sel(way=way, drop=True) - shot.velocity) for way in ("belt", "run")}
    agree = {way: away[way] <= data.error.sel(way=way, drop=True) + shot.error for way in away}
    run = data.cost.sel(way="run", drop=True)
    return xarray.Dataset(
        {
            "settles": settles,
            **{f"away_{way}": values for way, values in away.items()},
            **{f"agrees_{way}": values for way, values in agree.items()},
            "shooting": shot.cost.where(settles),
            "settling": (run * data.settled_part).where(settles),
            "whole": run.where(settles),
        }
    )


def three_ways(setup: cl.Setup, label: str) -> Part:
    """Compute the velocity of a motor under one law in the three ways."""
    numbers = {name: np.full(len(WAYS), np.nan) for name in UNITS}
    kind = "broke off"
    settling = multiplier = part = periods = np.nan
    try:
        # What is compiled or loaded once is not what a steady state costs.
        cl.steady(setup, belt=0.0, longest=100)
        steady, shot = by_shooting(setup)
        kind, periods = steady.kind, steady.periods
        if steady.kind != "without contact":
            curve = steady.curves().series["rotor_velocity"]
            result = [shot, by_belts(setup, float(np.abs(curve - shot.velocity).max()))]
            ran, part = by_run(setup, steady.orbit is not None)
            result.append(ran)
            if steady.orbit is not None:
                settling, multiplier = steady.orbit.settling_time, abs(steady.orbit.multipliers[0])
            numbers = {name: np.array([getattr(way, name) for way in result]) for name in UNITS}
    except (BrokenOffError, NotSettledError) as error:
        print(f"{label}: {error}", file=sys.stderr)
    return part_of(
        xarray.Dataset(
            {
                **{name: ("way", values, {"units": UNITS[name]}) for name, values in numbers.items()},
                "kind": kind,
                "periods": ((), periods, {"units": "1"}),
                "settling_time": ((), settling, {"units": "s"}),
                "largest_multiplier": ((), multiplier, {"units": "1"}),
                "settled_part": (
                    (),
                    part,
                    {"units": "1", "long_name": "part of the run until it has settled"},
                ),
            },
            coords={"way": [*WAYS]},
        )
    )


class SteadyStates(Experiment):
    """Do shooting, a rotor of prescribed speed and a long run give the same settled velocity?"""

    says = "The paper runs its motor for 0.1 s from rest and draws what it does on the way."

    def size(self) -> tuple[int, list[str]]:
        """Return the number of motors and the laws; the short form is one motor under two laws."""
        return (1, ["newton", "hertz_penalty"]) if self.short else (MOTORS, list(LAWS))

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield a task for every motor under every law."""
        (setup,) = setups.values()
        motors, laws = self.size()
        for number, motor in enumerate(drawn(setup)[:motors]):
            for law in laws:
                label = f"motor {number}, {law}"
                yield Task(label, three_ways, (under(motor, law), label))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return all motors under all laws."""
        motors, laws = self.size()
        index = pandas.Index(laws, name="law")
        rows = [xarray.concat(parts[i * len(laws) : (i + 1) * len(laws)], index) for i in range(motors)]
        every = xarray.concat(rows, "motor").transpose("motor", "law", "way")
        return every.assign_attrs(duration=setup.duration)

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a law: how many settle, how far the ways are apart, and what they cost."""
        rows: list[dict[str, object]] = []
        for law in data.law.values:
            every, here = judged(data).sel(law=law), data.sel(law=law)
            settles = every.settles
            rows.append(
                {
                    "law": str(law),
                    "settle": int(settles.sum()),
                    "belt agrees": int((every.agrees_belt & settles).sum()),
                    "run agrees": int((every.agrees_run & settles).sum()),
                    "belt off, most [rad/s]": float(every.away_belt.where(settles).max()),
                    "ripple, most [rad/s]": float(here.error.sel(way="belt").where(settles).max()),
                    "run off, most [rad/s]": float(every.away_run.where(settles).max()),
                    "settling time, median [ms]": 1e3 * float(here.settling_time.median()),
                    "shooting [ms]": 1e3 * float(every.shooting.mean()),
                    "run to 1e-6 [ms]": 1e3 * float(every.settling.mean()),
                    "whole run [ms]": 1e3 * float(every.whole.mean()),
                    "run over shooting": float(every.settling.sum() / every.shooting.sum()),
                    "others": ", ".join(sorted({*map(str, here.kind.values[~settles.values])})),
                }
            )
        return rows

    def draw(self, data: xarray.Dataset) -> Figure:
        """Velocities of belt and run over those of shooting, and costs."""
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.4), layout="constrained")
        every = judged(data)
        for i, law in enumerate(data.law.values):
            here = every.sel(law=law)
            shot = data.velocity.sel(law=law, way="shooting").where(here.settles)
            mark: dict[str, Any] = {"color": f"C{i % 7}", "markersize": 3.5, "linestyle": "none"}
            away = np.maximum(here.away_run / np.abs(shot), 1e-14)
            left.loglog(np.abs(shot), np.maximum(here.away_belt / np.abs(shot), 1e-14), "o", **mark)
            left.loglog(np.abs(shot), away, "x", **mark)
            right.loglog(1e3 * here.shooting, 1e3 * here.settling, "os^Dv<>P"[i % 8], label=str(law), **mark)
        left.plot([], [], "o", color="0.3", label="root of the belt's torque")
        left.plot([], [], "x", color="0.3", label="run of 1 s")
        # Between what a belt leaves out and what a run has left.
        left.legend(loc=(0.02, 0.62))
        left.set_xlabel("velocity by shooting (rad/s)")
        left.set_ylabel("relative distance from it")
        ends = np.array(right.get_xlim())
        for factor, line in ((1.0, ":"), (10.0, "--"), (100.0, "-.")):
            right.plot(ends, factor * ends, line, color="0.6", linewidth=0.7, zorder=0)
            right.annotate(
                f"{factor:.0f} times", (ends[1], factor * ends[1]), ha="right", va="bottom", fontsize=6
            )
        right.set_xlabel("processor time of shooting (ms)")
        right.set_ylabel("of the run until it has settled (ms)")
        figure.legend(*right.get_legend_handles_labels(), loc="outside upper center", ncols=4)
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether the three ways agree within their errors, and what a steady state costs."""
        every = judged(data)
        count = int(every.settles.sum())
        belt, run = (int((every[f"agrees_{way}"] & every.settles).sum()) for way in ("belt", "run"))
        ratio = float(every.settling.sum() / every.shooting.sum())
        whole = float(every.whole.sum() / every.shooting.sum())
        settled = data.duration / data.settling_time.where(every.settles)
        others = np.isfinite(data.velocity.sel(way="run")) & ~every.settles
        alike = int((every.agrees_run & others).sum())
        rest = f" Of {int(others.sum())} without one the means agree for {alike}." if others.any() else ""
        return (
            f"Of {data.kind.size} motors with a law {count} settle to an orbit within the run, of "
            f"{float(settled.min()):.0f} settling times or more. The run agrees with shooting within their "
            f"errors for {run} of them, the belt within the rotor's ripple for {belt}. Shooting takes "
            f"{1e3 * float(every.shooting.mean()):.3g} ms of a processor in the mean; the run until it has "
            f"settled to 1e-6 takes {ratio:.3g} times as much, and to its end {whole:.3g} times.{rest}"
        ), bool(count and run == count and belt == count and whole >= CHEAPER)


if __name__ == "__main__":
    main(__file__)
