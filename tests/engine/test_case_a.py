"""Case A at default settings ends where independent event-driven solvers end.

Placement 2, clearance 1 um, 100 V at 3210 and 6420 Hz, phase -pi/5, no load, from rest, at 5 ms.
"""

from functools import cache

import numpy as np
import pytest
from references import HERTZ_CASE_A, RIGID_CASE_A
from support.motors import case_a, final, hertz, run, total

from contactlab.laws import ContactLaw, LagrangeSlip, LagrangeStick
from contactlab.trajectory import Trajectory

DIGITS = {
    "rotor_velocity": 1e-6,
    "tip_normal_displacement": 1e-12,
    "tip_slope": 1e-10,
    "normal_impulse": 5e-9,
    "duration": 1e-9,
    "stick_duration": 1e-7,
}
"""A few units of the last digit of each number of `HERTZ_CASE_A`. A printed sum of impulses of 4.532969e-3
N s is a trapezoid over solver steps of 2 us and low by 4e-4; the quadrature of the force and the momentum
balance give the one that is used, as for the others."""

RIGID_VELOCITY, RIGID_IMPULSE = (RIGID_CASE_A[name][0] for name in ("rotor_velocity", "normal_impulse"))
"""Rigid contact with rigid stick, mu = 0.3."""

SLIP_VELOCITY = -0.4836
"""Rotor velocity that the law that always slips tends to in the paper's time stepping [rad/s]."""

TOUCH_DOWNS = 131.075e-6, 424.723e-6
"""First two of the Hertz contact [s]."""


@cache
def default_run(law: ContactLaw) -> Trajectory:
    return run(case_a(), law)


@cache
def stepped(law: ContactLaw, contact_step: float) -> Trajectory:
    return run(case_a(), law, contact_step=contact_step)


def measured(trajectory: Trajectory, name: str) -> float:
    """Last record of a series, or the sum of a column of the contacts."""
    return final(trajectory, name) if name in trajectory.series else total(trajectory, name)


@pytest.mark.parametrize("mu", HERTZ_CASE_A)
def test_hertz_ends_where_the_reference_ends(mu: float) -> None:
    trajectory = default_run(hertz(mu))
    assert len(trajectory.contacts["start_time"]) == 16
    starts = trajectory.contacts["start_time"][:2]
    assert starts == pytest.approx(TOUCH_DOWNS, abs=0.02e-6)
    for (name, digit), expected in zip(DIGITS.items(), HERTZ_CASE_A[mu], strict=True):
        # Without friction there is none to round off.
        assert measured(trajectory, name) == pytest.approx(expected, abs=digit if expected else 0.0), name


@pytest.mark.parametrize("name", RIGID_CASE_A)
def test_rigid_stick_in_its_limit_of_no_step_is_the_exact_rigid_motion(name: str) -> None:
    expected, half_a_digit, _ = RIGID_CASE_A[name]
    result = measured(default_run(LagrangeStick(0.3)), name)
    assert result == pytest.approx(expected, rel=0.0, abs=half_a_digit)


def test_without_friction_the_rotor_stays_exactly_at_rest() -> None:
    for law in (hertz(0.0), LagrangeStick(0.0), LagrangeSlip(0.0)):
        trajectory = default_run(law)
        assert np.all(trajectory.series["rotor_velocity"] == 0.0)
        assert np.all(trajectory.series["friction_force"] == 0.0)


def test_rigid_stick_extrapolates_to_the_exact_rigid_motion() -> None:
    coarse, fine = (stepped(LagrangeStick(0.3), h) for h in (5e-8, 2.5e-8))
    velocity = 2.0 * final(fine, "rotor_velocity") - final(coarse, "rotor_velocity")
    impulse = 2.0 * total(fine, "normal_impulse") - total(coarse, "normal_impulse")
    # The reference has six digits.
    assert velocity == pytest.approx(RIGID_VELOCITY, abs=1e-6)
    assert impulse == pytest.approx(RIGID_IMPULSE, rel=1e-6)


def test_slip_only_law_tends_to_its_own_rotor_velocity() -> None:
    velocities = [final(stepped(LagrangeSlip(0.3), h), "rotor_velocity") for h in (1e-6, 1e-7, 1e-8)]
    distances = [abs(velocity - SLIP_VELOCITY) for velocity in velocities]
    assert distances[0] > distances[1] > distances[2]
    # It chatters where the tip would stick: what is left is of the size of the step over a contact.
    assert distances[2] < 2e-4
    limit = final(default_run(LagrangeSlip(0.3)), "rotor_velocity")
    assert limit == pytest.approx(SLIP_VELOCITY, abs=5e-5)
    # Eight percent away from the law with stick, at any step.
    assert abs(velocities[2] - RIGID_VELOCITY) > 0.03


@pytest.mark.parametrize("law", [LagrangeStick(0.3), LagrangeSlip(0.3)], ids=lambda law: law.name)
def test_rigid_peak_force_doubles_as_the_step_halves_but_the_impulse_stays(law: ContactLaw) -> None:
    runs = [stepped(law, h) for h in (2e-7, 1e-7, 5e-8, 2.5e-8)]
    peaks = [r.contacts["peak_normal_force"].max() for r in runs]
    impulses = [total(r, "normal_impulse") for r in runs]
    for i in range(3):
        assert peaks[i + 1] / peaks[i] == pytest.approx(2.0, rel=1e-3 if i == 2 else 0.01)
        assert impulses[i + 1] == pytest.approx(impulses[i], rel=1e-3)
    # The paper's peak: impulse over step.
    assert peaks[1] == pytest.approx(1545.0, rel=0.01)
