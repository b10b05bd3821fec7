"""How a run ends: at its end, cut, diverged, interrupted, or not begun at all."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.faulty_laws import NegativeBound, NoImpulse, NoLoss, NoNumber
from support.motors import case_a, default_motor, every_law, final, hertz, run

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, LagrangeStick
from contactlab.motor.motor import Motor
from contactlab.trajectory import Ending

STEPS_PER_CALL = "contactlab.engine.simulation.STEPS_PER_CALL"

laws = pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)


def resonant_without_damping() -> Motor:
    frequency = float(default_motor().modes.natural_frequency[0])
    return default_motor(mass_damping=0.0, stiffness_damping=0.0, frequency=frequency)


@laws
def test_interrupting_keeps_what_the_run_had(law: ContactLaw, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(STEPS_PER_CALL, 50)

    def interrupt(time: float) -> None:
        if time > 0.4e-3:
            raise KeyboardInterrupt

    cut = simulate(case_a(), law, duration=1e-3, record_interval=1e-5, progress=interrupt)
    assert cut.ending is Ending.INTERRUPTED
    assert not cut.complete
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
import warnings
sys.path[:0] = {folders!r}
from dataclasses import replace
import numpy as np
from contactlab.engine import simulate
from contactlab.trajectory import Ending
from support.motors import default_motor, every_law, hertz

# What overflows on the way is what the ending is about.
warnings.simplefilter("error")
for law in every_law():
    for volts in (1e6, 1e9, 1e15, 1e30, 1e150):
        motor = default_motor()
        louder = volts / 100.0 * motor.drive.phasors
        motor = replace(motor, drive=replace(motor.drive, phasors=louder))
        result = simulate(motor, law, duration=1e-3, record_interval=1e-5)
        print(law.name, volts, result.ending is Ending.DIVERGED)
for stiffness in (1e20, 1e100, 1e300):
    motor, law = default_motor(), hertz(stiffness=stiffness)
    result = simulate(motor, law, duration=1e-3, record_interval=1e-5)
    print(stiffness, result.ending in (Ending.COMPLETE, Ending.DIVERGED, Ending.STALLED))
"""


def test_absurd_voltages_and_stiffnesses_diverge_and_never_hang() -> None:
    # In a process of its own, so that a hang is a failure and not the end of all tests.
    root = Path(__file__).parents[2]
    script = ABSURD.format(folders=[str(root / name) for name in ("tests", "validation", "experiments")])
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    assert len(lines) == 18
    assert all(line.endswith("True") for line in lines), lines


@pytest.mark.parametrize(
    "law", [NoNumber(), NegativeBound(), NoImpulse(), NoLoss()], ids=lambda law: law.name
)
def test_a_force_that_is_no_number_ends_the_run(law: ContactLaw) -> None:
    result = simulate(case_a(), law, duration=1e-3, record_interval=1e-5)
    assert result.ending is Ending.DIVERGED
    # What there was is kept, and is finite to the end.
    assert all(np.isfinite(series).all() for series in result.series.values())


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(("duration", value) for value in (0.0, -1.0, float("nan"), float("inf"))),
        *(("record_interval", value) for value in (0.0, 2e-3, float("nan"))),
        *(("contact_step", value) for value in (0.0, float("nan"), 1e-17)),
        *(("tolerance", value) for value in (0.0, 1.0)),
    ],
)
def test_an_argument_out_of_range_is_refused(key: str, value: float) -> None:
    arguments = {"duration": 1e-3, "record_interval": 1e-5, key: value}
    with pytest.raises(ValueError, match=key.replace("_", ".")):
        simulate(case_a(), hertz(), **arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("motor", "law", "more", "key"),
    [
        (case_a(), LagrangeStick(0.3), {"tolerance": 1e-6, "contact_step": 5e-8}, "lagrange_stick"),
        (default_motor(clearance=-1e-6), LagrangeStick(0.3), {}, "gap"),
        (resonant_without_damping(), hertz(), {}, "mode 1"),
    ],
)
def test_what_a_law_or_motor_cannot_run_is_refused(
    motor: Motor, law: ContactLaw, more: dict[str, float], key: str
) -> None:
    with pytest.raises(ValueError, match=key):
        simulate(motor, law, duration=1e-3, record_interval=1e-5, **more)  # type: ignore[arg-type]
