"""Claims on the cross-validation of laws by impacts which a known law has made."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from data_support.measured_impacts import drawn_bodies
from data_support.struck_discs import struck_discs
from support.command_line import Command

import contactlab as cl
from contactlab.impacts import velocities_after
from contactlab.laws.composed import label_of
from contactlab_data.inference.cross_validation import ValidationError, least_error_fit, noise_of
from contactlab_data.inference.held_out import folds_of_measurements
from contactlab_data.inference.impact_problem import (
    ConstantImpulse,
    ImpactProblem,
    LawPredictor,
    frictionless,
)
from contactlab_data.inference.influence import without_idle
from contactlab_data.inference.law_numbers import usual_laws
from contactlab_data.measured.files import write_impacts
from contactlab_data.measured.impacts import MeasuredImpacts

TRUTH = cl.Poisson(0.2, 0.6)
SPREAD = 0.05
LAWS = ("newton", "poisson", "lagrange_stick")


@pytest.fixture(scope="module")
def impacts() -> MeasuredImpacts:
    return struck_discs(TRUTH, 240, seed=1, spread=SPREAD)


@pytest.fixture(scope="module")
def result(impacts: MeasuredImpacts) -> cl.Result:
    return cl.validate([*map(cl.law, LAWS)], data=impacts, folds=3, seed=3)


@pytest.fixture(scope="module")
def data(result: cl.Result) -> xarray.Dataset:
    return result.data.to_dataset()


def test_folds_are_a_partition_of_even_parts_that_a_seed_fixes():
    fold = folds_of_measurements(np.arange(103), 5, seed=4)

    assert sorted(np.bincount(fold)) == [20, 20, 21, 21, 21]
    assert (fold == folds_of_measurements(np.arange(103), 5, seed=4)).all()
    assert (fold != folds_of_measurements(np.arange(103), 5, seed=5)).any()


def test_repeats_of_one_measurement_stay_in_one_fold_of_even_parts():
    measurement = np.repeat(np.arange(30), np.arange(30) % 4 + 1)
    fold = folds_of_measurements(measurement, 5, seed=1)

    assert all(len(set(fold[measurement == each])) == 1 for each in range(30))
    assert np.ptp(np.bincount(fold, minlength=5)) <= 4


def test_the_law_that_made_the_impacts_is_first_and_its_parameters_are_found(result: cl.Result) -> None:
    data = result.data.to_dataset()
    assert data["law"].values[0] == "poisson"
    assert data["law"].values[2] == "lagrange_stick"
    values = data.sel(law="poisson")["value"].sel(parameter=["friction_coefficient", "restitution"]).values
    assert values == pytest.approx(np.tile([0.2, 0.6], (3, 1)), abs=0.015)
    assert (data["group"].values[:3] == [1, 2, 3]).all()
    assert result.tables["errors"]["law"].tolist() == data["law"].values.tolist()


def test_its_held_out_error_is_that_of_the_noise(impacts: MeasuredImpacts, data: xarray.Dataset) -> None:
    true = velocities_after(TRUTH, impacts.delassus, impacts.velocity_before)
    floor = impacts.errors(true).mean()

    # Two parameters of 160 impacts cost less than a hundredth of it.
    assert float(data["prediction_error"].sel(law="poisson")) == pytest.approx(floor, rel=0.02)


def test_every_impact_is_held_out_once_and_baselines_and_floors_stand_beside(data: xarray.Dataset) -> None:
    assert np.isfinite(data["error"].values).all()
    assert sorted(np.bincount(data["fold"].values)) == [80, 80, 80]
    assert data["kind"].values.tolist() == ["rigid"] * 3 + ["baseline"] * 2 + ["floor"] * 2
    floors = data["prediction_error"].values[-2:]
    # Any impulse makes any velocity of the contact; an admissible one does not where the noise made energy.
    assert floors[-1] == pytest.approx(0.0, abs=1e-12)
    assert floors[0] >= floors[-1]
    assert (data["prediction_error"].values[:1] < data["prediction_error"].values[3:5]).all()


def test_one_in_a_hundred_impacts_is_above_noise_under_the_true_law_and_an_outlier_is_found() -> None:
    many = struck_discs(TRUTH, 4000, seed=2, spread=SPREAD)
    true = velocities_after(TRUTH, many.delassus, many.velocity_before)

    # The larger of two variances stands for both.
    assert 0.0005 < (many.errors(true) > noise_of(many).bound).mean() <= 0.014
    after = many.velocity_after.copy()
    after[7] += 1.0
    moved = replace(many, velocity_after=after)
    assert moved.errors(true)[7] > noise_of(moved).bound[7]


@pytest.mark.parametrize("coordinates", [3, 6])
def test_noise_that_is_estimated_is_that_which_is_stated(coordinates: int) -> None:
    """The errors put in have the covariance s^2 M^-1; of 2000 impacts s is estimated to 2 % at most."""
    noise = 0.05
    bodies = drawn_bodies(2000, 5, noise, coordinates)
    variance = noise**2 * bodies.mass[0, 0, 0]
    stated = replace(bodies, covariance=variance * np.linalg.inv(bodies.mass))
    about = {"title": "", "source": "", "licence": "", "left_out": 0, "number": np.arange(1, 2001)}
    bounds = [noise_of(MeasuredImpacts.of_bodies(each, **about)).bound for each in (bodies, stated)]
    assert np.median(bounds[0] / bounds[1]) == pytest.approx(1.0, rel=0.05)


def test_without_covariance_and_with_contact_velocities_alone_the_noise_is_unknown() -> None:
    some = replace(struck_discs(TRUTH, 30, seed=2), covariance=None)

    assert np.isnan(noise_of(some).bound).all()


def test_the_restitution_of_head_on_impacts_is_the_median_of_theirs() -> None:
    # The least sum of |e_i - e|, and an outlier weighs no more than another.
    seen = np.array([0.50, 0.52, 0.55, 0.61, 0.05])
    entry = np.ones(5)
    impacts = MeasuredImpacts(
        np.tile(np.eye(2), (5, 1, 1)),
        np.column_stack([-entry, 0.0 * entry]),
        np.column_stack([seen, 0.0 * entry]),
        0.5 * entry,
        0.0 * entry,
        None,
        *("Balls", "Closed form", "CC0-1.0"),
        0,
        np.arange(5),
    )
    problem = ImpactProblem(impacts, LawPredictor.of(cl.Newton(), {"restitution": None}))

    assert least_error_fit(problem, seed=0).values[0] == pytest.approx(0.52, abs=2e-3)
    square = problem.error_residuals(np.array([0.5])) ** 2
    errors = np.abs(seen - 0.5)
    assert square.reshape(5, 3).sum(axis=1) == pytest.approx(errors**2 / np.hypot(errors, 0.01), abs=1e-15)


def test_a_number_without_effect_is_fixed_and_one_that_no_impact_depends_on_is_undetermined() -> None:
    stiff = without_idle(LawPredictor.of(cl.LagrangeAgeing()), struck_discs(TRUTH, 40, seed=0))
    # What sticks is not older than an impact, which takes no time.
    assert {"strengthening", "ageing_time", "longest_age"} <= set(stiff.idle)
    assert "friction_coefficient" not in stiff.idle
    # Small slips stick with any friction that is not small.
    sticking = struck_discs(cl.Newton(1.0, 0.5), 60, seed=0)
    before = sticking.velocity_before * [1.0, 0.05]
    after = velocities_after(cl.Newton(1.0, 0.5), sticking.delassus, before)
    slow = replace(sticking, velocity_before=before, velocity_after=after)
    outcome = cl.validate(cl.Newton(), data=slow, folds=3)

    friction = outcome.data.to_dataset().sel(law="newton", parameter="friction_coefficient")
    low, high = friction["interval"].values
    assert 0.02 < low < 0.5
    assert high == float(friction["range"][1])
    assert f"at least {low:.4g}" in friction["remark"].item()


def test_evidence_of_all_impacts_stands_beside_the_errors_if_wanted(tmp_path: Path) -> None:
    impacts = struck_discs(cl.Newton(0.2, 0.6), 30, seed=1, spread=0.05)
    laws, plain = [cl.Newton(), cl.LagrangeStick()], {"data": impacts, "folds": 3}
    both = cl.validate(laws, **plain, method="nested", points=25, output=tmp_path)
    alone = cl.validate(laws, **plain)
    assert "evidence" not in alone.tables
    np.testing.assert_array_equal(both.tables["errors"]["low"], alone.tables["errors"]["low"])
    evidence = both.tables["evidence"].set_index("law")["ln Z"]
    assert evidence["newton"].value > evidence["lagrange_stick"].value + 10.0
    again = cl.load(tmp_path / "validate.nc")
    assert again.findings == both.findings
    assert again.tables["evidence"].equals(both.tables["evidence"])


def test_too_few_impacts_and_one_law_twice_are_refused(tmp_path: Path) -> None:
    few = struck_discs(TRUTH, 9, seed=0)

    with pytest.raises(ValidationError, match="9"):
        cl.validate(cl.Newton(), data=few, output=tmp_path)
    with pytest.raises(ValidationError, match="newton"):
        cl.validate([cl.Newton(), cl.Newton()], data=few)
    assert not [*tmp_path.iterdir()]


def test_the_baselines_are_what_they_say() -> None:
    impacts = struck_discs(cl.Newton(0.0, 0.7), 50, seed=4)
    problem = ImpactProblem(impacts, frictionless())
    assert least_error_fit(problem, 0).values[0] == pytest.approx(0.7, abs=1e-5)
    constant = ImpactProblem(impacts, ConstantImpulse.of(impacts))
    jump = constant.velocities_after(np.array([0.1, 0.02])) - impacts.velocity_before
    impulse = np.linalg.solve(impacts.delassus, jump[..., None])[..., 0]
    expected = np.column_stack([np.full(50, 0.1), -0.02 * np.sign(impacts.velocity_before[:, 1])])
    assert impulse == pytest.approx(expected)


def test_usual_laws_have_labels_of_their_own_and_every_rigid_law_is_among_them() -> None:
    labels = [predictor.label for predictor in usual_laws()]

    assert len(labels) == len(set(labels))
    assert {"newton", "poisson", "stronge", "brach", "chatterjee_ruina", "johnson"} <= set(labels)
    assert label_of(cl.law("composed", damping="flores", friction="mindlin")) in labels


@pytest.mark.long
def test_a_compliant_law_that_made_the_impacts_beats_the_rigid_ones() -> None:
    law = cl.Composed(cl.HertzPoint(), cl.Flores(0.6), cl.Mindlin(0.3, stiffness_ratio=0.8))
    impacts = struck_discs(law, 200, seed=6, spread=0.02)
    mindlin = cl.law("composed", damping="flores", friction="mindlin")
    outcome = cl.validate([mindlin, cl.Poisson(), cl.Newton()], data=impacts, folds=2).data.to_dataset()

    assert outcome["law"].values[0] == label_of(mindlin)
    ratio = outcome["value"].sel(law=label_of(mindlin), parameter="friction.stiffness_ratio").values
    assert np.median(ratio) == pytest.approx(0.8, rel=0.1)


@pytest.mark.long
def test_the_verb_leaves_table_page_figures_and_dataset(command: Command) -> None:
    write_impacts(struck_discs(TRUTH, 30, seed=0, spread=SPREAD), Path("discs.csv"))
    overrides = ["law=newton", "contact.friction_coefficient=0.05..0.5", "folds=2", "output=here"]
    status, out, _ = command("validate", "discs.csv", *overrides)
    assert status == 0
    with xarray.open_dataset("here/validate.nc") as data:
        best = str(data["law"].values[0])
        assert data.attrs["folds"] == 2
        assert len(data.attrs["data_digest"]) == 64
        limits = data["range"].sel(law="newton", parameter="friction_coefficient").values
        assert limits.tolist() == [0.05, 0.5]
    page = Path("here/report.html").read_text(encoding="utf-8")
    assert best in out
    assert "<img" in page
    assert "http" not in page
    for name in ("prediction_error.png", "impacts.pdf", "residuals.png", "errors.csv", "parameters.tex"):
        assert (Path("here") / name).stat().st_size > 0
    status, _, error = command("validate", "none.csv", "law=newton", "output=no")
    assert status == 2
    assert "none.csv" in error
    assert not Path("no").exists()
