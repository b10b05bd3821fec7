"""The arguments of a simulation, refused in sentences, and the contact step where none is asked for."""

from math import inf
from typing import Final
from zlib import crc32

import numpy as np

from contactlab.checks import SMALLEST_STEP, check_kind, check_number, shown
from contactlab.engine.plant import Plant, persisting_rates, resolved_rate
from contactlab.engine.state import LEAVES, RUNNING, TOUCHING
from contactlab.laws.base import SET_VALUED, ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.declaration import refuse_unsound
from contactlab.motor import NormalModes
from contactlab.motor.motor import Motor

LARGEST_TURN: Final = 0.01
"""Largest step in rigid contact, times the tip's rate [1]."""


def default_contact_step(modes: NormalModes, law: ContactLaw) -> float:
    """Give the step in contact [s] of a law on a resonator, at most the law's `default_contact_step`.

    A rigid law that projects puts the tip back onto the closed gap after every step, after an impact at
    speed v by about v h / 2. That bends the modes, which costs or gives energy of the order of rate h
    times that of the impact and is in no term of the ledger, with

        rate^2 = sum_j row_j^2 min(omega_j, k_j/c_j)^2 / sum_j row_j^2,

    row_j being the tip's displacement in mode j; an overdamped mode counts by its slow root.
    """
    step = law.default_contact_step
    if not isinstance(law, MultiplierLaw) or not law.projects:
        return step
    row = modes.tip_displacement
    turning = float(np.linalg.norm(row * persisting_rates(modes.stiffness, modes.damping)))
    return min(step, LARGEST_TURN * float(np.linalg.norm(row)) / turning) if turning > 0.0 else step


def check_kinds(motor: Motor, law: ContactLaw) -> None:
    """Refuse what is no motor, or no law of either family, by a TypeError."""
    check_kind("The motor", motor, Motor)
    check_law(law)


def check_law(law: ContactLaw) -> None:
    """Refuse what is no law of either family by a TypeError."""
    if isinstance(law, str):
        raise TypeError(
            f"The law is the text {law!r}; it must be a law and not its name. "
            f"Make it: contactlab.law({law!r})."
        )
    check_kind("The law", law, ContactLaw)
    refuse_unsound(type(law))
    if not isinstance(law, PenaltyLaw | MultiplierLaw):
        raise TypeError(
            f"{type(law).__name__} is neither a PenaltyLaw nor a MultiplierLaw; derive it from one."
        )


def check_numbers(
    law: ContactLaw, duration: float, interval: float, step: float, tolerance: float | None
) -> None:
    """Refuse times, steps and a tolerance that no run can have; arguments and errors as of `simulate`."""
    for name, value in (("duration", duration), ("contact step", step)):
        check_number(f"The {name}", value)
        if not 0.0 < value < inf:
            raise ValueError(f"The {name} is {value} s; it must be positive and finite.")
    check_number("The record interval", interval)
    if not 0.0 < interval <= duration:
        raise ValueError(
            f"The record interval is {interval} s; it must be positive and at most the duration, "
            f"{duration} s."
        )
    if step < SMALLEST_STEP * duration:
        raise ValueError(
            f"The contact step is {step} s; it must be at least {SMALLEST_STEP * duration:.3g} s, "
            f"{SMALLEST_STEP:g} of the duration: shorter steps do not move the clock. Leave it out for the "
            "law's own default."
        )
    check_tolerance(law, tolerance)


def check_tolerance(law: ContactLaw, tolerance: float | None) -> None:
    """Refuse a tolerance that no step can have, and any of a rigid law; None is the default."""
    if tolerance is None:
        return
    if isinstance(law, MultiplierLaw):
        raise ValueError(
            f"The tolerance is {tolerance}, but {law.name} has no error control: its contact step sets its "
            "error. Leave the tolerance out."
        )
    check_number("The tolerance", tolerance)
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"The tolerance is {tolerance}; it must lie between 0 and 1.")


def check_rates(plant: Plant, duration: float) -> None:
    """Refuse a motor that moves too fast for the clock of its run, by a ValueError."""
    rate, most = resolved_rate(plant), 1.0 / (SMALLEST_STEP * duration)
    if rate > most:
        raise ValueError(
            f"The fastest mode or tone turns at {rate:.6g} rad/s; a run of {duration:.6g} s follows at most "
            f"{most:.3g} rad/s. Leave it out, or run shorter."
        )


def memory_mark(law: ContactLaw) -> int:
    """Give a number by which a memory is told from another law's; zero for none."""
    names = ",".join(f"{one.name} {one.life}" for one in law.internal_variables)
    return crc32(names.encode())


def check_start(start: object, plant: Plant, law: ContactLaw) -> None:
    """Refuse what is no state, another motor's, a failed run's, or in contact under another kind of law."""
    if not isinstance(start, dict) or not {"q", "v", *(LEAVES.names or ())} <= set(start):
        raise TypeError(
            f"The start is {shown(start)}; it must be the state of a trajectory, `trajectory.state`."
        )
    count = np.size(start["q"])
    if count != plant.mode_count:
        raise ValueError(
            f"The start is a state of {count - 1} modes, and the motor has {plant.mode_count - 1}; go on "
            "with a motor of as many."
        )
    if start["ending"] != RUNNING:
        raise ValueError(
            f"The start is the state of a run that failed at {start['time']:.6g} s; it cannot go on. Take a "
            "state of before."
        )
    friction = law.friction_kind if isinstance(law, PenaltyLaw) else SET_VALUED
    kind = isinstance(law, PenaltyLaw), friction, memory_mark(law)
    told = start["compliant"], start["friction_kind"], start["memory_of"]
    if start["phase"] == TOUCHING and told != kind:
        raise ValueError(
            f"The start is a state in contact under a law of another kind than {law.name}; cut the run in "
            "flight to go on with another kind."
        )
