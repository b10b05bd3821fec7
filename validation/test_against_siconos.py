"""Siconos, a package for nonsmooth dynamics, tends to the contacts that our rigid laws tend to.

Siconos steps over impacts on a fixed grid in time. Where in a step an impact falls is chance, so that
its errors are of first order in the step with a scatter of the same size: the limit is that of a
straight line through many steps, weighted with the size of the scatter.
"""

import os
from functools import cache

import numpy as np
import pytest
from foreign.problem import CASE_A, MOTORS, problem_of
from foreign.siconos_run import SiconosRun, find_siconos, siconos_runs
from support.motors import default_motor, final, run, total

from contactlab.laws import ContactLaw, LagrangeSlip, LagrangeStick, MoreauJean, Newton
from contactlab.trajectory import Trajectory

pytestmark = pytest.mark.long

STEPS = (4e-7, 2.8e-7, 2e-7, 1.4e-7, 1e-7, 7e-8, 5e-8, 3.5e-8)

TOLERANCE = 5e-4
"""Of Siconos's limit, as a share of how far a quantity can go. Measured: 2.6e-4 at worst."""

RESTITUTION = 0.5

STATES = ("rotor_velocity", "rotor_angle", "tip_normal_displacement", "tip_slope")
IMPULSES = ("normal_impulse", "friction_impulse")

End = dict[str, float]

motors = pytest.mark.parametrize("name", MOTORS)


@cache
def foreign_runs(name: str, restitution: float = 0.0) -> list[SiconosRun]:
    """Siconos's runs; without Siconos a test is skipped, but not in continuous integration."""
    if (python := find_siconos()) is None:
        (pytest.fail if os.environ.get("CI") else pytest.skip)("No Python here has Siconos.")
    return siconos_runs(python, problem_of(name) | {"restitution": restitution}, STEPS)


@cache
def our_run(name: str, law: ContactLaw, contact_step: float) -> Trajectory:
    return run(default_motor(**MOTORS[name]), law, problem_of(name)["duration"], contact_step=contact_step)


def our_limit(name: str, law: ContactLaw) -> End:
    """End of a run as the step goes to zero."""
    coarse, fine = (our_run(name, law, h) for h in (5e-9, 2.5e-9))
    return {
        **{k: 2.0 * final(fine, k) - final(coarse, k) for k in STATES},
        **{k: 2.0 * total(fine, k) - total(coarse, k) for k in IMPULSES},
    }


def siconos_limit(runs: list[SiconosRun]) -> End:
    """Intercepts of straight lines through the ends over the step."""
    steps = np.array([r.step for r in runs])
    ends = {
        **{k: [getattr(r, k) for r in runs] for k in STATES},
        **{k: [getattr(r, k).sum() for r in runs] for k in IMPULSES},
    }
    lines = {k: np.polyfit(steps, values, 1, w=1.0 / steps) for k, values in ends.items()}
    return {k: float(line[1]) for k, line in lines.items()}


def worst_share(name: str, limit: End, ours: End) -> float:
    """Largest difference of two limits over how far each quantity can go.

    A rotor that is pushed to and fro stays near rest: it is measured by the speed that its friction could
    give it.
    """
    problem, made = (
        problem_of(name),
        our_run(name, LagrangeStick(problem_of(name)["friction_coefficient"]), 5e-9),
    )
    impulse = total(made, "normal_impulse")
    push = problem["friction_coefficient"] * impulse
    speed = push * problem["rotor_radius"] / problem["rotor_inertia"]
    travel = {
        "rotor_velocity": speed,
        "rotor_angle": 0.5 * speed * problem["duration"],
        **{k: float(np.abs(made.series[k]).max()) for k in STATES[2:]},
        "normal_impulse": impulse,
        "friction_impulse": push,
    }
    return max(abs(limit[k] - ours[k]) / travel[k] for k in ours)


@motors
def test_siconos_extrapolates_to_our_extrapolated_rigid_motion(name: str) -> None:
    law, limit = LagrangeStick(problem_of(name)["friction_coefficient"]), siconos_limit(foreign_runs(name))
    assert worst_share(name, limit, our_limit(name, law)) < TOLERANCE
    if name == CASE_A:
        assert limit["rotor_velocity"] == pytest.approx(-0.448569, abs=2e-5)
        assert worst_share(name, limit, our_limit(name, LagrangeSlip(0.3))) > 20.0 * TOLERANCE


@motors
def test_siconos_tends_to_our_rigid_contacts_with_first_order(name: str) -> None:
    law, runs = LagrangeStick(problem_of(name)["friction_coefficient"]), foreign_runs(name)
    coarse, fine = (our_run(name, law, h).contacts for h in (5e-9, 2.5e-9))
    ours = {k: 2.0 * fine[k] - coarse[k] for k in (*IMPULSES, "start_time")}
    errors = []
    for foreign in runs:
        # On its grid in time: measured up to 0.7 steps away.
        assert foreign.start_time == pytest.approx(ours["start_time"], abs=foreign.step)
        away = [getattr(foreign, k) - ours[k] for k in IMPULSES]
        errors.append(float(np.sqrt(np.mean(np.square(away)))) / ours["normal_impulse"].max())
    order = np.polyfit(np.log([r.step for r in runs]), np.log(errors), 1)[0]
    assert 0.85 < order < 1.2, errors
    assert errors[-1] < 1e-3, errors


@motors
@pytest.mark.parametrize("law", [Newton, MoreauJean], ids=lambda law: law.name)
def test_siconos_with_restitution_extrapolates_to_our_bounces(
    name: str, law: type[Newton] | type[MoreauJean]
) -> None:
    mu, limit = problem_of(name)["friction_coefficient"], siconos_limit(foreign_runs(name, RESTITUTION))
    assert worst_share(name, limit, our_limit(name, law(mu, RESTITUTION))) < TOLERANCE
    # And not to contacts without restitution.
    assert worst_share(name, limit, our_limit(name, LagrangeStick(mu))) > 20.0 * TOLERANCE
