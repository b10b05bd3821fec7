"""A command that is killed at random and started again, for tests of studies."""

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

KILLS = 2
"""Twenty of every study took fourteen minutes and passed. Here are those that are done in ways of their own:
in one process, in several, as a sweep, by a sampler with checkpoints."""


def assert_the_same_when_killed(command: Sequence[str], place: Path) -> None:
    """A module of Python that writes into `killed` leaves the same bytes when it is killed as without.

    Args:
        command: the module and its arguments.
        place: in which it runs.
    """
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    folder = place / "killed"

    def begun() -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, "-m", *command], env=environment, cwd=place, stdout=subprocess.DEVNULL
        )

    def files() -> dict[str, bytes]:
        # What a killed process was writing stays under a hidden name for a day.
        whole = (path for path in folder.iterdir() if path.suffix != ".partial")
        return {path.name: path.read_bytes() for path in whole}

    since = perf_counter()
    assert begun().wait() == 0
    duration = perf_counter() - since
    expected = files()
    shutil.rmtree(folder)

    draws, kills = np.random.default_rng(0), 0
    while kills < KILLS:
        process = begun()
        try:
            assert process.wait(draws.uniform(0.2, 1.0) * duration) == 0
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            kills += 1
        else:
            assert files() == expected
            shutil.rmtree(folder)
    assert begun().wait() == 0
    assert files() == expected
