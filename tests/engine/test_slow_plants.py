"""Default records and steps of slow plants, by rates and duration; motors keep theirs."""

from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

import contactlab as cl
from contactlab import checks
from contactlab.checks import MOST_RECORDS
from contactlab.config import ConfigurationError
from contactlab.engine.defaults import (
    CONTACT_TURN,
    DEFAULT_COUNT,
    RECORD_INTERVAL,
    RECORD_TURN,
    default_contact_step,
    default_record_interval,
)
from contactlab.laws import Composed, HuntCrossley, LuGre

HERTZ = cl.HertzPenalty(stiffness=1e9)
HEIGHT = 0.1
FALLING = cl.ball(0.1, height=HEIGHT)


@given(st.floats(1e-4, 1e6), st.floats(1e-6, 1e5))
@example(1.0, 0.1)
def test_defaults_resolve_the_fastest_rate_and_are_no_more_than_the_run_needs(
    rate: float, duration: float
) -> None:
    plant = cl.oscillator(1.0, rate**2, gap=1.0)
    interval, step = default_record_interval(plant, duration), default_contact_step(plant, HERTZ, duration)
    assert step is not None
    for value, shortest, turn in ((interval, RECORD_INTERVAL, RECORD_TURN), (step, 4e-6, CONTACT_TURN)):
        assert value <= max(shortest, turn / rate * (1.0 + 1e-12))
        # What is shorter than both bounds is so for one of them.
        least = min(turn / rate, duration / DEFAULT_COUNT)
        assert value >= min(max(shortest, least), duration) * (1.0 - 1e-12)
    assert interval <= duration


@pytest.mark.parametrize("duration", [1e-7, 0.02, 1.0, 8567.0])
def test_motors_keep_their_microsecond_and_the_step_of_the_law(duration: float) -> None:
    motor = cl.build().motor
    assert default_record_interval(motor, duration) == min(1e-6, duration)
    assert default_contact_step(motor, HERTZ, duration) == 4e-6


def test_an_overdamped_mode_counts_by_its_slow_root() -> None:
    stiff = cl.oscillator(1.0, 1e8, damping=1e9, gap=1.0)
    assert default_record_interval(stiff, 1e4) == pytest.approx(0.1)


@pytest.mark.parametrize("law", [HERTZ, cl.Newton(restitution=1.0)], ids=["compliant", "rigid"])
@pytest.mark.parametrize("duration", [5.0, 143.0])
def test_an_elastic_ball_keeps_its_height_for_as_long_as_one_waits(
    law: cl.ContactLaw, duration: float
) -> None:
    run = cl.simulate(FALLING, law, duration=duration)
    assert run.complete, run.message
    assert run["gap"].size <= DEFAULT_COUNT + 2
    left = run.contacts["separation_velocity"].values
    left = left[np.isfinite(left)]
    assert left == pytest.approx(sqrt(2.0 * 9.81 * HEIGHT), rel=1e-5)
    period = 2.0 * sqrt(2.0 * HEIGHT / 9.81)
    assert abs(left.size - duration / period) < 2.0


def test_how_long_a_ball_rests_does_not_move_its_rebounds() -> None:
    law = cl.Newton(restitution=0.9)
    short, long = (cl.simulate(FALLING, law, duration=duration) for duration in (5.0, 8567.0))
    assert short.complete
    assert long.complete
    names = ["start_time", "approach_velocity"]
    before, after = (run.contacts[names].isel(contact=slice(40)).to_array() for run in (short, long))
    assert after.sizes["contact"] == 40
    np.testing.assert_allclose(after, before, rtol=1e-9)


def test_a_ball_that_rings_on_its_contact_is_no_stall() -> None:
    run = cl.simulate(FALLING, Composed(damping=HuntCrossley(0.8)), duration=5.0)
    assert run.complete, run.message


@pytest.mark.long
def test_stick_slip_of_bristles_takes_few_steps_and_has_the_same_digits() -> None:
    law = Composed(friction=LuGre(1.0, 1.5, 1e5, sqrt(1e5), 1e-3))
    depth = (1.0 / law.normal.stiffness) ** (2.0 / 3.0)
    rubbing = cl.belt(1.0, 2.0, belt_velocity=0.1, penetration=depth)
    slow = cl.simulate(rubbing, law, duration=40.0)
    fine = cl.simulate(rubbing, law, duration=40.0, contact_step=5e-5, record_interval=1.0)
    assert slow.state["contact_steps"] < 3e5
    ends = (float(run["tip_tangential_displacement"][-1]) for run in (slow, fine))
    assert next(ends) == pytest.approx(next(ends), abs=1e-8)


def test_records_that_do_not_fit_are_refused_by_key_and_size(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    duration = 8567.0
    with pytest.raises(ValueError, match=r"record_interval.*GB"):
        cl.simulate(FALLING, HERTZ, duration=duration, record_interval=1e-6)
    with pytest.raises(ValueError, match=r"record_interval.*GB"):
        cl.simulate(replace(cl.build(), duration=duration))
    for lines in ([], ["record.interval=1 us"]):
        with pytest.raises(ConfigurationError, match=r"record\.interval.*GB"):
            cl.build([f"solver.duration={duration}", *lines])
    few = tmp_path / "meminfo"
    few.write_text("MemTotal: 9 kB\nMemAvailable: 3800 kB\n")
    monkeypatch.setattr(checks, "MEMORY_INFO", few)
    with pytest.raises(ConfigurationError, match=r"record\.interval.*MB"):
        cl.build()
    assert cl.build(["record.interval=10 us"]).record_interval == 1e-5
    monkeypatch.setattr(checks, "MEMORY_INFO", tmp_path / "absent")
    assert cl.build([f"record.interval={0.02 / MOST_RECORDS}"])
