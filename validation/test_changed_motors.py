"""A motor or law that changes at a cut acts from the cut on: at its time, from the state that is there."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from engine.test_going_on import FAMILIES, INTERVAL, cuts, laws, run, uncut
from numpy.testing import assert_allclose
from oracle.composed import Judge, Parts
from oracle.friction_parts import SetValued
from oracle.normal_parts import Power
from oracle.rigid import RigidJudge, Rough, newton as newtons
from support.motors import STIFFNESS, case_a, default_motor, final, hertz, oracle_motor

import contactlab as cl
from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.laws import ContactLaw, HertzPenalty, Newton
from contactlab.laws.base import STICK
from contactlab.laws.composed import Composed
from contactlab.laws.normal import Prony
from contactlab.motor import Motor, block
from contactlab.motor.bodies import way_of
from contactlab.trajectory import Trajectory
from contactlab.variables import SERIES

LOUD = {"voltage_1": 40.0, "load_torque": 2e-3}
SILENT = {"voltage_1": 0.0, "voltage_2": 0.0, "rotor_damping": 1e-4}

VARIABLES = {each.name for each in SERIES} - {"energy_residual"}
"""Charges and currents jump with the voltage."""


def sequence(law: ContactLaw, *steps: tuple[Motor, float], **options: Any) -> Trajectory:
    """A run of motors, each until its time [s]."""
    whole, start, done = None, None, 0.0
    for motor, end in steps:
        interval = min(1e-5, end - done)
        piece = simulate(motor, law, duration=end - done, record_interval=interval, start=start, **options)
        assert piece.complete, piece.message
        whole = piece if whole is None else whole.followed_by(piece)
        start, done = piece.state, end
    assert whole is not None
    return whole


@laws
def test_the_record_at_a_change_is_the_end_of_the_uncut_run(law: ContactLaw) -> None:
    for at in cuts(law).values():
        first = run(law, at * INTERVAL)
        second = run(law, 1e-4, default_motor(**SILENT), start=first.state)
        assert second.complete
        assert second.time[0] == first.time[-1]
        for name in VARIABLES:
            scale = np.abs(first.series[name]).max()
            assert_allclose(second.series[name][0], first.series[name][-1], rtol=0, atol=1e-11 * scale)
        drive = np.abs(uncut(law).series["drive_work"]).max()
        assert np.abs(second.series["energy_residual"]).max() <= 1e-2 * drive
        # Nothing drives it from the record on.
        assert np.ptp(second.series["drive_work"]) <= 1e-15 * drive


PLASTIC = Newton(0.3, 0.0)

JUDGED: dict[str, tuple[ContactLaw, Callable[[], Any]]] = {
    "plastic": (PLASTIC, lambda: RigidJudge(oracle_motor(), newtons(0.3, 0.0), Rough(0.3), 1e-11)),
    "newton": (Newton(), lambda: RigidJudge(oracle_motor(), newtons(0.3, 0.5), Rough(0.3), 1e-11)),
    "hertz": (hertz(), lambda: Judge(oracle_motor(), Parts(Power(STIFFNESS, 1.5), SetValued(0.3)), 1e-11)),
}


@pytest.mark.parametrize("name", JUDGED)
def test_changes_end_where_the_independent_integrator_ends(name: str) -> None:
    """Three changes, two of them within one step: both are good to 1e-11."""
    law, judge = JUDGED[name]
    for at in cuts(law).values():
        first = at * INTERVAL + 2.3e-7
        times = first, first + 5e-9, first + 2e-4, 2.1e-3
        motors: tuple[dict[str, float], ...] = {}, LOUD, SILENT, LOUD
        changes = [(time, oracle_motor(**motor)) for time, motor in zip(times, motors[1:], strict=False)]
        right = judge().run(times[-1], changes)
        steps = zip((default_motor(**motor) for motor in motors), times, strict=True)
        result = sequence(law, *steps, tolerance=1e-9)
        assert result.contacts["start_time"].size == len(right.starts)
        assert final(result, "rotor_velocity") == pytest.approx(right.rotor_velocity, abs=1e-10)
        for each in ("normal_impulse", "friction_impulse"):
            expected = np.array(getattr(right, f"{each}s"))
            assert_allclose(result.contacts[each], expected, rtol=0, atol=1e-10 * np.abs(expected).sum())


@pytest.mark.parametrize("law", [Newton(), PLASTIC, hertz(), *FAMILIES[-2:]], ids=lambda law: law.title)
def test_the_end_is_smooth_in_the_time_of_a_change(law: ContactLaw) -> None:
    """From time to time of a grid it moves by what the grid's step does, and not by a step of the engine."""
    for place in cuts(law).values():
        grid = place * INTERVAL + 2e-8 * np.arange(12)
        end = grid[-1] + 1e-5
        loaded = default_motor(load_torque=5e-3)
        ends = [final(sequence(law, (case_a(), at), (loaded, end)), "rotor_velocity") for at in grid]
        differences = np.diff(ends)
        # What the torque takes from the rotor in the time between two of them.
        assert differences == pytest.approx(5e-3 / case_a().rotor.inertia * 2e-8, rel=0.5)
        assert np.ptp(differences) <= 1e-3 * np.abs(differences).max()


