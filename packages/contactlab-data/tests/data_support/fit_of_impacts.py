"""A fit of two laws in a folder, for a test that kills it."""

import sys
from pathlib import Path

from data_support.struck_discs import struck_discs

import contactlab as cl
from contactlab_data.inference import nested_sampling

if __name__ == "__main__":
    # Checkpoints after every group of proposals.
    nested_sampling.EVERY = -1.0
    impacts = struck_discs(cl.Poisson(0.2, 0.6), 40, seed=1, spread=0.05)
    setups = [cl.build([f"law={name}"]) for name in ("newton", "poisson")]
    cl.fit(setups, data=impacts, output=Path(sys.argv[1]), points=25, starts=2)
