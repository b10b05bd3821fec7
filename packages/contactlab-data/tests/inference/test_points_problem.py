"""Claims on operating points as data: the truth is found, a wrong law has no odds, and faults have a name."""

from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.arrays import Array
from contactlab.cli.verbs.example import examples
from contactlab.studies.compare.repeats import MARGIN
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.maximum_likelihood import followed_search, maximum_likelihood
from contactlab_data.inference.problem import Problem
from contactlab_data.measured.files import read_measurements
from contactlab_data.measured.series import MeasuredPoints

LOADS = (0.0, -1.5, -3.0)
"""Braking [mN m]: the motor turns negative."""


def velocities(law: str, *others: str) -> Array:
    torques = [f"rotor.load_torque={1e-3 * load}" for load in LOADS]
    return np.array(
        [cl.steady(cl.build([f"law={law}", torque, *others])).velocity.value for torque in torques]
    )


def written(path: Path, velocity: Array, error: float = 0.01) -> Path:
    rows = [f"{load},{v!r},{error}" for load, v in zip(LOADS, velocity.tolist(), strict=True)]
    head = "rotor.load_torque [mN m],rotor_velocity [rad/s],rotor_velocity_error [rad/s]"
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def problem(path: Path, law: str, *others: str) -> Problem:
    data = read_measurements(path)
    assert isinstance(data, MeasuredPoints)
    (candidate,) = candidates_of(
        data, {"": cl.build([f"law={law}", *others])}, {"drive.voltage_1": (50, 150)}
    )
    return candidate.problem


@pytest.mark.parametrize("others", [[], ["contact.preload=5", "rotor.bearing_damping=300"]])
def test_predictions_are_the_settled_velocities(tmp_path: Path, others: list[str]) -> None:
    """Also of a motor that is pressed on its rotor and never leaves it."""
    exact = velocities("hertz_penalty", *others)
    made = problem(written(tmp_path / "points.csv", exact), "hertz_penalty", *others)
    predicted = made.predict(np.array([100.0]))
    assert predicted["rotor_velocity"] == pytest.approx(exact, rel=1e-12)
    missed = made.residuals(np.array([90.0]))
    other = velocities("hertz_penalty", "drive.voltage_1=90", *others)
    assert missed == pytest.approx((exact - other) / 0.01, rel=1e-9)


@pytest.mark.long
def test_a_fit_finds_the_truth(tmp_path: Path) -> None:
    exact = velocities("newton", "law.restitution=0.4")
    noise = 0.01 * np.random.default_rng(1).standard_normal(exact.size)
    path = written(tmp_path / "points.csv", exact + noise)
    fitted = cl.fit(
        cl.build(["law=newton"]), data=path, free={"law.restitution": (0.1, 0.7)}, points=25, starts=1
    )
    restitution = fitted.numbers["law.restitution"]
    assert abs(restitution.value - 0.4) < 4.0 * restitution.error


def test_the_template_of_a_motor_is_explained_by_the_law_and_the_motor_that_made_it() -> None:
    template = next(each.source for each in examples() if each.name == "motor_measurement")

    def misfit(*others: str) -> float:
        setup = cl.build(["law=newton", "resonator=finite_element", "law.restitution=0.4", *others])
        free = {"contact.friction_coefficient": (0.1, 0.6)}
        (candidate,) = candidates_of(read_measurements(template), {"": setup}, free)
        return float(np.abs(candidate.problem.residuals(np.array([0.25]))).max())

    assert misfit() < 3.0 < 10.0 < misfit("drive.phase=-0.3")


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ("rotor_velocity [rad/s]\n1\n2\n", "rotor.load_torque"),
        ("rotor.load_torque [N m],rotor_velocity [rad/s]\n0,1\n", "1 operating points"),
        ("load [N m],rotor_velocity [rad/s]\n0,1\n1,1\n", "load"),
        ("law.stiffness [N m],rotor_velocity [rad/s]\n0,1\n1,1\n", "law.stiffness"),
        ("rotor.load_torque [N m],rotor_velocity\n0,1\n1,1\n", "rotor_velocity"),
        (
            "rotor.load_torque [N m],rotor_velocity [rad/s],rotor_velocity_error [rad/s]\n0,1,0\n1,1,1\n",
            "error",
        ),
    ],
)
def test_wrong_points_are_refused_by_name(tmp_path: Path, content: str, named: str) -> None:
    path = tmp_path / "points.csv"
    path.write_text(content)
    with pytest.raises(cl.MeasurementError) as refused:
        read_measurements(path)
    assert named in str(refused.value)


