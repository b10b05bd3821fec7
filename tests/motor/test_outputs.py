"""Charge, current and points: the motion of the modes, the work of the voltages, the clamped capacitance."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import contactlab as cl
from contactlab.engine import simulate
from contactlab.motor import Motor
from contactlab.motor.outputs import dielectric_loss
from contactlab.steady_state.period_map import PeriodMap
from contactlab.trajectory import Trajectory

BASES = ("ritz", "finite_element")


def period_of(*overrides: str, records: int = 512) -> Trajectory:
    """One period of a motor after fifty, from where it is then."""
    section = PeriodMap(cl.build(overrides), belt=-1.0)
    z = section.end_of(section.run(np.zeros(2 * section.scale.size), 50))
    return section.run(z, 1, records)


def run_of(motor: Motor, duration: float = 2e-3) -> Trajectory:
    return simulate(motor, cl.HertzPenalty(), duration=duration, record_interval=1e-6)


def motor_with(**fields: Any) -> Motor:
    motor = cl.build().motor
    return replace(motor, modes=replace(motor.modes, **fields))


def charges(run: Trajectory) -> np.ndarray:
    return np.stack([run.series["charge_1"], run.series["charge_2"]])


@pytest.mark.parametrize("basis", BASES)
def test_the_charge_is_that_of_capacitance_and_motion(basis: str) -> None:
    run = period_of(f"resonator={basis}", "law=hertz_penalty")
    modes = run.motor.modes
    expected = modes.capacitance @ run.motor.drive.voltage(run.time[-1])
    expected += modes.coupling.T @ run.final.displacement
    assert charges(run)[:, -1] == pytest.approx(expected, rel=1e-12)


# Trapezoids miss the kinks of a contact; the impulse of a rigid law falls within a record interval.
@pytest.mark.parametrize(("law", "error"), [("hertz_penalty", 1e-4), ("lagrange_stick", 2e-3)])
@pytest.mark.parametrize("basis", BASES)
def test_what_the_voltages_do_on_the_charge_is_the_work_of_the_drive(
    basis: str, law: str, error: float
) -> None:
    run = period_of(f"resonator={basis}", f"law={law}")
    voltage = run.motor.drive.voltage(run.time)
    steps = 0.5 * (voltage[:, 1:] + voltage[:, :-1]) * np.diff(charges(run), axis=1)
    # What the capacitance stores is there again after a period; the motion need not be.
    work = pytest.approx(run.series["drive_work"][-1], rel=error)
    assert steps.sum() == work
    assert np.trapezoid(np.sum(voltage * run.currents, axis=0), run.time) == work


def test_a_resonator_without_contact_takes_the_current_of_its_admittance() -> None:
    run = period_of("contact.clearance=1e-4")
    modes, drive = run.motor.modes, run.motor.drive
    w, k, c = drive.angular_frequency, modes.stiffness[:, None], modes.damping[:, None]
    response = (modes.coupling @ drive.phasors) / (k - w**2 + 1j * c * w)
    phasors = 1j * w * (modes.capacitance @ drive.phasors + modes.coupling.T @ response)
    expected = (phasors @ np.exp(1j * np.multiply.outer(w, run.time))).real
    # What is left of the start after fifty periods.
    assert run.currents == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("basis", BASES)
def test_both_bases_have_the_clamped_capacitance_of_two_layers(basis: str) -> None:
    result = cl.build([f"resonator={basis}", "piezoceramic.permittivity=6e-9"]).motor.modes.capacitance
    layer = 6e-9 * 16e-3 * (10.146e-3 - 0.914e-3) / 1e-3
    assert result == pytest.approx(2.0 * layer * np.eye(2))


def test_a_dielectric_turns_its_loss_tangent_into_heat_that_the_source_pays() -> None:
    run, lossy = (simulate_a_period(tangent) for tangent in (0.0, 0.02))
    modes, drive = run.motor.modes, run.motor.drive
    expected = sum(
        w * modes.capacitance[e, e] * 0.02 * abs(drive.phasors[e, k]) ** 2 / 2.0
        for k, w in enumerate(drive.angular_frequency)
        for e in range(2)
    )
    assert dielectric_loss(lossy.motor) == pytest.approx(expected, rel=1e-12)
    more = np.sum(drive.voltage(run.time) * (lossy.currents - run.currents), axis=0)
    assert more[:-1].mean() == pytest.approx(expected, rel=1e-9)
    assert dielectric_loss(run.motor) == 0.0


def simulate_a_period(loss_tangent: float) -> Trajectory:
    motor = motor_with(loss_tangent=loss_tangent)
    period = 1.0 / motor.drive.frequency[0]
    return simulate(motor, cl.HertzPenalty(), duration=period, record_interval=period / 512)


def test_a_voltage_as_samples_takes_the_charge_of_the_tone() -> None:
    motor = cl.build().motor
    time = np.linspace(0.0, 2.2e-3, 2200)
    sampled = cl.Drive(waveform=cl.Waveform.sampled(time, motor.drive.voltage(time), 7))
    tone, wave = run_of(motor), run_of(replace(motor, drive=sampled))
    for name in ("charge_1", "charge_2", "current_1", "current_2"):
        apart = np.abs(tone.series[name] - wave.series[name]).max()
        assert apart < 1e-7 * np.abs(tone.series[name]).max()


def test_a_resonator_that_does_not_tell_its_capacitance_has_no_current() -> None:
    unknown = run_of(motor_with(capacitance=None, loss_tangent=0.1), 1e-4)
    assert not {"charge_1", "current_1"} & set(unknown.series)
    assert np.isnan(unknown.currents).all()
    assert np.isnan(dielectric_loss(unknown.motor))
    with pytest.raises(ValueError, match="capacitance has shape"):
        motor_with(capacitance=np.ones(2))


def test_a_point_moves_as_its_row_says_with_its_rate_and_a_run_is_the_same_with_it() -> None:
    modes = cl.build().motor.modes
    without, run = run_of(motor_with()), run_of(motor_with(points={"tip": modes.tip_displacement}))
    np.testing.assert_allclose(
        run.series["point_tip"], run.series["tip_normal_displacement"], rtol=1e-13, atol=1e-20
    )
    for name, values in without.series.items():
        np.testing.assert_array_equal(values, run.series[name])
    # The velocity integrates to the displacement, to the second order of the records.
    gone = np.trapezoid(run.series["point_tip_velocity"], run.time)
    assert gone == pytest.approx(np.ptp(run.series["point_tip"][[0, -1]]), rel=1e-3)


def test_a_point_stays_one_of_a_motor_on_a_bearing_and_of_one_with_residual_modes() -> None:
    modes = cl.build().motor.modes
    motor = cl.on_bearing(motor_with(points={"tip": modes.tip_displacement}), cl.Bearing(0.1, 1.0))
    run = run_of(motor)
    np.testing.assert_allclose(
        run.series["point_tip"], run.series["tip_normal_displacement"], rtol=1e-13, atol=1e-20
    )
    more = cl.add_residual_modes(motor_with(points={"tip": modes.tip_displacement}).modes, *RESIDUAL)
    assert more.points["tip"].tolist() == [*modes.tip_displacement.tolist(), 0.0, 0.0]


RESIDUAL = np.diag([cl.RitzResonator().tip_mass, cl.RitzResonator().tip_inertia]), np.diag([1e-7, 0.01])


@pytest.mark.parametrize(("name", "row"), [("no name", 4), ("tip", 3)])
def test_a_point_without_a_name_or_a_number_for_every_mode_is_refused(name: str, row: int) -> None:
    with pytest.raises(ValueError, match="point"):
        motor_with(points={name: np.ones(row)})
