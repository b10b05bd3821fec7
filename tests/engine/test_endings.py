"""How a run ends: at its end, cut, diverged, interrupted, or not begun at all."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.faulty_laws import NegativeBound, NoImpulse, NoNumber
from support.motors import case_a, default_motor, every_law, final, hertz, run

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, LagrangeStick
from contactlab.motor.motor import Motor
from contactlab.sweeps.state import status_of
from contactlab.testing.plants import block
from contactlab.trajectory import Ending

STEPS_PER_CALL = "contactlab.engine.simulation.STEPS_PER_CALL"

laws = pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)


def overdriven() -> Motor:
    """A motor at 1 MV, which no configuration allows."""
    motor = default_motor()
    return replace(motor, drive=replace(motor.drive, phasors=1e4 * motor.drive.phasors))


@laws
def test_interrupting_keeps_what_the_run_had(law: ContactLaw, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(STEPS_PER_CALL, 50)

    def interrupt(time: float) -> None:
        if time > 0.4e-3:
            raise KeyboardInterrupt

    cut = simulate(case_a(), law, duration=1e-3, record_interval=1e-5, progress=interrupt)
    assert cut.ending is Ending.INTERRUPTED
    assert not cut.complete
    assert "nterrupted" in cut.message
    whole = run(case_a(), law, 1e-3)
    records = cut.time.size
    assert 30 < records < 101
    assert np.array_equal(cut.time, whole.time[:records])
    assert np.array_equal(cut.series["tip_slope"], whole.series["tip_slope"][:records])


def test_a_contact_that_the_end_cuts_is_listed_without_a_separation() -> None:
    cut = run(case_a(), hertz(), 140e-6, 1e-6)
    assert len(cut.contacts["start_time"]) == 1
    assert np.isnan(cut.contacts["separation_velocity"][0])
    reached = cut.contacts["start_time"][0] + cut.contacts["duration"][0]
    assert reached == pytest.approx(140e-6, rel=1e-12)
    assert cut.contact_mode[-1] != 0
    # Still being pressed together: the last instant is the hardest one.
    deepest = -final(cut, "gap")
    assert cut.contacts["max_penetration"] == pytest.approx([deepest], rel=1e-9)
    assert cut.contacts["peak_normal_force"] == pytest.approx([1e10 * deepest**1.5], rel=1e-6)
    whole = run(case_a(), hertz(), 300e-6, 1e-6)
    assert whole.contacts["separation_velocity"][0] > 0.0
    assert whole.contacts["duration"][0] > cut.contacts["duration"][0]


ABSURD = """
import sys
sys.path.insert(0, {tests!r})
from dataclasses import replace
import numpy as np
from contactlab.engine import simulate
from contactlab.trajectory import Ending
from support.motors import default_motor, every_law, hertz

# What overflows on the way is what the ending is about.
np.seterr(all="ignore")
for law in every_law():
    for volts in (1e6, 1e9, 1e15, 1e30, 1e150):
        motor = default_motor()
        louder = volts / 100.0 * motor.drive.phasors
        motor = replace(motor, drive=replace(motor.drive, phasors=louder))
        result = simulate(motor, law, duration=1e-3, record_interval=1e-5)
        print(law.name, volts, result.ending is Ending.DIVERGED, result.message)
for stiffness in (1e20, 1e100, 1e300):
    motor, law = default_motor(), hertz(stiffness=stiffness)
    result = simulate(motor, law, duration=1e-3, record_interval=1e-5)
    ended = result.ending in (Ending.COMPLETE, Ending.DIVERGED, Ending.STALLED)
    print(law.name, stiffness, ended, "diverges")
