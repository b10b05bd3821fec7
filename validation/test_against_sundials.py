"""SUNDIALS' CVODE, through scikit-sundae, ends where `hertz_penalty` ends, with and without friction."""

import numpy as np
import pytest
from foreign.cvode_run import CvodeRun, solve
from foreign.problem import CASE_A, MOTORS, problem_of
from support.motors import default_motor, final, hertz, oracle_motor, run, total

from contactlab.trajectory import Trajectory

pytestmark = pytest.mark.long

STIFFNESSES = dict(zip(MOTORS, (1e10, 3e9, 2e10, 5e10), strict=True))
"""K [N m^-3/2]: contacts of every softness."""

RTOL = 1e-11


def shares(foreign: CvodeRun, ours: Trajectory) -> dict[str, float]:
    """How far CVODE is from us, as a share of how far each quantity goes if it goes anywhere."""
    result = {}
    for k in ("rotor_velocity", "tip_normal_displacement", "tip_slope"):
        travel = float(np.abs(ours.series[k]).max())
        result[k] = abs(getattr(foreign, k) - final(ours, k)) / (travel or 1.0)
    impulse = total(ours, "normal_impulse")
    for k in ("normal_impulse", "friction_impulse"):
        result[k] = abs(getattr(foreign, k) - total(ours, k)) / (impulse or 1.0)
    return result


@pytest.mark.parametrize("name", MOTORS)
@pytest.mark.parametrize("frictionless", [False, True], ids=["friction", "smooth"])
def test_cvode_ends_where_we_end_and_makes_our_contacts(name: str, frictionless: bool) -> None:
    stiffness, duration = STIFFNESSES[name], problem_of(name)["duration"]
    mu = 0.0 if frictionless else problem_of(name)["friction_coefficient"]
    ours = run(default_motor(**MOTORS[name]), hertz(mu, stiffness), duration, 1e-6)
    motor = oracle_motor(**MOTORS[name] | {"friction_coefficient": mu})
    coarse, fine = (solve(motor, stiffness, duration, rtol) for rtol in (1e-7, RTOL))
    # Measured: 1.2e-9 at worst, of which CVODE's part is a tenth.
    assert max(shares(fine, ours).values()) < 5e-9
    assert max(shares(fine, ours).values()) < 0.05 * max(shares(coarse, ours).values())
    contacts = ours.contacts
    assert len(fine.start_time) == len(contacts["start_time"]) >= 4
    assert fine.start_time == pytest.approx(contacts["start_time"], abs=1e-12)
    assert fine.time_in_contact == pytest.approx(contacts["duration"].sum(), abs=1e-12)
    assert fine.time_in_stick == pytest.approx(contacts["stick_duration"].sum(), abs=1e-10)
    if name == CASE_A and not frictionless:
        assert fine.rotor_velocity == pytest.approx(-0.4468048, abs=1e-7)
