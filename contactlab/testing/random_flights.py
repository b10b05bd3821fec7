"""Random free flights through the engine, and whether it finds the first touch-down of each."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from math import inf
from typing import Final

import numpy as np
import pandas as pd

from contactlab.laws import HertzPenalty
from contactlab.motor import NormalModes, RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.testing.claim import REFERENCES, Claims, at_least, at_most, proof
from contactlab.testing.flights import Flight, double_well, flight_of
from contactlab.testing.plants import run

DURATION = 1e-3
"""Longest flight [s]."""

AFTER_TOUCH = 2e-6
"""How long a flight goes on where it should have touched [s]."""

TIME_DIGIT = 1e-15
"""Error of a touch-down [s] on top of the gap's round-off over its rate, see `Flight.round_off`."""

KINDS: Final = ("any clearance", "graze", "double dip", "double well", "resonance")
"""How the clearance of a flight is found, see `random_flight`."""

FAULTS: Final = ("missed", "late", "invented")
"""What may be wrong with a touch-down, see `judge`."""

SHAPES = (2, 4, 6)
"""Beam shapes of the resonators: up to 6 overdamped modes, decays down to a microsecond."""


def random_flight(seed: int, number: int) -> tuple[str, Flight]:
    """Draw kind and flight of a number; every pair of seed and number is a flight of its own.

        any clearance   10 nm to 3 um, by its logarithm
        graze           one of the lowest points so far dips or misses by 1e-14 to 1e-9 m
        double dip      the same, with a fast tone that makes a lower dip follow within microseconds
        double well     two dips within what may be one step of the engine; the first dips or misses
        resonance       damped by 0.1 to 10 1/s, a tone at the first natural frequency or off by up to 1 %,
                        so that the steady state may be 1e5 times what moves; half of them grazes

    Drives have one to four tones between 1 and 20 kHz with any amplitudes and phases; the fast tone
    lies between 30 and 200 kHz. Those of the double wells are solved for, up to 100 V.
    """
    rng = np.random.default_rng([seed, number])
    kind = KINDS[int(rng.choice(len(KINDS), p=(0.25, 0.25, 0.17, 0.17, 0.16)))]
    modes = _modes(int(rng.choice(SHAPES)))
    if kind == "double well":
        return kind, _well(rng, modes)
    drive = _slow_tones(rng)
    if kind == "resonance":
        modes, drive = _at_resonance(rng, modes, drive)
    if kind == "double dip":
        drive = _with_fast_tone(rng, modes, drive)
    flight = flight_of(Motor(modes, drive))
    if kind == "any clearance" or (kind == "resonance" and rng.random() < 0.5):
        return kind, flight.with_clearance(10.0 ** rng.uniform(-8.0, -5.5))
    far = flight.with_clearance(1e-4)
    times, heights = far.minima(DURATION)
    lowest = np.flatnonzero(heights <= np.minimum.accumulate(heights))
    if lowest.size == 0:
        return kind, far
    chosen = int(rng.choice(lowest))
    if kind == "double dip" and lowest.size > 1:
        # The dip that is followed by the one that is lower by least.
        chosen = int(lowest[np.diff(heights[lowest]).argmax()])
    miss = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-14.0, -9.0))
    close = far.lowered_to(miss, float(times[chosen]))
    # Tones that only ever pull the tip away leave no room for a clearance.
    return kind, close if close.motor.geometry.clearance > 0.0 else far


def judge(flight: Flight) -> dict[str, float]:
    """Run one flight through the engine, up to its first touch-down and a little further.

    Returns:
        Whether it `touched` by the reference; whether the engine `missed` that, `invented` a touch-down
        where there is none or before there is one, or found one too `late`; the `error` of its time [s],
        and the `excess` of that over what round-off explains [s], infinite where there is no time.

    Raises:
        RuntimeError: the engine gave the run up.
    """
    expected = flight.first_touch(DURATION)
    end = DURATION if expected is None else min(expected + AFTER_TOUCH, DURATION)
    made = run(flight.motor, HertzPenalty(stiffness=1e10, friction_coefficient=0.0), end)
    found = made.contacts["start_time"]
    touched, invented = expected is not None, expected is None and found.size > 0
    missed, late, error = touched and found.size == 0, False, 0.0
    excess = inf if missed or invented else -inf
    if expected is not None and found.size > 0:
        error = float(found[0]) - expected
        rate = abs(float(flight.at(expected)[1]))
        excess = abs(error) - flight.round_off(expected, made.statistics["flight_steps"]) / rate
        invented, late = excess > TIME_DIGIT and error < 0.0, excess > TIME_DIGIT and error > 0.0
    faults = {"missed": missed, "invented": invented, "late": late}
    return {"touched": touched, **faults, "error": abs(error), "excess": excess}


