"""What others find: the paper's printed table, independent solvers, and flights in closed form.

Case A: placement 2, clearance 1 um, 100 V at 3210 and 6420 Hz, phase -pi/5, no load, from rest, at 5 ms.
Its numbers are those of two event-driven solvers that share no code with this package (DOP853 at a
relative tolerance of 1e-10, every switch an event); the tests run one of them again.
"""

from collections.abc import Iterable
from math import inf
from typing import Final

import pandas as pd

from contactlab.laws import HertzPenalty, LagrangeSlip, LagrangeStick
from contactlab.motor import RitzResonator
from contactlab.testing.claim import Claim, Claims, at_least, at_most, close
from contactlab.testing.flights import DURATION, Flight, random_flight
from contactlab.testing.plants import last, paper_motor, run
from contactlab.trajectory import Trajectory

PLACEMENTS = {"placement 1": (15.968e-3, 25.065e-3), "placement 2": (0.914e-3, 10.146e-3)}
"""Start and end of the first patch set [m]."""

TABLE_1 = {
    "placement 1": ((-0.016, -0.057, 0.006), (2.02e3, 5.38e3)),
    "placement 2": ((0.021, 0.027, 0.005), (3.21e3, 5.46e3)),
}
"""Couplings Gamma_11, Gamma_21, Gamma_31 [N/V] and frequencies f_1, f_2 [Hz] as printed in Table 1."""

DIGITS = {
    "rotor_velocity": (1e-6, "rad s-1"),
    "tip_normal_displacement": (1e-12, "m"),
    "tip_slope": (1e-10, "rad"),
    "normal_impulse": (5e-9, "N s"),
    "duration": (1e-9, "s"),
    "stick_duration": (1e-7, "s"),
}
"""What is compared of the compliant case: a few units of the last digit, unit."""

HERTZ_CASE_A = {
    0.3: (-0.4468048, -2.3727588e-6, 1.0026338e-4, 4.534830e-3, 9.908710e-4, 2.483e-4),
    0.0: (0.0, -2.3728353e-6, 1.0207838e-4, 4.534537e-3, 9.908446e-4, 0.0),
}
"""Their values by friction coefficient, K = 1e10 N m^-3/2."""

RIGID_CASE_A = {
    "rotor_velocity": (-0.448569, 5e-7, "rad s-1"),
    "normal_impulse": (3.380450e-3, 5e-10, "N s"),
    "duration": (5.198480e-4, 5e-11, "s"),
}
"""Rigid contact with tangentially rigid stick, mu = 0.3: value, half a unit of its last digit, unit."""

CASE_A_DURATION = 5e-3

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


def random_touchdowns(flights: int = 1000, seed: int = 0) -> Claims:
    """Flights that touch, graze by less than a nanometre, dip twice, or dip between two samples."""
    for kind, result in tally(judged(seed, range(flights))).iterrows():
        text = f"random flights, {kind}"
        yield at_least(f"{text}: of them touch", result["touched"], 1)
        for fault in FAULTS:
            statement = f"{text}: touch-downs {fault} of {result['flights']:.0f} flights"
            yield at_most(statement, result[fault], 0)


def printed_table() -> Claims:
    """The ten numbers of Table 1, to half a unit of the printed digit."""
    for placement, (start, end) in PLACEMENTS.items():
        resonator = RitzResonator(patch_start=start, patch_end=end)
        couplings, frequencies = TABLE_1[placement]
        coupling, frequency = resonator.matrices.coupling, resonator.modes.natural_frequency
        for i, printed in enumerate(couplings):
            text = f"Table 1, {placement}: coupling {i + 1}1"
            yield Claim(text, printed, float(coupling[i, 0]), 0.5e-3, units="N V-1")
        for i, printed in enumerate(frequencies):
            text = f"Table 1, {placement}: frequency {i + 1}"
            yield Claim(text, printed, float(frequency[i]), 5.0, units="Hz")


def compliant_case_a() -> Claims:
    """The Hertz contact at default settings."""
    for mu, expected in HERTZ_CASE_A.items():
        made = run(paper_motor(), HertzPenalty(1e10, mu), CASE_A_DURATION)
        text = f"case A, hertz_penalty, mu {mu:g}"
        yield close(f"{text}: contacts", made.contacts["duration"].size, 16, 0.0)
        for value, (name, (digit, units)) in zip(expected, DIGITS.items(), strict=True):
            # Without friction there is none to round off.
            left = digit if value else 0.0
            yield Claim(f"{text}: {name}", value, _measure(made, name), left, units=units)


def rigid_case_a() -> Claims:
    """The rigid laws in their limit of no step; in time stepping an impact has its impulse over the step."""
    made = run(paper_motor(), LagrangeStick(0.3), CASE_A_DURATION)
    for name, (value, left, units) in RIGID_CASE_A.items():
        yield Claim(f"case A, lagrange_stick: {name}", value, _measure(made, name), left, units=units)
    text, law = "case A, lagrange_slip", LagrangeSlip(0.3)
    result = last(run(paper_motor(), law, CASE_A_DURATION), "rotor_velocity")
    # What the paper's time stepping tends to.
    yield Claim(f"{text}: velocity", -0.4836, result, 5e-5, units="rad s-1")
    steps = [run(paper_motor(), law, CASE_A_DURATION, step) for step in (5e-8, 2.5e-8)]
    peaks = [float(made.contacts["peak_normal_force"].max()) for made in steps]
    yield close(f"{text}: peak force at half the step", peaks[1] / peaks[0], 2.0, 1e-3)


def _measure(made: Trajectory, name: str) -> float:
    """Last record of a series, or the sum of a column of the contacts."""
    return last(made, name) if name in made.series else float(made.contacts[name].sum())
