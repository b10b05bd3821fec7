"""Claims on fits of force curves: the numbers of law and recording, and what tells the state of the tip."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import curve_fit

import contactlab as cl
from contactlab.cli.study import as_overrides
from contactlab.cli.verbs.example import examples
from contactlab.config import ConfigurationError
from contactlab.force_curves import BY_LAW, FREE, TOUCHING, Recording
from contactlab.motor.table import MeasurementError
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.curve_problem import curve_problem, jumps_of, states_of
from contactlab_data.inference.nested_sampling import sample
from contactlab_data.measured.files import read_measurements
from contactlab_data.measured.series import MeasuredSeries

RADIUS, MODULUS, WORK, STIFFNESS, NOISE = 20e-9, 1e9, 0.05, 1.0, 5e-11
"""Radius [m], E* [Pa], w [J/m^2], k [N/m] and noise [N]: the truth."""

RECORDED = {"contact_point": 48.31e-9, "baseline": 3e-10, "tilt": -0.005}
FREE_OF_CURVE = dict.fromkeys(RECORDED, "free") | {"cantilever_stiffness": STIFFNESS}
DOWN = np.linspace(60e-9, 40e-9, 250)
CYCLE = np.append(DOWN, DOWN[::-1])

ADHESIVE = {"law.normal.effective_modulus": (1e7, 1e11), "law.normal.work_of_adhesion": (1e-3, 1.0)}
TRUTH = RECORDED | dict(zip(ADHESIVE, (MODULUS, WORK), strict=True))
LAWS: dict[str, tuple[Any, list[str], dict[str, Any]]] = {
    "jkr": (cl.Jkr(RADIUS, MODULUS, WORK), [], ADHESIVE),
    "dmt": (cl.Dmt(RADIUS, MODULUS, WORK), [], ADHESIVE),
    "maugis": (cl.Maugis(RADIUS, MODULUS, WORK, 1.0), ["law.normal.tabor_number=1"], ADHESIVE),
    "hertz_elliptic": (
        cl.HertzElliptic(RADIUS, RADIUS, MODULUS),
        ["law.normal.radius_along=20e-9", "law.normal.radius_across=20e-9"],
        {"law.normal.effective_modulus": (1e7, 1e11)},
    ),
}
"""Laws by name: normal part, overrides of what is known, and free numbers."""


def series(force: np.ndarray, position: np.ndarray = CYCLE, noise: float | None = NOISE) -> MeasuredSeries:
    """A measured force curve, whose noise is stated or not."""
    errors = {} if noise is None else {"normal_force": np.full(force.size, noise)}
    rows = np.arange(force.size, dtype=float)
    return MeasuredSeries(rows, {"normal_force": force}, errors, {}, {}, "", {"z": position})


def made(name: str, seed: int, noise: float | None = NOISE, **recorded: float) -> MeasuredSeries:
    """A curve of a law, with noise."""
    law = cl.Composed(LAWS[name][0])
    force = cl.force_curve(law, CYCLE, **(RECORDED | recorded), cantilever_stiffness=STIFFNESS)
    return series(force + NOISE * np.random.default_rng(seed).standard_normal(CYCLE.size), noise=noise)


def setup_of(name: str) -> cl.Setup:
    radius = [] if name == "hertz_elliptic" else [f"law.normal.radius={RADIUS}"]
    return cl.build(["law=composed", f"law/normal={name}", *radius, *LAWS[name][1]])


def least_squares(setup: Any, data: Any, **options: Any) -> Any:
    """The group of a fit by least squares."""
    fit = cl.fit(setup, data=data, method="least_squares", held_out="off", output=None, **options)
    return next(iter(fit.data.children.values()))


def covered(seeds: range) -> dict[str, list[bool]]:
    """Whether the 90 % interval of each number contains the truth, of curves without a stated noise.

    Each curve in turn is of another law with adhesion.
    """
    inside: dict[str, list[bool]] = {key: [] for key in TRUTH}
    laws = [name for name, (_, _, free) in LAWS.items() if free == ADHESIVE]
    for seed in seeds:
        name = laws[seed % len(laws)]
        fit = least_squares(setup_of(name), made(name, seed, None), free=ADHESIVE, **FREE_OF_CURVE)
        summary = fit["summary"].to_dataset()
        for key, truth in TRUTH.items():
            row = summary.sel(parameter=key)
            inside[key].append(bool(row["low"] <= truth <= row["high"]))
    return inside


@pytest.mark.parametrize(("name", "seed"), [(name, seed) for seed, name in enumerate(LAWS)])
def test_law_and_recording_are_found_within_four_errors(name: str, seed: int) -> None:
    fit = least_squares(setup_of(name), made(name, seed), free=LAWS[name][2], **FREE_OF_CURVE)
    summary = fit["summary"].to_dataset()
    for key in (*RECORDED, *LAWS[name][2]):
        row = summary.sel(parameter=key)
        assert abs(row["best"] - TRUTH[key]) < 4.0 * row["deviation"]
    assert summary.sel(parameter="contact_point")["deviation"] < 1e-10
    assert fit.attrs["fits"] == 1
    assert 0.85 < fit.attrs["misfit"] < 1.15


@pytest.mark.long
def test_intervals_of_thirty_curves_contain_the_truth_as_often_as_they_say() -> None:
    """Of 30 intervals of 90 % less than 22 contain it with a probability of 0.2 %."""
    assert all(sum(inside) >= 22 for inside in covered(range(30)).values())


def straight(seed: int = 0) -> tuple[MeasuredSeries, np.ndarray, np.ndarray]:
    """A curve of a known spring at a known place, the design of baseline and tilt, and what they explain."""
    force = cl.force_curve(cl.Composed(cl.Linear(2.0)), CYCLE, **RECORDED, cantilever_stiffness=STIFFNESS)
    force = force + NOISE * np.random.default_rng(seed).standard_normal(CYCLE.size)
    # Spring and cantilever in series.
    rest = force - 2.0 / 3.0 * np.maximum(RECORDED["contact_point"] - CYCLE, 0.0)
    return series(force), np.column_stack([np.ones(CYCLE.size), CYCLE - CYCLE[0]]), rest


KNOWN = {
    "known": ["law.normal.stiffness", "contact.friction_coefficient", "law.friction.static_ratio"],
    "contact_point": RECORDED["contact_point"],
    "cantilever_stiffness": STIFFNESS,
    "free": {"baseline": (0.0, 1e-9), "tilt": (-0.05, 0.05)},
}
SPRING = ["law=composed", "law/normal=linear", "law.normal.stiffness=2"]


def gaussian(design: np.ndarray, rest: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean, covariance and ln Z of numbers of a linear model under even priors of `KNOWN`."""
    covariance = NOISE**2 * np.linalg.inv(design.T @ design)
    mean = covariance @ design.T @ rest / NOISE**2
    most = -0.5 * np.sum((rest - design @ mean) ** 2) / NOISE**2
    most -= rest.size * np.log(NOISE * np.sqrt(2.0 * np.pi))
    volume = np.prod([high - low for low, high in KNOWN["free"].values()])
    evidence = most + np.log(2.0 * np.pi) + 0.5 * np.linalg.slogdet(covariance)[1] - np.log(volume)
    return mean, covariance, float(evidence)


