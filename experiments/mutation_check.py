"""Break the physics on purpose, one line at a time, and see the tests turn red each time.

    python experiments/mutation_check.py [--only WORD] [--list] [--workers N] [--output DIR]

Every error is put into a copy of the project; the tests that should notice it first are run there, and
where they stay green the whole suite. The unchanged copy must be green under the same tests. The status
is 1 where an error is caught by nobody.
"""

import argparse
import csv
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from mutation.kinds import Mutation
from mutation.mutations import MUTATIONS
from tqdm import tqdm

ROOT = Path(__file__).resolve().parents[1]
PARTS = ("contactlab", "conf", "tests", "experiments", "pyproject.toml", "README.md")


@dataclass(frozen=True)
class Outcome:
    """What became of an error.

    Args:
        name: of the error.
        caught: whether a test failed.
        by: the first test that did.
        seconds: how long it took.
    """

    name: str
    caught: bool
    by: str
    seconds: float


def copy_project(target: Path) -> None:
    """Copy what the tests need, without compiled code."""
    for part in PARTS:
        source = ROOT / part
        if source.is_dir():
            shutil.copytree(source, target / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, target / part)


def run_tests(project: Path, tests: Sequence[str]) -> tuple[bool, str]:
    """Whether the tests of a copy are green, and the first that is not."""
    # Nothing of the compiled code of another copy, and nothing left behind.
    places = {"PYTHONPATH": str(project), "NUMBA_CACHE_DIR": str(project / "kernels")}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    done = subprocess.run(
        command, cwd=project, env=os.environ | places, capture_output=True, text=True, check=False
    )
    # Only a test that fails has caught anything; a copy whose tests cannot run at all says nothing.
    if done.returncode not in (0, 1):
        raise RuntimeError(f"The tests of a copy cannot run:\n{done.stdout}{done.stderr}")
    found = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    return done.returncode == 0, found[1] if found else done.stdout[-200:].strip()


def try_out(mutation: Mutation) -> Outcome:
    """Put one error into a copy and run the tests."""
    started = perf_counter()
    with TemporaryDirectory() as folder:
        project = Path(folder)
        copy_project(project)
        path = mutation.find(project)
        path.write_text(mutation.apply(path.read_text(encoding="utf-8")), encoding="utf-8")
        green, by = run_tests(project, mutation.tests)
        if green:
            green, by = run_tests(project, ())
    return Outcome(mutation.name, not green, "" if green else by, perf_counter() - started)


def try_unchanged(tests: Sequence[str]) -> bool:
    """Whether an unchanged copy is green."""
    with TemporaryDirectory() as folder:
        copy_project(Path(folder))
        return run_tests(Path(folder), tests)[0]


def write_table(outcomes: Sequence[Outcome], folder: Path) -> None:
    """One row an error."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "mutation_check.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["error", "caught", "by", "seconds"])
        writer.writerows([o.name, o.caught, o.by, f"{o.seconds:.0f}"] for o in outcomes)


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the chosen errors; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", default="", help="errors whose name has this word")
    parser.add_argument("--list", action="store_true", help="list the errors and stop")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="copies at a time")
    parser.add_argument("--output", type=Path, default=Path("outputs/mutation_check"))
    options = parser.parse_args(arguments)
    chosen = [m for m in MUTATIONS if options.only in m.name]
    if options.list or not chosen:
        print(*(f"{m.file}: {m.name}" for m in MUTATIONS), sep="\n")
        return 0 if chosen else 2
    if not try_unchanged(sorted({test for m in chosen for test in m.tests})):
        print("The unchanged project fails these tests; mend it first.", file=sys.stderr)
        return 2
    outcomes = []
    with ThreadPoolExecutor(options.workers) as pool:
        tasks = [pool.submit(try_out, mutation) for mutation in chosen]
        for task in tqdm(as_completed(tasks), total=len(tasks), unit=" errors", disable=None):
            outcome = task.result()
            outcomes.append(outcome)
            verdict = f"caught by {outcome.by}" if outcome.caught else "CAUGHT BY NOBODY"
            tqdm.write(f"{outcome.name}: {verdict} ({outcome.seconds:.0f} s)")
    write_table(outcomes, options.output)
    missed = sum(not outcome.caught for outcome in outcomes)
    print(f"{len(outcomes)} errors, {len(outcomes) - missed} caught, {missed} not.")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
