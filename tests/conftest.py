"""Fixtures that several test modules share."""

import logging
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import Command
from hypothesis import settings
from sweeps import Simulations

from contactlab import cli, engine

# Somebody else's project; it runs in its own environment, by tests/test_outside.py.
collect_ignore = ["example_law"]

# The same examples in every run: a failure is one that everybody can repeat.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


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
    monkeypatch.setattr(engine, "simulate", made)
    return made
