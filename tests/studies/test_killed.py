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
"""Twenty of every study took fourteen minutes and passed."""

LAWS = "law=hertz_penalty,newton"
COMMANDS = {
    "basins": ["basins", "count=4", "output=killed"],
    "characterise": ["characterise", "law=newton", "output=killed"],
    "compare": [
        "compare", LAWS, "samples=2", "starts=1", "observe=rotor_velocity", "workers=1", "output=killed",
    ],
    "steady states over phase": ["-m", "steady", "drive.phase=0,-0.6", LAWS, "output=killed"],
    "numbers of runs": [
        "-m", "contact.clearance=linspace(0,2e-6,30)", LAWS, "sweep.keep=metrics", "sweep.chunk=2",
        "sweep.workers=2", "solver.duration=5e-3", "hydra.sweep.dir=killed",
    ],
}  # fmt: skip
OF_IMPACTS = ("fit", "validate")


@pytest.mark.long
@pytest.mark.parametrize("study", [*COMMANDS, *OF_IMPACTS])
def test_a_study_killed_at_random_leaves_the_same_bytes(study: str, tmp_path: Path) -> None:
    if study == "fit":
        pytest.importorskip("dynesty", reason="There is no dynesty; pip install 'contactlab[fit]' brings it.")
    arguments = ["-m", "support.study_of_impacts", study, "killed"]
    if study in COMMANDS:
        arguments = ["-m", "contactlab", *COMMANDS[study]]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS.parent), str(TESTS)])}
    folder = tmp_path / "killed"

    def begun() -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, *arguments], env=environment, cwd=tmp_path, stdout=subprocess.DEVNULL
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
