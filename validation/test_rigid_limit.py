"""Rigid laws in their limit of no step: an event-driven oracle, closed forms, and their own time stepping."""

from functools import cache

import numpy as np
import pytest
from test_against_oracle import DURATION, LOADED, MOTORS, OBLIQUE, STRONG, friction_of
from oracle.composed import JudgedRun
from oracle.rigid import Impact, RigidJudge, Rough, newton as newtons, plastic_ageing, process
from support.command_line import cases
from support.motors import case_a, default_motor, final, oracle_motor, total

from contactlab.engine import simulate
from contactlab.laws import (
    LagrangeAgeing,
    LagrangeSlip,
    LagrangeStick,
    MoreauJean,
    MultiplierLaw,
    Newton,
    Stronge,
)
from contactlab.laws.base import STICK
from contactlab.trajectory import Trajectory

AGEING = 1.2, 0.01, 1e-5

JUDGED = {
    "stick": (lambda mu: newtons(mu, 0.0), Rough, LagrangeStick),
    "newton": (lambda mu: newtons(mu, 0.5), Rough, lambda mu: Newton(mu, 0.5)),
    "stronge": (lambda mu: process(mu, 0.7, True), Rough, lambda mu: Stronge(mu, 0.7)),
    "ageing": (
        lambda mu: plastic_ageing(Rough(mu, *AGEING)),
        lambda mu: Rough(mu, *AGEING),
        lambda mu: LagrangeAgeing(mu, *AGEING),
    ),
}


def limit_of(motor: object, law: MultiplierLaw, duration: float = DURATION, **others: float) -> Trajectory:
    return simulate(motor, law, duration=duration, record_interval=1e-5, **others)


@cache
def judged(name: str, law: str) -> tuple[JudgedRun, MultiplierLaw]:
    mu = friction_of(MOTORS[name])
    impact, rough, made = JUDGED[law]
    made_impact: Impact = impact(mu)
    return RigidJudge(oracle_motor(**MOTORS[name]), made_impact, rough(mu), 1e-11).run(DURATION), made(mu)


@pytest.mark.parametrize("law", JUDGED)
@pytest.mark.parametrize("name", cases(MOTORS, (LOADED, STRONG, OBLIQUE)))
def test_rigid_laws_end_where_the_oracle_ends(name: str, law: str) -> None:
    """Both are good to 1e-9 and better, but for the oracle's last rebounds: 1e-7 m/s of some 0.1 m/s."""
    reference, made = judged(name, law)
    result = limit_of(default_motor(**MOTORS[name]), made, tolerance=1e-9)
    assert result.complete, result.message
    assert final(result, "rotor_velocity") == pytest.approx(reference.rotor_velocity, rel=5e-8)
    assert total(result, "normal_impulse") == pytest.approx(sum(reference.normal_impulses), rel=5e-8)
    travel = np.abs(result.series["tip_normal_displacement"]).max()
    assert final(result, "tip_normal_displacement") == pytest.approx(reference.u, abs=1e-9 * travel)


STEPPED = [
    ("case A", LagrangeStick),
    ("case A", LagrangeSlip),
    (LOADED, LagrangeStick),
    (STRONG, LagrangeStick),
]


@pytest.mark.parametrize(("name", "law"), STEPPED)
def test_the_stepping_of_the_paper_tends_to_the_limit_with_first_order(
    name: str, law: type[LagrangeStick] | type[LagrangeSlip]
) -> None:
    """Slip alone chatters at zero slip; its mean is the contact that friction holds."""
    changes = MOTORS.get(name, {})
    motor, duration = (default_motor(**changes), DURATION) if changes else (case_a(), 5e-3)
    made = law(friction_of(changes))
    exact = limit_of(motor, made, duration)
    steps = np.array([4e-7, 1e-7, 2.5e-8])
    runs = [limit_of(motor, made, duration, contact_step=h) for h in steps]
    for of in (lambda run: final(run, "rotor_velocity"), lambda run: total(run, "normal_impulse")):
        errors = np.abs([of(run) - of(exact) for run in runs])
        assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > 0.8, errors
        assert errors[-1] < 2e-3 * abs(of(exact))


def test_the_error_falls_with_the_tolerance() -> None:
    motor, law = case_a(), LagrangeStick(0.3)
    exact = final(limit_of(motor, law, tolerance=1e-12), "rotor_velocity")
    errors = [
        abs(final(limit_of(motor, law, tolerance=t), "rotor_velocity") / exact - 1.0)
        for t in (1e-5, 1e-7, 1e-9)
    ]
    assert errors[0] < 1e-6
    assert errors[1] < 1e-8
    assert errors[2] < 1e-10


@pytest.mark.parametrize("law", [LagrangeStick(0.3), LagrangeSlip(0.3), Newton(0.3, 0.5)], ids=repr)
def test_the_ledger_closes(law: MultiplierLaw) -> None:
    """But for what the flight's quadrature misses of the fastest modes, which an impact moves at once."""
    result = limit_of(case_a(), law, 5e-3)
    assert np.abs(result.series["energy_residual"]).max() < 1e-8 * result.series["drive_work"][-1]


def test_two_ways_to_say_the_restitution_have_one_limit() -> None:
    newton, moreau_jean = (limit_of(case_a(), law(0.3, 0.5)) for law in (Newton, MoreauJean))
    for name, values in newton.series.items():
        assert np.array_equal(values, moreau_jean.series[name]), name


def test_a_contact_that_lasts_holds_gap_rate_and_slip() -> None:
    result = limit_of(case_a(), LagrangeStick(0.3), 5e-3)
    touching = result.contact_mode != 0
    # The round-off of a distance of 25 mm.
    assert np.abs(result.series["gap"][touching]).max() < 1e-15
    sticking = result.contact_mode == STICK
    assert np.abs(result.series["slip_velocity"][sticking]).max(initial=0.0) < 1e-12
