"""Claims on studies that are killed: the same bytes as without."""

from pathlib import Path

import pytest
from support.killed import assert_the_same_when_killed

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
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("study", COMMANDS)
def test_a_study_killed_at_random_leaves_the_same_bytes(study: str, tmp_path: Path) -> None:
    assert_the_same_when_killed(COMMANDS[study], tmp_path)
