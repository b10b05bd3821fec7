"""Folders as runs and maps leave them."""

from pathlib import Path

from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab.results.netcdf import to_datatree, write_tree
from contactlab.sweeps.state import COMPLETE, Job, State, write_state


def left_run(folder: Path) -> Path:
    """A run's folder as a run leaves it."""
    folder.mkdir(parents=True)
    digest = write_tree(to_datatree(synthetic_trajectory(), CONFIGURATION), folder / "run.nc")
    write_state(folder, State(COMPLETE, Job(key="key"), digest=digest))
    return folder / "run.nc"
