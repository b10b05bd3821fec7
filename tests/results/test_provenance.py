"""A result names the code that made it, and no other."""

import platform
import re
import shutil
import subprocess
from importlib.metadata import version
from pathlib import Path

import pytest

from contactlab.results import provenance
from contactlab.results.provenance import UNKNOWN, git_state, versions

needs_git = pytest.mark.skipif(
    shutil.which("git") is None, reason="There is no git; on Debian, apt-get install git brings it."
)


def git(folder: Path, *arguments: str) -> str:
    """Run git with an identity of its own and give back what it prints."""
    identity = ("-c", "user.name=Test", "-c", "user.email=test@example.org")
    command = ["git", "-C", str(folder), *identity, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A clean checkout with one commit."""
    for name in ("contactlab/law.py", "conf/law.yaml", "README.md"):
        file = tmp_path / name
        file.parent.mkdir(exist_ok=True)
        file.write_text("first\n")
    git(tmp_path, "init", "--quiet")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--quiet", "--message", "first")
    return tmp_path


@needs_git
def test_a_clean_checkout_gives_its_commit(checkout: Path) -> None:
    (checkout / "outputs").mkdir()
    (checkout / "outputs" / "run.nc").touch()
    assert git_state(checkout) == (git(checkout, "rev-parse", "HEAD"), 0)


@needs_git
@pytest.mark.parametrize(
    "name", ["contactlab/law.py", "conf/law.yaml", "README.md", "contactlab/new_law.py", "conf/new_law.yaml"]
)
def test_a_changed_or_unknown_source_is_dirty(checkout: Path, name: str) -> None:
    (checkout / name).write_text("second\n")
    assert git_state(checkout)[1] == 1


@needs_git
def test_looking_leaves_the_index_alone(checkout: Path) -> None:
    index = checkout / ".git" / "index"
    (checkout / "README.md").touch()
    before = index.read_bytes(), index.stat().st_mtime_ns
    git_state(checkout)
    assert (index.read_bytes(), index.stat().st_mtime_ns) == before


@needs_git
def test_a_repository_around_an_installed_package_is_not_its_own(checkout: Path) -> None:
    site = checkout / "environment" / "site-packages"
    site.mkdir(parents=True)
    assert git_state(site) == (UNKNOWN, UNKNOWN)


@needs_git
def test_a_hook_of_another_repository_does_not_mislead(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GIT_DIR", str(checkout / "elsewhere"))
    assert re.fullmatch("[0-9a-f]{40}", git_state(checkout)[0])


def test_a_missing_git_is_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / ".git").mkdir()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert git_state(tmp_path) == (UNKNOWN, UNKNOWN)


def test_versions_are_those_of_the_installed_packages() -> None:
    result = versions()
    assert result["python_version"] == platform.python_version()
    for package in ("numpy", "scipy", "numba", "xarray", "netCDF4"):
        assert result[f"{package}_version"] == version(package)
    assert "contactlab_version" in result


def test_a_package_without_metadata_is_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "PACKAGES", ("no-such-distribution",))
    versions.cache_clear()
    try:
        assert versions()["no-such-distribution_version"] == UNKNOWN
    finally:
        versions.cache_clear()
