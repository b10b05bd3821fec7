"""NUMBA_DISABLE_JIT: every kernel as the Python function that it was, for coverage and debuggers."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import contactlab
from contactlab.engine import simulate
from contactlab.laws import HertzPenalty, Stronge
from contactlab.laws.composed import Composed
from contactlab.laws.friction import LuGre
from contactlab.testing.plants import paper_motor
from contactlab.trajectory import Trajectory

DURATION = 2.5e-4
"""The first contact, from 131 us on, is over by then [s]."""
LAWS = (HertzPenalty(), Stronge(), Composed(friction=LuGre()))

SCRIPT = """
import sys
from dataclasses import dataclass
from typing import ClassVar
import numpy as np
from contactlab.compiler.kernels import kernel
from contactlab.engine import simulate
from contactlab.laws import HertzPenalty, LawError, PenaltyLaw, Stronge
from contactlab.laws.composed import Composed
from contactlab.laws.friction import LuGre
from contactlab.testing.plants import paper_motor

@kernel
def bound(normal, parameters):
    return 0.3 * normal

@dataclass(frozen=True)
class Spring(PenaltyLaw):
    name = "spring"
    equation = "N = k d"
    source = "a test"
    default_contact_step = 4e-6
    stiffness: float = 1e7

    @property
    def force(self):
        def spring(gap, gap_rate, slip, impact_speed, parameters):
            normal = parameters[0] * max(-gap, 0.0)
            return normal, bound(normal, parameters), -0.5 * normal * gap, 0.0
        return spring

class Writing(Spring):
    @property
    def force(self):
        def spring(gap, gap_rate, slip, impact_speed, parameters):
            parameters[0] *= 0.5
            return 0.0, 0.0, 0.0, 0.0
        return spring

saved = {}
for number, law in enumerate([HertzPenalty(), Stronge(), Composed(friction=LuGre()), Spring()]):
    found = simulate(paper_motor(), law, duration=float(sys.argv[2]), record_interval=1e-6)
    for columns in (found.series, found.contacts):
        saved |= {f"{number} {name}": column for name, column in columns.items()}
np.savez(sys.argv[1], **saved)
try:
    simulate(paper_motor(), Writing(), duration=float(sys.argv[2]), record_interval=1e-6)
except LawError as error:
    assert "read-only" in str(error), error
else:
    raise AssertionError("parameters were written to")
"""


def python(folder: Path, *arguments: str, jit: bool = True) -> str:
    """Run Python, with machine code or without, and give what it says on stderr."""
    path = str(Path(contactlab.__file__).resolve().parents[1])
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": path, "NUMBA_DISABLE_JIT": "0" if jit else "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


def columns_of(run: Trajectory) -> dict[str, np.ndarray]:
    return {**run.series, **run.contacts}


@pytest.mark.long
def test_laws_of_both_families_give_the_same_bits_without_machine_code(tmp_path: Path) -> None:
    runs = [simulate(paper_motor(), law, duration=DURATION, record_interval=1e-6) for law in LAWS]
    (tmp_path / "script.py").write_text(SCRIPT)
    line = ("-W", "error", "script.py")
    assert not python(tmp_path, *line, "interpreted.npz", str(DURATION), jit=False)
    python(tmp_path, *line, "compiled.npz", str(DURATION))
    with np.load(tmp_path / "interpreted.npz") as result:
        with np.load(tmp_path / "compiled.npz") as compiled:
            assert {name.split()[0] for name in result} == set("0123")
            for name in compiled:
                np.testing.assert_array_equal(result[name], compiled[name], err_msg=name)
        for number, run in enumerate(runs):
            assert run.contacts["start_time"].size > 0
            for name, column in columns_of(run).items():
                np.testing.assert_array_equal(result[f"{number} {name}"], column, err_msg=name)