def test_baseline_and_tilt_alone_have_the_gaussian_posterior() -> None:
    data, design, rest = straight()
    mean, covariance, evidence = gaussian(design, rest)
    fit = least_squares(cl.build(SPRING), data, **KNOWN)
    summary = fit["summary"].to_dataset()
    deviation = np.sqrt(np.diag(covariance))
    for key, value, size in zip(KNOWN["free"], mean, deviation, strict=True):
        row = summary.sel(parameter=key)
        assert abs(row["best"] - value) < 1e-3 * size
        assert float(row["deviation"]) == pytest.approx(size, rel=0.05)
        # The profile of a linear number ends at 1.645 deviations.
        np.testing.assert_allclose(
            [row["low"], row["high"]], value + 1.645 * size * np.array([-1, 1]), rtol=0.02
        )
    assert fit.attrs["log_evidence"] == pytest.approx(evidence, abs=0.01)


@pytest.mark.long
def test_nested_sampling_has_the_gaussian_posterior_of_baseline_and_tilt() -> None:
    data, design, rest = straight()
    mean, covariance, evidence = gaussian(design, rest)
    recording = {key: KNOWN[key] for key in ("contact_point", "cantilever_stiffness")}
    (candidate,) = candidates_of(
        data, {"": cl.build(SPRING)}, KNOWN["free"], KNOWN["known"], recording=recording
    )
    posterior = sample(candidate.problem, points=200, seed=1, workers=1)
    own, spread = posterior.moments()
    deviation, four = np.sqrt(np.diag(covariance)), 4.0 / np.sqrt(posterior.effective)
    assert (np.abs(own - mean) < four * deviation).all()
    scale = np.outer(deviation, deviation)
    # The variance of a normal variable has twice the variance of its mean.
    np.testing.assert_allclose(spread / scale, covariance / scale, atol=np.sqrt(2.0) * four)
    assert posterior.log_evidence == pytest.approx(evidence, abs=3.0 * posterior.error)


