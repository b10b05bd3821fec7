"""Record interval, step in contact and tolerance of a run that is given none."""

from typing import Final

from contactlab.checks import SMALLEST_STEP
from contactlab.laws.base import ContactLaw, PenaltyLaw, is_stepped
from contactlab.motor.motor import Motor

DEFAULT_TOLERANCE = 1e-7
"""Error of the force at a compliant step's start, as an impulse over that of the contact; the step's end
converges with nearly twice the order of this estimate."""

RECORD_INTERVAL: Final = 1e-6
"""Shortest default time between records [s]."""

RECORD_TURN, CONTACT_TURN = 1.0 / 32.0, 1.0 / 512.0
"""Longest default record interval and step in contact, times the fastest rate that persists [rad]."""

DEFAULT_COUNT: Final = 1e5
"""Number of records, and of longest steps in contact, beyond which their defaults shorten no more."""


def run_numbers(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    record_interval: float | None,
    contact_step: float | None,
    tolerance: float | None,
) -> tuple[float, float | None, float | None]:
    """Return record interval [s], contact step [s] and tolerance [1] of a run, defaults in place of None.

    A rigid law in its limit has no contact step, time stepping no tolerance.
    """
    if record_interval is None:
        record_interval = default_record_interval(motor, duration)
    if contact_step is None:
        contact_step = default_contact_step(motor, law, duration)
    if tolerance is None and not is_stepped(law, contact_step):
        tolerance = DEFAULT_TOLERANCE
    return record_interval, contact_step, tolerance


def default_record_interval(motor: Motor, duration: float) -> float:
    """Return the time between records [s] of a run that has none of its own.

    It is a microsecond for fast motors and short runs, a share of the shortest period for slow ones, see
    `for_slow`, and at most the duration.
    """
    return min(for_slow(RECORD_INTERVAL, RECORD_TURN, motor, duration), duration)


def default_contact_step(motor: Motor, law: ContactLaw, duration: float) -> float | None:
    """Return the step in contact [s] of a law on a motor; None of a rigid law, which is solved in its limit.

    Of a compliant law, whose error does not depend on it, it is the law's `default_contact_step`, or longer
    for slow motors, see `for_slow`, and for runs of which it would be no part that moves the clock.
    """
    if isinstance(law, PenaltyLaw):
        shortest = max(law.default_contact_step, SMALLEST_STEP * duration)
        return for_slow(shortest, CONTACT_TURN, motor, duration)
    return None


def for_slow(shortest: float, turn: float, motor: Motor, duration: float) -> float:
    """Return a time [s] by which the fastest rate that persists turns by an angle [rad].

    It is at most the duration over `DEFAULT_COUNT`, as where nothing vibrates, and at least the shortest.
    """
    rate, longest = motor.persisting_rate, duration / DEFAULT_COUNT
    return max(shortest, min(turn / rate, longest) if rate > 0.0 else longest)
