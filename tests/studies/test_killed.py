"""Claims on fits and validations that are killed: the same bytes as without."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

TESTS = Path(__file__).parents[1]
KILLS = 20


def begun(verb: str, folder: Path) -> "subprocess.Popen[bytes]":
    """Begin or continue a study in a folder."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS.parent), str(TESTS)])}
    command = [sys.executable, "-m", "support.inference_study", verb, str(folder)]
    return subprocess.Popen(command, env=environment, cwd=TESTS, stdout=subprocess.DEVNULL)


@pytest.mark.long
@pytest.mark.parametrize("verb", ["fit", "validate"])
def test_a_study_killed_at_random_leaves_the_same_bytes(verb: str, tmp_path: Path) -> None:
    if verb == "fit":
        pytest.importorskip("dynesty", reason="There is no dynesty; pip install 'contactlab[fit]' brings it.")
    assert begun(verb, tmp_path / "whole").wait() == 0
    expected = {path.name: path.read_bytes() for path in (tmp_path / "whole").iterdir()}

    def files() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in (tmp_path / "killed").iterdir()}

    draws, kills = np.random.default_rng(0), 0
    while kills < KILLS:
        process = begun(verb, tmp_path / "killed")
        try:
            assert process.wait(draws.uniform(1.0, 6.0)) == 0
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            kills += 1
        else:
            assert files() == expected
            shutil.rmtree(tmp_path / "killed")
    assert begun(verb, tmp_path / "killed").wait() == 0
    assert files() == expected
