"""The pace of a run: how many events and steps in contact it may take within a period, and no more."""

from math import ceil, pi

from contactlab.engine.plant import Plant, motion_rate
from contactlab.engine.run import END, EVENT_LIMIT, MOST_STEPS, WINDOW, Run

STEP_LIMIT = 20_000
"""Steps in contact, rejected ones included, within the time that the pace of a run is watched over, on top
of twice those of the contact step, see `_window`; healthy runs take some 300, or 900 at tight tolerances."""


def set_pace(plant: Plant, run: Run, contact_step: float, compliant: bool) -> None:
    """Set the window that a run is watched over, and the steps in contact beyond which it stalls."""
    # No longer than the run: the slowest of modes may be one that hardly has a period.
    run.real[WINDOW] = min(_window(plant, contact_step, compliant), run.real[END])
    run.whole[MOST_STEPS] = STEP_LIMIT + 2 * ceil(run.real[WINDOW] / contact_step)


def _window(plant: Plant, contact_step: float, compliant: bool) -> float:
    """Time that the pace of a run is watched over [s]: a period of what makes its contacts.

    A rigid contact lasts a step at least, and the flight after it longer: its window is long enough for an
    event every fifth step to be chatter, if that is far from what a few periods bring. Where nothing has a
    period, the step alone says what is often.
    """
    rate = motion_rate(plant)
    often = (2.0 if compliant else 5.0) * EVENT_LIMIT * contact_step
    if rate == 0.0:
        return often
    period = 2.0 * pi / rate
    return period if compliant else max(period, min(often, 5.0 * period))
