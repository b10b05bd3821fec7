"""Checks of what a run is given: motor and law, times, steps and tolerance."""

from math import inf

from contactlab.checks import SMALLEST_STEP, check_kind, check_number, check_records
from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw, is_stepped
from contactlab.laws.declaration import refuse_unsound
from contactlab.motor.motor import Motor


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


def check_numbers(law: ContactLaw, duration: float, step: float | None, tolerance: float | None) -> None:
    """Refuse times, steps and a tolerance that no run can have; arguments and errors as of `simulate`."""
    times = {"duration": duration} | ({} if step is None else {"contact step": step})
    for name, value in times.items():
        check_number(f"The {name}", value)
        if not 0.0 < value < inf:
            raise ValueError(f"The {name} is {value} s; it must be positive and finite.")
    if step is not None and step < SMALLEST_STEP * duration:
        raise ValueError(
            f"The contact step is {step} s; it must be at least {SMALLEST_STEP * duration:.3g} s, "
            f"{SMALLEST_STEP:g} of the duration: shorter steps do not move the clock. Leave it out for the "
            "law's own default."
        )
    idle = f"{law.name} is stepped by {step} s, which sets its error" if is_stepped(law, step) else ""
    check_tolerance(tolerance, idle)


def check_tolerance(tolerance: float | None, idle: str = "") -> None:
    """Refuse a tolerance that no step can have, and any that is idle, for a reason; None is the default."""
    if tolerance is None:
        return
    if idle:
        raise ValueError(f"The tolerance is {tolerance}, but {idle}. Leave the tolerance out.")
    check_number("The tolerance", tolerance)
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"The tolerance is {tolerance}; it must lie between 0 and 1.")


def check_interval(law: ContactLaw, duration: float, interval: float) -> None:
    """Refuse a record interval [s] that no run of a duration [s] can have, or too many records."""
    check_number("The record interval", interval)
    if not 0.0 < interval <= duration:
        raise ValueError(
            f"The record interval is {interval} s; it must be positive and at most the duration, "
            f"{duration} s."
        )
    check_records(duration, interval, "The record interval, record_interval,", len(law.internal_variables))
