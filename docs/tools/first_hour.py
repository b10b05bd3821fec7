"""From nothing to the first figure, and to green tests: what a new user waits for, step by step.

python docs/tools/first_hour.py [python=3.11,3.12,3.13,3.14,3.15] [commit=HEAD] [before=COMMIT] [tests=true]
                                 [output=DIR]

A commit is cloned into an empty folder and README's two commands are read out of the clone and run, each
by every Python in an environment of its own, with no compiled code of an earlier run and no cache but pip's
own. `before=COMMIT` measures that commit first, to be compared. `python` is a version that is looked for as
`.ci/run` does, or a path. `tests=false` leaves README's second command out.

OUTPUT has steps.csv, packages.csv (what each installed package takes on the disk) and table.md. Processor
time is that of all processes that a step starts and waits for. The status is 1 where a step fails.
It needs Python and git alone.
"""

import csv
import json
import os
import platform
import resource
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from readme_commands import FIGURE, GREEN, steps_of

ROOT = Path(__file__).resolve().parents[2]
VERSIONS = ("3.11", "3.12", "3.13", "3.14", "3.15")
GIVEN = {
    "python": ",".join(VERSIONS),
    "commit": "HEAD",
    "before": "",
    "tests": "true",
    "output": "outputs/first_hour",
}
"""Keys and their defaults."""

DONE, FAILED, REFUSED = 0, 1, 2
ENVIRONMENT = ".venv"
OF_OTHERS = ("PYTHON", "VIRTUAL_ENV", "NUMBA_", "MPL", "OPENBLAS_", "OMP_", "CONTACTLAB_", "PYTEST_")
"""Settings of whoever measures, which a new user has not."""

SIZES = """
import json
from importlib.metadata import distributions
size = lambda path: path.stat().st_blocks * 512 if path.is_file() else 0
files = {each.metadata["Name"]: each.files or () for each in distributions()}
print(json.dumps({name: sum(size(one.locate()) for one in of) for name, of in files.items()}))
"""
"""Asks an environment what its packages take on the disk [byte]."""


@dataclass(frozen=True)
class Step:
    """A step of README's commands, as it was waited for.

    Args:
        commit: short name of what was cloned.
        python: version of the Python.
        name: what the step does.
        wall, processor: time on the clock, and of all processors [s].
        environment: size on the disk afterwards [MB].
        load: of the machine before it, in processes that want to run: 0 where it was idle.
        passed: whether the step ended with status 0.
    """

    commit: str
    python: str
    name: str
    wall: float
    processor: float
    environment: float
    load: float
    passed: bool


@dataclass(frozen=True)
class Package:
    """A package of the environment after README's first command, and its size on the disk [MB]."""

    commit: str
    python: str
    name: str
    size: float


def python_path(wanted: str) -> str:
    """The path of a Python that can make environments, by its version or path; empty for none."""
    made = sorted(Path.home().glob(f".pyenv/versions/{wanted}.*/bin/python"))
    result = ""
    for candidate in (wanted, f"python{wanted}", *map(str, made)):
        # A name on the path need not lead to a Python, and Debian's need not make environments.
        if shutil.which(candidate):
            label = [candidate, "-c", "import ensurepip, sys, venv; print(sys.executable)"]
            done = subprocess.run(label, capture_output=True, text=True, check=False)
            result = done.stdout.strip() if done.returncode == 0 else result
    return result


def of_new_user(python: str, folder: Path) -> dict[str, str]:
    """The settings of a new user whose `python3` is this one: no cache but pip's."""
    cached = subprocess.run(
        [python, "-m", "pip", "cache", "dir"], capture_output=True, text=True, check=False
    ).stdout.strip()
    own = {name: text for name, text in os.environ.items() if not name.startswith(OF_OTHERS)}
    places = folder / "bin"
    places.mkdir()
    (places / "python3").write_text(f'#!/bin/sh\nexec "{python}" "$@"\n')
    (places / "python3").chmod(0o755)
    # Not the environment of whoever measures.
    paths = [path for path in own["PATH"].split(os.pathsep) if not (Path(path) / "activate").exists()]
    own |= {"PATH": os.pathsep.join([str(places), *paths]), "XDG_CACHE_HOME": str(folder / "cache")}
    return own | ({"PIP_CACHE_DIR": cached} if cached else {})


def measured(commit: str, python: str, tests: bool, log: Path) -> Iterator[Step | Package]:
    """Clone, run the steps, and give what each took; ends at the first that fails.

    Args:
        commit: of this project.
        python: path of the Python.
        tests: whether README's second command is run, too.
        log: what the steps print.
    """
    version = _output_of([python, "-c", "import platform; print(platform.python_version())"])
    with TemporaryDirectory(prefix="first_hour_") as place:
        folder = Path(place)
        clone, settings = folder / "clone", of_new_user(python, folder)
        _output_of(["git", "clone", "--quiet", str(ROOT), str(clone)])
        _output_of(["git", "-C", str(clone), "checkout", "--quiet", commit])
        short = _output_of(["git", "-C", str(clone), "rev-parse", "--short", "HEAD"])
        for name, command in steps_of((clone / "README.md").read_text(encoding="utf-8"), tests):
            load, before, began = os.getloadavg()[0], _processor_time(), perf_counter()
            with log.open("a", encoding="utf-8") as stated:
                print(f"== {short}, Python {version}: {command}", file=stated, flush=True)
                done = subprocess.run(
                    ["bash", "-c", command],
                    cwd=clone,
                    env=settings,
                    stdout=stated,
                    stderr=stated,
                    check=False,
                )
            wall, spent = perf_counter() - began, _processor_time() - before
            figure = name != "first run" or any(clone.rglob("run.png"))
            size = _size(clone / ENVIRONMENT)
            passed = done.returncode == 0 and figure
            yield Step(short, version, name, wall, spent, size, load, passed)
            if not passed:
                return
            if name == "install":
                sizes = json.loads(_output_of([str(clone / ENVIRONMENT / "bin/python"), "-c", SIZES]))
                yield from (Package(short, version, item, size / 1e6) for item, size in sizes.items())


