"""The arguments of a simulation, refused in sentences."""

from math import inf

from contactlab.checks import SMALLEST_STEP, check_kind, check_number
from contactlab.engine.plant import Plant, resolved_rate
from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.declaration import refuse_unsound
from contactlab.motor.motor import Motor


def check_kinds(motor: Motor, law: ContactLaw) -> None:
    """Refuse what is no motor or no law.

    Raises:
        TypeError: it is of another kind, or a law of neither family.
    """
    check_kind("The motor", motor, Motor)
    if isinstance(law, str):
        raise TypeError(
            f"The law is the text {law!r}; it must be a law and not its name. Make it from its class: "
            f"contactlab.laws.law_class({law!r})(...)."
        )
    check_kind("The law", law, ContactLaw)
    refuse_unsound(type(law))
    if not isinstance(law, PenaltyLaw | MultiplierLaw):
        raise TypeError(
            f"{type(law).__name__} is neither a PenaltyLaw nor a MultiplierLaw; derive it from one."
        )


def check_numbers(
    law: ContactLaw,
    duration: float,
    record_interval: float,
    contact_step: float,
    tolerance: float | None,
) -> None:
    """Refuse times, steps and a tolerance that no run can have; arguments as of `simulate`.

    Raises:
        TypeError: one is no number.
        ValueError: one is out of its range.
    """
    check_number("The duration", duration)
    check_number("The record interval", record_interval)
    check_number("The contact step", contact_step)
    if not 0.0 < duration < inf:
        raise ValueError(f"The duration is {duration} s; it must be positive and finite.")
    if not 0.0 < record_interval <= duration:
        raise ValueError(
            f"The record interval is {record_interval} s; it must be positive and at most the "
            f"duration, {duration} s."
        )
    if not 0.0 < contact_step < inf:
        raise ValueError(f"The contact step is {contact_step} s; it must be positive and finite.")
    if contact_step < SMALLEST_STEP * duration:
        raise ValueError(
            f"The contact step is {contact_step} s; it must be at least {SMALLEST_STEP * duration:.3g} s, "
            f"{SMALLEST_STEP:g} of the duration: shorter steps do not move the clock. Leave it out for the "
            "law's own default."
        )
    if tolerance is not None:
        if isinstance(law, MultiplierLaw):
            raise ValueError(
                f"The tolerance is {tolerance}, but {law.name} has no error control: its contact "
                "step sets its error. Leave the tolerance out."
            )
        check_number("The tolerance", tolerance)
        if not 0.0 < tolerance < 1.0:
            raise ValueError(f"The tolerance is {tolerance}; it must lie between 0 and 1.")


def check_rates(plant: Plant, duration: float) -> None:
    """Refuse a motor that moves too fast for the clock of its run.

    Raises:
        ValueError: what persists of its modes and tones has a period that the clock cannot see.
    """
    rate, most = resolved_rate(plant), 1.0 / (SMALLEST_STEP * duration)
    if rate > most:
        raise ValueError(
            f"The fastest mode or tone turns at {rate:.6g} rad/s; a run of {duration:.6g} s follows at most "
            f"{most:.3g} rad/s. Leave it out, or run shorter."
        )