def test_contact_point_and_stiffness_of_hertz_are_those_of_scipy() -> None:
    """Without a cantilever the depth is z_0 - z: N = K (z_0 - z)^1.5 + F_0."""
    truth = 2e5, 48e-9, 3e-10

    def model(z: np.ndarray, stiffness: float, place: float, baseline: float) -> np.ndarray:
        return stiffness * np.maximum(place - z, 0.0) ** 1.5 + baseline

    force = model(DOWN, *truth) + NOISE * np.random.default_rng(5).standard_normal(DOWN.size)
    best, covariance = curve_fit(
        lambda z, a, b, c: model(z, 1e5 * a, 1e-9 * b, 1e-10 * c),
        DOWN,
        force,
        (1.0, 50.0, 1.0),
        np.full(DOWN.size, NOISE),
        absolute_sigma=True,
        xtol=1e-12,
        ftol=1e-12,
    )
    fit = least_squares(
        cl.build(["law=composed", "law/normal=hertz_point"]),
        series(force, DOWN),
        free={"law.normal.stiffness": (1e4, 1e7)},
        contact_point="free",
        baseline="free",
    )
    summary = fit["summary"].to_dataset()
    keys = ("law.normal.stiffness", "contact_point", "baseline")
    scales = np.array([1e5, 1e-9, 1e-10])
    errors = scales * np.sqrt(np.diag(covariance))
    found = summary.sel(parameter=[*keys])
    assert (np.abs(found["best"].values - scales * best) < 0.01 * errors).all()
    np.testing.assert_allclose(found["deviation"], errors, rtol=0.1)


def test_jumps_of_the_data_tell_where_the_tip_was() -> None:
    """A law of less adhesion would be pulled off rows before, and has its last pull there."""
    options = {"contact_point": 48e-9, "cantilever_stiffness": STIFFNESS}
    strong, weak = (cl.Composed(cl.Jkr(RADIUS, MODULUS, work)) for work in (WORK, 0.8 * WORK))
    force, own = (cl.force_curve(law, CYCLE, **options) for law in (strong, weak))
    touches = force != 0.0
    rows = np.flatnonzero(np.diff(touches.astype(int)))
    jumps = jumps_of(CYCLE, force + NOISE * np.random.default_rng(1).standard_normal(CYCLE.size))
    assert jumps.tolist() == rows.tolist()
    assert np.array_equal(states_of(CYCLE, jumps), np.where(touches, TOUCHING, FREE))
    # Half of a cycle without a jump is the law's.
    assert set(states_of(CYCLE, jumps[:1])[DOWN.size :].tolist()) == {BY_LAW}
    problem = curve_problem(series(force), weak, (), Recording(**options), discrepancy=False)
    late = int(rows[1]) - 2
    assert own[late] == 0.0
    predicted = problem.predict(np.empty(0))["normal_force"][problem.places == late]
    np.testing.assert_allclose(predicted, own.min(), rtol=0.02)
    beside = [row + shift for row in rows for shift in (-1, 0, 1, 2)]
    assert sorted({*range(CYCLE.size)} - {*problem.places.tolist()}) == beside


def test_noise_has_no_jumps() -> None:
    noise = np.random.default_rng(2).standard_normal((200, 500))
    assert sum(jumps_of(CYCLE, each).size for each in noise) <= 5


def test_curves_share_the_law_and_each_has_a_contact_point_of_its_own() -> None:
    sets = {"first": made("dmt", 1), "second": made("dmt", 2, contact_point=50e-9)}
    (candidate,) = candidates_of(
        sets, {"": setup_of("dmt")}, ADHESIVE, own=["contact_point"], recording=FREE_OF_CURVE
    )
    names = [item.name for item in candidate.problem.parameters]
    assert {"first.contact_point", "second.contact_point", "tilt"} < {*names}
    values = TRUTH | {"first.contact_point": 48.31e-9, "second.contact_point": 50e-9}
    residuals = candidate.problem.residuals(np.array([values[name] for name in names]))
    assert np.mean(residuals**2) == pytest.approx(1.0, abs=0.2)


@pytest.mark.long
def test_nested_sampling_finds_the_numbers_of_jkr_and_prefers_it_to_hertz() -> None:
    (jkr,) = candidates_of(made("jkr", 3), {"": setup_of("jkr")}, ADHESIVE, recording=FREE_OF_CURVE)
    posterior = sample(jkr.problem, points=100, seed=1, workers=1)
    mean, covariance = posterior.moments()
    for item, value, variance in zip(jkr.problem.free, mean, np.diag(covariance), strict=True):
        assert abs(value - TRUTH[item.name]) < 4.0 * np.sqrt(variance)
    free = LAWS["hertz_elliptic"][2]
    (hertz,) = candidates_of(made("jkr", 3), {"": setup_of("hertz_elliptic")}, free, recording=FREE_OF_CURVE)
    assert sample(hertz.problem, points=50, seed=1, workers=1).log_evidence < posterior.log_evidence - 100.0


def written(path: Path, head: str, rows: np.ndarray) -> Path:
    """A CSV file of a header and rows."""
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.17g")
    return path


