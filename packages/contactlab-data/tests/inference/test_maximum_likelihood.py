"""Claims on least squares as a method: closed forms of linear problems, profiles, what decides a number."""

from dataclasses import replace

import numpy as np
import pytest
from inference.linear import Linear
from scipy.stats import t as student

import contactlab as cl
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.determination import determinations
from contactlab_data.inference.fit import searched
from contactlab_data.inference.maximum_likelihood import (
    maximum_likelihood,
    normal_posterior,
    profile_ends,
    scale_of,
    standardised,
)
from contactlab_data.inference.nested_sampling import sample
from contactlab_data.inference.problem import Problem
from contactlab_data.inference.synthetic import made_impacts, without_errors
from contactlab_data.measured.impacts import MeasuredImpacts
from contactlab_data.measured.series import MeasuredSeries

NORMAL, AMPLITUDE = 10.0, 2e-3
"""[N], [m] of a loop."""

TRUTH = np.array([0.3, 90.0])
"""Friction coefficient [1] and viscous friction [N s/m], in which the force is linear."""

KEYS = {"contact.friction_coefficient": (0.0, 2.0), "law.viscous_friction": (0.0, 400.0)}
VOLUME = 2.0 * 400.0
TIME = (np.arange(120) + 0.5) / 60.0
"""Two cycles; no instant is a reversal, at which the force jumps."""

DESIGN = -np.column_stack(
    [NORMAL * np.sign(np.cos(2.0 * np.pi * TIME)), 2.0 * np.pi * AMPLITUDE * np.cos(2.0 * np.pi * TIME)]
)


def loop(noise: float, *, stated: bool = True, seed: int = 1) -> MeasuredSeries:
    """Friction of Coulomb with a dashpot on a sine: mu N sign v + c v, which jumps."""
    force = DESIGN @ TRUTH + np.random.default_rng(seed).normal(0.0, noise, TIME.size)
    path = {"slip": AMPLITUDE * np.sin(2.0 * np.pi * TIME), "normal": NORMAL + 0.0 * TIME}
    errors = {"friction_force": np.full(TIME.size, noise)} if stated else {}
    return MeasuredSeries(TIME, {"friction_force": force}, errors, {}, {}, "", path)


def problem_of(data, law: str = "composed", free=None, **options) -> Problem:
    words = ["law=composed", "law/friction=coulomb", "law.viscous_friction=50"]
    setup = cl.build(words if law == "composed" else [f"law={law}"])
    (candidate,) = candidates_of(data, {"": setup}, free or KEYS, **options)
    return candidate.problem


def posterior_of(problem: Problem):
    best = maximum_likelihood(problem, 4, 0)
    ends = np.array([item.ends for item in determinations(problem, best)])
    return best, normal_posterior(problem, best, ends, 0)


