"""Finds a Python that has Siconos and runs `siconos_motor` there: no wheel of Siconos exists."""

import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from foreign.problem import Problem

Array = NDArray[np.float64]

SCRIPT = Path(__file__).with_name("siconos_motor.py")
CHOICE = "CONTACTLAB_SICONOS_PYTHON"
"""Environment variable that names a Python with Siconos."""

SHORTEST_FLIGHT = 10e-6
"""Pushing steps further apart than this belong to different contacts [s]."""


@dataclass(frozen=True)
class SiconosRun:
    """End state, and one entry a contact: when it began [s] and its impulses [N s]; step [s]."""

    step: float
    rotor_velocity: float
    rotor_angle: float
    tip_normal_displacement: float
    tip_slope: float
    start_time: Array
    normal_impulse: Array
    friction_impulse: Array


def find_siconos() -> str | None:
    """The Python that can import Siconos: the one that the environment names, else Debian's."""
    named = os.environ.get(CHOICE)
    for candidate in [named] if named else ["/usr/bin/python3", "python3"]:
        python = shutil.which(candidate)
        if python and _start([python, "-c", "import siconos.kernel"]).returncode == 0:
            return python
    return None


def siconos_runs(python: str, problem: Problem, steps: Sequence[float]) -> list[SiconosRun]:
    """The motor at several time steps [s], as many at a time as there are processors."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda step: _run(python, problem, step), steps))


def _start(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run a command without the settings that are meant for this Python and not for the other."""
    environment = {key: os.environ[key] for key in os.environ if not key.startswith("PYTHON")}
    return subprocess.run(command, capture_output=True, text=True, env=environment)


def _run(python: str, problem: Problem, step: float) -> SiconosRun:
    with TemporaryDirectory() as folder:
        source, target = Path(folder, "problem.json"), Path(folder, "result.json")
        source.write_text(json.dumps({**problem, "step": step}))
        done = _start([python, str(SCRIPT), str(source), str(target)])
        if done.returncode:
            raise RuntimeError(f"Siconos ended with status {done.returncode}:\n{done.stderr}")
        result = json.loads(target.read_text())
    time, normal, friction = (
        np.array(result.pop(name)) for name in ("time", "normal_impulse", "friction_impulse")
    )
    first = np.flatnonzero(np.diff(time, prepend=-np.inf) > SHORTEST_FLIGHT)
    return SiconosRun(
        start_time=time[first],
        normal_impulse=np.add.reduceat(normal, first),
        friction_impulse=np.add.reduceat(friction, first),
        **result,
    )
