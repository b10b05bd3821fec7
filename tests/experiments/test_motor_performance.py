"""What a motor can do: the belt agrees with free and with loaded rotors, which it was not made from."""

from dataclasses import replace

import experiment
import motor_performance
import numpy as np
import pytest
from variations import changed

from contactlab.config import Setup
from contactlab.engine import simulate


def setup_of(*overrides: str) -> Setup:
    return experiment.setup_of("optimise_motor", overrides)


@pytest.mark.parametrize("law", ["hertz_penalty", "lagrange_stick"])
def test_a_free_rotor_settles_at_the_belts_root_within_its_ripple(law: str) -> None:
    setup = setup_of(f"law={law}")
    result = motor_performance.performance(setup)
    period = 1.0 / setup.motor.drive.frequency[0]
    # From near the root, twenty times as long as a rotor takes to get up to speed.
    near = replace(setup.motor.rotor, initial_velocity=-0.9 * result.velocity)
    run = simulate(
        replace(setup.motor, rotor=near),
        setup.law,
        duration=1200 * period,
        record_interval=period / 100.0,
        contact_step=setup.contact_step,
    )
    velocity = np.abs(run.series["rotor_velocity"])
    last = velocity[-100:]
    # It has settled far below the ripple, and the ripple is small.
    assert abs(last.mean() - velocity[-200:-100].mean()) < 1e-3 * np.ptp(last)
    assert np.ptp(last) < 0.01 * result.velocity
    assert last.mean() == pytest.approx(result.velocity, rel=0.0, abs=np.ptp(last))


def test_a_motor_under_its_stall_torque_is_held_and_turns_only_below() -> None:
    setup = setup_of()
    torque = motor_performance.performance(setup).stall_torque
    # The motor turns backwards, so that a load that brakes it is negative.
    for share, turns in ((0.98, -1.0), (1.02, 1.0)):
        loaded = replace(setup.motor.rotor, load_torque=-share * torque, inertia=4.8e-3)
        run = simulate(replace(setup.motor, rotor=loaded), setup.law, duration=0.04, record_interval=0.01)
        assert np.sign(run.series["rotor_velocity"][-1] - run.series["rotor_velocity"][1]) == turns


def test_half_a_period_of_the_second_tone_later_it_is_the_same_motor_in_the_mirror() -> None:
    setup = setup_of()
    phase = setup.configuration["drive"]["phase"]
    turned = changed(setup, {"drive.phase": phase + 0.5 * np.pi})
    for velocity in (0.0, -1.0):
        item = motor_performance.on_belt(setup, velocity)
        other = motor_performance.on_belt(turned, -velocity)
        assert other.torque == pytest.approx(-item.torque, rel=1e-6)
        assert other.peak_force == pytest.approx(item.peak_force, rel=1e-6)


def test_a_motor_that_does_not_touch_or_does_not_rub_is_none() -> None:
    with pytest.raises(motor_performance.NoMotorError, match="touch"):
        motor_performance.performance(setup_of("contact.clearance=1e-4"))
    with pytest.raises(motor_performance.NoMotorError, match="turn"):
        motor_performance.performance(setup_of("contact.friction_coefficient=0"))


def test_damping_of_the_rotor_makes_it_slower_and_leaves_the_stall_torque() -> None:
    free = motor_performance.performance(setup_of())
    damped = motor_performance.performance(setup_of("rotor.damping=1e-3"))
    assert damped.stall_torque == free.stall_torque
    assert damped.velocity < 0.9 * free.velocity