def judged(seed: int, numbers: Iterable[int]) -> pd.DataFrame:
    """Run the random flights with these numbers; gives a row for each, see `judge`.

    Raises:
        RuntimeError: the engine gave a run up; with its flight, which `random_flight` gives again.
    """
    rows = []
    for number in numbers:
        kind, flight = random_flight(seed, number)
        try:
            rows.append({"kind": kind, "number": number, **judge(flight)})
        except RuntimeError as error:
            raise RuntimeError(f"Flight {number} of seed {seed}: {error}") from error
    return pd.DataFrame(rows)


def tally(flights: pd.DataFrame) -> pd.DataFrame:
    """Count the flights of every kind; give the largest error and excess, and the number of the latter."""
    return flights.groupby("kind").agg(
        flights=("number", "size"),
        **{name: (name, "sum") for name in ("touched", *FAULTS)},
        **{name: (name, "max") for name in ("error", "excess")},
        worst=("excess", lambda excess: flights.loc[excess.idxmax(), "number"]),
    )


@proof(REFERENCES)
def random_touchdowns(flights: int = 1000, seed: int = 0) -> Claims:
    """Flights that touch, graze by less than a nanometre, dip twice, or dip between two samples."""
    for kind, found in tally(judged(seed, range(flights))).iterrows():
        words = f"random flights, {kind}"
        yield at_least(f"{words}: of them touch", found["touched"], 1)
        for fault in FAULTS:
            statement = f"{words}: touch-downs {fault} of {found['flights']:.0f} flights"
            yield at_most(statement, found[fault], 0)


@cache
def _modes(shapes: int) -> NormalModes:
    return RitzResonator(shapes=shapes).modes


def _slow_tones(rng: np.random.Generator) -> Drive:
    tones = int(rng.integers(1, 5))
    size = 10.0 ** rng.uniform(0.5, 2.0)
    phasors = rng.normal(size=(2, tones)) + 1j * rng.normal(size=(2, tones))
    return Drive(rng.uniform(1e3, 20e3, tones), size * phasors)


def _at_resonance(
    rng: np.random.Generator, modes: NormalModes, drive: Drive
) -> tuple[NormalModes, Drive]:
    """Give the same shapes with one small damping for all, and the first tone at the first of them."""
    weak = replace(modes, damping=np.full(modes.damping.size, 10.0 ** rng.uniform(-1.0, 1.0)))
    off = rng.choice([-1.0, 0.0, 1.0]) * 10.0 ** rng.uniform(-9.0, -2.0)
    frequency = drive.frequency.copy()
    frequency[0] = float(modes.natural_frequency[0]) * (1.0 + off)
    return weak, replace(drive, frequency=frequency)


def _well(rng: np.random.Generator, modes: NormalModes) -> Flight:
    """Give two minima 0.2 to 0.6 rad of the fastest tone apart, from 20 us on, tilted up to the barrier."""
    frequency = 4e3 * (np.arange(5) + rng.uniform(0.2, 1.0, 5))
    half = rng.uniform(0.1, 0.3) / (2.0 * np.pi * frequency.max())
    when = rng.uniform(2e-5, 3e-4)
    barrier, tilt = 1e-11, 1e-11 * rng.uniform(-0.5, 0.5)
    flight = double_well(modes, frequency, when, half, barrier, tilt)
    drive = flight.motor.drive
    share = min(1.0, 100.0 / float(np.abs(drive.phasors).max()))
    weak = flight_of(Motor(modes, replace(drive, phasors=share * drive.phasors)))
    weak = weak.with_clearance(1e-4)
    times, _ = weak.minima(when + 2.0 * half)
    miss = float(rng.choice([-1.0, 1.0]) * share * barrier * 10.0 ** rng.uniform(-3.0, -0.5))
    close = weak.lowered_to(miss, float(times[np.abs(times - when + half).argmin()]))
    return close if close.motor.geometry.clearance > 0.0 else weak


def _with_fast_tone(rng: np.random.Generator, modes: NormalModes, drive: Drive) -> Drive:
    """Give a drive and one more tone, which moves the tip by 1 to 100 nm once it is steady."""
    frequency = 10.0 ** rng.uniform(np.log10(30e3), np.log10(200e3))
    tone = 2j * np.pi * frequency
    phasors = rng.normal(size=2) + 1j * rng.normal(size=2)
    steady = modes.coupling @ phasors / (modes.stiffness + modes.damping * tone + tone**2)
    phasors *= 10.0 ** rng.uniform(-9.0, -7.0) / abs(modes.tip_displacement @ steady)
    return replace(
        drive,
        frequency=np.append(drive.frequency, frequency),
        phasors=np.column_stack([drive.phasors, phasors]),
    )