def _output_of(label: Sequence[str]) -> str:
    return subprocess.run(label, capture_output=True, text=True, check=True).stdout.strip()


def _processor_time() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def _size(folder: Path) -> float:
    """What a folder takes on the disk [MB]."""
    return sum(path.lstat().st_blocks for path in folder.rglob("*")) * 512 / 1e6


def page_of(steps: Sequence[Step]) -> str:
    """The steps as Markdown: a row a commit and Python, processor time with the clock's in brackets."""
    names = list(dict.fromkeys(step.name for step in steps))
    sums = {"first figure": FIGURE, "green tests": GREEN} if "tests" in names else {"first figure": FIGURE}
    heads = ["commit", "Python", *names, *sums, "size", "load"]
    lines = [heads, ["---"] * len(heads)]
    for commit, version in dict.fromkeys((step.commit, step.python) for step in steps):
        of = {step.name: step for step in steps if (step.commit, step.python) == (commit, version)}
        cells = [_seconds([of[name]]) if name in of else "" for name in names]
        for parts in sums.values():
            there = [of[name] for name in parts if name in of]
            # An older README installs what tests need at once.
            whole = all(step.passed for step in there) and parts[-1] in of
            cells.append(_seconds(there) if whole else "not reached")
        size = of.get("first run", [*of.values()][-1]).environment
        load = max(step.load for step in of.values())
        lines.append([commit, version, *cells, f"{size:.0f} MB", f"{load:.0f}"])
    stated = (
        f"Processor time, on the clock in brackets, on {os.cpu_count()} processors ({platform.machine()}, "
        f"{platform.system()}). The load is the highest before a step: how many others wanted to run."
    )
    return "\n".join([*(f"| {' | '.join(line)} |" for line in lines), "", stated, ""])


def _seconds(steps: Sequence[Step]) -> str:
    stated = f"{sum(step.processor for step in steps):.0f} s ({sum(step.wall for step in steps):.0f} s)"
    return stated if all(step.passed for step in steps) else f"{stated}, failed"


def write(result: Sequence[Step | Package], folder: Path) -> None:
    """Write both tables and the page."""
    for kind, name in ((Step, "steps.csv"), (Package, "packages.csv")):
        rows = [each for each in result if isinstance(each, kind)]
        with (folder / name).open("w", encoding="utf-8", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(field.name for field in fields(kind))
            table.writerows(
                (f"{cell:.2f}" if isinstance(cell, float) else cell for cell in astuple(row)) for row in rows
            )
    steps = [each for each in result if isinstance(each, Step)]
    (folder / "table.md").write_text(page_of(steps), encoding="utf-8")


def wanted(label: Sequence[str]) -> dict[str, str]:
    """The values of all keys.

    Raises:
        ValueError: a word is no KEY=VALUE, or not one of these; a sentence.
    """
    options = dict(GIVEN)
    for word in label:
        key, sign, text = word.partition("=")
        if not sign or key not in GIVEN:
            raise ValueError(f"'{word}' is none of {', '.join(f'{key}=...' for key in GIVEN)}.")
        options[key] = text
    if options["tests"] not in ("true", "false"):
        raise ValueError(f"tests={options['tests']} must be true or false.")
    return options


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and write; returns the exit status."""
    label = list(sys.argv[1:] if arguments is None else arguments)
    if "--help" in label or "-h" in label:
        print(__doc__)
        return DONE
    try:
        options = wanted(label)
        commits = [_commit(each) for each in (options["before"], options["commit"]) if each]
    except ValueError as fault:
        print(fault, file=sys.stderr)
        return REFUSED
    pythons = _pythons(options)
    if not pythons:
        print(f"No Python of {options['python']} is on this machine.", file=sys.stderr)
        return REFUSED
    folder = Path(options["output"])
    folder.mkdir(parents=True, exist_ok=True)
    log = folder / "steps.log"
    log.unlink(missing_ok=True)
    result: list[Step | Package] = []
    for commit in commits:
        for python in pythons:
            for each in measured(commit, python, options["tests"] == "true", log):
                result.append(each)
                write(result, folder)
                if isinstance(each, Step):
                    print(f"{each.commit}, Python {each.python}, {each.name}: {_seconds([each])}", flush=True)
    print(f"\n{(folder / 'table.md').read_text(encoding='utf-8')}\nWritten to {folder}.")
    return DONE if all(each.passed for each in result if isinstance(each, Step)) else FAILED


def _commit(name: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(ROOT), "rev-parse", "--verify", "--quiet", f"{name}^{{commit}}"],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise ValueError(f"There is no commit '{name}' in {ROOT}.")
    return done.stdout.strip()


def _pythons(options: Mapping[str, str]) -> list[str]:
    """Return the paths of the chosen Pythons and report those that are missing."""
    result = {version: python_path(version) for version in options["python"].split(",")}
    for version in [each for each, path in result.items() if not path]:
        print(f"Python {version} is not on this machine.", file=sys.stderr)
    return [path for path in result.values() if path]


if __name__ == "__main__":
    sys.exit(main())
