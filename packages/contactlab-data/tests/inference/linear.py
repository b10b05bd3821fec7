"""A linear model with flat priors, whose posterior and evidence can be written down."""

import numpy as np
import xarray
from scipy.stats import norm

from contactlab.parameter import Parameter
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.problem import Problem

ANY = Parameter("x", "1", "any number")
SIGMA = 0.1


class Linear(Problem):
    """y = a + b t with noise of a known size; an optional third number changes nothing."""

    law = "linear"
    nuisances = ()
    parameters = data = None

    def __init__(self, idle=False):
        draws = np.random.default_rng(7)
        self.time = np.linspace(0.0, 1.0, 12)
        self.values = 0.3 + 0.5 * self.time + SIGMA * draws.standard_normal(12)
        names = ["a", "b", "idle"][: 2 + idle]
        self.parameters = tuple(FreeParameter(name, -2.0, 2.0, False, ANY) for name in names)
        self.data = xarray.Dataset({"y": ("time", self.values, {"units": "1"})}, {"time": self.time})

    @property
    def design(self):
        return np.column_stack([np.ones(12), self.time])

    def predict(self, values):
        return {"y": values[0] + values[1] * self.time}

    def residuals(self, values):
        return (self.values - self.predict(values)["y"]) / SIGMA

    def log_densities(self, predicted, _values, observed=None):
        values = self.values if observed is None else observed["y"]
        return {"y": norm.logpdf(values - predicted["y"], scale=SIGMA)}

    def replicate(self, predicted, _values, draws):
        return {"y": predicted["y"] + SIGMA * draws.standard_normal(12)}

    def closed_form(self):
        """Mean, covariance and log evidence, the prior being far wider than the likelihood."""
        covariance = np.linalg.inv(self.design.T @ self.design) * SIGMA**2
        mean = covariance @ self.design.T @ self.values / SIGMA**2
        missed = self.values - self.design @ mean
        largest = -0.5 * missed @ missed / SIGMA**2 - 12 * np.log(np.sqrt(2 * np.pi) * SIGMA)
        volume = np.log(2 * np.pi) + 0.5 * np.linalg.slogdet(covariance)[1]
        return mean, covariance, largest + volume - 2 * np.log(4.0)
