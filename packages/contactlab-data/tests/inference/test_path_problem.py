"""Claims on forces measured on a prescribed path: the law that made them in another program is found."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.command_line import cases

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab.laws.registry import own
from contactlab_data.inference import path_problem as path_module
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.law_numbers import free_numbers
from contactlab_data.inference.least_squares import best_fit
from contactlab_data.inference.nested_sampling import sample
from contactlab_data.inference.path_problem import path_problem
from contactlab_data.measured.files import MeasurementError, read_measurements
from contactlab_data.measured.series import FORCES, MeasuredSeries
from contactlab_data.studies.fit import Fit

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
    # What is left is the error of the spline through the samples, and of the integration above.
    np.testing.assert_allclose(predicted, exact, atol=1e-7 * np.abs(exact).max())


CYCLE = (np.arange(60) + 0.5) / 60.0
"""Times of a cycle, none at a reversal [s]."""


def loop_of(amplitude: float, time: np.ndarray = CYCLE, normal: float = NORMAL) -> MeasuredSeries:
    """Forces, not measured yet, on a sine of one cycle a second."""
    path = {"slip": amplitude * np.sin(2.0 * np.pi * time), "normal": normal + 0.0 * time}
    return MeasuredSeries(time, dict.fromkeys(FORCES, 0.0 * time), {}, {}, {}, "", path)


def predicted_by(law: cl.ContactLaw, data: MeasuredSeries, degree: int = 7) -> dict[str, np.ndarray]:
    """Return the forces of a law with nothing free."""
    return path_problem(data, law, (), discrepancy=False, degree=degree).predict(np.empty(0))


def test_coulomb_with_a_dashpot_is_known_at_every_instant_of_a_loop() -> None:
    """F = -(mu N sign v + sigma_2 v), next to a reversal as elsewhere."""
    amplitude, viscous = 2e-3, 90.0
    law = cl.Composed(friction=cl.Coulomb(FRICTION), viscous_friction=viscous)
    velocity = 2.0 * np.pi * amplitude * np.cos(2.0 * np.pi * CYCLE)
    exact = -FRICTION * NORMAL * np.sign(velocity) - viscous * velocity
    forces = predicted_by(law, loop_of(amplitude))
    np.testing.assert_allclose(forces["friction_force"], exact, atol=1e-7 * FRICTION * NORMAL)
    np.testing.assert_allclose(forces["normal_force"], NORMAL, rtol=1e-12)


@pytest.mark.parametrize("degree", [1, 7])
def test_at_a_reversal_friction_is_that_before_it_and_at_the_start_that_after_it(degree: int) -> None:
    """Two cycles from a reversal on, of which every twentieth sample lies at another."""
    sample = np.arange(81)
    law = cl.LagrangeStick(friction_coefficient=FRICTION)
    force = predicted_by(law, loop_of(2e-3, 0.25 + sample / 40.0), degree)["friction_force"]
    way = np.where((np.maximum(sample, 1) - 1) // 20 % 2 == 0, 1.0, -1.0)
    np.testing.assert_allclose(force, way * FRICTION * NORMAL, rtol=1e-12)


@pytest.mark.parametrize(
    "name", cases(own("friction"), {"coulomb", "mindlin", "regularised", "elasto_plastic"})
)
def test_a_force_at_an_instant_is_the_rate_of_its_impulse(name: str) -> None:
    """The mean of the two shortest intervals beside each instant, from the engine's impulses."""
    # A run unites rings as the patch grows; on a path the patch is whole from the start.
    rings = ["law.friction.first_ring=2e6"] if name == "microslip" else []
    law = cl.build(["law=composed", f"law/friction={name}", *rings]).law
    data, finer = loop_of(2e-6), 500
    path = {"normal": NORMAL, "slip": data.path["slip"], "degree": 7}
    step = float(CYCLE[1] - CYCLE[0])
    run = cl.drive(law, CYCLE, **path, record_interval=step / finer)
    means = run["friction_force"].values
    inside = finer * np.arange(1, CYCLE.size - 1)
    expected = 0.5 * (means[inside] + means[inside + 1])
    predicted = predicted_by(law, data)["friction_force"][1:-1]
    np.testing.assert_allclose(predicted, expected, atol=1e-6 * np.abs(means).max())


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


LOOPS = ((8.0, 2e-3, 90.0, 60, 0.15), (20.0, 1e-3, 70.0, 40, 0.4))
"""Load [N], amplitude [m], angular frequency [1/s], samples and noise [N] of two loops of one law."""

LINEAR = {"contact.friction_coefficient": (0.1, 0.5), "law.viscous_friction": (0.0, 40.0)}


def linear_loops(
    seed: int, level: float = 1.0
) -> tuple[dict[str, MeasuredSeries], list[np.ndarray], list[np.ndarray]]:
    """Loops whose model is linear in its numbers, F = X (mu, sigma_2), with X and F over the noise.

    Friction jumps at their reversals; the noise is a level times that of `LOOPS`.
    """
    draws, sets, rows, data = np.random.default_rng(seed), {}, [], []
    for load, amplitude, turn, count, size in LOOPS:
        time, noise = (np.arange(count) + 0.5) / count * 2.0 * np.pi / turn, level * size
        velocity = amplitude * turn * np.cos(turn * time)
        rows.append(np.column_stack([-load * np.sign(velocity), -velocity]) / noise)
        data.append(rows[-1] @ [0.21, 9.0] + draws.standard_normal(count))
        path = {"slip": amplitude * np.sin(turn * time), "normal": load + 0.0 * time}
        errors = {"friction_force": np.full(count, noise)}
        friction = {"friction_force": noise * data[-1]}
        sets[f"loop{len(sets)}"] = MeasuredSeries(time, friction, errors, {}, {}, "", path)
    return sets, rows, data


