"""Claims on the likelihoods: the quick forms are the multivariate normal's."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, multivariate_t, norm, t

import contactlab as cl
from contactlab_data.inference.free_parameters import free_parameters
from contactlab_data.inference.impact_problem import ImpactProblem, LawPredictor, impact_log_densities
from contactlab_data.inference.motor_problem import filtered, ornstein_uhlenbeck, student_log_densities
from contactlab_data.inference.problem import IMPOSSIBLE
from contactlab_data.inference.synthetic import made_impacts, with_noise, without_errors
from contactlab_data.measured.impacts import squared_norm

DRAWS = np.random.default_rng(5)
TIME = np.sort(DRAWS.uniform(0.0, 3.0, 40))
WHITE = DRAWS.uniform(0.2, 0.5, 40)


@pytest.mark.parametrize(("amplitude", "correlation"), [(0.0, 1.0), (0.7, 0.4), (2.0, 10.0), (1.0, 1e-6)])
def test_the_filter_gives_the_density_of_the_dense_multivariate_normal(amplitude, correlation):
    residuals = DRAWS.standard_normal(40)
    apart = np.abs(TIME[:, None] - TIME)
    dense = np.diag(WHITE**2) + amplitude**2 * np.exp(-apart / correlation)

    missed, deviation = np.empty((2, 40))
    filtered(residuals, TIME, WHITE, amplitude, correlation, missed, deviation)
    result = norm.logpdf(missed, scale=deviation)

    assert result.sum() == pytest.approx(multivariate_normal(cov=dense).logpdf(residuals), rel=1e-12)
    # Of each given those before it: the first alone knows of none.
    assert result[0] == pytest.approx(multivariate_normal(cov=dense[:1, :1]).logpdf(residuals[:1]), rel=1e-12)


def test_a_drawn_discrepancy_has_the_covariance_that_the_likelihood_takes():
    draws, time = np.random.default_rng(1), np.array([0.0, 0.1, 0.5])
    paths = draws.standard_normal((20_000, 3))
    for path in paths:
        ornstein_uhlenbeck(path, time, 2.0, 0.3)

    expected = 4.0 * np.exp(-np.abs(time[:, None] - time) / 0.3)

    np.testing.assert_allclose(np.cov(paths.T), expected, atol=4.0 * 5.0 / np.sqrt(20_000))


def test_the_density_of_an_impact_is_that_of_stated_error_and_error_of_the_law():
    data = made_impacts(cl.law("newton"), 6, 0.05, 1)
    residuals = 0.1 * np.random.default_rng(2).standard_normal((6, 2))
    scale = squared_norm(data.delassus, data.velocity_before)

    result = np.empty(6)
    impact_log_densities(residuals, data.covariance, data.delassus, scale, 0.2, np.inf, result)

    for i in range(6):
        u = data.velocity_before[i]
        size = 0.2**2 * (u @ np.linalg.inv(data.delassus[i]) @ u)
        covariance = data.covariance[i] + size * data.delassus[i]
        assert result[i] == pytest.approx(multivariate_normal(cov=covariance).logpdf(residuals[i]), rel=1e-10)


def test_the_error_of_a_law_is_measured_as_the_errors_of_measured_impacts():
    law = cl.law("newton", restitution=0.6)
    data = without_errors(made_impacts(law, 500, 0.05, 3))
    free = free_parameters(law, {"restitution": None})
    problem = ImpactProblem(data, LawPredictor(law, free, ""), discrepancy=True)
    sizes = np.geomspace(0.01, 0.2, 60)

    best = sizes[np.argmax([problem.log_likelihood(np.array([0.6, size])) for size in sizes])]

    # Two directions share the norm; their mean square is twice that of one.
    errors = data.errors(problem.predict(np.array([0.6]))["velocity_after"])
    assert best == pytest.approx(np.sqrt(np.mean(errors**2) / 2.0), rel=0.06)
    assert best == pytest.approx(0.05, rel=0.06)


def test_a_law_that_cannot_be_made_of_the_values_is_impossible_not_an_error():
    law = cl.law("newton")
    data = with_noise(made_impacts(law, 4, 0.05, 3), 0.1)
    free = free_parameters(law, {"restitution": None})
    problem = ImpactProblem(data, LawPredictor(law, free, ""))

    assert problem.log_likelihood(np.array([7.0])) == IMPOSSIBLE
    assert not np.isfinite(problem.residuals(np.array([7.0]))).any()


@pytest.mark.parametrize("degrees_of_freedom", [1.0, 3.5, 50.0])
def test_student_densities_are_those_of_an_independent_library(degrees_of_freedom):
    data = made_impacts(cl.law("newton"), 6, 0.05, 1)
    residuals = 0.1 * np.random.default_rng(2).standard_normal((6, 2))
    scale = squared_norm(data.delassus, data.velocity_before)

    result = np.empty(6)
    impact_log_densities(residuals, data.covariance, data.delassus, scale, 0.2, degrees_of_freedom, result)

    for i in range(6):
        shape = data.covariance[i] + 0.2**2 * scale[i] * data.delassus[i]
        expected = multivariate_t(shape=shape, df=degrees_of_freedom).logpdf(residuals[i])
        assert result[i] == pytest.approx(expected, rel=1e-10)
    white = np.linspace(0.1, 0.4, 12)
    np.testing.assert_allclose(
        student_log_densities(residuals.ravel(), white, degrees_of_freedom),
        t.logpdf(residuals.ravel(), degrees_of_freedom, scale=white),
        rtol=1e-12,
    )


@pytest.mark.long
def test_student_noise_finds_the_friction_that_outliers_hide_from_normal_noise():
    law = cl.law("newton", restitution=0.6, friction_coefficient=0.2)
    data = without_errors(made_impacts(law, 300, 0.02, 3))
    after = data.velocity_after.copy()
    after[::6, 1] *= -1.0
    data = replace(data, velocity_after=after)
    free = free_parameters(law, {"friction_coefficient": (0.02, 0.8)})
    values, sizes = np.linspace(0.02, 0.8, 79), np.geomspace(0.005, 0.9, 25)
    off = {}
    for degrees_of_freedom in (np.inf, 2.0):
        problem = ImpactProblem(data, LawPredictor(law, free, ""), True, degrees_of_freedom)
        off[degrees_of_freedom] = max(
            (problem.log_likelihood(np.array([mu, size])), abs(mu - 0.2)) for mu in values for size in sizes
        )[1]

    assert off[2.0] <= 0.02
    assert off[np.inf] > 0.04
