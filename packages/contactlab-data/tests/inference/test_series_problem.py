"""Claims on the problem of series: the run of its values, at the times of the data."""

import numpy as np
import pytest

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab.config.schema import declared_in
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.motor_problem import records_at, series_problem
from contactlab_data.inference.problem import IMPOSSIBLE
from contactlab_data.inference.synthetic import made_series, without_errors
from contactlab_data.measured.files import read_measurements
from contactlab_data.measured.series import MeasuredSeries

WORDS = ["law=hertz_penalty", "solver.duration=1e-3", "record.interval=1e-5", "law.stiffness=1e10"]
SETUP = cl.build([*WORDS, "piezoceramic=pz26_datasheet"])
SERIES = ("rotor_velocity", "gap", "normal_force", "current_1", "current_2")


def keys(**ranges):
    known = declared_in(SETUP.configuration)
    named = {name.replace("__", "."): ends for name, ends in ranges.items()}
    return [FreeParameter(name, *ends, False, known[name]) for name, ends in named.items()]


FREE = keys(law__stiffness=(5e9, 2e10), contact__friction_coefficient=(0.1, 0.5), rotor__inertia=(1e-7, 1e-5))
TRUTH = np.array([1e10, 0.3, SETUP.configuration["rotor"]["inertia"]])


def test_at_the_truth_the_model_is_the_run_that_made_the_data_and_only_there():
    data = made_series(SETUP, SERIES, 1e-9, 1)
    problem = series_problem(data, SETUP.configuration, FREE, discrepancy=False)
    at_truth, off = problem.predict(TRUTH), problem.predict(TRUTH * [1.0, 1.0, 1.01])

    for name in SERIES:
        np.testing.assert_allclose(
            at_truth[name], data.values[name], atol=1e-7 * np.abs(data.values[name]).max()
        )
    run = SETUP.run()
    assert at_truth["rotor_velocity"].tobytes() == run.series["rotor_velocity"].tobytes()
    assert not np.allclose(off["rotor_velocity"], at_truth["rotor_velocity"], rtol=1e-3)


def test_times_that_begin_late_are_records_and_uneven_ones_lie_between_records():
    late = records_at(np.arange(5, 40) * 1e-5)
    assert late[0] == pytest.approx(1e-5)
    assert late[1].tolist() == [*range(5, 40)]
    uneven = np.cumsum(np.random.default_rng(1).uniform(0.5e-5, 1.5e-5, 90))
    assert records_at(uneven)[1] is None

    run = SETUP.run(record_interval=1e-7)
    values = {"rotor_velocity": np.interp(uneven, run.time, run.series["rotor_velocity"])}
    data = MeasuredSeries(uneven, values, {}, SETUP.configuration, {})
    problem = series_problem(data, SETUP.configuration, FREE, discrepancy=False)

    result = problem.predict(TRUTH)["rotor_velocity"]
    np.testing.assert_allclose(result, values["rotor_velocity"], atol=0.02 * np.abs(result).max())


def test_forces_are_refused_between_records():
    time = np.cumsum(np.random.default_rng(1).uniform(0.5e-5, 1.5e-5, 20))
    data = MeasuredSeries(time, {"normal_force": np.ones(20)}, {}, SETUP.configuration, {})

    with pytest.raises(ConfigurationError, match="normal_force"):
        series_problem(data, SETUP.configuration, FREE, discrepancy=False)


def test_noise_and_discrepancy_are_free_where_they_are_not_stated():
    stated = made_series(SETUP, ["rotor_velocity", "gap"], 0.01, 1)
    result = series_problem(without_errors(stated), SETUP.configuration, FREE, discrepancy=True)

    assert [item.name for item in result.free[3:]] == [
        "noise.rotor_velocity",
        "discrepancy.rotor_velocity",
        "noise.gap",
        "discrepancy.gap",
    ]
    assert len(series_problem(stated, SETUP.configuration, FREE, discrepancy=False).free) == 3
    # At the truth the stated noise is that of the data: half a chi square a datum.
    problem = series_problem(stated, SETUP.configuration, FREE, discrepancy=False)
    chi_square = float(np.sum(problem.residuals(TRUTH) ** 2))
    assert chi_square == pytest.approx(202.0, abs=4.0 * np.sqrt(2.0 * 202.0))


@pytest.mark.parametrize(
    "stop",
    [
        ["drive.voltage_1=0", "drive.voltage_2=0", "rotor.initial_velocity=-3"],
        ["solver.changes=['0.2 ms; drive.voltage_1=0; drive.voltage_2=0']"],
    ],
)
def test_a_motor_that_stops_is_predicted_from_a_velocity_or_a_change_of_the_drive(tmp_path, stop):
    overrides = ["law=newton", *stop]
    run = cl.build([*overrides, "solver.duration=4e-4", "record.interval=1e-5"]).run()
    rows = zip(1e3 * run.time, run.series["rotor_velocity"], strict=True)
    path = tmp_path / "stop.csv"
    head = "time [ms],rotor_velocity [rad/s]"
    path.write_text("\n".join([head, *(f"{t!r},{v!r}" for t, v in np.array([*rows]).tolist())]) + "\n")
    free = {"rotor.inertia": (1e-7, 1e-4)}
    (candidate,) = candidates_of(read_measurements(path), {"": cl.build(overrides)}, free)
    truth = cl.build(overrides).motor.rotor.inertia
    predicted = candidate.problem.predict(np.array([truth, 1.0]))

    np.testing.assert_allclose(predicted["rotor_velocity"], run.series["rotor_velocity"], rtol=1e-6)


def test_values_that_no_motor_can_have_are_impossible_not_an_error():
    data = made_series(SETUP, ["gap"], 0.01, 1)
    problem = series_problem(
        data, SETUP.configuration, keys(contact__clearance=(0.0, 1.0)), discrepancy=False
    )

    assert problem.log_likelihood(np.array([0.5])) == IMPOSSIBLE


def test_a_number_of_a_motor_without_influence_is_not_free_and_that_is_stated():
    """A rotor that the tip never touches runs down by its damping, whatever the law."""
    lines = ["law=newton", "contact.clearance=0.1 mm", "rotor.initial_velocity=1", "rotor.damping=0.05"]
    setup = cl.build([*lines, "solver.duration=1e-3", "record.interval=1e-5"])
    data = made_series(setup, ("rotor_velocity",), 1e-3, 1)
    free = {"law.restitution": (0.1, 0.9), "rotor.damping": (0.01, 0.1)}
    (candidate,) = candidates_of(data, {"": setup}, free)
    assert [item.name for item in candidate.problem.parameters] == ["rotor.damping"]
    assert " law.restitution." in candidate.numbers
    with pytest.raises(ConfigurationError, match=r"law\.restitution"):
        candidates_of(data, {"": setup}, {"law.restitution": (0.1, 0.9)})
