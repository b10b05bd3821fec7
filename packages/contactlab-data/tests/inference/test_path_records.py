"""Claims on records of forces on a path: gaps, means, velocities, files, and damping under a load."""

from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab.driving import integrated
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.path_records import record_problem
from contactlab_data.inference.problem import Problem
from contactlab_data.inference.synthetic import made_impacts
from contactlab_data.measured.files import MeasurementError, read_measurements
from contactlab_data.measured.series import MeasuredSeries, gaps
from contactlab_data.studies.fit import Fit

NORMAL, FRICTION, AMPLITUDE, VISCOUS = 10.0, 0.3, 2e-3, 90.0
TURN = 2.0 * np.pi
TIME = (np.arange(60) + 0.5) / 60.0
"""Times of a cycle, none at a reversal [s]."""

LAW = cl.Composed(friction=cl.Coulomb(FRICTION), viscous_friction=VISCOUS)


def force(time: np.ndarray) -> np.ndarray:
    """Friction of Coulomb with a dashpot on a sine: it jumps at a reversal."""
    velocity = TURN * AMPLITUDE * np.cos(TURN * time)
    return -FRICTION * NORMAL * np.sign(velocity) - VISCOUS * velocity


def columns(time: np.ndarray = TIME) -> dict[str, list[str]]:
    """Columns of a file as texts."""
    every = {
        "time [s]": time,
        "slip [m]": AMPLITUDE * np.sin(TURN * time),
        "normal [N]": NORMAL + 0.0 * time,
        "friction_force [N]": force(time),
    }
    return {name: [*map(repr, values.tolist())] for name, values in every.items()}


def written(path: Path, table: dict[str, list[str]], *head: str) -> Path:
    rows = [",".join(row) for row in zip(*table.values(), strict=True)]
    path.write_text("\n".join([*(f"# {line}" for line in head), ",".join(table), *rows]) + "\n")
    return path


def problem_of(data: MeasuredSeries, law: cl.ContactLaw = LAW, degree: int = 7) -> Problem:
    return record_problem(data, law, (), discrepancy=False, degree=degree)


def test_rows_without_a_force_are_on_the_path_and_are_not_compared(tmp_path: Path) -> None:
    table = columns()
    table["friction_force [N]"][10:30] = [""] * 20
    whole = read_measurements(written(tmp_path / "whole.csv", columns()))
    some = read_measurements(written(tmp_path / "some.csv", table))
    assert "20 of 60" in some.notes[0]
    expected = problem_of(whole).predict(np.empty(0))["friction_force"]
    problem = problem_of(some)
    predicted = problem.predict(np.empty(0))["friction_force"]
    kept = np.r_[:10, 30:60]
    np.testing.assert_allclose(predicted, expected[kept], rtol=1e-12)
    assert np.isfinite(problem.log_likelihood(np.array([0.1])))
    assert problem.data["time"].values.tolist() == TIME[kept].tolist()


def test_missing_rows_are_told_where_the_gap_is_long() -> None:
    time = np.delete(np.linspace(0.0, 1.0, 101), np.arange(40, 60))
    (text,) = gaps(time)
    assert "0.39 s" in text
    assert not [*gaps(np.delete(np.linspace(0.0, 1.0, 101), [40]))]


def test_forces_that_are_means_are_integrals_of_the_law() -> None:
    """Their sum times the interval is the impulse."""
    time = np.linspace(0.0, 1.0, 41)
    path = {"slip": AMPLITUDE * np.sin(TURN * time), "normal": NORMAL + 0.0 * time}
    zeros = {"friction_force": 0.0 * time}
    about = {"forces": "means"}
    data = MeasuredSeries(time, zeros, {}, {}, about, "", path)
    assert data.means
    predicted = problem_of(data).predict(np.empty(0))["friction_force"]
    # The integral of -mu N sign(v) - c v.
    slip = path["slip"]
    signs = np.where(time < 0.25, time, np.where(time < 0.75, 0.5 - time, time - 1.0))
    exact = -(FRICTION * NORMAL * np.diff(signs) + VISCOUS * np.diff(slip)) / np.diff(time)
    assert predicted.size == 40
    # Reversals lie at ends of intervals here.
    np.testing.assert_allclose(predicted, exact, atol=2e-3 * FRICTION * NORMAL)
    values = MeasuredSeries(time, zeros, {}, {}, {}, "", path)
    assert not values.means
    assert np.abs(problem_of(values).predict(np.empty(0))["friction_force"][1:] - exact).max() > 0.05


