"""Whoever imports the package, asks for help or simulates loads what that needs and no more."""

import subprocess
import sys
from pathlib import Path

import pytest

COMPILER = {"numba", "llvmlite"}
PLOTTING = {"matplotlib"}
DATASETS = {"xarray", "pandas", "netCDF4"}
ALGORITHMS = {"scipy"}
OTHERS = {"pint", "jinja2", "joblib"}
STUDIES = {f"contactlab.{name}" for name in ("studies.compare", "datasheet", "inference", "steady_state")}


def imported_by(*command: str, folder: Path) -> set[str]:
    """Return the modules that a command of Python imports."""
    run = subprocess.run(
        [sys.executable, "-X", "importtime", *command], cwd=folder, capture_output=True, text=True, check=True
    )
    lines = [line for line in run.stderr.splitlines() if line.startswith("import time:")]
    return {line.rpartition("|")[2].strip() for line in lines}


def test_the_package_alone_imports_none_of_its_modules(tmp_path: Path) -> None:
    imported = imported_by("-c", "import contactlab", folder=tmp_path)
    assert not {name for name in imported if name.startswith("contactlab.")}
    assert imported.isdisjoint({"numpy", "hydra", *COMPILER, *PLOTTING, *DATASETS, *ALGORITHMS, *OTHERS})


@pytest.mark.parametrize(
    "line", [("help",), ("laws",), ("--help",), ("help", "steady"), ("law=none",)], ids=" ".join
)
def test_help_and_listings_load_neither_compiler_nor_datasets(line: tuple[str, ...], tmp_path: Path) -> None:
    pass


@pytest.mark.parametrize("picture", ["false", "true"])
def test_a_run_imports_what_it_needs_and_no_more(picture: str, tmp_path: Path) -> None:
    short = ("solver.duration=1e-4", "hydra.run.dir=here", f"record.picture={picture}")
    imported = imported_by("-m", "contactlab", *short, folder=tmp_path)
    assert {"contactlab.results.netcdf", "netCDF4"} <= imported
    assert ("matplotlib" in imported) is (picture == "true")
    assert "matplotlib.pyplot" not in imported
    assert imported.isdisjoint({"xarray", "pandas", *ALGORITHMS, *OTHERS, *STUDIES})