@pytest.mark.parametrize(
    "head", ["rotor.torque [N m]", "rotor.load_torque [m]", "drive.voltage_1 [V]", "contact.clearance [m]"]
)
def test_points_of_no_motor_are_refused_by_key(tmp_path: Path, head: str) -> None:
    path = tmp_path / "points.csv"
    path.write_text(f"{head},rotor_velocity [rad/s]\n0,1\n-1,1\n")
    with pytest.raises(cl.ConfigurationError) as refused:
        problem(path, "newton")
    assert head.split()[0] in str(refused.value)


SEVERAL = ("newton", "contact.clearance=3.895e-6")
"""A motor that the start decides: the rotor turns, or nothing touches it."""


def idle(path: Path) -> Path:
    """Write points of a motor without load."""
    head = "drive.voltage_2 [V],rotor_velocity [rad/s],rotor_velocity_error [rad/s]"
    path.write_text(f"{head}\n99.9,-1,0.3\n100.1,-1,0.3\n")
    return path


def test_a_misfit_of_several_motions_is_no_function_of_its_inputs(tmp_path: Path) -> None:
    """One orbit has one misfit."""
    values, path = np.array([100.0]), idle(tmp_path / "points.csv")
    assert problem(path, "hertz_penalty").spread(values) < 1e-4
    assert MARGIN < problem(path, *SEVERAL).spread(values) < np.inf


BOTH = {"contact.friction_coefficient": (0.2, 0.4), "drive.voltage_1": (90.0, 110.0)}
PRESSED = ("contact.preload=5", "rotor.bearing_damping=300")


def pressed(path: Path, friction: float, voltage: float) -> Problem:
    """Points of a pressed motor, their velocities by runs from rest of fifty settling times."""
    setup = cl.build(["law=hertz_penalty", *PRESSED])
    truth = setup.with_({"contact.friction_coefficient": friction, "drive.voltage_1": voltage})
    period, velocity = 1.0 / truth.configuration["drive"]["frequency"], []
    for load in LOADS:
        run = truth.with_({"rotor.load_torque": 1e-3 * load}).run(
            duration=150.0 * period, record_interval=period
        )
        velocity.append(np.diff(run.series["rotor_angle"])[-1] / period)
    data = read_measurements(written(path, np.array(velocity), 1e-3))
    (candidate,) = candidates_of(data, {"": setup}, BOTH)
    return candidate.problem


def test_a_fit_whose_states_follow_each_other_finds_what_long_runs_were_made_with(tmp_path: Path) -> None:
    """Also the optimum of a search from rest, and the same bits each time."""
    made = pressed(tmp_path / "points.csv", 0.3, 102.0)
    (near, best), (_, again) = (followed_search(made, 1, 0) for _ in range(2))
    assert near is not made
    assert best.values == pytest.approx([0.3, 102.0], rel=1e-4)
    assert best.values.tobytes() == again.values.tobytes()
    assert best.values == pytest.approx(maximum_likelihood(made, 1, 0).values, rel=1e-5)


def test_predictions_beside_stated_values_depend_on_no_others(tmp_path: Path) -> None:
    """As processes that share work need: in any order they are the same bits."""
    values = [np.array([x]) for x in (100.0, 103.0, 104.0)]
    made = problem(written(tmp_path / "points.csv", np.ones(3)), "hertz_penalty")
    one, other = (made.following(values[0]) for _ in range(2))
    forwards = [one.predict(x)["rotor_velocity"] for x in values]
    backwards = [other.predict(x)["rotor_velocity"] for x in values[::-1]][::-1]
    assert [x.tobytes() for x in forwards] == [x.tobytes() for x in backwards]
    for x, y in zip(values, forwards, strict=True):
        assert y == pytest.approx(made.predict(x)["rotor_velocity"], rel=1e-6)


def test_a_search_does_not_change_to_a_motion_that_is_not_reached_from_rest(tmp_path: Path) -> None:
    """Beyond 3.891 um nothing touches the rotor of a motor from rest; one that turns goes on turning."""
    path = idle(tmp_path / "points.csv")
    path.write_text(path.read_text().replace("-1,0.3", "1.883,0.01"))
    free = {"contact.clearance": (3.88e-6, 3.895e-6)}
    (candidate,) = candidates_of(read_measurements(path), {"": cl.build(["law=newton"])}, free)
    made = candidate.problem
    turning = maximum_likelihood(made.following(), 1, 0)
    assert np.abs(turning.residuals).max() < 1.0 < 100.0 < np.abs(made.residuals(turning.values)).max()
    near, best = followed_search(made, 1, 0)
    assert near is made
    assert made.residuals(best.values) == pytest.approx(best.residuals, abs=1e-6)
    assert best.cost > turning.cost
