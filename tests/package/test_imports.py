"""Whoever imports the package, asks for help or simulates imports what that needs and no more."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

COMPILER = {"numba", "llvmlite"}
PLOTTING = {"matplotlib"}
DATASETS = {"xarray", "pandas", "netCDF4"}
OTHERS = {"jinja2", "joblib", "pint", "dask"}
ALGORITHMS = {f"scipy.{name}" for name in ("integrate", "interpolate", "optimize", "sparse.linalg", "stats")}
ANALYSES = {
    "contactlab.studies.characterise",
    "contactlab_data.inference",
    "contactlab_data.measured",
    "contactlab.steady_state",
}
ANALYSES |= {
    "contactlab.studies.compare.study",
    "contactlab_data.studies.fit",
    "contactlab.studies.sweep.study",
}


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
    assert imported.isdisjoint({"numpy", "contactlab.laws"}) is (line == "help")


@pytest.mark.parametrize("picture", ["false", "true"])
def test_a_run_imports_neither_analyses_nor_what_only_they_need(picture: str, tmp_path: Path) -> None:
    short = ("solver.duration=1e-4", "hydra.run.dir=here", f"record.picture={picture}")
    imported = imported_by("-m", "contactlab", *short, folder=tmp_path)
    assert {"contactlab.engine", "numba", "netCDF4"} <= imported
    assert ("matplotlib" in imported) is (picture == "true")
    assert imported.isdisjoint({"matplotlib.pyplot", "xarray", "pandas", *ALGORITHMS, *OTHERS, *ANALYSES})


ROOT = Path(__file__).parents[2]


def layers() -> list[list[str]]:
    """Return the modules of each layer, the highest first."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    rows = project["tool"]["importlinter"]["contracts"][0]["layers"]
    return [row.replace(" ", "").split("|") for row in rows]


def test_the_table_of_modules_is_that_of_the_layers() -> None:
    page = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    rows = page.partition("| module | subject |\n|---|---|\n")[2].partition("\n\n")[0].splitlines()
    assert [re.findall(r"`(\w+)`", row.split("|")[1]) for row in rows] == layers()


ALONE = """
import os, pkgutil, sys
from importlib import import_module
from pathlib import Path

import hydra, matplotlib.figure, numba, pandas, scipy.optimize, scipy.stats, xarray

layers = sys.argv[1:]
for i, layer in enumerate(layers):
    below = {room for lower in layers[i:] for room in lower.split("|")}
    for room in layer.split("|"):
        if child := os.fork():
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0, room
            continue
        module = import_module(f"contactlab.{room}")
        names = [module.__name__]
        if hasattr(module, "__path__"):
            names = [each.name for each in pkgutil.walk_packages(module.__path__, f"{module.__name__}.")]
        # The entry point runs the command.
        for name in names if room != "__main__" else ():
            import_module(name)
        loaded = {name.split(".")[1] for name in sys.modules if name.startswith("contactlab.")}
        # The package itself makes use of it.
        loaded.discard("lazy")
        others = {*layer.split("|")} - {room}
        for each in (loaded - below) | (loaded & others):
            print(room, "imports", each)
        sys.stdout.flush()
        os._exit(0)
"""
"""Imports every room in a process of its own, each of which has the other packages already."""


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork"), reason="The system has no fork.")
def test_each_room_alone_imports_those_below_it_and_no_other(tmp_path: Path) -> None:
    plain = ["|".join(row) for row in layers() if row != ["__main__"]]
    run = subprocess.run(
        [sys.executable, "-c", ALONE, *plain], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert run.stdout == ""
