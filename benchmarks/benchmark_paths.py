"""Laws on a path and behind a frame beside SciPy's LSODA on the same equation at the same error.

    python benchmarks/benchmark_paths.py [repeats] [--keep]

Processor times, the least of some repeats, in turn in one process: of an evaluation as in a fit
(`contactlab.driving.LawOnPath`), of a call of `contactlab.drive` with a thousand records, and of
`scipy.integrate.odeint` on the literature's equation in Python, with the path's velocity in closed form.
LSODA has the largest tolerance at which its forces are as near to a reference as those of the law's own loop
at its default, over the whole path or from kink to kink, whichever is less; the reference is by DOP853.
`--keep` puts the rows into paths.csv, from which experiments/results_pages.py writes docs/accuracy.md.
"""

import argparse
import csv
from collections.abc import Callable, Iterable
from itertools import pairwise
from math import cos, exp, pi, sinh
from pathlib import Path
from time import process_time
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.integrate import odeint, solve_ivp

import contactlab as cl
from contactlab.arrays import Array
from contactlab.driving import FIT_TOLERANCE, Frame, LawOnPath

KEPT: Final = Path(__file__).with_name("paths.csv")
"""Times by case [s], and errors of the force over its largest value [1]."""

LOAD: Final = 10.0
TOLERANCES: Final = np.geomspace(1e-3, 1e-12, 19)
STARTS: Final = 3
"""Timings of a tolerance before one is chosen."""


class Case(NamedTuple):
    """A law on a path, and its equation.

    Args:
        law, time, slip, degree, frame, instants: as of `LawOnPath`, under the normal force `LOAD`.
        rates: y' of a time and a state y.
        friction: [N] of times and states, shape (time, state).
        start, sizes: y at the start, and the sizes that errors of it are relative to.
        kinks: times at which y' has one [s].
    """

    law: cl.ContactLaw
    time: Array
    slip: Array
    degree: int
    frame: Frame | None
    instants: Array
    rates: Callable[[float, Any], list[float]]
    friction: Callable[[Array, Array], Array]
    start: list[float]
    sizes: list[float]
    kinks: list[float]


def lugre() -> Case:
    """Return a loop of LuGre's friction, 100 ms at 20 Hz."""
    own = cl.LuGre()
    mu, rise = own.friction_coefficient, own.friction_coefficient * (own.static_ratio - 1.0)
    s0, s1, scale, size, turn = (
        own.bristle_stiffness,
        own.bristle_damping,
        own.stribeck_velocity,
        1e-4,
        40.0 * pi,
    )

    def rates(t: float, y: Any) -> list[float]:
        v = size * turn * cos(turn * t)
        return [v - s0 * abs(v) * y[0] / (mu + rise * exp(-((v / scale) ** 2)))]

    def friction(t: Array, y: Array) -> Array:
        v = size * turn * np.cos(turn * t)
        flow = v - s0 * np.abs(v) * y[:, 0] / (mu + rise * np.exp(-((v / scale) ** 2)))
        return -LOAD * (s0 * y[:, 0] + s1 * flow)

    time = np.linspace(0.0, 0.1, 401)
    kinks = [(n + 0.5) * pi / turn for n in range(4)]
    slip = size * np.sin(turn * time)
    return Case(
        cl.Composed(friction=own), time, slip, 7, None, time, rates, friction, [0.0], [mu / s0], kinks
    )


def dahl() -> Case:
    """Return a loop of Dahl's friction, 100 ms at 20 Hz."""
    own = cl.Dahl()
    mu, sigma, size, turn = own.friction_coefficient, own.rest_stiffness, 1e-5, 40.0 * pi

    def rates(t: float, y: Any) -> list[float]:
        v = size * turn * cos(turn * t)
        return [v - abs(v) * sigma * y[0] / mu]

    time = np.linspace(0.0, 0.1, 401)
    kinks = [(n + 0.5) * pi / turn for n in range(4)]

    def friction(_: Array, y: Array) -> Array:
        return -LOAD * sigma * y[:, 0]

    slip = size * np.sin(turn * time)
    return Case(
        cl.Composed(friction=own), time, slip, 7, None, time, rates, friction, [0.0], [mu / sigma], kinks
    )


def dahl_behind_a_frame() -> Case:
    """Return Dahl's friction behind a spring and a dashpot, a second at 1 Hz."""
    own = cl.Dahl(friction_coefficient=0.3, rest_stiffness=1e6)
    mu, sigma, size, turn = 0.3, 1e6, 4e-6, 2.0 * pi
    stiffness, damping = 4e5, 2e3

    def rates(t: float, y: Any) -> list[float]:
        stretches = (LOAD * sigma * y[1] - stiffness * y[0]) / damping
        v = size * turn * cos(turn * t) - stretches
        return [stretches, v - abs(v) * sigma * y[1] / mu]

    def friction(_: Array, y: Array) -> Array:
        return -LOAD * sigma * y[:, 1]

    time = np.linspace(0.0, 1.0, 401)
    slip, frame = size * np.sin(turn * time), Frame(stiffness, damping)
    sizes = [size, mu / sigma]
    # Where the slip reverses is not known before.
    return Case(cl.Composed(friction=own), time, slip, 7, frame, time, rates, friction, [0.0, 0.0], sizes, [])


