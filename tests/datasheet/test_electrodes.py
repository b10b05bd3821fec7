"""Charge and current: the motion of the modes, the work of the voltages, and the clamped capacitance."""

from dataclasses import replace

import numpy as np
import pytest

import contactlab as cl
from contactlab.datasheet.electrodes import currents, dielectric_loss, modal_motion
from contactlab.steady_state.period_map import PeriodMap
from contactlab.trajectory import Trajectory

BASES = ("ritz", "finite_element")


def period_of(*overrides: str, records: int = 512) -> Trajectory:
    """One period of a motor after fifty, from where it is then."""
    section = PeriodMap(cl.build(overrides), belt=-1.0)
    z = section.end_of(section.run(np.zeros(2 * section.scale.size), 50))
    return section.run(z, 1, records)


def with_loss(run: Trajectory, tangent: float) -> Trajectory:
    return replace(run, motor=replace(run.motor, modes=replace(run.motor.modes, loss_tangent=tangent)))


@pytest.mark.parametrize("basis", BASES)
def test_every_mode_ends_where_the_engine_says_that_it_does_to_second_order(basis: str) -> None:
    gaps = []
    for records in (128, 512):
        run = period_of(f"resonator={basis}", "law=hertz_penalty", records=records)
        q, v = modal_motion(run)
        apart = np.sqrt(run.motor.modes.stiffness) * (q[:, -1] - run.final.displacement)
        gap = np.hypot(np.linalg.norm(apart), np.linalg.norm(v[:, -1] - run.final.velocity))
        gaps.append(float(gap / np.linalg.norm(run.final.velocity)))
    assert gaps[1] < 1e-4
    assert gaps[1] < 1.1 * gaps[0] / 4.0**2


# The impulse of a rigid law is moved by half of a record interval at most.
@pytest.mark.parametrize(("law", "error"), [("hertz_penalty", 1e-4), ("lagrange_stick", 2e-3)])
@pytest.mark.parametrize("basis", BASES)
def test_what_the_voltages_do_on_the_charge_is_the_work_of_the_drive(
    basis: str, law: str, error: float
) -> None:
    run = period_of(f"resonator={basis}", f"law={law}")
    voltage = run.motor.drive.voltage(run.time)
    charge = run.motor.modes.charge(modal_motion(run)[0], voltage)
    steps = 0.5 * (voltage[:, 1:] + voltage[:, :-1]) * np.diff(charge, axis=1)
    # What the capacitance stores is there again after a period; the motion need not be.
    work = pytest.approx(run.series["drive_work"][-1], rel=error)
    assert steps.sum() == work
    assert np.trapezoid(np.sum(voltage * currents(run), axis=0), run.time) == work


def test_a_resonator_without_contact_takes_the_current_of_its_admittance() -> None:
    run = period_of("contact.clearance=1e-4")
    modes, drive = run.motor.modes, run.motor.drive
    w, k, c = drive.angular_frequency, modes.stiffness[:, None], modes.damping[:, None]
    response = (modes.coupling @ drive.phasors) / (k - w**2 + 1j * c * w)
    phasors = 1j * w * (modes.capacitance @ drive.phasors + modes.coupling.T @ response)
    expected = (phasors @ np.exp(1j * np.multiply.outer(w, run.time))).real
    assert currents(run) == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("basis", BASES)
def test_both_bases_have_the_clamped_capacitance_of_two_layers(basis: str) -> None:
    result = cl.build([f"resonator={basis}", "piezoceramic.permittivity=6e-9"]).motor.modes.capacitance
    layer = 6e-9 * 16e-3 * (10.146e-3 - 0.914e-3) / 1e-3
    assert result == pytest.approx(2.0 * layer * np.eye(2))


def test_a_dielectric_turns_its_loss_tangent_into_heat_that_the_source_pays() -> None:
    run = period_of()
    lossy = with_loss(run, 0.02)
    modes, drive = run.motor.modes, run.motor.drive
    expected = sum(
        w * modes.capacitance[e, e] * 0.02 * abs(drive.phasors[e, k]) ** 2 / 2.0
        for k, w in enumerate(drive.angular_frequency)
        for e in range(2)
    )
    assert dielectric_loss(lossy.motor) == pytest.approx(expected, rel=1e-12)
    more = np.sum(drive.voltage(run.time) * (currents(lossy) - currents(run)), axis=0)
    assert more[:-1].mean() == pytest.approx(expected, rel=1e-9)
    assert dielectric_loss(run.motor) == 0.0


def test_a_resonator_that_does_not_tell_its_capacitance_has_no_current() -> None:
    run = period_of()
    silent = replace(run.motor.modes, capacitance=None, loss_tangent=0.1)
    unknown = replace(run, motor=replace(run.motor, modes=silent))
    assert np.isnan(currents(unknown)).all()
    assert np.isnan(dielectric_loss(unknown.motor))
    with pytest.raises(ValueError, match="capacitance has shape"):
        replace(run.motor.modes, capacitance=np.ones(2))
