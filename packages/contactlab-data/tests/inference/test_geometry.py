"""Free numbers of the geometry of planar bodies, and verdicts on many pairs of laws."""

from dataclasses import replace

import numpy as np
import pytest
from data_support.measured_impacts import drawn_bodies
from data_support.struck_discs import struck_discs

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab.impacts import velocities_after
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.cross_validation import pair_p_values
from contactlab_data.inference.held_out import folds_of_measurements
from contactlab_data.inference.impact_problem import ImpactProblem, LawPredictor
from contactlab_data.inference.law_numbers import corrections_in
from contactlab_data.measured.bodies import BodyImpacts
from contactlab_data.measured.impacts import MeasuredImpacts

LAW = cl.Poisson(0.2, 0.6)
WRONG = {"normal_arm": 0.5e-3, "tangential_arm": -4e-3, "tilt": 0.03, "inertia": 0.8}
ARMS = {"data.normal_arm": ("-10 mm", "10 mm"), "data.tangential_arm": ("-10 mm", "10 mm")}
OTHERS = {"data.tilt": (-0.1, 0.1), "data.inertia": (0.5, 1.5)}


def bodies_of(count: int, noise: float = 0.0) -> tuple[BodyImpacts, BodyImpacts]:
    """Return impacts under Poisson's law, with the geometry that made them and as a file has it."""
    drawn = replace(drawn_bodies(count, seed=3), rotation=2)
    true = drawn.corrected(**WRONG)
    # Those that approach with the true geometry.
    true, drawn = (each.part(true.contact(true.before)[:, 0] < -0.05) for each in (true, drawn))
    before = true.contact(true.before)
    jump = velocities_after(LAW, true.delassus(), before) - before
    after = true.after_impulses(np.linalg.solve(true.delassus(), jump[..., None])[..., 0])
    scale = noise / np.sqrt(np.diag(true.mass[0]) / true.mass[0, 0, 0])
    after = after + scale * np.random.default_rng(0).normal(size=after.shape)
    return replace(true, after=after), replace(drawn, after=after)


def measured(bodies: BodyImpacts) -> MeasuredImpacts:
    approaching = bodies.contact(bodies.before)[:, 0] < 0.0
    bodies = bodies.part(approaching)
    number = np.arange(1, len(bodies.before) + 1)
    texts = {"title": "Bodies", "source": "A generator", "licence": "CC0-1.0"}
    return MeasuredImpacts.of_bodies(bodies, **texts, left_out=0, number=number)


def test_a_tilt_turns_the_delassus_matrix_and_inertia_and_arms_change_it_as_said() -> None:
    bodies = replace(drawn_bodies(20, seed=1), rotation=2)
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, s], [-s, c]])
    np.testing.assert_allclose(bodies.corrected(tilt=0.3).delassus(), turn @ bodies.delassus() @ turn.T)
    light = bodies.corrected(inertia=1e12).delassus()
    np.testing.assert_allclose(light, np.broadcast_to(np.eye(2) / 0.04, light.shape), rtol=1e-6, atol=1e-6)
    moved = bodies.corrected(normal_arm=2e-3, tangential_arm=-1e-3)
    np.testing.assert_allclose((moved.normal - bodies.normal)[:, 2], 2e-3)
    np.testing.assert_allclose((moved.tangential - bodies.tangential)[:, 2], -1e-3)
    with pytest.raises(ValueError, match="planar"):
        replace(bodies, rotation=None).corrected(tilt=0.1)


