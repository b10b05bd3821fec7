"""
Laws held to measurements
=========================

Which law explains what somebody measured? Here the truth is known: an ellipse hits a plate under Poisson's
law, and is measured with an error of 3 %. Each law is fitted to two thirds of the impacts and predicts the
rest.
"""

import contactlab as cl
from contactlab_data.inference.synthetic import made_impacts

truth = cl.Poisson(friction_coefficient=0.2, restitution=0.6)
measured = made_impacts(truth, count=90, noise=0.03, seed=1)

# %%
# A frictionless law and a constant impulse are baselines: a law that is no better explains nothing.

laws = (cl.Newton(), cl.Poisson(), cl.Stronge(), cl.MoreauJean())
result = cl.validate(laws, data=measured, folds=3)
print(result.findings[0])
figures = result.study.figures(result.data)
errors = figures["prediction_error"]

# %%
# Residuals over the angle, the approach velocity and the slip show where a law fails.

residuals = figures["residuals"]
