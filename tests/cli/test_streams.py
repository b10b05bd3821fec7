"""A run does not depend on whether anybody can read what it prints."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from support.command_line import cases

from contactlab.metrics import read_run

pytestmark = pytest.mark.skipif(
    os.name != "posix", reason="A POSIX shell alone closes streams so; run the tests on Linux or macOS."
)

RUN = "solver.duration=0.2 ms"
STREAMS = ("2>&-", ">&-", "<&- >&- 2>&-", "> /dev/full", "| true")


def shell(redirection: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = f"{sys.executable} -m contactlab '{RUN}' record.picture=false hydra.run.dir=run {redirection}"
    return subprocess.run(["/bin/sh", "-c", command], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("redirection", cases(STREAMS, ("<&- >&- 2>&-",)), ids=str)
def test_a_run_is_whole_wherever_its_words_go(redirection: str, tmp_path: Path) -> None:
    if "/dev/full" in redirection and not Path("/dev/full").exists():
        pytest.skip("There is no /dev/full, a device that takes nothing; run the tests on Linux.")
    ran = shell(redirection, tmp_path)
    assert json.loads((tmp_path / "run/state.json").read_text())["state"] == "complete"
    tree = read_run(tmp_path / "run" / "run.nc")
    assert tree["time"].values[-1] == 0.2e-3
    assert "Traceback" not in ran.stderr
    assert "Exception ignored" not in ran.stderr
    assert ran.returncode == 0
