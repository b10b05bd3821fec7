"""The compiled code is kept where it belongs to these sources, and found again."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba.core.errors import TypingError

from contactlab import compiled
from contactlab.compilation import telling

PROBE = "from contactlab import compiled; print(compiled.code_folder())"


def test_the_folder_is_the_same_in_every_process() -> None:
    result = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=True)
    assert Path(result.stdout.strip()) == compiled.code_folder()


def test_a_chosen_cache_directory_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert compiled.code_folder.__wrapped__().parent == tmp_path


def test_without_a_writable_directory_the_code_lives_for_the_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked))
    result = compiled.code_folder.__wrapped__()
    assert result.is_dir()
    assert result.name.startswith("contactlab-")


def test_a_change_of_a_kernels_source_changes_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "engine").mkdir()
    source = tmp_path / "engine" / "module.py"
    source.write_text("a = 1\n")
    monkeypatch.setattr(compiled, "PACKAGE", tmp_path)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    before = compiled.code_folder.__wrapped__()
    source.write_text("a = 2\n")
    after = compiled.code_folder.__wrapped__()
    assert before != after
    assert before.parent == after.parent == tmp_path / "__pycache__"


def test_a_read_only_installation_falls_back_to_the_users_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "package"
    package.mkdir()
    # A file in the way stands for a directory without write permission, which root does not have.
    (package / "__pycache__").touch()
    monkeypatch.setattr(compiled, "PACKAGE", package)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "users"))
    assert compiled.code_folder.__wrapped__().parent == tmp_path / "users" / "contactlab"


@compiled.inner_kernel
def _third(x: float) -> float:
    return x / 3.0


@compiled.kernel
def _within(x: float) -> float:
    return _third(x) + 1.0


@compiled.kernel
def _around(x: float) -> float:
    return _third(x) + _within(x)


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_kernels_that_call_each_other_share_an_inner_kernel() -> None:
    inner: Any = _third
    with telling() as made:
        assert _around(6.0) == 5.0
    # Once for each of the two units, and the kernel that is called from the other.
    assert sorted(made.functions) == ["_around", "_third", "_third", "_within"]
    assert _within(6.0) == 3.0
    assert not inner.overloads


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_a_kernel_that_does_not_compile_leaves_no_inner_code_behind() -> None:
    @compiled.fleeting_kernel
    def wrong(x: float) -> float:
        return x.missing  # type: ignore[attr-defined, no-any-return]

    @compiled.kernel
    def fails(x: float) -> float:
        return _third(x) + wrong(x)

    with pytest.raises(TypingError):
        fails(6.0)
    inner: Any = _third
    assert not inner.overloads
    assert _within(9.0) == 4.0
