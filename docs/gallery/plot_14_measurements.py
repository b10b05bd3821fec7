"""
Laws held to measurements
=========================

Which law explains what somebody measured? Here the truth is known: an ellipse hits a plate under Poisson's
law, and is measured with an error of 3 %. Each law is fitted to two thirds of the impacts and has to foretell
the rest.
"""

import contactlab as cl
from contactlab.inference.models import LawModel
from contactlab.inference.study import study
from contactlab.inference.synthetic import made_impacts
from contactlab.studies.validate_figures import draw_errors, draw_residuals
from contactlab.studies.validate_tables import headline

truth = cl.Poisson(friction_coefficient=0.2, restitution=0.6)
measured = made_impacts(truth, count=90, noise=0.03, seed=1)

# %%
# Beside the laws stand a frictionless one and a constant impulse: who is no better than these has explained
# nothing.

laws = (cl.Newton(), cl.Poisson(), cl.Stronge(), cl.MoreauJean())
found = study(measured, [LawModel.of(law) for law in laws], folds=3, workers=1)
print(headline(found))
errors = draw_errors(found)

# %%
# What a law misses tells where it fails: over the angle, the speed of the approach, or the slip.

missed = draw_residuals(found)