def gaussian(
    rows: list[np.ndarray], data: list[np.ndarray], level: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean, deviation and ln Z of a linear model, whose ranges hold all of its likelihood."""
    x, y = np.concatenate(rows), np.concatenate(data)
    noise = level * np.concatenate([np.full(each[3], each[4]) for each in LOOPS])
    curvature = x.T @ x
    mean, deviation = np.linalg.solve(curvature, x.T @ y), np.sqrt(np.diag(np.linalg.inv(curvature)))
    for (low, high), middle, size in zip(LINEAR.values(), mean, deviation, strict=True):
        assert low + 4.0 * size < middle < high - 4.0 * size
    most = -0.5 * np.sum((y - x @ mean) ** 2) - np.sum(np.log(noise * np.sqrt(2.0 * np.pi)))
    volume = np.prod([high - low for low, high in LINEAR.values()])
    evidence = most + np.log(2.0 * np.pi) - 0.5 * np.linalg.slogdet(curvature)[1] - np.log(volume)
    return mean, deviation, float(evidence)


def linear_setup() -> cl.Setup:
    return cl.build(["law=composed", "law/friction=coulomb", "law.viscous_friction=1"])


def test_the_likelihood_of_a_linear_law_is_gaussian() -> None:
    sets, rows, data = linear_loops(1)
    (candidate,) = candidates_of(sets, {"": linear_setup()}, LINEAR)
    noise = np.concatenate([np.full(each[3], each[4]) for each in LOOPS])
    x, y = np.concatenate(rows), np.concatenate(data)
    for values in ([0.21, 9.0], [0.12, 35.0], [0.45, 0.5]):
        exact = -0.5 * np.sum((y - x @ values) ** 2) - np.sum(np.log(noise * np.sqrt(2.0 * np.pi)))
        assert candidate.problem.log_likelihood(np.array(values)) == pytest.approx(exact, abs=1e-3)


@pytest.mark.parametrize("level", [0.1, 0.5, 1.5])
def test_least_squares_of_a_linear_law_have_the_gaussian_integrals(level: float) -> None:
    """ln Z within 0.1 and means within 0.05 deviations; Laplace's approximation is exact here."""
    sets, rows, data = linear_loops(1, level)
    mean, deviation, evidence = gaussian(rows, data, level)
    options: dict[str, Any] = {"method": "least_squares", "held_out": "off", "output": None}
    result = cl.fit(linear_setup(), data=list(sets.values()), free=LINEAR, **options)
    fit = next(iter(result.data.children.values()))
    assert abs(fit.attrs["log_evidence"] - evidence) < 0.1
    for key, value, size in zip(LINEAR, mean, deviation, strict=True):
        row = fit["summary"].to_dataset().sel(parameter=key)
        assert abs(float(row["best"]) - value) < 1e-3 * size
        assert abs(result.numbers[key].value - value) < 0.05 * size
        assert result.numbers[key].error == pytest.approx(size, rel=0.05)


@pytest.mark.long
def test_nested_sampling_of_a_linear_law_has_the_gaussian_integrals() -> None:
    sets, rows, data = linear_loops(1, 0.1)
    mean, deviation, evidence = gaussian(rows, data, 0.1)
    (candidate,) = candidates_of(sets, {"": linear_setup()}, LINEAR)
    posterior = sample(candidate.problem, points=400, seed=2, workers=1)
    assert posterior.log_evidence == pytest.approx(evidence, abs=3.0 * posterior.error)
    own, _ = posterior.moments()
    assert (np.abs(own - mean) < 4.0 * deviation / np.sqrt(posterior.effective)).all()


def test_a_path_that_is_interrupted_is_no_path_without_a_prediction(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where Ctrl-C reaches the run itself, the search and the sampling end with it."""
    law = cl.Composed(friction=cl.Coulomb(FRICTION))
    # A contact that opens is a run.
    data = loop_of(2e-3)
    data = replace(data, path={"slip": data.path["slip"], "gap": 1e-6 * np.cos(20.0 * CYCLE)})
    assert predicted_by(law, data) is not None

    def stop(time: float) -> None:
        if time > 0.0:
            raise KeyboardInterrupt

    whole = path_module.simulate
    monkeypatch.setattr(path_module, "simulate", lambda *args, **named: whole(*args, **named, progress=stop))
    with pytest.raises(KeyboardInterrupt):
        predicted_by(law, data)


def test_a_number_without_influence_is_not_free_and_that_is_stated() -> None:
    """Under a given load a stiffness moves the gap alone; with Mindlin's friction it is also the spring's."""
    free = {"law.normal.stiffness": (1e9, 1e11), "contact.friction_coefficient": (0.1, 0.5)}
    data = loop_of(2e-6)
    for friction, idle in (("coulomb", ["law.normal.stiffness"]), ("mindlin", [])):
        setup = cl.build(["law=composed", f"law/friction={friction}"])
        (candidate,) = candidates_of(data, {"": setup}, free)
        names = {item.name for item in candidate.problem.parameters}
        assert names == {*free} - {*idle}
        assert all(f" {key}." in candidate.numbers for key in idle)
    stiffness = {"law.normal.stiffness": (1e9, 1e11)}
    measured = replace(data, errors=dict.fromkeys(FORCES, 0.1 + 0.0 * CYCLE))
    with pytest.raises(ConfigurationError, match="stiffness"):
        candidates_of(measured, {"": cl.build(["law=composed"])}, stiffness)
