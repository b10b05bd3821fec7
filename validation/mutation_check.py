"""Break the physics on purpose, one place at a time, and see the tests turn red each time.

    python validation/mutation_check.py [--only WORD] [--list] [--workers N] [--output DIR]

Every error of `mutations.yaml` is put into a copy of the project; the tests that should notice it first
are run there, and where they stay green the whole suite. The unchanged copy must be green under the same
tests. The status is 1 where an error is caught by nobody.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import pandas as pd
import yaml
from tqdm import tqdm

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Mutation:
    """One error put into one file.

    Args:
        name: description of the error.
        file: below the project's root.
        old, new: text that stands exactly once in the file, however it is broken into lines, and what
            it becomes.
        tests: the test files that run first.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...] = ()

    def apply(self, project: Path) -> None:
        """Put the error into a project.

        Raises:
            ValueError: the old text does not stand exactly once.
        """
        path = project / self.file
        source = path.read_text(encoding="utf-8") if path.is_file() else ""
        pattern = r"(?<!\w)" + r"\s+".join(map(re.escape, self.old.split())) + r"(?!\w)"
        if (count := len(re.findall(pattern, source))) != 1:
            raise ValueError(
                f"'{self.name}': its text stands {count} times in {self.file}; it must stand once. "
                "Bring validation/mutations.yaml up to date."
            )
        path.write_text(re.sub(pattern, lambda _: self.new, source), encoding="utf-8")


MUTATIONS = tuple(
    Mutation(name, file, m["old"], m["new"], tuple(f"{t}.py" for t in m["tests"].split()))
    for file, errors in yaml.safe_load((ROOT / "validation/mutations.yaml").read_text()).items()
    for name, m in errors.items()
)


@dataclass(frozen=True)
class Outcome:
    """What became of an error: whether a test caught it, which did first, and how long it took [s]."""

    error: str
    caught: bool
    by: str
    seconds: float


def copy_project(target: Path) -> None:
    """Copy the project's files, without compiled code."""
    listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listing, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for source in (ROOT / name for name in names.split("\0") if name):
        # What is deleted and not committed is listed as well.
        if source.is_file():
            copy = target / source.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, copy)


def run_tests(project: Path, tests: Sequence[str]) -> tuple[bool, str]:
    """Return whether the tests of a copy are green, and the first that is not."""
    # Nothing of the compiled code of another copy, and nothing left behind.
    places = {"PYTHONPATH": str(project), "NUMBA_CACHE_DIR": str(project / "kernels")}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    done = subprocess.run(
        command, cwd=project, env=os.environ | places, capture_output=True, text=True, check=False
    )
    values = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    # Only a test that fails has caught anything; a copy whose tests cannot run at all says nothing. Several
    # processes that stop at the first failure are interrupted (2).
    if done.returncode not in (0, 1) and not (done.returncode == 2 and values):
        raise RuntimeError(f"The tests of a copy cannot run:\n{done.stdout}{done.stderr}")
    return done.returncode == 0, values[1] if values else done.stdout[-200:].strip()


def try_out(mutation: Mutation | None, tests: Sequence[str]) -> Outcome:
    """Put one error, or none, into a copy and run tests; the whole suite where an error stays unseen."""
    started = perf_counter()
    with TemporaryDirectory() as folder:
        project = Path(folder)
        copy_project(project)
        if mutation:
            mutation.apply(project)
        green, by = run_tests(project, tests)
        if green and mutation:
            # Its own tests fail on every error: they hold the list to the sources.
            green, by = run_tests(
                project, ("tests", "validation", "--ignore=validation/test_mutation_check.py")
            )
    seconds = round(perf_counter() - started)
    return Outcome(mutation.name if mutation else "", not green, "" if green else by, seconds)


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
    if (unchanged := try_out(None, sorted({t for m in chosen for t in m.tests}))).caught:
        label = f"The unchanged project fails {unchanged.by}; mend it first."
        print(label, file=sys.stderr)
        return 2
    outcomes = []
    with ThreadPoolExecutor(options.workers) as pool:
        tasks = [pool.submit(try_out, mutation, mutation.tests) for mutation in chosen]
        for task in tqdm(as_completed(tasks), total=len(tasks), unit=" errors", disable=None):
            outcome = task.result()
            outcomes.append(outcome)
            verdict = f"caught by {outcome.by}" if outcome.caught else "CAUGHT BY NOBODY"
            tqdm.write(f"{outcome.error}: {verdict} ({outcome.seconds:.0f} s)")
    options.output.mkdir(parents=True, exist_ok=True)
    table = pd.DataFrame(map(asdict, outcomes))
    table.to_csv(options.output / "mutation_check.csv", index=False)
    missed = sum(not outcome.caught for outcome in outcomes)
    print(f"{len(outcomes)} errors, {len(outcomes) - missed} caught, {missed} not.")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
