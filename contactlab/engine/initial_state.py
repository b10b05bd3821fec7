"""The state that a run begins in: at t = 0, in the contact of another run, or where another run ended."""

from collections.abc import Mapping
from typing import Any, Final
from zlib import crc32

import numpy as np

from contactlab.checks import shown
from contactlab.engine.plant import Plant
from contactlab.engine.state import (
    NAMES,
    OPEN,
    PRESSED,
    RELEASED,
    RUNNING,
    STATE,
    TOUCHING,
    EndState,
    State,
    copy_of,
    new_record,
    state_as_value,
    state_from_value,
)
from contactlab.laws.base import SET_VALUED, ContactLaw, PenaltyLaw

GOES_ON: Final = (
    *("phase", "mode", "sign", "impact_speed", "memory", "law.variables_mark"),
    *("limits.release_gap", "limits.remembered", "normal_before", "friction_before"),
)
"""What a contact, or the residual indentation that the last one has left, is continued from."""

AT_REST: Final = 1e-14
"""Gap [m] up to which a run begins at rest in contact, not in flight."""


def memory_mark(law: ContactLaw) -> int:
    """Return a number that identifies the internal variables of a law; zero for none."""
    if not law.internal_variables:
        return 0
    # By names and lives: a parameter that changes leaves the variables what they were.
    names = ",".join(f"{each.name} {each.life}" for each in law.internal_variables)
    return crc32(names.encode())


def check_start(start: object, plant: Plant, law: ContactLaw) -> None:
    """Refuse what is no state, another motor's, a failed run's, or in contact under another kind of law."""
    if not isinstance(start, Mapping) or not (isinstance(start, EndState) or set(start) >= NAMES):
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
    state = start["law.compliant"], start["law.friction_kind"], start["law.variables_mark"]
    if start["phase"] == TOUCHING and state != kind:
        raise ValueError(
            f"The start is a state in contact under a law of another kind than {law.name}; cut the run in "
            "flight to go on with another kind."
        )


def phase_at(gap: float, rate: float) -> int:
    """Return the first phase of a motion from its gap [m], over that of a touch-down, and gap rate [m/s]."""
    if gap < 0.0 or (gap == 0.0 and rate < 0.0):
        return PRESSED
    return OPEN if gap > 0.0 else RELEASED


def overlap_at(gap: float, law: ContactLaw) -> str:
    """Return why a law cannot start at a gap [m]; nothing where it can."""
    if gap >= 0.0 or isinstance(law, PenaltyLaw):
        return ""
    return (
        f"The gap is {gap} m at the start; it must not be negative where the law is rigid: tip and rotor "
        "would overlap."
    )


# A first step continues a polynomial of zeros, of some length.
_FRESH: Final = new_record(
    STATE, length=1.0, least_remainder=np.inf, most_remainder=-np.inf, initial_energy=np.nan
)
_FRESH["limits"]["release_gap"] = np.inf


def fresh_state() -> Any:
    """Return the state of a run at t = 0, whose phase is not set yet."""
    return copy_of(_FRESH)


def state_in_contact(contact: State) -> Any:
    """Return the state of a run at t = 0 that goes on in the contact of another's `Trajectory.state`.

    Its motion is free, and so are its internal variables, see `Prepared.begin_with`.
    """
    nothing = np.zeros(0)
    value = state_as_value(fresh_state(), nothing, nothing)
    return state_from_value(value | {name: contact[name] for name in GOES_ON})[0]
