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
    setups = [cl.build([f"law={name}"]) for name in ("newton", "poisson")]
    if verb == "fit":
        cl.fit(setups, data=impacts, output=folder, points=25, starts=2)
    else:
        cl.validate(setups, data=replace(impacts, title="Discs"), folds=2, output=folder)