@pytest.mark.parametrize("law", [Newton(), HertzPenalty()], ids=lambda law: law.title)
def test_a_pressed_block_breaks_away_when_it_is_pushed(law: ContactLaw) -> None:
    """It rests under mu N, slides from the change on, v = (P - mu N) t / m, and stands under more weight."""
    weight = 10.0
    depth = (weight / law.stiffness) ** (2.0 / 3.0) if isinstance(law, HertzPenalty) else 0.0
    at_rest, pushed, heavy = (
        block(1.0, height=-depth, weight=load, push=push)
        for load, push in ((weight, 2.0), (weight, 5.0), (2.0 * weight, 5.0))
    )
    first = sequence(law, (at_rest, 1.23e-3), (pushed, 3.23e-3))
    assert way_of(first.series["tip_slope"])[-1] == pytest.approx(4e-6, rel=1e-9)
    assert final(first, "slip_velocity") == pytest.approx(4e-3, rel=1e-9)
    if depth == 0.0:
        # Twice the weight brakes by 1 m/s^2, until it stands.
        last = sequence(law, (at_rest, 1.23e-3), (pushed, 3.23e-3), (heavy, 8.23e-3))
        assert way_of(last.series["tip_slope"])[-1] == pytest.approx(1.2e-5, rel=1e-9)
        assert last.contact_mode[-1] == STICK
        assert last.contacts["start_time"].size == 1


@pytest.mark.parametrize("law", ["newton", "lagrange_stick", "hertz_penalty"])
def test_a_rotor_pressed_on_the_tip_takes_changes_at_any_time(law: str) -> None:
    base = [f"law={law}", "contact.preload=5", "rotor.bearing_damping=300", "solver.duration=1.2 ms"]
    times = 1e-3 + 1e-7 * np.arange(8)
    runs = [
        cl.build([*base, f"solver.changes=['{at!r}; contact.preload=4; drive.voltage_1=50']"]).run()
        for at in times.tolist()
    ]
    ends = np.array([final(each, "rotor_velocity") for each in runs])
    assert all(each.complete for each in runs)
    whole = cl.build(base).run()
    assert abs(ends[0] - final(whole, "rotor_velocity")) > 10.0 * np.abs(np.diff(ends)).max()
    assert np.ptp(np.diff(ends, 2)) <= 1e-2 * np.abs(np.diff(ends)).max()


def test_what_another_law_stores_at_a_change_is_no_loss() -> None:
    law, harder = hertz(), hertz(stiffness=2.0 * STIFFNESS)
    first = run(law, cuts(law)["slip"] * INTERVAL)
    second = run(harder, 5e-4, start=first.state)
    before, after = first.series["contact_energy"][-1], second.series["contact_energy"][0]
    assert after == pytest.approx(2.0 * before, rel=1e-9) != 0.0
    assert second.complete
    assert np.abs(second.series["energy_residual"]).max() <= 1e-7 * after
    for name in ("friction_loss", "contact_loss", "damping_loss", "drive_work", "load_work"):
        assert second.series[name][0] == pytest.approx(first.series[name][-1], rel=1e-12)


def test_another_rotor_turns_on_at_the_same_velocity() -> None:
    motor = case_a()
    heavier = replace(motor, rotor=replace(motor.rotor, inertia=3.0 * motor.rotor.inertia))
    for law in (Newton(), hertz()):
        for at in cuts(law).values():
            first = run(law, at * INTERVAL)
            second = run(law, 2e-4, heavier, start=first.state)
            for name in ("rotor_velocity", "rotor_angle", "slip_velocity", "gap"):
                assert second.series[name][0] == pytest.approx(first.series[name][-1], rel=1e-9, abs=1e-16)
            assert second.complete


def moved(motor: Motor, clearance: float) -> Motor:
    return replace(motor, geometry=replace(motor.geometry, clearance=clearance))


