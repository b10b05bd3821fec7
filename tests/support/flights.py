"""Free flights from rest in closed form, where they first touch the rotor, and flights of a wanted shape.

Every mode is the steady answer to its tones and two exponentials that cancel it at t = 0, unless it is
exactly critical: q(t) = Re sum_k S_k exp(i w_k t) + A exp(r_1 t) + B exp(r_2 t),  r^2 + c r + k = 0.

The first touch-down is searched on a dense grid, without any bound on the motion: whether a search that
has one is right can be judged by it.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import inf
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.laws import HertzPenalty
from contactlab.motor import NormalModes, RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.testing.plants import free_motion, run

Phasors = NDArray[np.complex128]

FAR = 1e-4
"""Clearance [m] that no flight bridges."""

DURATION = 1e-3
"""Longest random flight [s]."""

RESONATORS = tuple(RitzResonator(shapes=shapes) for shapes in (2, 4, 6))
"""Up to six overdamped modes, decays down to a microsecond."""

KINDS: Final = ("any clearance", "graze", "double dip", "double well", "resonance")
"""How the clearance of a random flight is found, see `random_flight`."""


@dataclass(frozen=True)
class Flight:
    """Hold the tip of a motor that never touches: u [m] and th [rad] are real parts of sums of exponentials.

    `exponents` [1/s], `u` and `th` have the shape (term,).
    """

    motor: Motor
    exponents: Phasors
    u: Phasors
    th: Phasors

    def at(self, time: Array | float) -> tuple[Array, Array]:
        """Return gap [m] and gap rate [m/s], shape of the time, good to their own round-off."""
        return self._gap_and_rate(np.exp(np.multiply.outer(time, self.exponents)))

    def round_off(self, time: float, steps: int) -> float:
        """Return the round-off of the gap [m] at a time [s] that was reached in so many steps.

        A phase that has grown to |exponent| t is rounded by eps |exponent| t, and with it the rate of
        its term, which moves the slowest mode by its round-off over that mode's own rate. Operations
        are rounded independently of each other, so that n of them leave sqrt(n) times as much.
        """
        rates = np.abs(self.exponents)
        sizes = np.exp(self.exponents.real * time) * (1.0 + rates * time)
        sizes *= np.maximum(rates / np.sqrt(self.motor.modes.stiffness.min()), 1.0)
        slope = abs(float((np.exp(self.exponents * time) @ self.th).real))
        geometry = self.motor.geometry
        lever = geometry.tip_length * slope * (1.0 + geometry.tip_length / geometry.rotor_radius)
        gap = sizes @ np.abs(self.u) + lever * (sizes @ np.abs(self.th))
        # Sines, products and sums of its steady and free part: 16 roundings of a term in one step, about.
        eps = np.finfo(np.float64).eps * np.sqrt(16.0 * steps)
        return float(eps * (gap + geometry.clearance))

    def with_clearance(self, clearance: float) -> "Flight":
        """Return the same vibration under a rotor at another distance [m]."""
        geometry = replace(self.motor.geometry, clearance=clearance)
        return replace(self, motor=replace(self.motor, geometry=geometry))

    def lowered_to(self, gap: float, when: float) -> "Flight":
        """Return the same vibration with the clearance at which the gap [m] at a time [s] has this value."""
        flight = self
        for _ in range(3):
            # The gap follows the clearance but for the slope of the normal, 1e-8 and less.
            missing = gap - float(flight.at(when)[0])
            flight = flight.with_clearance(flight.motor.geometry.clearance + missing)
        return flight

    def on_grid(self, duration: float) -> tuple[Array, Array, Array]:
        """Return times [s], gaps [m] and gap rates [m/s]; at rest the rate is zero, not its round-off."""
        fastest = float(np.abs(self.exponents).max())
        # 16 points while the fastest exponential turns or decays by one: 100 a period.
        side = int(np.ceil(np.sqrt(16.0 * fastest * duration + 1.0)))
        step = duration / (side * side - 1)
        # exp(r (i side + j) step) is a product, so that a grid of n points takes 2 sqrt(n) exponentials.
        coarse, fine = (
            np.exp(np.multiply.outer(size * np.arange(side), self.exponents)) for size in (step * side, step)
        )
        gap, rate = self._gap_and_rate((coarse[:, None] * fine).reshape(side * side, -1))
        rate[0] = 0.0
        return step * np.arange(side * side, dtype=np.float64), gap, rate

    def minima(self, duration: float) -> tuple[Array, Array]:
        """Return times [s] and gaps [m] of the gap's local minima in (0, duration)."""
        time, _, rate = self.on_grid(duration)
        return self._turns(time, rate)

    def _turns(self, time: Array, rate: Array) -> tuple[Array, Array]:
        left = np.flatnonzero((rate[:-1] < 0.0) & (rate[1:] > 0.0))
        curvature = (rate[left + 1] - rate[left]) / time[1]
        turn = time[left] - rate[left] / curvature
        for _ in range(8):
            turn = np.clip(turn - self.at(turn)[1] / curvature, time[left], time[left + 1])
        return turn, self.at(turn)[0]

    def first_touch(self, duration: float) -> float | None:
        """Return the time at which the gap first falls to zero [s], between grid points too, or None."""
        time, gap, rate = self.on_grid(duration)
        turns, dips = self._turns(time, rate)
        end = min([*time[gap <= 0.0], *turns[dips <= 0.0]], default=None)
        if end is None:
            return None
        start = time[time < end][-1]
        return float(brentq(lambda t: self.at(t)[0], start, end, xtol=1e-19, rtol=1e-15))

    def _gap_and_rate(self, waves: Phasors) -> tuple[Array, Array]:
        """Gap [m] and its rate [m/s] from the exponentials in the last axis."""
        geometry, order = self.motor.geometry, self.exponents[:, None] ** [0, 1]
        u, u_rate, th, th_rate = np.moveaxis(
            (waves @ np.hstack([self.u[:, None] * order, self.th[:, None] * order])).real, -1, 0
        )
        arm, radius = geometry.tip_length, geometry.rotor_radius
        sine = np.sin(th)
        across, across_rate = -arm * sine, -arm * np.cos(th) * th_rate
        rise = u - geometry.clearance - 2.0 * arm * np.sin(0.5 * th) ** 2
        rise_rate = u_rate - arm * sine * th_rate
        distance = np.hypot(across, radius - rise)
        gap = (across**2 + rise**2 - 2.0 * radius * rise) / (distance + radius)
        return gap, (across * across_rate - (radius - rise) * rise_rate) / distance


