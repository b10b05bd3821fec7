"""A run whose energy ledger is open says so, and one whose ledger is closed does not."""

import numpy as np
import pytest
from support.faulty_laws import Sound, Unledgered
from support.motors import case_a, default_motor, every_law

import contactlab as cl
from contactlab.engine import simulate
from contactlab.laws import ContactLaw, LagrangeStick
from contactlab.metrics import METRICS, assess
from contactlab.motor.motor import Motor
from contactlab.results.netcdf import to_datatree
from contactlab.trajectory import LEDGER_LIMIT, Ending, Trajectory, openness


def ran(motor: Motor, law: ContactLaw, interval: float = 1e-5, **options: float) -> Trajectory:
    return simulate(motor, law, duration=5e-3, record_interval=interval, **options)


@pytest.mark.parametrize("interval", [1e-6, 1e-5, 5e-3], ids=["fine", "usual", "none"])
def test_a_loss_missing_from_the_ledger_is_noticed_at_any_record_interval(interval: float) -> None:
    trajectory = ran(case_a(), Unledgered(), interval)
    assert trajectory.ending is Ending.UNBALANCED
    assert trajectory.ending.reached_end
    assert not trajectory.complete
    assert trajectory.time[-1] == 5e-3
    tree = to_datatree(trajectory, {})
    assert (tree.attrs["complete"], tree.attrs["ending"]) == (0, "unbalanced")
    assert assess(tree)["energy_residual"] > LEDGER_LIMIT
    assert ran(case_a(), Sound(), interval).complete


def test_a_shorter_step_closes_the_ledger_of_a_rigid_law() -> None:
    motor = default_motor(voltage_1=400.0, voltage_2=300.0, friction_coefficient=0.8)
    coarse = ran(motor, LagrangeStick(0.8), contact_step=1e-5)
    assert coarse.ending is Ending.UNBALANCED
    assert ran(motor, LagrangeStick(0.8)).complete


@pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)
def test_ending_and_metric_judge_by_the_same_scale(law: ContactLaw) -> None:
    assert METRICS["energy_residual"].bound == LEDGER_LIMIT
    for changes in ({}, {"load_torque": -2e-2}, {"initial_velocity": -5.0}):
        trajectory = ran(default_motor(**changes), law)
        series = trajectory.series
        energy = sum(series[f"{kind}_energy"][0] for kind in ("kinetic", "strain", "contact"))
        works = [float(np.abs(series[f"{kind}_work"]).max()) for kind in ("drive", "load")]
        share = openness(float(np.abs(series["energy_residual"]).max()), *works, float(energy))
        assert assess(to_datatree(trajectory, {}))["energy_residual"] == pytest.approx(share, rel=1e-6)
        assert trajectory.complete == (share <= LEDGER_LIMIT)


@pytest.mark.parametrize(
    "law", [cl.LagrangeStick(friction_coefficient=0.3), cl.Newton(friction_coefficient=0.3)]
)
def test_a_block_at_rest_turns_nothing_over_and_is_complete(law: cl.ContactLaw) -> None:
    run = cl.simulate(cl.block(1.0, weight=10.0, push=0.75), law, duration=1.0, record_interval=1e-3)
    assert run.complete
    assert np.abs(run["slip_velocity"]).max() < 1e-13


@pytest.mark.parametrize("duration", [1.0, 100.0, 400.0])
def test_a_ball_that_rests_for_minutes_is_complete(duration: float) -> None:
    """In one step its weight takes it to hundreds of metres a second, and the contact takes that back."""
    run = simulate(cl.ball(), cl.Newton(restitution=0.5), duration=duration, record_interval=duration)
    assert run.complete, run.message
    fallen = 0.5 * 9.81 * duration**2
    assert abs(run.series["gap"][-1]) < 32.0 * np.finfo(float).eps * fallen
