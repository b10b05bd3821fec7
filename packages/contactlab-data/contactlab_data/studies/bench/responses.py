"""Answers of a contact law to the questions of the bench: blocks and balls as runs, impacts by the law."""

from contextlib import suppress
from itertools import groupby
from time import process_time
from typing import Any, Final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.equilibrium import penetrations
from contactlab.impacts import impact
from contactlab.laws import ContactLaw, LawError, PenaltyLaw
from contactlab.motor.bodies import ball, block, way_of
from contactlab.simulation import simulate
from contactlab_data.inference.calibration import identify
from contactlab_data.studies.bench.measures import Numbers, of_block, of_bounce
from contactlab_data.studies.bench.questions import questions

SPEED: Final = 1.0
"""Speed at which a law is given the restitution of a question [m/s]; at others it has what it has."""

REPEATS: Final = 2
"""How often a question is put; what is compiled at first has no part in the time."""


def responses_of(law: ContactLaw) -> tuple[Array, Array]:
    """Return the answers of a law to every question, and their processor times [s], shape (case,) each.

    Friction (the numbers with the symbol mu) and restitution are those of the question, all else is the
    law's. NaN where it has no answer.
    """
    laws, values, seconds = dict[tuple[float, ...], ContactLaw | None](), list[float](), list[float]()
    for (_, _, kind), group in groupby(questions()[0], lambda case: case[:3]):
        cases = [*group]
        numbers = cases[0].numbers
        key = numbers["friction"], numbers.get("restitution", -1.0)
        if key not in laws:
            laws[key] = _with(law, numbers)
        chosen, response, took = laws[key], dict[str, float](), 0.0
        if chosen is not None:
            for _ in range(REPEATS):
                began = process_time()
                with suppress(ValueError, LawError):
                    response = KINDS[kind](chosen, numbers)
                took = process_time() - began
        values += [response.get(case.quantity, np.nan) for case in cases]
        seconds += [took / len(cases)] * len(cases)
    return np.array(values), np.array(seconds)


def _with(law: ContactLaw, numbers: Numbers) -> ContactLaw | None:
    """Return a law with friction and restitution; None if it cannot have them.

    Without an impact the restitution is 0 where the law admits it.
    """
    places = [(name, each.symbol) for name, _, each in law.effective() if each is not None]
    names = [name for name, symbol in places if symbol == "e"]
    try:
        for name in (name for name, symbol in places if symbol == "mu"):
            law = law.changed(name, numbers["friction"])
        if "restitution" in numbers:
            datum = numbers["restitution"], SPEED
            return identify(law, mass=numbers["mass"], restitution=datum, free=names or None).law
    except ValueError:
        return None
    for name in names:
        with suppress(ValueError):
            law = law.changed(name, 0.0)
    return law


def _run(motor: Any, law: ContactLaw, duration: float, interval: float) -> Any:
    run = simulate(motor, law, duration=duration, record_interval=interval)
    if not run.complete:
        raise ValueError(run.message)
    return run


def _block(law: ContactLaw, numbers: Numbers) -> dict[str, float]:
    """Answer for a block on a plane; a compliant one begins at its equilibrium."""
    weight = numbers["mass"] * numbers["gravity"]
    cone, belt = numbers["friction"] * weight, numbers.get("belt_velocity", 0.0)
    depth = float(penetrations(law, np.array([weight]))[0]) if isinstance(law, PenaltyLaw) else 0.0
    motor = block(
        numbers["mass"],
        height=-depth,
        weight=weight,
        push=numbers["push"] * cone,
        push_amplitude=numbers.get("amplitude", 0.0) * cone,
        push_frequency=numbers.get("frequency", 1.0),
        stiffness=numbers.get("stiffness", 0.0),
        velocity=belt,
        belt_velocity=belt,
    )
    run = _run(motor, law, numbers["duration"], 1e-3)
    time = run["time"].values
    # On the belt, which friction does not brake.
    way = way_of(run["tip_slope"].values) - belt * time
    return of_block(numbers, time, way, float(run["slip_velocity"][-1]))


def _bounce(law: ContactLaw, numbers: Numbers) -> dict[str, float]:
    """Answer for a ball that falls onto the plane."""
    motor = ball(numbers["mass"], height=numbers["height"], gravity=numbers["gravity"])
    run = _run(motor, law, numbers["duration"], 1e-5)
    gap = run["gap"].values
    return of_bounce(numbers, run["time"].values, gap, float(gap[-1] - gap[-2]) / 1e-5)


def _impact(law: ContactLaw, numbers: Numbers) -> dict[str, float]:
    """Answer by the law itself, on the Delassus matrix of the bodies."""
    nn, nt, tt, rate, slip = (numbers[name] for name in ("nn", "nt", "tt", "rate", "slip"))
    made = impact(law, [[nn, nt], [nt, tt]], [rate, slip])
    after, along = made["velocity_after"].values[0].tolist()
    energy = 1.0 - float(made["energy_loss"].values[0]) / numbers["kinetic"]
    return {"rebound": -after / rate, "energy": energy, "slip": abs(along)}


KINDS: Final = {"block": _block, "bounce": _bounce, "impact": _impact, "linkage": _impact}
"""Functions that answer, by the kind of a question."""