def closed_form(data: MeasuredSeries, noise: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean, covariance and ln Z: a normal integral, the ranges being far wider than the posterior."""
    seen = data.values["friction_force"]
    covariance = noise**2 * np.linalg.inv(DESIGN.T @ DESIGN)
    mean = covariance @ DESIGN.T @ seen / noise**2
    missed = seen - DESIGN @ mean
    largest = -0.5 * missed @ missed / noise**2 - seen.size * np.log(np.sqrt(2.0 * np.pi) * noise)
    volume = np.log(2.0 * np.pi) + 0.5 * np.linalg.slogdet(covariance)[1] - np.log(VOLUME)
    return mean, covariance, largest + volume


@pytest.mark.parametrize("noise", [3e-3, 3e-2, 0.3])
def test_a_loop_that_is_linear_in_its_numbers_has_the_posterior_of_the_closed_form(noise: float) -> None:
    data = loop(noise)
    mean, covariance, log_evidence = closed_form(data, noise)
    deviation = np.sqrt(np.diag(covariance))
    _, posterior = posterior_of(problem_of(data))
    own, spread = posterior.moments()

    assert np.abs((own - mean) / deviation).max() < 0.05
    np.testing.assert_allclose(spread, covariance, rtol=1e-3, atol=1e-3 * covariance.max())
    assert posterior.log_evidence == pytest.approx(log_evidence, abs=0.1)
    reach = np.abs(posterior.interval - own[:, None]) / deviation[:, None]
    np.testing.assert_allclose(reach, 1.6449, rtol=0.02)


@pytest.mark.long
@pytest.mark.parametrize("noise", [3e-3, 3e-2, 0.3])
def test_nested_sampling_of_that_loop_has_the_closed_form_too(noise: float) -> None:
    data = loop(noise)
    mean, covariance, log_evidence = closed_form(data, noise)
    result = sample(problem_of(data), points=400, seed=2)
    own, _ = result.moments()
    assert result.log_evidence == pytest.approx(log_evidence, abs=3.0 * result.error)
    assert np.abs((own - mean) / np.sqrt(np.diag(covariance))).max() < 4.0 / np.sqrt(result.effective)


def test_of_noise_of_free_size_intervals_are_those_of_student() -> None:
    data = loop(0.05, stated=False)
    seen = data.values["friction_force"]
    mean, *_ = np.linalg.lstsq(DESIGN, seen)
    left = seen.size - 2
    square = float(np.sum((seen - DESIGN @ mean) ** 2)) / left
    deviation = np.sqrt(square * np.diag(np.linalg.inv(DESIGN.T @ DESIGN)))
    best, posterior = posterior_of(problem_of(data))
    np.testing.assert_allclose(np.sqrt(np.diag(posterior.moments()[1]))[:2], deviation, rtol=1e-3)
    reach = np.abs(posterior.interval[:2] - best.values[:, None]) / deviation[:, None]
    np.testing.assert_allclose(reach, student.ppf(0.95, left), rtol=0.02)
    # The likeliest size divides by all residuals; its deviation is that of chi-square.
    assert best.noise[0] == pytest.approx(np.sqrt(square * left / seen.size), rel=1e-3)
    assert np.sqrt(posterior.moments()[1][2, 2]) == pytest.approx(
        best.noise[0] / np.sqrt(2.0 * seen.size), rel=0.02
    )


def test_numbers_that_nothing_is_known_of_keep_the_deviation_of_their_range() -> None:
    problem = Linear(idle=True)
    best = maximum_likelihood(problem, 2, 0)
    ends = profile_ends(problem.residuals, best, *scale_of(problem, best))
    posterior = normal_posterior(problem, best, ends, 0)
    mean, covariance, _ = Linear().closed_form()
    np.testing.assert_allclose(posterior.moments()[1][:2, :2], covariance, rtol=1e-6)
    assert np.abs((posterior.moments()[0][:2] - mean) / np.sqrt(np.diag(covariance))).max() < 1e-3
    assert ends[2].tolist() == [0.0, 1.0]
    assert np.sqrt(posterior.moments()[1][2, 2]) == pytest.approx(4.0 / np.sqrt(12.0))
    assert np.isnan(posterior.log_evidence)
    assert posterior.samples[:, 2].min() < -1.5 < 1.5 < posterior.samples[:, 2].max()


NOISES = [
    ({}, []),
    ({"discrepancy": "on"}, [0.5]),
    ({"degrees_of_freedom": 3.0}, []),
    ({"degrees_of_freedom": None}, [4.0]),
]


@pytest.mark.parametrize(("options", "noise"), NOISES)
@pytest.mark.parametrize("kind", ["loop", "impacts"])
def test_half_the_squares_are_the_likelihood_of_every_noise(kind: str, options, noise) -> None:
    """What the noise alone sets cancels in a difference."""
    if kind == "loop":
        problem, pair = problem_of(loop(0.1), **options), (TRUTH, TRUTH * [1.02, 0.97])
    else:
        free = {"law.restitution": (0.0, 1.0)}
        problem = problem_of(made_impacts(cl.Newton(0.3, 0.6), 20, 0.05, 1), "newton", free, **options)
        pair = np.array([0.6]), np.array([0.58])
    one, other = (np.append(values, noise) for values in pair)
    halves = [0.5 * float(np.sum(problem.residuals(values) ** 2)) for values in (one, other)]
    difference = problem.log_likelihood(one) - problem.log_likelihood(other)
    assert difference == pytest.approx(halves[1] - halves[0], rel=1e-9)


def impulse_ratios(data: MeasuredImpacts) -> np.ndarray:
    """Tangential over normal impulse of contacts that stick: with less friction they slip."""
    law = cl.law("newton", restitution=0.6, friction_coefficient=0.8)
    jump = data.before.velocities_after(law) - data.velocity_before
    impulse = np.linalg.solve(data.delassus, jump[..., None])[..., 0]
    return np.abs(impulse[:, 1] / impulse[:, 0])


def sticking(noise: float) -> MeasuredImpacts:
    """Impacts of a body of which one alone, the last, slips under a friction of 0.2."""
    data = made_impacts(cl.law("newton", restitution=0.6, friction_coefficient=0.2), 200, noise, 3)
    ratios = impulse_ratios(data)
    few = np.flatnonzero(ratios < 0.15)[:15], np.flatnonzero((ratios > 0.3) & (ratios < 0.5))[:1]
    return data.part(np.concatenate(few))


def test_the_impact_that_alone_decides_a_number_is_named_by_fit_and_by_validate_alike() -> None:
    data = sticking(0.003)
    free = {"law.restitution": (0.0, 1.0), "contact.friction_coefficient": (0.0, 0.8)}
    problem = problem_of(data, "newton", free)
    best = maximum_likelihood(problem, 8, 0)
    friction = next(x for x in determinations(problem, best) if x.number.name.endswith("coefficient"))
    low, high = friction.interval
    assert low < 0.2 < high < low + 0.05
    assert friction.alone == f"impact {data.number[-1]}"
    # What sticks needs so much friction, and sets no upper end.
    needed = impulse_ratios(data.part(np.arange(15))).max()
    assert friction.number.from_unit(friction.of_others[0]) == pytest.approx(needed, abs=0.02)
    assert friction.of_others[1] == 1.0

    (fitted,) = cl.fit(
        cl.build(["law=newton"]), data=data, free=free, method="least_squares"
    ).data.children.values()
    judged = cl.validate(cl.build(["law=newton"]), data=data, free=free, folds=4).data.to_dataset()
    judged = judged.sel(law="newton", parameter="friction_coefficient")
    assert friction.remark in fitted.attrs["findings"]
    assert judged["remark"].item() == friction.remark
    own = fitted["summary"].to_dataset().sel(parameter="contact.friction_coefficient")
    np.testing.assert_allclose(judged["interval"], [own["low"], own["high"]], rtol=1e-3)


def test_the_profile_of_a_bent_problem_is_where_the_likelihood_says() -> None:
    """Impacts that are all sticking bound friction on one side, where Gauss and Newton see nothing."""
    data = sticking(0.003).part(np.arange(15))
    law = cl.law("newton", restitution=0.6, friction_coefficient=0.2)
    data = replace(data, velocity_after=data.before.velocities_after(law))
    problem = problem_of(data, "newton", {"contact.friction_coefficient": (0.0, 0.8)})
    best = maximum_likelihood(problem, 8, 0)
    (friction,) = determinations(problem, best)
    low = friction.interval[0]
    grid = np.linspace(0.02, 0.79, 300)
    likelihood = np.array([problem.log_likelihood(np.array([mu])) for mu in grid])
    inside = grid[likelihood > likelihood.max() - 0.5 * 1.6449**2]
    assert low == pytest.approx(inside.min(), abs=0.01)
    assert friction.remark.startswith("it is at least")


def test_noise_of_each_file_is_its_own() -> None:
    """The file with more noise counts less: the mean that the sizes found weigh."""
    sets = {"quiet": loop(0.02, stated=False, seed=2), "loud": loop(0.4, stated=False, seed=3)}
    best = maximum_likelihood(problem_of(sets), 2, 0)
    assert best.noise == pytest.approx([0.02, 0.4], rel=0.25)
    mean, covariance, _ = closed_form(sets["quiet"], best.noise[0])
    other, wide, _ = closed_form(sets["loud"], best.noise[1])
    weights = np.linalg.inv(covariance), np.linalg.inv(wide)
    joint = np.linalg.solve(sum(weights), weights[0] @ mean + weights[1] @ other)
    assert np.abs((best.values - joint) / np.sqrt(np.diag(covariance))).max() < 0.05


def test_the_likeliest_size_of_impacts_is_that_of_their_residuals() -> None:
    data = without_errors(made_impacts(cl.Newton(0.3, 0.6), 30, 0.05, 1))
    problem = problem_of(data, "newton", {"law.restitution": (0.0, 1.0)})
    best = maximum_likelihood(problem, 2, 0)
    # Two directions an impact: the likeliest size makes their mean square one.
    assert np.mean(standardised(problem, best.noise)(best.values) ** 2) == pytest.approx(1.0, rel=1e-3)


def test_a_result_of_least_squares_has_the_groups_of_every_fit() -> None:
    data = made_impacts(cl.Newton(0.3, 0.6), 30, 0.05, 1)
    setup, free = cl.build(["law=newton"]), {"law.restitution": (0.0, 1.0)}
    (candidate,) = candidates_of(data, {"": setup}, free)
    tree = searched(candidate)
    groups = {"posterior", "posterior_predictive", "log_likelihood", "observed_data", "weighted_samples"}
    assert groups | {"summary", "residuals", "held_out"} <= set(tree.children)
    assert tree["posterior_predictive"]["velocity_after"].shape == (1, 250, 30, 2)
    assert tree["held_out"].sizes["fold"] == 5
    assert 0.8 < tree.attrs["misfit"] <= tree.attrs["held_out_misfit"] < 1.2
