"""SUNDIALS' CVODE, through scikit-sundae, ends where `hertz_penalty` ends, with and without friction."""

from functools import cache

import numpy as np
import pytest
from foreign.cvode_run import CvodeRun, solve
from foreign.problem import CASE_A, MOTORS, problem_from, problem_of
from hypothesis import Phase, given, settings, strategies as st
from support.command_line import cases
from support.motors import default_motor, final, hertz, run, total

from contactlab.trajectory import Trajectory

STIFFNESSES = dict(zip(MOTORS, (1e10, 1e10, 3e9, 2e10, 1e9, 5e10, 1e11), strict=True))
"""K [N m^-3/2]: contacts of every softness."""

RTOL = 1e-11

TOLERANCE = 5e-9
"""As a share of how far a quantity goes. Measured: 1.2e-9 at worst, of which CVODE's part is a tenth."""

SHORT = (CASE_A, "no clearance, loaded and damped, turning backwards", "three shapes, driven by its load")

motors = pytest.mark.parametrize("name", cases(MOTORS, SHORT))
frictions = pytest.mark.parametrize("frictionless", [False, True], ids=["friction", "smooth"])


def friction_of(name: str, frictionless: bool) -> float:
    return 0.0 if frictionless else problem_of(name)["friction_coefficient"]


@cache
def cvode_run(name: str, frictionless: bool, rtol: float = RTOL) -> CvodeRun:
    mu = friction_of(name, frictionless)
    return solve(problem_of(name), STIFFNESSES[name], mu, rtol)


@cache
def our_run(name: str, frictionless: bool) -> Trajectory:
    law = hertz(friction_of(name, frictionless), STIFFNESSES[name])
    return run(default_motor(**MOTORS[name]), law, problem_of(name)["duration"], 1e-6)


def shares(foreign: CvodeRun, ours: Trajectory) -> dict[str, float]:
    """How far CVODE is from us, as a share of how far each quantity goes if it goes anywhere."""
    found = {}
    for k in ("rotor_velocity", "rotor_angle", "tip_normal_displacement", "tip_slope"):
        travel = float(np.abs(ours.series[k]).max())
        found[k] = abs(getattr(foreign, k) - final(ours, k)) / (travel or 1.0)
    impulse = total(ours, "normal_impulse")
    for k in ("normal_impulse", "friction_impulse"):
        found[k] = abs(getattr(foreign, k) - total(ours, k)) / (impulse or 1.0)
    return found


@motors
@frictions
def test_cvode_ends_where_we_end(name: str, frictionless: bool) -> None:
    away = shares(cvode_run(name, frictionless), our_run(name, frictionless))
    assert max(away.values()) < TOLERANCE, away


@motors
@frictions
def test_cvode_makes_our_contacts(name: str, frictionless: bool) -> None:
    foreign, contacts = cvode_run(name, frictionless), our_run(name, frictionless).contacts
    assert len(foreign.start_time) == len(contacts["start_time"]) >= 4
    # Measured: 3e-14 s and 6e-14 s; 1.3e-11 s in one motor that leaves its stick gently.
    assert foreign.start_time == pytest.approx(contacts["start_time"], abs=1e-12)
    assert foreign.time_in_contact == pytest.approx(contacts["duration"].sum(), abs=1e-12)
    assert foreign.time_in_stick == pytest.approx(contacts["stick_duration"].sum(), abs=1e-10)


@pytest.mark.long
def test_most_motors_stick_and_slip_so_that_the_switch_is_judged() -> None:
    runs = [cvode_run(name, False) for name in MOTORS]
    sticking = [r.time_in_stick / r.time_in_contact for r in runs]
    assert sum(0.05 < share < 0.95 for share in sticking) >= 4, sticking


@motors
def test_cvode_tends_to_us_as_its_tolerance_falls(name: str) -> None:
    ours = our_run(name, False)
    coarse, fine = (max(shares(cvode_run(name, False, rtol), ours).values()) for rtol in (1e-7, RTOL))
    assert fine < 0.05 * coarse, (coarse, fine)


def test_cvode_meets_the_printed_numbers_of_case_a() -> None:
    foreign = cvode_run(CASE_A, False)
    assert foreign.rotor_velocity == pytest.approx(-0.4468048, abs=1e-7)
    assert foreign.tip_normal_displacement == pytest.approx(-2.3727588e-6, abs=1e-13)
    assert foreign.tip_slope == pytest.approx(1.0026338e-4, abs=1e-11)
    assert len(foreign.start_time) == 16


random_motors = st.fixed_dictionaries(
    {
        "patch_start": st.floats(0.3e-3, 14e-3),
        "clearance": st.floats(1e-9, 2e-6),
        # Next to no friction moves the rotor by less than the solvers' absolute tolerances.
        "friction_coefficient": st.floats(0.02, 1.0),
        "voltage_1": st.floats(60.0, 300.0),
        "voltage_2": st.floats(60.0, 300.0),
        "frequency": st.floats(2000.0, 4000.0),
        "frequency_ratio": st.sampled_from([1.0, 1.5, 2.0, 3.0]),
        "phase": st.floats(-3.0, 3.0),
        "shapes": st.integers(2, 6),
        "tip_length": st.floats(8e-3, 25e-3),
        "rotor_radius": st.floats(8e-3, 40e-3),
        "rotor_inertia": st.floats(2e-6, 1e-4),
        "load_torque": st.floats(-5e-3, 5e-3),
        "rotor_damping": st.floats(0.0, 1e-3),
        "initial_velocity": st.floats(-2.0, 2.0),
    }
)


def ends_where_we_end(changes: dict[str, float], exponent: float) -> None:
    changes = changes | {"patch_end": changes["patch_start"] + 9e-3}
    stiffness, mu = 10.0**exponent, changes["friction_coefficient"]
    foreign = solve(problem_from(changes, 2e-3), stiffness, mu, RTOL)
    ours = run(default_motor(**changes), hertz(mu, stiffness), 2e-3, 1e-6)
    # Measured over 222 motors: median 3e-10, worst 2e-7, where a single faint contact is all there is:
    # our tolerance is a share of the tip's vibration, not of what one touch gives.
    assert max(shares(foreign, ours).values()) < 1e-6
    assert foreign.start_time == pytest.approx(ours.contacts["start_time"], abs=1e-11)


@pytest.mark.parametrize("count", cases((4, 25), (4,)))
def test_cvode_ends_where_we_end_for_random_motors(count: int) -> None:
    # Shrinking a failure would run CVODE for minutes; the failing motor itself is small enough.
    phases = [Phase.explicit, Phase.generate]
    judge = given(random_motors, st.floats(8.5, 11.5))(ends_where_we_end)
    settings(max_examples=count, derandomize=True, deadline=None, phases=phases)(judge)()
