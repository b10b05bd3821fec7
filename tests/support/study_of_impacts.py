"""A fit and a validation in a folder, for tests that kill them."""

import sys
from dataclasses import replace
from pathlib import Path

from support.struck_discs import struck_discs

import contactlab as cl
from contactlab.inference import nested_sampling

if __name__ == "__main__":
    verb, folder = sys.argv[1], Path(sys.argv[2])
    # Checkpoints after every group of proposals.
    nested_sampling.EVERY = -1.0
    impacts = struck_discs(cl.Poisson(0.2, 0.6), 40, seed=1, spread=0.05)
    if verb == "fit":
        cl.fit(impacts, ["newton", "poisson"], output=folder, points=25, starts=2)
    else:
        cl.validate(replace(impacts, title="Discs"), ["newton", "poisson"], folds=2, output=folder)