def rock() -> Case:
    """Return two velocity steps of rate and state behind a spring, 40 s."""
    a, b, distance, v0, mu = 0.01, 0.013, 1e-5, 1e-6, 0.6
    own = cl.RateAndState(mu, a, b, distance, v0, fresh_age=distance / v0, creep_velocity=1e-14)
    stiffness, speeds, edges = 3.0 * (b - a) * LOAD / distance, (v0, 10.0 * v0, v0), [0.0, 10.0, 20.0, 40.0]

    def rates(t: float, y: Any) -> list[float]:
        pull = speeds[int(t > edges[1]) + int(t > edges[2])]
        v = 2.0 * v0 * sinh(y[0] / (LOAD * a)) * exp(-(mu + b * y[1]) / a)
        return [stiffness * (pull - v), (v0 * exp(-y[1]) - v) / distance]

    def friction(_: Array, y: Array) -> Array:
        return -y[:, 0]

    way = np.append(0.0, np.cumsum(speeds * np.diff(edges)))
    time, instants, frame = np.array(edges), np.linspace(0.0, 40.0, 401), Frame(stiffness, force=mu * LOAD)
    start, sizes, law = [mu * LOAD, 0.0], [mu * LOAD, 1.0], cl.Composed(friction=own)
    return Case(law, time, way, 1, frame, instants, rates, friction, start, sizes, edges[1:3])


CASES: Final[dict[str, Callable[[], Case]]] = {
    "lugre, on the path": lugre,
    "dahl, on the path": dahl,
    "dahl, behind a frame": dahl_behind_a_frame,
    "rate_and_state, behind a frame": rock,
}


def from_kink_to_kink(case: Case, kinks: Iterable[float], solve: Callable[[Array, Any], Array]) -> Array:
    """Return the states at the instants of a case, by a solver of one smooth part."""
    states, state = [np.array([case.start])], np.array(case.start)
    for begin, end in pairwise([case.instants[0], *kinks, case.instants[-1]]):
        inside = case.instants[(case.instants > begin) & (case.instants <= end)]
        # Just behind a kink, where the part after it holds.
        stops = np.unique([np.nextafter(begin, np.inf), *inside, end])
        part = solve(stops, state)
        states.append(part[np.searchsorted(stops, inside)])
        state = part[-1]
    return np.concatenate(states)


def by_lsoda(case: Case, tolerance: float, kinks: Iterable[float]) -> Array:
    """Return the friction at the instants of a case [N]."""
    errors: Any = {"rtol": tolerance, "atol": tolerance * np.array(case.sizes), "mxstep": 100_000}
    states = from_kink_to_kink(case, kinks, lambda t, y: odeint(case.rates, y, t, tfirst=True, **errors))
    return case.friction(case.instants, states)


def reference(case: Case) -> Array:
    """Return the friction at the instants of a case [N], by another method and a far smaller tolerance."""
    errors: Any = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14 * np.array(case.sizes)}
    states = from_kink_to_kink(
        case, case.kinks, lambda t, y: solve_ivp(case.rates, (t[0], t[-1]), y, t_eval=t, **errors).y.T
    )
    return case.friction(case.instants, states)


def seconds(function: Callable[[], object]) -> float:
    """Return the processor time of a call [s]."""
    begun = process_time()
    function()
    return process_time() - begun


def measured(case: Case, repeats: int) -> dict[str, float]:
    """Return times [s] and errors [1] of a case."""
    exact = reference(case)

    def error(friction: Array) -> float:
        # The first instant lies just behind the start.
        return float(np.abs(friction - exact)[1:].max() / np.abs(exact).max())

    path: dict[str, Any] = {"normal": LOAD, "slip": case.slip, "degree": case.degree}
    loop = LawOnPath(case.law, case.time, **path, frame=case.frame, instants=case.instants)
    loop.run(case.law)
    own = error(loop.path.forces[:, 1])
    tried: list[tuple[float, float, Callable[[], Array]]] = []
    for kinks in [[], case.kinks] if case.kinks else [[]]:
        for tolerance in TOLERANCES:

            def solve(tolerance: float = tolerance, kinks: list[float] = kinks) -> Array:
                return by_lsoda(case, tolerance, kinks)

            if (missed := error(solve())) <= own:
                tried.append((min(seconds(solve) for _ in range(STARTS)), missed, solve))
                break
    if not tried:
        raise RuntimeError(f"LSODA is nowhere as near to the reference as {own:.1e}.")
    _, missed, lsoda = min(tried, key=lambda each: each[0])
    frame = case.frame.numbers if case.frame else {}
    # A case is called as a user calls it, at the same tolerance.
    calls: dict[str, Callable[[], object]] = {
        "evaluation": lambda: loop.run(case.law),
        "call": lambda: cl.drive(case.law, case.time, **path, **frame, tolerance=FIT_TOLERANCE),
        "LSODA": lsoda,
    }
    times = dict.fromkeys(calls, np.inf)
    for _ in range(repeats + 1):
        for name, call in calls.items():
            times[name] = min(times[name], seconds(call))
    return times | {"error": own, "error of LSODA": missed}


def kept() -> dict[str, dict[str, float]]:
    """Return the rows that were kept, by case."""
    with KEPT.open(encoding="utf-8", newline="") as file:
        return {row.pop("case"): {k: float(x) for k, x in row.items()} for row in csv.DictReader(file)}


def keep(rows: dict[str, dict[str, float]]) -> None:
    """Write rows into the file."""
    with KEPT.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", *next(iter(rows.values()))])
        writer.writerows([name, *(f"{x:.4g}" for x in row.values())] for name, row in rows.items())


def main() -> None:
    """Print the rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("repeats", nargs="?", type=int, default=20)
    parser.add_argument("--keep", action="store_true", help=f"put the rows into {KEPT.name}")
    arguments = parser.parse_args()
    rows = {}
    for name, case in CASES.items():
        rows[name] = measured(case(), arguments.repeats)
        print(f"{name:32}" + ", ".join(f"{k} {x:.3g}" for k, x in rows[name].items()), flush=True)
    if arguments.keep:
        keep(rows)


if __name__ == "__main__":
    main()
