"""How all tests run, and fixtures that several modules share."""

import logging
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import settings
from support.command_line import Command
from support.sweeps import Simulations
from threadpoolctl import threadpool_limits

from contactlab.cli import main as cli

# Somebody else's project; it runs in its own environment, by tests/laws/test_other_packages.py.
collect_ignore = ["tests/example_law", "tests/example_study"]

NEED_DATA = ["packages/contactlab-data/tests", "tests/benchmarks", "tests/documentation", "tests/experiments"]
"""Tests that need contactlab-data: its own, and those of pages, experiments and benchmarks of both."""

WITHOUT_DATA = find_spec("contactlab_data") is None

EXPLORER = "packages/contactlab-explorer/tests"
"""Tests that need contactlab-explorer."""

WITHOUT_EXPLORER = find_spec("contactlab_explorer") is None

collect_ignore_glob = [f"{folder}/*" for folder in NEED_DATA if WITHOUT_DATA]
collect_ignore_glob += [f"{EXPLORER}/*"] if WITHOUT_EXPLORER else []

# The same examples in every run: a failure is one that everybody can repeat.
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("repeatable")

MOST_WORKERS = 8
"""Beyond these the longest modules set the pace, and each worker takes 0.4 GB."""

LONGEST = (
    *("test_blocks.py", "test_killed.py", "test_experiments.py"),
    *("test_contract.py", "test_compare.py", "test_compare_recorded.py", "test_cross_validation.py"),
    *("test_reading.py", "test_own_study.py", "test_sweep_jobs.py", "test_collect.py", "test_saboteurs.py"),
    *("test_curve_problem.py", "test_path_problem.py"),
)
"""Modules of tens of seconds: they run first, so that no worker has one left where the others have ended."""

COMPILATIONS = ("archard", "lagrange_ageing"), ("hertz_penalty", "lagrange_stick")
"""Laws whose runs and impacts compile all units of the engine, by processes that have none in common."""

COMPILATION = """
import sys
from contactlab.engine import simulate
from contactlab.impacts import velocities_after
from contactlab.laws import LAWS
from contactlab.testing.plants import block

for name in sys.argv[1:]:
    simulate(block(1.0), LAWS[name](), duration=1e-4, record_interval=1e-4)
    velocities_after(LAWS[name](), [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.5])
"""
"""Compiles units of the engine, or loads their code."""


def pytest_configure() -> None:
    """Keep small matrices from threads; let Ctrl-C reach what tests start in a shell's background."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    threadpool_limits(1, user_api="blas")
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_report_header() -> list[str]:
    """Return which tests are left out where a package of this project is not installed."""
    lines = [f"without contactlab-data: {', '.join(NEED_DATA)} are left out"] if WITHOUT_DATA else []
    return lines + ([f"without contactlab-explorer: {EXPLORER} is left out"] if WITHOUT_EXPLORER else [])


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """The processors for the whole suite; this process alone for chosen modules and for debuggers."""
    if any(Path(argument.split("::")[0]).is_file() for argument in config.args):
        return 0
    if hasattr(os, "sched_getaffinity"):
        return min(len(os.sched_getaffinity(0)), MOST_WORKERS)
    return min(os.cpu_count() or 1, MOST_WORKERS)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the longest modules."""
    items.sort(key=lambda item: item.path.name not in LONGEST)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the engine once, before the workers and the processes of the tests all do so at once."""
    if session.config.getoption("numprocesses") and not session.config.getoption("collectonly"):
        compiling = [subprocess.Popen([sys.executable, "-c", COMPILATION, *laws]) for laws in COMPILATIONS]
        for process in compiling:
            process.wait()


@pytest.fixture
def command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Iterator[Command]:
    """Runs the command in an empty directory; gives its exit status, output and errors."""
    monkeypatch.chdir(tmp_path)
    handlers = logging.root.handlers[:]

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["contactlab", *arguments])
        try:
            status = cli.main()
        except SystemExit as stop:
            status = int(stop.code or 0)
        out, err = capfd.readouterr()
        return status, out, err

    yield run
    logging.root.handlers[:] = handlers


@pytest.fixture
def simulations(monkeypatch: pytest.MonkeyPatch) -> Simulations:
    """Counts the runs that the command makes."""
    made = Simulations()
    monkeypatch.setattr("contactlab.config.setup.simulate", made)
    return made
