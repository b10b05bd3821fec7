"""Which code made a result: versions of the packages and the revision of the checkout."""

import os
import platform
import subprocess
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final

UNKNOWN: Final = "unknown"
"""Stands where nothing can be said, e.g. for the revision of an installed wheel."""

PACKAGES: Final = ("contactlab", "numpy", "scipy", "numba", "xarray", "netCDF4")
"""Distributions whose version can change a result or the file that holds it."""

_SOURCES: Final = ("contactlab/", "conf/")
"""Folders of a checkout in which a file that git does not know can still change a run."""

_WITHOUT_NUMBERS: Final = ("cli", "examples", "plot", "testing")
"""Folders of the package on which no number of a run or a study depends."""

_GIT_TIMEOUT: Final = 10.0


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of `PACKAGES`, by attribute name such as `numpy_version`."""
    names = {"contactlab_version": UNKNOWN, "python_version": platform.python_version()}
    for package in PACKAGES:
        try:
            names[f"{package}_version"] = version(package)
        except PackageNotFoundError:
            names[f"{package}_version"] = UNKNOWN
    return names


@cache
def code_digest() -> str:
    """Return the digest of the sources of this package that numbers depend on, 64 hexadecimal digits.

    A version names a release, and a commit what was committed; this names the code as it lies on the
    disk, in a checkout with changes too.
    """
    return digest_of(Path(__file__).resolve().parents[1])


def digest_of(package: Path) -> str:
    """Return the digest of the sources in a package's folder, whatever machine it lies on."""
    digest = sha256()
    files = {file.relative_to(package).as_posix(): file for file in package.rglob("*.py")}
    for name, file in sorted(files.items()):
        # Compiled code may lie below, with sources written for it.
        if "__pycache__" not in file.parts and name.partition("/")[0] not in _WITHOUT_NUMBERS:
            # Line ends differ between systems, and say nothing.
            digest.update(f"{name}\0".encode() + file.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return digest.hexdigest()


def code_attributes() -> dict[str, str | int]:
    """Return the global attributes of a dataset that identify the code: conventions, versions, revision."""
    revision, dirty = checkout_state()
    return {
        "Conventions": "CF-1.11",
        "source": f"contactlab {versions()['contactlab_version']}, numerical simulation",
        # Without a date: the same run leaves the same bytes.
        "history": f"made by contactlab {versions()['contactlab_version']}",
        **versions(),
        "code_digest": code_digest(),
        "git_revision": revision,
        "git_dirty": dirty,
    }


@cache
def checkout_state() -> tuple[str, int | str]:
    """Return revision and dirty flag of the checkout that this package runs from.

    Evaluated once a process, since the code in memory does not change afterwards either.
    """
    return git_state(Path(__file__).resolve().parents[2])


def git_state(root: Path) -> tuple[str, int | str]:
    """Return the revision of a checkout and tell whether it differs from that revision.

    Dirty means a change to any tracked file, or an unknown file among the sources. Results that
    lie about elsewhere in the checkout are no change of the code.

    Args:
        root: folder that holds `.git`. A parent's repository does not count: a wheel in a virtual
            environment inside some other checkout has nothing to do with it.

    Returns:
        The commit and 1 (dirty) or 0 (clean); `UNKNOWN` twice where there is no such checkout, no
        commit yet or no git.
    """
    if not (root / ".git").exists():
        return UNKNOWN, UNKNOWN
    # A git hook's own GIT_DIR would point elsewhere, and a look must not write to the index.
    environment = {k: v for k, v in os.environ.items() if not k.startswith("GIT_")}
    environment["GIT_OPTIONAL_LOCKS"] = "0"
    try:
        status = subprocess.run(
            ["git", "-C", str(root), "status", "--porcelain=v2", "--branch", "-z"],
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_GIT_TIMEOUT,
            check=True,
        ).stdout.decode(errors="replace")
    except (OSError, subprocess.SubprocessError):
        return UNKNOWN, UNKNOWN
    commit, dirty = UNKNOWN, False
    for line in status.split("\0"):
        if line.startswith("# branch.oid "):
            commit = line.removeprefix("# branch.oid ")
        elif line.startswith("? "):
            dirty |= line.removeprefix("? ").startswith(_SOURCES)
        else:
            dirty |= line.startswith(("1 ", "2 ", "u "))
    return (UNKNOWN, UNKNOWN) if commit in {UNKNOWN, "(initial)"} else (commit, int(dirty))