def flight_of(motor: Motor) -> Flight:
    """Return the closed flight of a motor from rest."""
    return Flight(motor, *free_motion(motor))


def drive_through(modes: NormalModes, frequency: Array, when: float, u: Array, th: Array) -> Drive:
    """Return the weakest drive whose tip, from rest, has these derivatives at an instant [s].

    u and th have the orders 0, 1, ... [m/s^n], [rad/s^n], equally many; NaN leaves one free. The motion is
    linear in the phasors, four real unknowns to each tone [Hz]: they follow from a linear system of least
    norm.
    """
    order = np.arange(u.size)
    reals = np.eye(2 * frequency.size)
    units: Phasors = np.concatenate([reals, 1j * reals]).reshape(-1, 2, frequency.size)
    results = []
    for unit in units:
        flight = flight_of(Motor(modes, Drive(frequency, unit)))
        waves = np.exp(flight.exponents * when)[:, None] * flight.exponents[:, None] ** order
        results.append(np.concatenate([(flight.u @ waves).real, (flight.th @ waves).real]))
    # Derivatives in the time of the fastest tone, so that all are of one size.
    scale = np.tile((2.0 * np.pi * frequency.max()) ** -order.astype(np.float64), 2)
    wanted = np.concatenate([u, th]) * scale
    values = ~np.isnan(wanted)
    system = (np.array(results).T * scale[:, None])[values]
    sizes = np.linalg.lstsq(system, wanted[values], rcond=None)[0]
    return Drive(frequency, np.tensordot(sizes, units, axes=1))


