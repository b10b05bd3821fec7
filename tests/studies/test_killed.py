"""Claims on studies that are killed: the same bytes as without."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest

TESTS = Path(__file__).parents[1]
KILLS = 2
"""Twenty of every study took fourteen minutes and passed. Here are those that are done in ways of their own:
in one process, in several, as a sweep, by a sampler with checkpoints."""

LAWS = "law=hertz_penalty,newton"
COMMANDS = {
    "compare": [
        "contactlab", "compare", LAWS, "samples=2", "starts=1", "observe=rotor_velocity", "workers=1",
        "output=killed",
    ],
    "steady states over phase": ["contactlab", "-m", "steady", "drive.phase=0,-0.6", LAWS, "output=killed"],
    "numbers of runs": [
        "contactlab", "-m", "contact.clearance=linspace(0,2e-6,30)", LAWS, "sweep.keep=metrics",
        "sweep.chunk=2", "sweep.workers=2", "solver.duration=5e-3", "hydra.sweep.dir=killed",
    ],
    "fit": ["support.fit_of_impacts", "killed"],
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("study", COMMANDS)
def test_a_study_killed_at_random_leaves_the_same_bytes(study: str, tmp_path: Path) -> None:
    if study == "fit":
        pytest.importorskip("dynesty", reason="There is no dynesty; pip install 'contactlab[fit]' brings it.")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS.parent), str(TESTS)])}
    folder = tmp_path / "killed"

    def begun() -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, "-m", *COMMANDS[study]], env=environment, cwd=tmp_path, stdout=subprocess.DEVNULL
        )

    def files() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in folder.iterdir()}

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
