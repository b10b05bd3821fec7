"""Helpers for tests of the command, in this process and in others with packages of their own; long forms."""

import json
import os
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

import pytest

import contactlab

Command = Callable[..., tuple[int, str, str]]
"""Takes arguments; gives exit status, output and errors."""


def left_behind() -> list[Path]:
    return list(Path().rglob("*"))


STATUS, END = "\x1e", "\x1f"
"""Before the status of one of several commands, and after all that it says."""

ONE_AFTER_ANOTHER = f"""
import json, os, re, sys
from contactlab.cli.main import main

for line in json.loads(sys.argv[1]):
    variables = [word for word in line if re.match("[A-Z_]+=", word)]
    os.environ.update(word.split("=", 1) for word in variables)
    sys.argv[1:] = [word for word in line if word not in variables]
    print({STATUS!r}, main(), {END!r}, sep="", end="", flush=True)
    print({END!r}, end="", file=sys.stderr, flush=True)
"""

EXAMPLE = Path(__file__).parents[1].joinpath("example_law")


@dataclass(frozen=True)
class Elsewhere:
    """A folder with packages, and another to run in.

    Args:
        packages: where they are installed.
        folder: where commands run.
    """

    packages: Path
    folder: Path

    def python(self, *arguments: str, **variables: str) -> tuple[int, str, str]:
        """Exit status, output and errors of Python."""
        # The contactlab that runs the tests, wherever another one may be installed.
        own = str(Path(contactlab.__file__).resolve().parents[1])
        paths = [str(self.packages), own, os.environ.get("PYTHONPATH", "")]
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))} | variables,
            capture_output=True,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout, done.stderr

    def command(self, *arguments: str, **variables: str) -> tuple[int, str, str]:
        """Exit status, output and errors of the command."""
        return self.python("-m", "contactlab", *arguments, **variables)

    def commands(self, lines: Sequence[Sequence[str]]) -> list[tuple[int, str, str]]:
        """Run several commands, one after another in one process; arguments with NAME= set variables."""
        message = json.dumps([*map(list, lines)])
        status, out, err = self.python("-c", ONE_AFTER_ANOTHER, message)
        assert status == 0, err
        (*outs, _), (*errs, _) = out.split(END), err.split(END)
        results = [text.rpartition(STATUS) for text in outs]
        return [(int(code), text, names) for (text, _, code), names in zip(results, errs, strict=True)]

    def install(self, *wheels: Path) -> None:
        """Install wheels by pip."""
        options = ["--quiet", "--no-deps", "--no-index", "--target", str(self.packages)]
        status, _, err = self.python("-m", "pip", "install", *options, *map(str, wheels))
        assert status == 0, err
        for wheel in wheels:
            wheel.unlink()

    def wheel(
        self,
        name: str,
        version: str,
        entries: Mapping[str, str],
        modules: Mapping[str, str],
        parts: Mapping[str, Mapping[str, str]] = MappingProxyType({}),
    ) -> Path:
        """Make the wheel of a distribution as a build tool would; parts are by group."""
        stem = f"{name.replace('-', '_')}-{version}"
        points = "".join(
            f"[{group}]\n" + "".join(f"{word} = {entry}\n" for word, entry in named.items())
            for group, named in {"contactlab.laws": entries, **parts}.items()
        )
        files = {f"{module}.py": text for module, text in modules.items()} | {
            f"{stem}.dist-info/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
            f"{stem}.dist-info/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
            f"{stem}.dist-info/entry_points.txt": points,
        }
        record = f"{stem}.dist-info/RECORD"
        wheel = self.folder / f"{stem}-py3-none-any.whl"
        with zipfile.ZipFile(wheel, "w") as archive:
            for path, text in files.items():
                archive.writestr(path, text)
            archive.writestr(record, "".join(f"{path},,\n" for path in [*files, record]))
        return wheel

    def example(self) -> Path:
        """Make the wheel of the example as its pyproject.toml says."""
        project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))
        modules = project["tool"]["setuptools"]["py-modules"]
        groups = project["project"]["entry-points"]
        return self.wheel(
            project["project"]["name"],
            project["project"]["version"],
            groups["contactlab.laws"],
            {name: (EXAMPLE / f"{name}.py").read_text(encoding="utf-8") for name in modules},
            {group: entries for group, entries in groups.items() if group != "contactlab.laws"},
        )


Case = TypeVar("Case")


def cases(every: Iterable[Case], short: Collection[Case]) -> list[object]:
    """Parameters of a test: those in `short` always run, the others are of its long form."""
    return [case if case in short else pytest.param(case, marks=pytest.mark.long) for case in every]