def double_well(
    modes: NormalModes, frequency: Array, when: float, half: float, barrier: float, tilt: float
) -> Flight:
    """Return a flight whose gap has two minima, `half` before and after an instant [s], that stand at zero.

        g(when + x) = barrier ((x/half)^2 - 1)^2 + tilt x / half

    to the fifth order, and the slope th stays zero as long: the second minimum is higher by twice the tilt
    [m]. Steps that see only the ends of what lies between see nothing of it. It takes three tones [Hz] or
    more, and half of a small part of the fastest period.
    """
    shape = np.array([np.nan, tilt, -4.0 * barrier, 0.0, 24.0 * barrier, 0.0])
    u = -shape / half ** np.arange(6.0)
    drive = drive_through(modes, frequency, when, u, np.zeros(6))
    return flight_of(Motor(modes, drive)).with_clearance(FAR).lowered_to(barrier, when)


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
    modes = RESONATORS[int(rng.choice(len(RESONATORS)))].modes
    if kind == "double well":
        return kind, _well(rng, modes)
    tones = int(rng.integers(1, 5))
    size = 10.0 ** rng.uniform(0.5, 2.0)
    phasors = rng.normal(size=(2, tones)) + 1j * rng.normal(size=(2, tones))
    frequency = rng.uniform(1e3, 20e3, tones)
    if kind == "resonance":
        modes = replace(modes, damping=np.full(modes.damping.size, 10.0 ** rng.uniform(-1.0, 1.0)))
        off = rng.choice([-1.0, 0.0, 1.0]) * 10.0 ** rng.uniform(-9.0, -2.0)
        frequency[0] = float(modes.natural_frequency[0]) * (1.0 + off)
    phasors *= size
    if kind == "double dip":
        # One more tone moves the tip by 1 to 100 nm once it is steady.
        fast = 10.0 ** rng.uniform(np.log10(30e3), np.log10(200e3))
        volts, tone = rng.normal(size=2) + 1j * rng.normal(size=2), 2j * np.pi * fast
        steady = modes.coupling @ volts / (modes.stiffness + modes.damping * tone + tone**2)
        volts *= 10.0 ** rng.uniform(-9.0, -7.0) / abs(modes.tip_displacement @ steady)
        frequency, phasors = np.append(frequency, fast), np.column_stack([phasors, volts])
    flight = flight_of(Motor(modes, Drive(frequency, phasors)))
    if kind == "any clearance" or (kind == "resonance" and rng.random() < 0.5):
        return kind, flight.with_clearance(10.0 ** rng.uniform(-8.0, -5.5))
    far = flight.with_clearance(FAR)
    times, heights = far.minima(DURATION)
    lowest = np.flatnonzero(heights <= np.minimum.accumulate(heights))
    if lowest.size == 0:
        return kind, far
    chosen = int(rng.choice(lowest))
    if kind == "double dip" and lowest.size > 1:
        # The dip that is followed by the one that is lower by least.
        chosen = int(lowest[np.diff(heights[lowest]).argmax()])
    return kind, _grazing(rng, far, float(times[chosen]), -14.0, -9.0)


def _grazing(rng: np.random.Generator, far: Flight, when: float, low: float, high: float) -> Flight:
    """Return a flight that dips or misses at a time [s] by 10^low to 10^high [m], or the far one."""
    miss = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(low, high))
    close = far.lowered_to(miss, when)
    # Tones that only ever pull the tip away leave no room for a clearance.
    return close if close.motor.geometry.clearance > 0.0 else far


def _well(rng: np.random.Generator, modes: NormalModes) -> Flight:
    """Return two minima 0.2 to 0.6 rad of the fastest tone apart, from 20 us on, tilted up to the barrier."""
    frequency = 4e3 * (np.arange(5) + rng.uniform(0.2, 1.0, 5))
    half = rng.uniform(0.1, 0.3) / (2.0 * np.pi * frequency.max())
    when = rng.uniform(2e-5, 3e-4)
    barrier, tilt = 1e-11, 1e-11 * rng.uniform(-0.5, 0.5)
    drive = double_well(modes, frequency, when, half, barrier, tilt).motor.drive
    share = min(1.0, 100.0 / float(np.abs(drive.phasors).max()))
    drive = replace(drive, phasors=share * drive.phasors)
    weak = flight_of(Motor(modes, drive)).with_clearance(FAR)
    times, _ = weak.minima(when + 2.0 * half)
    dip, depth = float(times[np.abs(times - when + half).argmin()]), np.log10(share * barrier)
    return _grazing(rng, weak, dip, depth - 3.0, depth - 0.5)


FAULTS: Final = ("missed", "late", "invented")
"""What may be wrong with a touch-down, see `judge`."""


def judge(flight: Flight) -> dict[str, float]:
    """Run one flight through the engine, up to its first touch-down and a little further.

    Gives whether it `touched` by the reference; whether the engine `missed` that, `invented` a touch-down
    where there is none or before there is one, or found one too `late`; the `error` of its time [s],
    and the `excess` of that over what round-off explains [s], infinite where there is no time.
    """
    expected = flight.first_touch(DURATION)
    end = DURATION if expected is None else min(expected + 2e-6, DURATION)
    made = run(flight.motor, HertzPenalty(stiffness=1e10, friction_coefficient=0.0), end)
    result, error, excess = made.contacts["start_time"], 0.0, -inf
    if expected is not None and result.size > 0:
        error = float(result[0]) - expected
        rate = abs(float(flight.at(expected)[1]))
        excess = abs(error) - flight.round_off(expected, made.statistics["flight_steps"]) / rate
    elif expected is not None or result.size > 0:
        excess = inf
    fault = "missed" if result.size == 0 else "late" if error > 0.0 else "invented"
    # Round-off of the time itself is left.
    faults = {name: excess > 1e-15 and name == fault for name in FAULTS}
    return {"touched": expected is not None, **faults, "error": abs(error), "excess": excess}


def judged(seed: int, numbers: Iterable[int]) -> pd.DataFrame:
    """Run the random flights with these numbers; gives a row for each, see `judge`.

    A RuntimeError names the flight that the engine gave up; `random_flight` gives it again.
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
