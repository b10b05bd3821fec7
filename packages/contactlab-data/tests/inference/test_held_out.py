"""Claims on held-out data of a fit: numbers and misfits are those of the algebra, and faults have a name."""

from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.held_out import cycles, folds_of, held_out_misfits, residuals_of
from contactlab_data.inference.problem import Problem
from contactlab_data.inference.synthetic import made_impacts, with_noise
from contactlab_data.measured.series import MeasuredSeries

KEY = "contact.friction_coefficient"
FREE = {KEY: (0.05, 1.0)}
TIME = np.linspace(0.0, 1.0, 61)


def loop(truth: float, noise: float, seed: int, turns: float = 0.0) -> MeasuredSeries:
    """Friction mu N under a load that grows, of a block that is pulled, or swings so many times."""
    load = 5.0 + 5.0 * TIME
    slip = 1e-3 * np.sin(2.0 * np.pi * turns * TIME + 0.05) if turns else 1e-3 * TIME
    sign = np.sign(np.cos(2.0 * np.pi * turns * TIME + 0.05))
    friction = -truth * load * sign + np.random.default_rng(seed).normal(0.0, noise, TIME.size)
    errors = {"friction_force": np.full(TIME.size, noise)}
    path = {"normal": load, "slip": slip}
    return MeasuredSeries(TIME, {"friction_force": friction}, errors, {}, {}, "", path)


def problem_of(data, **options) -> Problem:
    setup = cl.build(["law=newton", "law.restitution=0.5"])
    (candidate,) = candidates_of(data, {"": setup}, FREE, **options)
    return candidate.problem


def line_of(data: MeasuredSeries) -> tuple[np.ndarray, np.ndarray]:
    """Slope and data over the error, which least squares see: friction is linear in mu."""
    noise = data.errors["friction_force"]
    return -data.path["normal"] / noise, data.values["friction_force"] / noise


def test_a_file_is_predicted_by_the_least_squares_of_the_others() -> None:
    sets = {"one": loop(0.3, 0.1, 1), "two": loop(0.3, 0.2, 2), "off": loop(0.36, 0.1, 3)}
    problem = problem_of(sets)
    data = held_out_misfits(problem, folds_of(problem, "files"), np.array([0.32]), seed=0)
    lines = {label: line_of(each) for label, each in sets.items()}
    for label, (slope, seen) in lines.items():
        others = [x for name, x in lines.items() if name != label]
        mu = sum(a @ b for a, b in others) / sum(a @ a for a, b in others)
        here = data.sel(fold=label)
        np.testing.assert_allclose(here["value"], [mu], rtol=1e-7)
        np.testing.assert_allclose(here["misfit"], np.sqrt(np.mean((seen - mu * slope) ** 2)), rtol=1e-6)
        assert here["count"] == TIME.size
    # Another friction: 0.06 of 7.5 N is four of its errors.
    assert data["misfit"].idxmax() == "off"
    assert float(data["misfit"].max()) > 3.0
    assert (data["misfit"] >= data["fitted_misfit"] * (1.0 - 1e-9)).all()


def test_residuals_are_a_set_for_each_file() -> None:
    sets = {"loop": loop(0.3, 0.1, 1), "drops": with_noise(made_impacts(cl.Newton(), 20, 0.02, 1), 0.02)}
    problem = problem_of(sets)
    values = np.array([0.27])
    data = residuals_of(problem, problem.residuals(values))
    assert set(data) == {"loop.friction_force", "drops.velocity_after"}
    slope, seen = line_of(sets["loop"])
    np.testing.assert_allclose(data["loop.friction_force"], seen - 0.27 * slope, rtol=1e-6, atol=1e-6)
    assert data["drops.velocity_after"].shape == (20, 2)


@pytest.mark.parametrize("turns", [2.0, 3.2, 3.9])
def test_cycles_of_a_loop_are_whole(turns: float) -> None:
    each = cycles(loop(0.3, 0.1, 1, turns).path["slip"])
    count = round(turns)
    assert set(each) == {*range(count)}
    sizes = np.bincount(each)
    assert sizes.min() > 0.75 * TIME.size / turns
    assert (np.diff(each) >= 0).all()


def test_a_cycle_is_predicted_by_the_others() -> None:
    problem = problem_of(loop(0.3, 0.1, 4, turns=3.0))
    folds = folds_of(problem, "cycles")
    assert folds.labels == ["cycle 1", "cycle 2", "cycle 3"]
    data = held_out_misfits(problem, folds, np.array([0.3]), seed=0)
    zero, unit = problem.residuals(np.array([0.2])), problem.residuals(np.array([0.3]))
    slope = (unit - zero) / 0.1
    for number, value in enumerate(data["value"].values[:, 0]):
        others = folds.fold != number
        left = problem.residuals(np.array([value]))[others]
        # The normal equation of the others alone.
        assert abs(slope[others] @ left) < 1e-5 * (slope[others] @ slope[others])


def test_what_cannot_be_held_out_is_refused() -> None:
    pulled, swinging = loop(0.3, 0.1, 1), loop(0.3, 0.1, 1, turns=3.0)
    drops = with_noise(made_impacts(cl.Newton(), 20, 0.02, 1), 0.02)
    with pytest.raises(ConfigurationError, match=r"held_out.*file"):
        folds_of(problem_of(pulled), "files")
    with pytest.raises(ConfigurationError, match=r"held_out.*cycle"):
        folds_of(problem_of(pulled), "cycles")
    with pytest.raises(ConfigurationError, match=r"held_out.*drops"):
        folds_of(problem_of({"loop": swinging, "drops": drops}), "cycles")
    with pytest.raises(ConfigurationError, match=r"own.*friction_coefficient"):
        folds_of(problem_of({"a": pulled, "b": swinging}, own=[KEY]), "files")


@pytest.mark.long
def test_a_fit_keeps_what_it_held_out(tmp_path: Path) -> None:
    setup = cl.build(["law=newton", "law.restitution=0.5"])
    data = [loop(0.3, 0.1, 1), loop(0.3, 0.2, 2)]
    result = cl.fit(
        setup, data=data, free=FREE, points=25, starts=1, held_out="files", output=tmp_path / "fit"
    )
    assert result.tables["held_out"]["held out"].tolist() == ["data_1", "data_2"]
    assert (tmp_path / "fit" / "residuals.png").exists()
    again = cl.load(tmp_path / "fit" / "fit.nc")
    assert again.tables["held_out"].equals(result.tables["held_out"])
