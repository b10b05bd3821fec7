"""Runs that claims are made about."""

from contactlab.engine import simulate
from contactlab.laws import ContactLaw
from contactlab.motor.motor import Motor
from contactlab.trajectory import Trajectory


def run(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
) -> Trajectory:
    """A run that must reach its end; without a record interval it is recorded at its ends only.

    Raises:
        RuntimeError: it did not.
    """
    return completed(attempt(motor, law, duration, contact_step, record_interval, tolerance))


def attempt(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
) -> Trajectory:
    """A run as `run` makes it, whatever becomes of it."""
    return simulate(
        motor,
        law,
        duration=duration,
        record_interval=duration if record_interval is None else record_interval,
        contact_step=contact_step,
        tolerance=tolerance,
    )


def completed(trajectory: Trajectory) -> Trajectory:
    """A run that has reached its end.

    Raises:
        RuntimeError: it has not.
    """
    if not trajectory.ending.reached_end:
        raise RuntimeError(f"{trajectory.law.name}: {trajectory.message}")
    return trajectory


def first(trajectory: Trajectory, name: str) -> float:
    """A column of the first contact."""
    return float(trajectory.contacts[name][0])


def last(trajectory: Trajectory, name: str) -> float:
    """The last record of a series."""
    return float(trajectory.series[name][-1])
