"""An edit of whatever a user's kernel calls or reads gives new code and a new run, everywhere."""

from collections.abc import Callable
from pathlib import Path

import pytest
import xarray
from support.command_line import Elsewhere
from support.sweeps import QUICK

LAW = """
from dataclasses import dataclass
from typing import ClassVar
from contactlab.compiler.kernels import kernel
from contactlab.laws import PenaltyLaw
import nearby

@kernel
def spring(gap, gap_rate, slip, impact_speed, parameters):
    normal = nearby.normal(gap)
    return normal, 0.0, -0.5 * normal * gap, 0.0

@dataclass(frozen=True)
class Borrowed(PenaltyLaw):
    name: ClassVar[str] = "borrowed"
    equation: ClassVar[str] = "N = k d"
    source: ClassVar[str] = "a test"
    default_contact_step: ClassVar[float] = 4e-6

    @property
    def force(self):
        return spring
"""
NEARBY = """
from contactlab.compiler.kernels import kernel
from far import pressed

@kernel
def normal(gap):
    return pressed(-gap)
"""
FAR = """
import numba

STIFFNESS = 1e7

@numba.njit(cache=True)
def pressed(depth):
    return STIFFNESS * depth
"""


@pytest.fixture
def elsewhere(tmp_path: Path) -> Elsewhere:
    made = Elsewhere(tmp_path / "packages", tmp_path)
    modules = {"borrowed": LAW, "nearby": NEARBY, "far": FAR}
    made.install(made.wheel("borrowed-law", "0.1", {"borrowed": "borrowed:Borrowed"}, modules))
    return made


def edits(elsewhere: Elsewhere) -> list[Callable[[], object]]:
    """What the helper's helper reads, and the helper between, each made twice as stiff."""

    def edit(name: str, old: str, new: str) -> Callable[[], object]:
        file = elsewhere.packages / name
        return lambda: file.write_text(file.read_text().replace(old, new))

    return [edit("far.py", "1e7", "2e7"), edit("nearby.py", "pressed(-gap)", "2.0 * pressed(-gap)")]


@pytest.mark.long
def test_a_sweep_is_run_again_with_new_code_after_an_edit_far_away(elsewhere: Elsewhere) -> None:
    line = ("-m", "law=borrowed,hertz_penalty", "solver.duration=0.2 ms", *QUICK)

    def peak() -> float:
        (run,) = elsewhere.folder.glob("sweep/law=borrowed*/run.nc")
        with xarray.open_dataset(run, group="contacts") as contacts:
            return float(contacts["peak_normal_force"][0])

    status, _, err = elsewhere.command(*line)
    assert status == 0, err
    # What meets a stiffer spring at a given speed is pushed harder, about as the root of the stiffness.
    peaks = [peak()]
    for edit in edits(elsewhere):
        edit()
        status, _, err = elsewhere.command(*line)
        assert status == 0, err
        peaks.append(peak())
        assert 1.2 < peaks[-1] / peaks[-2] < 1.6