"""


def test_absurd_voltages_and_stiffnesses_end_with_a_sentence_and_never_hang() -> None:
    # In a process of its own, so that a hang is a failure and not the end of all tests.
    script = ABSURD.format(tests=str(Path(__file__).parents[1]))
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    assert len(lines) == 18
    for line in lines:
        _, _, as_stated, message = line.split(maxsplit=3)
        assert as_stated == "True", line
        assert "diverges" in message


@pytest.mark.parametrize("law", [NoNumber(), NegativeBound(), NoImpulse()], ids=lambda law: law.name)
def test_a_law_that_answers_with_no_number_ends_the_run(law: ContactLaw) -> None:
    result = simulate(case_a(), law, duration=1e-3, record_interval=1e-5)
    assert result.ending is Ending.DIVERGED
    # What there was is kept, and is finite to the end.
    assert all(np.isfinite(series).all() for series in result.series.values())


def test_a_run_that_drowns_is_told_by_where_the_tip_is() -> None:
    with np.errstate(all="ignore"):
        motor = overdriven()
        result = simulate(motor, hertz(), duration=1e-3, record_interval=1e-5)
    assert result.ending is Ending.DIVERGED
    assert "the tip leans by" in result.message
    assert "1 rad is the most" in result.message
    assert "not finite" not in result.message


def test_a_diverged_run_holds_what_it_had() -> None:
    with np.errstate(all="ignore"):
        result = simulate(overdriven(), hertz(), duration=1e-3, record_interval=1e-6)
    assert result.ending is Ending.DIVERGED
    assert not result.complete
    assert 0.0 < result.time[-1] < 1e-3
    assert result.series["gap"].shape == result.time.shape


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"duration": 0.0}, "duration is 0.0 s; it must be positive"),
        ({"duration": -1.0}, "duration is -1.0 s"),
        ({"duration": float("nan")}, "duration is nan s"),
        ({"duration": float("inf")}, "duration is inf s; it must be positive and finite"),
        ({"record_interval": 0.0}, "record interval is 0.0 s; it must be positive"),
        ({"record_interval": 2e-3}, "at most the duration, 0.001 s"),
        ({"record_interval": float("nan")}, "record interval is nan s"),
        ({"contact_step": 0.0}, "contact step is 0.0 s"),
        ({"contact_step": float("nan")}, "contact step is nan s"),
        ({"tolerance": 0.0}, "tolerance is 0.0; it must lie between 0 and 1"),
        ({"tolerance": 1.0}, "tolerance is 1.0"),
    ],
)
def test_an_argument_out_of_range_is_refused_with_value_and_bound(
    arguments: dict[str, float], sentence: str
) -> None:
    given = {"duration": 1e-3, "record_interval": 1e-5} | arguments
    with pytest.raises(ValueError, match=sentence):
        simulate(case_a(), hertz(), **given)  # type: ignore[arg-type]


def test_a_rigid_law_refuses_a_tolerance_it_would_ignore() -> None:
    with pytest.raises(ValueError, match="lagrange_stick has no error control"):
        simulate(case_a(), LagrangeStick(0.3), duration=1e-3, record_interval=1e-5, tolerance=1e-6)


@laws
def test_a_start_in_touch_that_closes_is_a_contact_from_the_start(law: ContactLaw) -> None:
    ball = block(2e-3, gap_rate=-0.1, normal_stiffness=10.0)
    contacts = simulate(ball, law, duration=1e-4, record_interval=1e-5).contacts
    assert contacts["start_time"][0] == 0.0
    assert contacts["approach_velocity"][0] == pytest.approx(-0.1)
    assert contacts["normal_impulse"][0] > 0.9 * 2e-4


def test_a_rigid_start_with_overlap_is_refused() -> None:
    with pytest.raises(ValueError, match=r"gap is -1e-06 m at the start; .*law is rigid"):
        run(default_motor(clearance=-1e-6), LagrangeStick(0.3))


def test_an_undamped_mode_that_a_tone_meets_is_refused() -> None:
    frequency = float(default_motor(shapes=4).modes.natural_frequency[0])
    motor = default_motor(mass_damping=0.0, stiffness_damping=0.0, frequency=frequency)
    with pytest.raises(ValueError, match=r"meets mode 1 at .* Hz, which has no damping"):
        run(motor, hertz())


def test_a_sweep_has_a_status_for_every_ending() -> None:
    assert [status_of(ending).name for ending in Ending] == [ending.name for ending in Ending]
