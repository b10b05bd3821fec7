"""Claims on forces measured on a prescribed path: the law that made them in another program is found."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab.inference.fit import candidates_of
from contactlab.inference.law_numbers import free_numbers
from contactlab.inference.least_squares import best_fit
from contactlab.inference.path_problem import path_problem
from contactlab.measured.files import MeasurementError, read_measurements
from contactlab.studies.fit import Fit

NORMAL, FRICTION, STIFFNESS = 10.0, 0.27, 8e4
"""[N], [1], [1/m]: the truth."""

NOISE = 0.02
"""Standard deviation of the friction [N]."""

FREE = {"contact.friction_coefficient": (0.05, 1.0), "law.friction.rest_stiffness": (1e4, 1e6)}


def way(t):
    """Two tones."""
    return 4e-6 * np.sin(20.0 * np.pi * t) * (1.0 + 0.3 * np.sin(10.0 * np.pi * t))


def velocity(t):
    swing, turn = 1.0 + 0.3 * np.sin(10.0 * np.pi * t), 20.0 * np.pi
    own = turn * np.cos(turn * t) * swing + np.sin(turn * t) * 3.0 * np.pi * np.cos(10.0 * np.pi * t)
    return 4e-6 * own


def loop(noise: float, seed: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Times, and friction by Dahl's equation for the force."""
    time = np.linspace(0.0, 0.2, 201)

    def rate(t, force):
        yields = 1.0 + force[0] / (FRICTION * NORMAL) * np.sign(velocity(t))
        return [-STIFFNESS * NORMAL * velocity(t) * yields]

    exact = solve_ivp(rate, (0.0, 0.2), [0.0], t_eval=time, rtol=1e-10, atol=1e-10, max_step=1e-4).y[0]
    return time, exact + np.random.default_rng(seed).normal(0.0, noise, time.size)


def written(path: Path, columns: dict[str, np.ndarray]) -> Path:
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.12g")
    return path


def columns(noise: float) -> dict[str, np.ndarray]:
    time, friction = loop(noise)
    return {
        "time [ms]": 1e3 * time,
        "slip [um]": 1e6 * way(time),
        "normal [N]": NORMAL + 0.0 * time,
        "friction_force [N]": friction,
    }


def setup_of() -> cl.Setup:
    return cl.build(["law=composed", "law/friction=dahl"])


def test_the_law_that_made_a_loop_predicts_it(tmp_path: Path) -> None:
    data = read_measurements(written(tmp_path / "loop.csv", columns(0.0)))
    setup = setup_of()
    problem = path_problem(data, setup.law, free_numbers({"": setup}, FREE)[""], discrepancy=False)

    predicted = problem.predict(np.array([FRICTION, STIFFNESS]))["friction_force"]

    exact = data.values["friction_force"]
    # The path between the samples is a spline; its error is largest next to the ends.
    np.testing.assert_allclose(predicted, exact, atol=2e-4 * np.abs(exact).max())


def test_numbers_of_a_law_are_found_from_a_loop_within_their_errors(tmp_path: Path) -> None:
    data = read_measurements(written(tmp_path / "loop.csv", columns(NOISE)))
    setup = setup_of()
    keys = free_numbers({"": setup}, FREE)[""]
    problem = path_problem(Fit(data=data, noise=0.01).measurements[""], setup.law, keys, discrepancy=False)

    best = best_fit(problem.residuals, problem.parameters, 2, 0, step=problem.step)

    truth, step = np.array([FRICTION, STIFFNESS]), 1e-3
    left = (data.values["friction_force"] - problem.predict(best.values)["friction_force"]) / NOISE
    slopes = [
        (
            problem.predict(truth * (1.0 + step * unit))["friction_force"]
            - problem.predict(truth)["friction_force"]
        )
        / (step * NOISE)
        for unit in np.eye(2)
    ]
    errors = np.sqrt(np.linalg.inv(np.array(slopes) @ np.transpose(slopes)).diagonal())
    assert (np.abs(best.values / truth - 1.0) < 4.0 * errors).all()
    assert (errors < 0.01).all()
    assert np.sum(left**2) == pytest.approx(left.size, abs=5.0 * np.sqrt(2.0 * left.size))


def test_a_gap_may_be_prescribed_and_the_normal_force_measured(tmp_path: Path) -> None:
    time = np.linspace(0.0, 1.0, 101)
    depth = 1e-6 * (1.0 - 0.5 * np.cos(2.0 * np.pi * time))
    table = {"time [s]": time, "slip [m]": 0.0 * time, "gap [um]": -1e6 * depth}
    path = written(tmp_path / "press.csv", table | {"normal_force [N]": 7e9 * depth**1.5})
    setup = cl.build(["law=composed"])
    keys = free_numbers({"": setup}, {"law.normal.stiffness": (1e9, 1e11)})[""]
    problem = path_problem(read_measurements(path), setup.law, keys, discrepancy=False)
    best = best_fit(problem.residuals, problem.parameters, 2, 0, step=problem.step)
    np.testing.assert_allclose(best.values, [7e9], rtol=1e-4)


@pytest.mark.parametrize("missing", ["time [ms]", "normal [N]"])
def test_a_loop_lacks_nothing(tmp_path: Path, missing: str) -> None:
    table = columns(0.0)
    del table[missing]
    with pytest.raises(MeasurementError, match=missing.split(" ")[0]):
        read_measurements(written(tmp_path / "loop.csv", table))


def test_a_path_without_a_force_fits_nothing(tmp_path: Path) -> None:
    table = columns(0.0)
    del table["friction_force [N]"]
    data = read_measurements(written(tmp_path / "path.csv", table))
    with pytest.raises(ConfigurationError, match="friction_force"):
        candidates_of(data, {"": setup_of()}, FREE)


def test_a_gap_is_no_path_of_a_rigid_law(tmp_path: Path) -> None:
    table = columns(0.0)
    del table["normal [N]"]
    data = read_measurements(written(tmp_path / "path.csv", table | {"gap [um]": np.full(201, -1.0)}))
    with pytest.raises(ConfigurationError, match="gap"):
        candidates_of(data, {"": cl.build(["law=newton"])}, {"contact.friction_coefficient": (0.1, 0.5)})


def test_a_number_of_the_motor_is_no_number_of_a_loop(tmp_path: Path) -> None:
    data = read_measurements(written(tmp_path / "loop.csv", columns(0.0)))
    with pytest.raises(ConfigurationError, match="rotor"):
        candidates_of(data, {"": setup_of()}, {"rotor.inertia": (1e-7, 1e-5)})
    with pytest.raises(ConfigurationError, match="law"):
        candidates_of(data, {}, FREE)


@pytest.mark.long
def test_a_fit_of_a_loop_covers_the_truth(tmp_path: Path) -> None:
    path = written(tmp_path / "loop.csv", columns(NOISE))
    result = cl.fit(setup_of(), data=path, free=FREE, points=25, starts=1, output=tmp_path / "fit")
    for key, truth in zip(FREE, (FRICTION, STIFFNESS), strict=True):
        estimate = result.numbers[key]
        assert abs(estimate.value - truth) < 4.0 * estimate.error
    assert cl.load(tmp_path / "fit" / "fit.nc").numbers == result.numbers
