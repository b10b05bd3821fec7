"""Claims on fits of several data sets: likelihoods add, shared numbers are narrowed, own ones are not."""

from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.joint_problem import JointProblem
from contactlab_data.inference.synthetic import made_impacts, with_noise
from contactlab_data.measured.series import MeasuredSeries
from contactlab_data.studies.fit import Fit

KEY = "contact.friction_coefficient"
FREE = {KEY: (0.05, 1.0)}
TRUTH = 0.3

TIME = np.linspace(0.0, 1.0, 41)


def curve(noise: float, seed: int) -> MeasuredSeries:
    """Friction of a block under a load that grows: mu N."""
    load = 5.0 + 5.0 * TIME
    friction = -TRUTH * load + np.random.default_rng(seed).normal(0.0, noise, TIME.size)
    path = {"normal": load, "slip": 1e-3 * TIME}
    errors = {"friction_force": np.full(TIME.size, noise)}
    return MeasuredSeries(TIME, {"friction_force": friction}, errors, {}, {}, "", path)


def setup_of() -> cl.Setup:
    return cl.build(["law=newton", "law.restitution=0.5"])


def problem_of(data, **options) -> JointProblem:
    (candidate,) = candidates_of(data, {"": setup_of()}, FREE, **options)
    return candidate.problem


def test_log_likelihoods_of_independent_data_add() -> None:
    sets = {"impacts": with_noise(made_impacts(setup_of().law, 20, 0.02, 1), 0.02), "curve": curve(0.1, 2)}
    joint, values = problem_of(sets), np.array([0.27])
    each = [problem_of(data).log_likelihood(values) for data in sets.values()]
    np.testing.assert_allclose(joint.log_likelihood(values), sum(each), rtol=1e-13)
    assert [item.name for item in joint.parameters] == [KEY]
    assert set(joint.predict(values)) == {"impacts.velocity_after", "curve.friction_force"} == set(joint.data)


def test_a_shared_number_is_known_as_the_algebra_says() -> None:
    """Linear in mu: 1/s^2 = 1/s_1^2 + 1/s_2^2, and the best value is the mean that these weights have."""
    sets = {"one": curve(0.1, 3), "two": curve(0.3, 4)}
    weights, best = [], []
    for data in sets.values():
        load, noise = data.path["normal"], data.errors["friction_force"]
        weights.append(np.sum((load / noise) ** 2))
        best.append(-np.sum(load * data.values["friction_force"] / noise**2) / weights[-1])
    joint, step = problem_of(sets), 1e-3
    mean = float(np.dot(weights, best) / sum(weights))
    slope = joint.residuals(np.array([mean + step])) - joint.residuals(np.array([mean - step]))
    np.testing.assert_allclose(np.sum((slope / (2.0 * step)) ** 2), sum(weights), rtol=1e-8)
    assert abs(slope @ joint.residuals(np.array([mean]))) < 1e-6 * np.sum(slope**2)


def test_a_number_may_be_each_data_sets_own() -> None:
    joint = problem_of({"one": curve(0.1, 3), "two": curve(0.3, 4)}, own=[KEY])
    assert [item.name for item in joint.parameters] == [f"one.{KEY}", f"two.{KEY}"]
    first, second = joint.residuals(np.array([0.3, 0.2])), joint.residuals(np.array([0.3, 0.4]))
    np.testing.assert_array_equal(first[: TIME.size], second[: TIME.size])
    assert not np.allclose(first[TIME.size :], second[TIME.size :])


def test_noise_that_is_not_stated_is_each_data_sets_own() -> None:
    study = Fit(data=[curve(0.1, 3), curve(0.3, 4)], noise="free")
    (candidate,) = candidates_of(study.measurements, {"": setup_of()}, FREE)
    names = [item.name for item in candidate.problem.free]
    assert names == [KEY, "data_1.noise.friction_force", "data_2.noise.friction_force"]


def test_what_does_not_go_together_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="own"):
        problem_of({"one": curve(0.1, 3), "two": curve(0.3, 4)}, own=["law.restitution"])
    with pytest.raises(ConfigurationError, match="own"):
        problem_of({"one": curve(0.1, 3)}, own=[KEY])
    with pytest.raises(ConfigurationError, match="rotor"):
        candidates_of({"one": curve(0.1, 3)}, {"": setup_of()}, {"rotor.inertia": (1e-7, 1e-5)})
    with pytest.raises(ConfigurationError, match="data"):
        _ = Fit(data=[tmp_path / "a" / "x.csv", tmp_path / "b" / "x.csv"]).measurements


@pytest.mark.long
def test_a_fit_of_two_files_draws_both_and_is_read_again(tmp_path: Path) -> None:
    for name, noise in (("first", 0.1), ("second", 0.3)):
        data = curve(noise, 5)
        table = {"time": TIME, "slip": data.path["slip"], "normal": data.path["normal"]}
        table["friction_force"] = data.values["friction_force"]
        header = "time [s],slip [m],normal [N],friction_force [N]"
        rows = np.column_stack([*table.values()])
        np.savetxt(tmp_path / f"{name}.csv", rows, delimiter=",", header=header, comments="")
    files = [str(tmp_path / f"{name}.csv") for name in ("first", "second")]
    result = cl.fit(setup_of(), data=files, free=FREE, points=25, starts=1, output=tmp_path / "fit")
    estimate = result.numbers[KEY]
    assert abs(estimate.value - TRUTH) < 4.0 * estimate.error < 0.05
    assert {"predictions_first", "predictions_second"} <= {x.stem for x in (tmp_path / "fit").glob("*.png")}
    assert cl.load(tmp_path / "fit" / "fit.nc").numbers == result.numbers
