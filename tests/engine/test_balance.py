"""A run whose energy ledger is open says so, and one whose ledger is closed does not."""

from pathlib import Path

import numpy as np
import pytest
from support.faulty_laws import NoLoss, Sound, Unledgered
from support.motors import case_a, default_motor, every_law, hertz

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, LagrangeStick
from contactlab.metrics import METRICS, assess
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.results.netcdf import reached_end, to_datatree
from contactlab.studies.run_state import Status, status_of
from contactlab.testing.plants import block
from contactlab.trajectory import LEDGER_LIMIT, Ending, Trajectory, openness


def ran(motor: Motor, law: ContactLaw, interval: float = 1e-5, **given: float) -> Trajectory:
    return simulate(motor, law, duration=5e-3, record_interval=interval, **given)


@pytest.mark.parametrize("interval", [1e-6, 1e-5, 5e-3], ids=["fine", "usual", "none"])
def test_a_law_that_keeps_a_loss_to_itself_is_unbalanced_at_any_record_interval(interval: float) -> None:
    trajectory = ran(case_a(), Unledgered(), interval)
    assert trajectory.ending is Ending.UNBALANCED
    assert trajectory.ending.reached_end
    assert not trajectory.complete
    assert trajectory.time[-1] == 5e-3
    for part in ("ledger is open by", "at most 0.01", "tolerance", "does not fit its force"):
        assert part in trajectory.message
    assert ran(case_a(), Sound(), interval).complete


def test_a_rigid_law_is_told_to_take_a_shorter_step_and_that_helps() -> None:
    motor = default_motor(voltage_1=400.0, voltage_2=300.0, friction_coefficient=0.8)
    coarse = ran(motor, LagrangeStick(0.8), contact_step=1e-5)
    assert coarse.ending is Ending.UNBALANCED
    assert "Choose a shorter solver.contact_step than 1e-05 s." in coarse.message
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


def test_a_motor_that_its_load_drives_has_a_scale() -> None:
    silent = Drive(np.empty(0), np.empty((2, 0), dtype=np.complex128))
    motor = default_motor(load_torque=-1e-2)
    driven = Motor(motor.modes, silent, motor.geometry, motor.rotor)
    trajectory = ran(driven, hertz())
    assert trajectory.complete
    assert trajectory.series["load_work"][-1] < 0.0
    assert assess(to_datatree(trajectory, {}))["energy_residual"] < 1e-12


def test_the_share_is_of_what_came_in() -> None:
    assert openness(1.0, 4.0, -10.0, 2.0) == 0.1
    assert openness(1.0, -20.0, 0.0, 2.0) == 0.05
    assert openness(1.0, 0.0, 0.0, 2.0) == 0.5
    assert openness(0.0, 0.0, 0.0, 0.0) == 0.0
    assert openness(1e-30, 0.0, 0.0, 0.0) == np.inf


def test_a_body_at_rest_is_balanced() -> None:
    assert ran(block(1.0, height=1e-6), hertz()).complete


def test_a_loss_that_is_no_number_ends_the_run() -> None:
    trajectory = ran(case_a(), NoLoss())
    assert trajectory.ending is Ending.DIVERGED
    assert "normal loss nan at a gap of -1." in trajectory.message
    assert np.isfinite(trajectory.series["contact_loss"]).all()


def test_an_unbalanced_run_keeps_its_numbers_and_its_status(tmp_path: Path) -> None:
    trajectory = ran(case_a(), Unledgered())
    tree = to_datatree(trajectory, {})
    assert (tree.attrs["complete"], tree.attrs["ending"]) == (0, "unbalanced")
    assert reached_end(tree.attrs)
    assert status_of(trajectory.ending) is Status.UNBALANCED
    found = assess(tree)
    assert found["energy_residual"] > LEDGER_LIMIT
    assert np.isfinite(found["final_rotor_velocity"])


def test_what_a_dataset_says_of_its_end() -> None:
    assert reached_end({})
    assert reached_end({"complete": 1})
    assert reached_end({"complete": 0, "ending": "unbalanced"})
    for ending in ("diverged", "chattered", "interrupted", "stalled", "no such"):
        assert not reached_end({"complete": 0, "ending": ending})
