"""Claims on resonators that other packages bring: sound ones run as our own, broken ones harm no other."""

import sys
from pathlib import Path

import pytest

import contactlab as cl
from contactlab.config.groups import other_resonators
from contactlab.config.options import known_keys

SOURCE = '''
from dataclasses import dataclass
from typing import Annotated

import numpy as np

import contactlab as cl


@dataclass(frozen=True)
class Ring:
    """Two modes of one frequency."""

    frequency: Annotated[float, cl.Parameter("f", "Hz", "of both modes", above=0.0)] = 3000.0
    mass: Annotated[float, cl.Parameter("m", "kg", "modal mass", above=0.0)] = 0.01

    @property
    def modes(self) -> cl.NormalModes:
        omega, root = 2.0 * np.pi * self.frequency, self.mass**-0.5
        if self.frequency > 1e6:
            raise RuntimeError("too fast")
        return cl.NormalModes(
            stiffness=np.full(2, omega**2),
            damping=np.full(2, 0.02 * omega),
            coupling=0.1 * root * np.array([[1.0, 1.0], [1.0, -1.0]]),
            tip_displacement=root * np.array([1.0, 0.0]),
            tip_slope=root * np.array([0.0, 50.0]),
        )


NOTHING = 1
'''
ENTRIES = """[contactlab.resonators]
ring = their_ring:Ring
nothing = their_ring:NOTHING
absent = not_there:Ring
ritz = their_ring:Ring
"""


@pytest.fixture(autouse=True)
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> object:
    """A package that is installed as far as Python can tell."""
    (tmp_path / "their_ring.py").write_text(SOURCE)
    folder = tmp_path / "their_ring-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: their-ring\nVersion: 1.0\n")
    (folder / "entry_points.txt").write_text(ENTRIES)
    monkeypatch.syspath_prepend(str(tmp_path))
    for each in (other_resonators, known_keys):
        each.cache_clear()
    yield
    for each in (other_resonators, known_keys):
        each.cache_clear()
    sys.modules.pop("their_ring", None)


def test_a_resonator_of_another_package_runs_and_builds_again() -> None:
    setup = cl.build(["resonator=ring", "resonator.frequency=3.2 kHz", "solver.duration=2e-3"])
    assert setup.motor.modes.natural_frequency == pytest.approx([3200.0, 3200.0])
    assert setup.configuration["drive"]["frequency"] == pytest.approx(3200.0)
    run = setup.run()
    assert run.complete
    assert cl.build(setup.configuration).configuration == setup.configuration


def test_our_own_names_are_ours() -> None:
    assert cl.build(["resonator=ritz"]).motor.modes.stiffness.size == 4
    assert "their_ring" not in sys.modules


@pytest.mark.parametrize(
    ("choice", "named"),
    [
        (["resonator=nothing"], "nothing"),
        (["resonator=absent"], "absent"),
        (["resonator=ring", "resonator.frequency=-1"], "resonator.frequency"),
        (["resonator=ring", "resonator.frequency=2 MHz"], "too fast"),
        (["resonator=ring", "resonator.length=1"], "resonator.length"),
        (["resonator=ring", "placement.end=8 mm"], "placement.end"),
        (["resonator=rong"], "rong"),
    ],
)
def test_faults_have_a_name(choice: list[str], named: str) -> None:
    with pytest.raises(cl.ConfigurationError) as refused:
        cl.build(choice)
    assert named in str(refused.value)
