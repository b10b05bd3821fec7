"""A file stands under its name whole, or the folder is as it was."""

import errno
import os
from pathlib import Path

import pytest

from contactlab.output.files import whole_file


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


@pytest.mark.parametrize("stop", [KeyboardInterrupt, ValueError, MemoryError])
def test_whatever_stops_the_body_leaves_nothing(tmp_path: Path, stop: type[BaseException]) -> None:
    def stop_half_way() -> None:
        with whole_file(tmp_path / "run.nc") as partial:
            partial.write_text("ha")
            raise stop

    with pytest.raises(stop):
        stop_half_way()
    assert not list(tmp_path.iterdir())


def test_a_failed_file_leaves_its_predecessor_alone(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    path.write_text("before")

    def fail() -> None:
        with whole_file(path) as partial:
            partial.write_text("after")
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="cannot be written"):
        fail()
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [tmp_path / "run.nc"]


def test_a_failed_synchronisation_fails_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_descriptor: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", fail)

    def write() -> None:
        with whole_file(tmp_path / "run.nc") as partial:
            partial.write_text("whole")

    with pytest.raises(OSError, match=r"'run\.nc' cannot be written"):
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


def test_a_missing_folder_is_refused_in_a_sentence_that_names_it(tmp_path: Path) -> None:
    def write() -> None:
        with whole_file(tmp_path / "nowhere" / "run.nc"):
            pytest.fail("The body must not run.")

    with pytest.raises(
        OSError, match=r"'run.nc' cannot be written, its folder does not exist"
    ) as e:
        write()
    assert e.value.filename == str(tmp_path / "nowhere")


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()

    def write() -> None:
        with whole_file(tmp_path / "file" / "run.nc"):
            pytest.fail("The body must not run.")

    with pytest.raises(NotADirectoryError):
        write()
