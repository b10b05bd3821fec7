"""A file stands under its name whole, or the folder is as it was."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from contactlab.results import files
from contactlab.results.files import remove_stale, whole_file


def test_a_file_takes_its_name_only_after_the_body(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    with whole_file(path) as partial:
        partial.write_text("whole")
        assert not path.exists()
        assert partial.parent == tmp_path
        assert partial.name.startswith(".run.nc.")
        assert partial.name.endswith(".partial")
    assert path.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [tmp_path / "run.nc"]


@pytest.mark.parametrize("before", [None, "before"])
@pytest.mark.parametrize("stop", [KeyboardInterrupt, ValueError, OSError(errno.ENOSPC, "No space left")])
def test_whatever_stops_the_body_leaves_the_folder_as_it_was(
    tmp_path: Path, stop: type[BaseException] | OSError, before: str | None
) -> None:
    path = tmp_path / "run.nc"
    if before:
        path.write_text(before)

    def stop_half_way() -> None:
        with whole_file(path) as partial:
            partial.write_text("ha")
            raise stop

    with pytest.raises(stop if isinstance(stop, type) else OSError):
        stop_half_way()
    assert [file.read_text() for file in tmp_path.iterdir()] == ([before] if before else [])


def test_a_failed_synchronisation_fails_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_descriptor: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", fail)

    def write() -> None:
        with whole_file(tmp_path / "run.nc") as partial:
            partial.write_text("whole")

    with pytest.raises(OSError, match=r"run\.nc"):
        write()
    assert not list(tmp_path.iterdir())


def test_the_file_is_on_the_disk_before_it_takes_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[str] = []
    synchronise, replace = os.fsync, Path.replace

    def note_synchronise(descriptor: int) -> None:
        steps.append("fsync")
        synchronise(descriptor)

    def note_replace(self: Path, target: Path) -> Path:
        steps.append("name")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", note_synchronise)
    monkeypatch.setattr(Path, "replace", note_replace)
    with whole_file(tmp_path / "run.nc") as partial:
        partial.write_text("whole")
    assert steps == ["fsync", "name", "fsync"]


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    def write() -> None:
        with whole_file(tmp_path / "nowhere" / "run.nc"):
            pytest.fail("The body must not run.")

    with pytest.raises(OSError, match=r"run\.nc") as e:
        write()
    assert e.value.filename == str(tmp_path / "nowhere")


WRITES = """
import os, signal, sys, time
from pathlib import Path
from contactlab.results.files import whole_file
with whole_file(Path(sys.argv[1])) as partial:
    partial.write_text("half")
    os.kill(os.getpid(), int(sys.argv[2]))
    time.sleep(60.0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to send.")
def test_what_a_killed_process_left_is_not_under_the_name_and_goes_once_it_is_old(tmp_path: Path) -> None:
    line = [sys.executable, "-c", WRITES, str(tmp_path / "run.nc"), str(int(signal.SIGKILL))]
    assert subprocess.run(line, check=False, timeout=60.0).returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".run.nc.")
    for age, stays in ((0.0, True), (files.STALE_AFTER + 10.0, False)):
        os.utime(left, (0.0, time.time() - age))
        with whole_file(tmp_path / "other.nc") as partial:
            partial.write_text("whole")
        assert {*tmp_path.iterdir()} == {tmp_path / "other.nc", *([left] if stays else [])}


def test_only_temporary_files_are_removed(tmp_path: Path) -> None:
    kept = [tmp_path / name for name in ("run.nc", ".run.nc.partial", "run.nc.0123456789abcdef.partial")]
    for path in (*kept, tmp_path / ".run.nc.0123456789abcdef.partial"):
        path.write_text("mine")
        os.utime(path, (0.0, 0.0))
    remove_stale(tmp_path)
    assert {*tmp_path.iterdir()} == {*kept}


def test_two_that_write_the_same_file_do_not_disturb_each_other(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    with whole_file(path) as first, whole_file(path) as second:
        first.write_text("first")
        second.write_text("second")
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_a_fresh_file_takes_the_place_of_no_other(tmp_path: Path) -> None:
    path = tmp_path / "plan.json"

    def begin(text: str) -> None:
        with whole_file(path, fresh=True) as partial:
            partial.write_text(text)

    begin("first")
    with pytest.raises(FileExistsError):
        begin("second")
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to send.")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_process_that_a_signal_ends_leaves_no_half_file(number: signal.Signals, tmp_path: Path) -> None:
    line = [sys.executable, "-c", WRITES, str(tmp_path / "run.nc"), str(int(number))]
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=60.0)
    assert done.returncode == -number
    assert not [*tmp_path.iterdir()]
