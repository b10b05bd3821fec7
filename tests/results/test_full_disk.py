"""A full disk is a one-line error with the system's own reason, and no part of a file stays."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from support.command_line import Command, left_behind
from support.sweeps import begun, left_run

from contactlab import compare
from contactlab.studies.runner import TASKS
from contactlab.studies.sweep.collection import collect
from contactlab.studies.sweep.study import continued

resource = pytest.importorskip(
    "resource", reason="This system bounds no file; run the tests on Linux or macOS."
)


@contextmanager
def full(size: int) -> Iterator[None]:
    """No file can grow beyond a size [bytes]."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    # What a library still holds of the file that failed must not complain later.
    gc.collect()


def files(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if path.is_file()}


def test_a_collection_that_finds_no_space_leaves_the_one_before(tmp_path: Path) -> None:
    left_run(tmp_path / "1")
    collect(tmp_path, series=["gap"])
    before = (tmp_path / "sweep.nc").read_bytes()
    there = files(tmp_path)
    for size in (0, 10_000, len(before) - 10):
        with full(size), pytest.raises(OSError, match=r"sweep\.nc"):
            collect(tmp_path, series=["gap"])
        assert files(tmp_path) == there
        assert (tmp_path / "sweep.nc").read_bytes() == before
    collect(tmp_path, series=["gap"])


@pytest.mark.parametrize("size", [100, 1000, 4000])
def test_a_run_whose_configuration_finds_no_space_leaves_nothing(command: Command, size: int) -> None:
    line = ("law=newton", "solver.duration=20 us", "record.picture=false", "hydra.run.dir=here")
    with full(size):
        status, out, err = command(*line)
    assert (status, out) == (1, "")
    assert "here" in err
    assert left_behind() == []
    assert command(*line)[0] == 0


def test_a_sweep_that_finds_no_space_keeps_its_tasks(tmp_path: Path) -> None:
    sweep = begun(tmp_path, finished=3)
    there = files(tmp_path)
    with full(9_000), pytest.raises(OSError, match=r"sweep\.nc"):
        continued(sweep, tmp_path)
    assert files(tmp_path) == there
    assert len(list((tmp_path / TASKS).iterdir())) == 3
    assert not (continued(sweep, tmp_path)["status"] == 7).any()


def test_a_comparison_that_finds_no_space_leaves_nothing_half_written(tmp_path: Path) -> None:
    left_run(tmp_path / "1")
    with full(9_000), pytest.raises(OSError, match="nc'"):
        compare([tmp_path / "1"], output=tmp_path / "out", refine=False)
    assert not list(tmp_path.rglob("*.partial"))
