"""Whoever imports the package, asks for help or simulates imports what that needs and no more."""

import subprocess
import sys
from pathlib import Path

import pytest

COMPILER = {"numba", "llvmlite"}
PLOTTING = {"matplotlib"}
DATASETS = {"xarray", "pandas", "netCDF4"}
OTHERS = {"jinja2", "joblib", "pint", "pydantic", "dask"}
ALGORITHMS = {f"scipy.{name}" for name in ("integrate", "interpolate", "optimize", "sparse.linalg", "stats")}
ANALYSES = {
    "contactlab.studies.characterise",
    "contactlab.inference",
    "contactlab.measured",
    "contactlab.steady_state",
}
ANALYSES |= {"contactlab.studies.compare.study", "contactlab.studies.fit", "contactlab.studies.sweep.study"}


def imported_by(*command: str, folder: Path) -> set[str]:
    """The modules that a command of Python imports."""
    run = subprocess.run(
        [sys.executable, "-X", "importtime", *command], cwd=folder, capture_output=True, text=True, check=True
    )
    lines = [line for line in run.stderr.splitlines() if line.startswith("import time:")]
    return {line.rpartition("|")[2].strip() for line in lines}


def test_the_package_imports_none_of_its_modules_before_a_name_is_used(tmp_path: Path) -> None:
    imported = imported_by("-c", "import contactlab", folder=tmp_path)
    assert {name for name in imported if name.startswith("contactlab.")} == {"contactlab.lazy"}
    assert imported.isdisjoint({"numpy", "scipy", "hydra", *COMPILER, *PLOTTING, *DATASETS, *OTHERS})


@pytest.mark.parametrize("line", ["help", "laws", "--help", "law=newton drive=two_phase --help"])
def test_help_and_listings_import_neither_engine_nor_datasets(line: str, tmp_path: Path) -> None:
    imported = imported_by("-m", "contactlab", *line.split(), folder=tmp_path)
    assert "contactlab.cli.main" in imported
    assert imported.isdisjoint({"contactlab.engine", *COMPILER, *PLOTTING, *DATASETS, *ALGORITHMS, *OTHERS})
    assert imported.isdisjoint(ANALYSES)
    assert ("hydra" in imported) is ("--help" in line)


@pytest.mark.parametrize("picture", ["false", "true"])
def test_a_run_imports_neither_analyses_nor_what_only_they_need(picture: str, tmp_path: Path) -> None:
    short = ("solver.duration=1e-4", "hydra.run.dir=here", f"record.picture={picture}")
    imported = imported_by("-m", "contactlab", *short, folder=tmp_path)
    assert {"contactlab.engine", "numba", "netCDF4"} <= imported
    assert ("matplotlib" in imported) is (picture == "true")
    assert imported.isdisjoint({"matplotlib.pyplot", "xarray", "pandas", *ALGORITHMS, *OTHERS, *ANALYSES})