def test_a_rotor_that_is_moved_touches_where_it_is() -> None:
    law, motor = hertz(), case_a()
    at = cuts(law)
    away = run(law, 1e-5, moved(motor, 2e-6), start=run(law, at["slip"] * INTERVAL).state)
    assert away.complete
    assert not away.contact_mode[1:].any()
    near = run(law, 1e-6, moved(motor, 0.5e-6), start=run(law, at["slip"] * INTERVAL).state)
    assert near.contact_mode.all()
    flying = run(law, at["flight"] * INTERVAL)
    deep = moved(motor, 1e-6 - flying.series["gap"][-1] - 1e-8)
    pressed = run(law, 1e-6, deep, start=flying.state)
    assert pressed.contact_mode[0] != 0
    with pytest.raises(ValueError, match="gap"):
        run(Newton(), 1e-6, deep, start=flying.state)
    touching = run(PLASTIC, cuts(PLASTIC)["slip"] * INTERVAL)
    parted = run(PLASTIC, 1e-5, moved(motor, 2e-6), start=touching.state)
    assert not parted.contact_mode.any()
    assert parted.contacts["start_time"][0] == touching.contacts["start_time"][-1]
    with pytest.raises(ValueError, match="gap"):
        run(PLASTIC, 1e-6, moved(motor, 0.5e-6), start=touching.state)


def test_steps_and_tolerance_change_at_their_time() -> None:
    law = Newton()
    for at in cuts(law).values():
        first = run(law, at * INTERVAL)
        for name, value in (("tolerance", 1e-9), ("contact_step", 1e-8)):
            second = run(law, 1e-4, None, **{name: value, "start": first.state})
            assert second.time[0] == first.time[-1]
            begins = first.series["rotor_velocity"][-1]
            assert second.series["rotor_velocity"][0] == pytest.approx(begins, rel=1e-12)
            right = uncut(law).series["rotor_velocity"][at + 100]
            assert final(second, "rotor_velocity") == pytest.approx(right, rel=1e-3)


def test_an_impact_that_a_change_cuts_in_time_stepping_is_over() -> None:
    """A cut anywhere within the step of an impact leaves the rebound that the law asks for."""
    law = Newton()
    step, start = 1e-5, block(1.0, height=1e-3, gap_rate=-1.0)
    for share in (0.05, 0.3, 0.6, 0.95):
        first = simulate(start, law, duration=1e-3 + share * step, record_interval=1e-3, contact_step=step)
        second = simulate(
            block(1.0, height=1e-3, gap_rate=-1.0, push=1.0), law,
            duration=1e-3, record_interval=1e-3, contact_step=step, start=first.state,
        )  # fmt: skip
        assert second.contacts["separation_velocity"] == pytest.approx([law.restitution], rel=1e-9)
        # The impulse acts in the time that there is, and its force is the largest.
        mean = first.contacts["normal_impulse"] / first.contacts["duration"]
        assert first.contacts["duration"] == pytest.approx([share * step], rel=1e-6)
        assert first.contacts["peak_normal_force"] == pytest.approx(mean, rel=1e-9)


def test_a_waveform_goes_on_from_a_change() -> None:
    time = np.linspace(0.0, 3e-3, 400)
    tones = case_a().drive

    def driven(scale: float) -> Motor:
        voltage: Array = scale * tones.voltage(time)
        return replace(case_a(), drive=cl.Drive(waveform=cl.Waveform.sampled(time, voltage)))

    grid = 1.4e-3 + 2e-8 * np.arange(10)
    ends = [
        final(sequence(hertz(), (driven(1.0), at), (driven(0.5), 1.7e-3)), "rotor_velocity") for at in grid
    ]
    whole = final(sequence(hertz(), (driven(1.0), 1.4e-3), (driven(1.0), 1.7e-3)), "rotor_velocity")
    assert abs(ends[0] - whole) > 10.0 * np.abs(np.diff(ends)).max()
    assert np.abs(np.diff(ends)).min() > 1e-8
    assert np.ptp(np.diff(ends, 2)) <= 1e-3 * np.abs(np.diff(ends)).max()


def test_a_run_without_changes_is_the_same_in_any_number_of_parts() -> None:
    for law in (Newton(), hertz()):
        times = [0.0, *(at * INTERVAL for at in sorted(cuts(law).values())), 2e-3]
        state: Any = None
        for before, after in pairwise(times):
            part = run(law, after - before, start=state)
            state = part.state
        assert final(part, "rotor_velocity") == final(uncut(law), "rotor_velocity")


@pytest.mark.parametrize("load", [0.0, 1e-6])
def test_what_a_contact_stores_while_apart_is_its_loss_in_a_later_part_too(load: float) -> None:
    law = Composed(normal=Prony(first_time=2e-4))
    at = cuts(law)["flight"] * INTERVAL
    whole = sequence(law, (case_a(), at), (default_motor(load_torque=load), 2e-3))
    losses = whole.contacts["energy_loss"]
    ledger = whole.series["friction_loss"][-1] + whole.series["contact_loss"][-1]
    assert whole.series["contact_energy"][np.searchsorted(whole.time, at)] > 1e-3 * losses.max()
    assert_allclose(losses.sum(), ledger, rtol=1e-12)
    if load == 0.0:
        assert_allclose(losses, uncut(law).contacts["energy_loss"], rtol=0, atol=1e-12 * losses.max())
