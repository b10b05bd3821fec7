"""Claims on the likelihoods: the quick forms are the multivariate normal's."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import contactlab as cl
from contactlab.fitting.impact_model import ImpactModel
from contactlab.fitting.likelihood import approach_scale, impact_terms, series_terms, wandering
from contactlab.fitting.model import IMPOSSIBLE, log_likelihood
from contactlab.fitting.parameters import free_parameters
from contactlab.fitting.synthetic import made_impacts, with_noise, without_errors

DRAWS = np.random.default_rng(5)
TIME = np.sort(DRAWS.uniform(0.0, 3.0, 40))
WHITE = DRAWS.uniform(0.2, 0.5, 40)


@pytest.mark.parametrize(("amplitude", "correlation"), [(0.0, 1.0), (0.7, 0.4), (2.0, 10.0), (1.0, 1e-6)])
def test_the_filter_gives_the_density_of_the_dense_multivariate_normal(amplitude, correlation):
    residuals = DRAWS.standard_normal(40)
    apart = np.abs(TIME[:, None] - TIME)
    dense = np.diag(WHITE**2) + amplitude**2 * np.exp(-apart / correlation)

    found = series_terms(residuals, TIME, WHITE, amplitude, correlation)

    assert found.sum() == pytest.approx(multivariate_normal(cov=dense).logpdf(residuals), rel=1e-12)
    # Of each given those before it: the first alone knows of none.
    assert found[0] == pytest.approx(multivariate_normal(cov=dense[:1, :1]).logpdf(residuals[:1]), rel=1e-12)


def test_a_drawn_discrepancy_has_the_covariance_that_the_likelihood_takes():
    draws, time = np.random.default_rng(1), np.array([0.0, 0.1, 0.5])
    paths = np.array([wandering(draws, time, 2.0, 0.3) for _ in range(20_000)])

    expected = 4.0 * np.exp(-np.abs(time[:, None] - time) / 0.3)

    np.testing.assert_allclose(np.cov(paths.T), expected, atol=4.0 * 5.0 / np.sqrt(20_000))


def test_the_density_of_an_impact_is_that_of_stated_error_and_error_of_the_law():
    data = made_impacts(cl.law("newton"), 6, 0.05, 1)
    residuals = 0.1 * np.random.default_rng(2).standard_normal((6, 2))
    scale = approach_scale(data.delassus, data.velocity_before)

    found = impact_terms(residuals, data.covariance, data.delassus, scale, 0.2)

    for i in range(6):
        u = data.velocity_before[i]
        size = 0.2**2 * (u @ np.linalg.inv(data.delassus[i]) @ u)
        covariance = data.covariance[i] + size * data.delassus[i]
        assert found[i] == pytest.approx(multivariate_normal(cov=covariance).logpdf(residuals[i]), rel=1e-10)


def test_the_error_of_a_law_is_measured_as_the_errors_of_measured_impacts():
    law = cl.law("newton", restitution=0.6)
    data = without_errors(made_impacts(law, 500, 0.05, 3))
    free = free_parameters(law, {"restitution": None})
    model = ImpactModel(data, law, free, free, spread=True)
    sizes = np.geomspace(0.01, 0.2, 60)

    best = sizes[np.argmax([log_likelihood(model, np.array([0.6, size])) for size in sizes])]

    # Two directions share the norm; their mean square is twice that of one.
    errors = data.errors(model.predicted(np.array([0.6]))["velocity_after"])
    assert best == pytest.approx(np.sqrt(np.mean(errors**2) / 2.0), rel=0.06)
    assert best == pytest.approx(0.05, rel=0.06)


def test_a_law_that_cannot_be_made_of_the_values_is_impossible_not_an_error():
    law = cl.law("newton")
    data = with_noise(made_impacts(law, 4, 0.05, 3), 0.1)
    free = free_parameters(law, {"restitution": None})
    model = ImpactModel(data, law, free, free, spread=False)

    assert log_likelihood(model, np.array([7.0])) == IMPOSSIBLE
    assert not np.isfinite(model.residuals(np.array([7.0]))).any()
