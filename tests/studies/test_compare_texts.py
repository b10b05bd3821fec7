"""What findings say agrees with what they judge, and no raw exception is one."""

import warnings

import numpy as np
import pytest

import contactlab as cl
from contactlab.config.faults import failure_of
from contactlab.metrics import Run
from contactlab.motor.bodies import block, oscillator
from contactlab.motor.motor import Motor, free_reach
from contactlab.steady_state.means import _statistical_errors
from contactlab.studies.compare.scorecard import Reruns, limits_of
from contactlab.studies.tables import as_text, table_of_quantities
from contactlab.variables import Variable


@pytest.mark.parametrize("raised", [ZeroDivisionError("float division by zero"), KeyError("x"), ValueError()])
def test_an_unexpected_exception_is_told_with_its_kind_and_place(raised: Exception) -> None:
    try:
        raise raised
    except Exception as error:
        text = failure_of(error)
    assert text != str(raised)
    assert type(raised).__name__ in text
    assert "test_compare_texts.py" in text


def test_a_sentence_stays_as_it_is() -> None:
    assert failure_of(cl.laws.LawError("The law has no force.")) == "The law has no force."


def test_impacts_that_take_no_time_have_no_error_of_their_stick() -> None:
    count = 40
    ramp = np.linspace(0.0, 1.0, count)
    rows = {
        "start_time": ramp,
        "duration": np.zeros(count),
        "stick_duration": np.zeros(count),
        "peak_normal_force": np.full(count, np.inf),
    }
    columns = {"time": ramp, "drive_work": np.zeros(count), "friction_loss": np.zeros(count)}
    errors = _statistical_errors(Run(columns, rows, {}, "newton", {}, 0.0), np.nan, np.nan)
    assert np.isnan(errors[1:]).all()


@pytest.mark.parametrize(
    "motor",
    [
        block(1.0, weight=1.0, stiffness=100.0, push_amplitude=1.0),
        oscillator(1.0, 4.0, force=1.0, frequency=1.0 / np.pi, gap=0.1),
    ],
    ids=["sprung along the belt only", "in resonance without damping"],
)
def test_a_motor_without_a_free_steady_state_has_no_reach_and_no_warning(motor: Motor) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isnan(free_reach(motor))


@pytest.mark.parametrize(("error", "unit"), [(4e-3, "mN m"), (4e-12, "nN m"), (np.inf, "nN m")])
def test_the_prefix_of_a_unit_suits_the_error_too(error: float, unit: str) -> None:
    torque = Variable("torque", (), "N m", "M", "torque")
    text = as_text(table_of_quantities([torque], {"newton": {"torque": cl.Estimate(2e-9, error)}}))
    assert f" {unit} " in text


def test_a_law_without_a_steady_state_is_told_with_its_own_reason() -> None:
    reasons = {"newton": "It drifts.", "poisson": "It grows.", "stronge": "It drifts."}
    sentences = [
        *limits_of(
            [Reruns(Run({}, {}, {}, law, {}, 0.0, label=law), without=x) for law, x in reasons.items()]
        )
    ]
    assert len(sentences) == 2
    for law, reason in reasons.items():
        assert [reason in sentence for sentence in sentences] == [law in sentence for sentence in sentences]
