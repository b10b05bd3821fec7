"""A run imports what it needs and no more."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.long
@pytest.mark.parametrize("picture", ["false", "true"])
def test_the_plotting_is_imported_for_a_picture_alone(picture: str, tmp_path: Path) -> None:
    short = ("solver.duration=1e-4", "hydra.run.dir=here", f"record.picture={picture}")
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "contactlab", *short],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "contactlab.results.netcdf" in imported
    assert ("matplotlib" in imported) is (picture == "true")
    # As much as all of numpy and scipy that a run needs, and for comparisons alone.
    assert "scipy.stats" not in imported