def test_the_true_geometry_leaves_no_error_and_the_data_s_own_that_of_the_law_alone() -> None:
    _, stated = bodies_of(60)
    impacts, corrections = measured(stated), corrections_in({**ARMS, **OTHERS})
    problem = ImpactProblem(impacts, LawPredictor.of(cl.Poisson()), corrections=corrections)
    own = [{"friction_coefficient": 0.2, "restitution": 0.6}[item.name] for item in problem.predictor.free]
    true = np.array([*own, *(WRONG[item.field] for item in corrections)])

    after, outside = problem.prediction(true)
    assert impacts.errors(after, outside).max() < 1e-6
    neutral = np.array([*own, 0.0, 0.0, 0.0, 1.0])
    plain = ImpactProblem(impacts, LawPredictor.of(cl.Poisson()))
    after, outside = problem.prediction(neutral)
    np.testing.assert_allclose(after, plain.velocities_after(np.array(own)), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(impacts.errors(after, outside), impacts.errors(after), rtol=1e-9)
    squares = (problem.error_residuals(true) ** 2).sum()
    assert squares < 1e-6 * (problem.error_residuals(neutral) ** 2).sum()


@pytest.mark.long
def test_validate_recovers_arms_that_are_wrong_and_predicts_to_the_noise() -> None:
    true, stated = bodies_of(80, noise=0.01)
    arms = {name: WRONG[name] for name in ("normal_arm", "tangential_arm")}
    stated = replace(stated.corrected(**WRONG), rotation=2).corrected(**{n: -x for n, x in arms.items()})
    plain, free = (cl.validate(cl.Poisson(), data=measured(stated), free=f, folds=2) for f in (None, ARMS))

    data = free.data.to_dataset().sel(law="poisson")
    for name, value in arms.items():
        assert data["value"].sel(parameter=f"data.{name}").values == pytest.approx(value, abs=3e-4)
    before = true.contact(true.before)
    jump = velocities_after(LAW, true.delassus(), before) - before
    made = true.after_impulses(np.linalg.solve(true.delassus(), jump[..., None])[..., 0])
    noise = np.sqrt(true.energy(true.after - made) / true.energy(true.before)).mean()
    assert free.numbers["poisson"].value == pytest.approx(noise, rel=0.1)
    assert plain.numbers["poisson"].value > 2.0 * noise


def test_fit_has_them_among_its_free_numbers() -> None:
    impacts = measured(bodies_of(20)[1])
    (candidate,) = candidates_of(impacts, {"": cl.build(["law=poisson"])}, OTHERS)
    assert [item.name for item in candidate.problem.free][-3:-1] == ["data.tilt", "data.inertia"]


@pytest.mark.parametrize(
    ("key", "ends"),
    [("data.mass", (0, 1)), ("data.tilt", (0.1,)), ("data.inertia", (0, 1)), ("data.tilt", ("1 mm", "2 mm"))],
)
def test_other_numbers_of_the_data_are_refused(key: str, ends: tuple[float | str, ...]) -> None:
    with pytest.raises(ConfigurationError, match=key):
        corrections_in({key: ends})


def test_contact_velocities_alone_have_no_geometry() -> None:
    with pytest.raises(ConfigurationError, match=r"data\.tilt"):
        cl.validate(cl.Newton(), data=struck_discs(LAW, 60, seed=0), free={"data.tilt": (-0.1, 0.1)})


def test_pairs_are_corrected_for_their_number_and_floors_are_no_tests() -> None:
    # Intervals whose half-width is one: |difference|/1 x 1.96 standard errors.
    apart = np.array(
        [[0.0, -1.2, 3.0, 9.0], [1.2, 0.0, 0.5, 9.0], [-3.0, -0.5, 0.0, 9.0], [-9.0] * 3 + [0.0]]
    )
    intervals = np.stack([apart - 1.0, apart + 1.0], axis=-1)
    p_values = pair_p_values(apart, intervals, np.array([True, True, True, False]))

    assert np.isnan(p_values[3]).all()
    assert np.isnan(np.diag(p_values)).all()
    np.testing.assert_array_equal(p_values, p_values.T)
    # Alone the first would be significant, p = 0.0187; of three it is the second, twice that.
    assert p_values[0, 1] == pytest.approx(2.0 * 0.01868, rel=1e-3)
    assert p_values[0, 2] == pytest.approx(3.0 * 4.1e-9, rel=0.05)


def test_seeds_deal_impacts_into_folds_of_their_own() -> None:
    """Two impacts share a fold under both of two seeds, or neither, as often as by chance: 17 of 25."""
    folds = [folds_of_measurements(np.arange(2000), 5, seed) for seed in range(4)]
    pairs = np.random.default_rng(0).integers(0, 2000, (20000, 2)).T
    together = [fold[pairs[0]] == fold[pairs[1]] for fold in folds]
    for a in range(4):
        for b in range(a):
            assert (together[a] == together[b]).mean() == pytest.approx(0.68, abs=0.015)