def test_a_file_of_positions_and_forces_is_read_in_its_order_and_units(tmp_path: Path) -> None:
    force = made("jkr", 0).values["normal_force"]
    rows = np.column_stack([1e9 * CYCLE, 1e9 * force, 0.0 * force + 50.0])
    data = read_measurements(
        written(tmp_path / "curve.csv", "z [nm],normal_force [nN],normal_force_error [pN]", rows)
    )
    np.testing.assert_allclose(data.path["z"], CYCLE, rtol=1e-12)
    np.testing.assert_allclose(data.values["normal_force"], force, rtol=1e-12)
    np.testing.assert_allclose(data.errors["normal_force"], NOISE, rtol=1e-12)
    assert not data.notes
    turned = written(tmp_path / "turned.csv", "z [nm],normal_force [nN]", rows[:, :2] * [-1.0, 1.0])
    (note,) = read_measurements(turned).notes
    assert "z = " in note


@pytest.mark.parametrize(
    ("head", "word"),
    [
        ("z [nm],force [nN]", "normal_force"),
        ("z [nm],normal_force", "normal_force"),
        ("z [N],normal_force [nN]", "z"),
        ("z [nm],normal_force [nN],slip [nm]", "slip"),
        ("z [nm],normal_force [nN],time [s]", "time"),
    ],
)
def test_a_faulty_force_curve_is_refused_with_column_and_file(tmp_path: Path, head: str, word: str) -> None:
    path = written(tmp_path / "curve.csv", head, np.ones((20, head.count(",") + 1)))
    with pytest.raises(MeasurementError, match=rf"curve\.csv.*\b{word}\b"):
        read_measurements(path)


def test_seven_rows_are_no_force_curve(tmp_path: Path) -> None:
    path = written(tmp_path / "curve.csv", "z [nm],normal_force [nN]", np.ones((7, 2)))
    with pytest.raises(MeasurementError, match=r"curve\.csv.*\bz\b"):
        read_measurements(path)


def test_the_shipped_curve_has_the_numbers_that_made_it() -> None:
    path = next(each.source for each in examples() if each.name == "force_curve")
    options = dict.fromkeys(RECORDED, "free") | {"cantilever_stiffness": 0.5}
    fit = least_squares(setup_of("jkr"), path, free=ADHESIVE, **options)
    truth = dict(zip(ADHESIVE, (1e9, 0.05), strict=True)) | {"contact_point": 73e-9, "tilt": -0.004}
    summary = fit["summary"].to_dataset()
    for key, value in truth.items():
        row = summary.sel(parameter=key)
        assert abs(row["best"] - value) < 3.0 * row["deviation"]


@pytest.mark.parametrize(
    ("overrides", "position", "options", "word"),
    [
        (["law=newton"], CYCLE, {}, "newton"),
        (["law=composed", "law/normal=thornton"], CYCLE, {}, "thornton"),
        (["law=composed"], np.append(CYCLE, CYCLE), {}, "z"),
        (["law=composed"], CYCLE, {"frame": {"frame_stiffness": 1.0}}, "frame_stiffness"),
        (["law=composed"], CYCLE, {"recording": {"cantilever_stiffness": -1.0}}, "cantilever_stiffness"),
    ],
)
def test_what_is_no_force_curve_of_a_law_is_refused(
    overrides: list[str], position: np.ndarray, options: dict[str, Any], word: str
) -> None:
    data = series(np.linspace(0.0, 1e-9, position.size), position)
    with pytest.raises(ConfigurationError, match=word):
        candidates_of(data, {"": cl.build(overrides)}, {"tilt": (-1.0, 1.0)}, **options)


def test_numbers_of_a_recording_are_those_of_force_curves_and_have_a_value_or_a_range() -> None:
    with pytest.raises(ConfigurationError, match="tilt"):
        candidates_of(made("jkr", 0), {"": setup_of("jkr")}, {"tilt": (0.0, 1.0)}, recording={"tilt": "free"})
    motor = MeasuredSeries(np.arange(9.0), {"rotor_velocity": np.arange(9.0)}, {}, {}, {})
    with pytest.raises(ConfigurationError, match="contact_point"):
        candidates_of(motor, {"": cl.build([])}, {}, recording={"contact_point": 1e-9})


def test_on_the_command_a_number_of_the_recording_is_free_a_value_or_a_range() -> None:
    words = ["curve.csv", "law=composed", "contact_point=free", "tilt=2 mN/m", "baseline=-1 nN..1 nN"]
    lines = as_overrides("fit", words)
    assert "study.contact_point='free'" in lines or "study.contact_point=free" in lines
    assert any(line.startswith("study.tilt=") for line in lines)
    (free,) = (line for line in lines if line.startswith("study.free="))
    assert "baseline=-1 nN..1 nN" in free