def test_a_velocity_is_integrated_and_its_error_is_told(tmp_path: Path) -> None:
    table = columns()
    velocity = TURN * AMPLITUDE * np.cos(TURN * TIME)
    table = {name.replace("slip [m]", "velocity [mm/s]"): x for name, x in table.items()}
    table["velocity [mm/s]"] = [*map(repr, (1e3 * velocity).tolist())]
    data = read_measurements(written(tmp_path / "v.csv", table, "velocity_error: 0.1 mm/s"))
    exact = AMPLITUDE * (np.sin(TURN * TIME) - np.sin(TURN * TIME[0]))
    slip, text = integrated(TIME, velocity, np.full(60, 1e-4))
    np.testing.assert_allclose(data.path["slip"], slip, rtol=1e-12, atol=1e-15)
    told = float(text.split("differs by ")[1].split(" m")[0])
    assert np.abs(slip - exact).max() < told < 1e-2 * AMPLITUDE
    # A random walk of sixty steps of 1e-4 m/s in a sixtieth of a second.
    assert float(text.split("one of ")[1].split(" m")[0]) == pytest.approx(1e-4 / 60**0.5, rel=0.05)
    assert [*data.errors] == []
    assert data.notes == (text,)
    predicted = problem_of(data).predict(np.empty(0))["friction_force"]
    np.testing.assert_allclose(predicted[1:], force(TIME)[1:], rtol=1e-3)


LOSSY = cl.Composed(cl.HertzPoint(1e10), cl.Flores(0.7), cl.Mindlin(friction_coefficient=FRICTION))


def test_under_a_load_that_varies_damping_has_no_part(tmp_path: Path) -> None:
    table = columns()
    load = NORMAL * (1.0 + 0.3 * np.sin(3.0 * TURN * TIME))
    table["normal [N]"] = [*map(repr, load.tolist())]
    data = read_measurements(written(tmp_path / "load.csv", table))
    with pytest.raises(ValueError, match="normal force"):
        cl.drive(LOSSY, data.time, **data.path)
    bare = cl.Composed(cl.HertzPoint(1e10), friction=cl.Mindlin(friction_coefficient=FRICTION))
    same, other = (problem_of(data, law).predict(np.empty(0))["friction_force"] for law in (LOSSY, bare))
    np.testing.assert_array_equal(same, other)


def test_tracks_and_loops_share_a_law_with_a_damping(tmp_path: Path) -> None:
    words = ["law=composed", "law/damping=flores", "law/friction=mindlin"]
    setup = cl.build(words)
    free = {"law.damping.restitution": (0.3, 1.0), "contact.friction_coefficient": (0.05, 1.0)}
    sets = {
        "loop": read_measurements(written(tmp_path / "loop.csv", columns())),
        "drops": made_impacts(setup.law, 8, 0.05, 1),
    }
    (candidate,) = candidates_of(sets, {"": setup}, free)
    assert {item.name for item in candidate.problem.parameters} == {*free}
    values = np.array([x.to_unit(0.5) for x in candidate.problem.parameters])
    assert candidate.problem.predict(values) is not None


def test_names_with_wildcards_are_files_and_each_has_its_own_noise(tmp_path: Path) -> None:
    for name, head in {"a": [], "b": ["noise: 0.02"], "c": ["noise: free"]}.items():
        table = columns() | {"friction_force_error [N]": ["0.1"] * 60}
        written(tmp_path / f"{name}.csv", table, *head)
    sets = Fit(data=str(tmp_path / "*.csv")).measurements
    assert [*sets] == ["a", "b", "c"]
    size = np.sqrt(np.mean(force(TIME) ** 2))
    assert sets["a"].errors["friction_force"] == pytest.approx(0.1)
    assert sets["b"].errors["friction_force"] == pytest.approx(0.02 * size)
    assert not sets["c"].errors
    with pytest.raises(ConfigurationError, match="data"):
        _ = Fit(data=str(tmp_path / "*.nc")).measurements
    written(tmp_path / "d.csv", columns(), "noise: much")
    with pytest.raises(ConfigurationError, match="noise"):
        _ = Fit(data=tmp_path / "d.csv").measurements


@pytest.mark.parametrize("head", ["forces: sums", "velocity_error: 1 m/s"])
def test_a_key_that_means_nothing_here_is_refused(tmp_path: Path, head: str) -> None:
    with pytest.raises(MeasurementError, match=head.split(":")[0]):
        read_measurements(written(tmp_path / "loop.csv", columns(), head))


def test_forces_of_a_motor_at_their_times_are_refused() -> None:
    setup = cl.build(["law=newton", "solver.duration=2e-4", "record.interval=1e-5"])
    run = setup.run()
    about = {"forces": "values"}
    data = MeasuredSeries(run.time, {"normal_force": run.series["normal_force"]}, {}, {}, about)
    with pytest.raises(ConfigurationError, match="forces"):
        candidates_of(data, {"": setup}, {"law.restitution": (0.1, 0.9)})
