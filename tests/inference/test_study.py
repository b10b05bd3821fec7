"""Claims on laws that are judged by impacts which a known law has made."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.struck_discs import struck_discs

import contactlab as cl
from contactlab.impact import velocities_after
from contactlab.inference.candidates import probed, usual_law, usual_laws
from contactlab.inference.models import ConstantImpulse, LawModel, frictionless
from contactlab.inference.prediction import fitted, residuals
from contactlab.inference.study import ValidationError, study
from contactlab.inference.unexplained import noise_of, unexplained
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.studies import validate_tables as tables

TRUTH = cl.Poisson(0.2, 0.6)
SPREAD = 0.05
LAWS = ("newton", "poisson", "lagrange_stick")


@pytest.fixture(scope="module")
def impacts() -> MeasuredImpacts:
    return struck_discs(TRUTH, 240, seed=1, spread=SPREAD)


@pytest.fixture(scope="module")
def data(impacts: MeasuredImpacts) -> xarray.Dataset:
    return study(impacts, [usual_law(name) for name in LAWS], folds=4, seed=3, workers=1)


def test_the_law_that_made_the_impacts_is_first_and_its_parameters_are_found(data: xarray.Dataset) -> None:
    assert data["law"].values[0] == "poisson"
    assert data["law"].values[2] == "lagrange_stick"
    here = data.sel(law="poisson")
    values = here["value"].sel(parameter=["friction_coefficient", "restitution"]).values
    assert values == pytest.approx(np.tile([0.2, 0.6], (4, 1)), abs=0.015)
    assert (data["group"].values[:3] == [1, 2, 3]).all()
    assert tables.headline(data).startswith("poisson predicts best: ")


def test_its_held_out_error_is_that_of_the_noise(impacts: MeasuredImpacts, data: xarray.Dataset) -> None:
    true = velocities_after(TRUTH, impacts.delassus, impacts.velocity_before)
    floor = impacts.errors(true).mean()

    # Two parameters of 180 impacts cost less than a hundredth of it.
    assert float(data["prediction_error"].sel(law="poisson")) == pytest.approx(floor, rel=0.02)


def test_every_impact_is_held_out_once_and_baselines_and_floors_stand_beside(data: xarray.Dataset) -> None:
    assert np.isfinite(data["error"].values).all()
    assert sorted(np.bincount(data["fold"].values)) == [60, 60, 60, 60]
    kinds = data["kind"].values.tolist()
    assert kinds == ["rigid"] * 3 + ["baseline"] * 2 + ["floor"] * 2
    floors = data["prediction_error"].values[-2:]
    # Any impulse makes any velocity of the contact; an admissible one does not where the noise made energy.
    assert floors[-1] == pytest.approx(0.0, abs=1e-12)
    assert floors[0] >= floors[-1]
    assert (data["prediction_error"].values[:1] < data["prediction_error"].values[3:5]).all()
    # The law that sticks is worse than no friction.
    assert any("lagrange_stick" in line for line in tables.order(data))


@pytest.mark.long
def test_the_same_seed_gives_the_same_bits_whatever_the_workers_and_goes_on_where_it_was(
    impacts: MeasuredImpacts, data: xarray.Dataset, tmp_path: Path
) -> None:
    models = [usual_law(name) for name in LAWS]
    said: list[str] = []
    again = study(impacts, models, folds=4, seed=3, workers=2, keep=tmp_path)
    kept = study(impacts, models, folds=4, seed=3, workers=1, keep=tmp_path, announce=said.append)

    xarray.testing.assert_identical(again, data)
    xarray.testing.assert_identical(kept, data)
    assert said == ["5 of 5 laws are taken from an earlier start."]


def test_one_in_a_hundred_impacts_is_above_noise_under_the_true_law_and_an_outlier_is_named() -> None:
    many = struck_discs(TRUTH, 4000, seed=2, spread=SPREAD)
    errors = many.errors(velocities_after(TRUTH, many.delassus, many.velocity_before))

    # The larger of two variances stands for both.
    assert 0.0005 < unexplained(errors[None], noise_of(many)).mean() <= 0.014
    after = many.velocity_after.copy()
    after[7] += 1.0
    moved = replace(many, velocity_after=after)
    wrong = moved.errors(velocities_after(TRUTH, many.delassus, many.velocity_before))
    assert unexplained(np.stack([wrong, 2.0 * wrong]), noise_of(moved))[7]


def test_without_covariance_and_with_contact_velocities_alone_the_noise_cannot_be_told() -> None:
    some = replace(struck_discs(TRUTH, 30, seed=2), covariance=None)

    assert np.isnan(noise_of(some).bound).all()


def test_how_many_impacts_no_law_explains_is_a_sentence_of_its_own(data: xarray.Dataset) -> None:
    two = data.assign(unexplained=("impact", np.isin(np.arange(240), [7, 8]).astype(int)))
    unknown = data.assign(noise_bound=data["noise_bound"] * np.nan).assign_attrs(noise="not known: no way")

    assert tables.unexplained(two).startswith("No law explains 2 of 240 impacts: under every law their error")
    assert tables.unexplained(data).startswith("Every impact is explained by some law: its error is below ")
    assert tables.unexplained(unknown).endswith("no law explains, as the noise is not known: no way.")


def test_the_restitution_of_head_on_impacts_is_the_median_of_theirs() -> None:
    # The least sum of |e_i - e|, and an outlier weighs no more than another.
    seen = np.array([0.50, 0.52, 0.55, 0.61, 0.05])
    one = np.ones(5)
    impacts = MeasuredImpacts(
        np.tile(np.eye(2), (5, 1, 1)),
        np.column_stack([-one, 0.0 * one]),
        np.column_stack([seen, 0.0 * one]),
        0.5 * one,
        0.0 * one,
        None,
        *("Balls", "Closed form", "CC0-1.0"),
        0,
        np.arange(5),
    )
    found = fitted(LawModel.of(cl.Newton(), {"restitution": None}), impacts, seed=0)

    assert found.values[0] == pytest.approx(0.52, abs=2e-3)
    predicted = np.column_stack([0.5 * one, 0.0 * one])
    square = residuals(impacts, predicted) ** 2
    errors = np.abs(seen - 0.5)
    assert square.reshape(5, 3).sum(axis=1) == pytest.approx(errors**2 / np.hypot(errors, 0.01), abs=1e-15)


def test_a_number_that_changes_nothing_is_held_and_one_that_no_impact_feels_cannot_be_told() -> None:
    stiff = probed(LawModel.of(cl.LagrangeAgeing()), struck_discs(TRUTH, 40, seed=0))
    # What sticks is not older than an impact, which takes no time.
    assert {"strengthening", "ageing_time", "longest_age"} <= set(stiff.held)
    assert "friction_coefficient" not in stiff.held
    # Small slips stick with any friction that is not small.
    sticking = struck_discs(cl.Newton(1.0, 0.5), 60, seed=0)
    before = sticking.velocity_before * [1.0, 0.05]
    after = velocities_after(cl.Newton(1.0, 0.5), sticking.delassus, before)
    slow = replace(sticking, velocity_before=before, velocity_after=after)
    found = study(slow, [usual_law("newton")], folds=3, workers=1)

    assert "friction_coefficient" in found["cannot_tell"].sel(law="newton").item()
    assert any("cannot tell friction_coefficient" in line for line in tables.warnings(found))


def test_too_few_impacts_and_one_law_twice_are_refused_in_a_sentence(tmp_path: Path) -> None:
    few = struck_discs(TRUTH, 9, seed=0)

    with pytest.raises(ValidationError, match=r"There are 9 impacts; 5 folds .* need 10 at least"):
        study(few, [usual_law("newton")], keep=tmp_path, workers=1)
    with pytest.raises(ValidationError, match="newton is there twice"):
        study(few, [usual_law("newton")] * 2, workers=1)
    assert not [*tmp_path.iterdir()]


def test_the_plainest_predictions_are_what_they_say() -> None:
    impacts = struck_discs(cl.Newton(0.0, 0.7), 50, seed=4)
    assert fitted(frictionless(), impacts, 0).values[0] == pytest.approx(0.7, abs=1e-5)
    constant = ConstantImpulse.of(impacts)
    jump = constant.after(np.array([0.1, 0.02]), impacts) - impacts.velocity_before
    impulse = np.linalg.solve(impacts.delassus, jump[..., None])[..., 0]
    expected = np.column_stack([np.full(50, 0.1), -0.02 * np.sign(impacts.velocity_before[:, 1])])
    assert impulse == pytest.approx(expected)


def test_usual_laws_have_labels_of_their_own_and_every_rigid_law_is_among_them() -> None:
    labels = [model.label for model in usual_laws()]

    assert len(labels) == len(set(labels))
    assert {"newton", "poisson", "stronge", "brach", "chatterjee_ruina", "johnson"} <= set(labels)
    assert usual_law("composed", damping="flores", friction="mindlin").label in labels


@pytest.mark.long
def test_a_compliant_law_that_made_the_impacts_beats_the_rigid_ones() -> None:
    law = cl.Composed(cl.HertzPoint(), cl.Flores(0.6), cl.Mindlin(0.3, stiffness_ratio=0.8))
    impacts = struck_discs(law, 200, seed=6, spread=0.02)
    mindlin = usual_law("composed", damping="flores", friction="mindlin")
    found = study(impacts, [mindlin, usual_law("poisson"), usual_law("newton")], workers=1)

    assert found["law"].values[0] == mindlin.label
    ratio = found["value"].sel(law=mindlin.label, parameter="friction.stiffness_ratio").values
    assert np.median(ratio) == pytest.approx(0.8, rel=0.1)
