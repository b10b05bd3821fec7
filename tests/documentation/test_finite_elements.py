"""The page on COMSOL and Ansys: its scripts, on stand-ins with the interfaces of both, leave the same modes.

The stand-ins have the shapes of MPh 1 and PyMAPDL 0.6x: a row a solution and a column a point of `evaluate`,
nodal results in the order of `mesh.nnum`, and a scalar of `*GET`.
"""

import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import contactlab as cl

PAGE = Path(__file__).resolve().parents[2] / "docs/howto/finite_elements.md"

FREQUENCY = np.array([38.2e3, 39.4e3, 71e3])
SHAPES = np.array([[0.3, 4.1], [4.4, -0.2], [1.9, 2.6]])
CHARGES = np.array([[2.1, 2.1], [1.9, -1.9], [0.4, 0.3]])
"""Of three modes: x and y of the tip, and the charges of two electrodes."""


class Comsol:
    """A model of MPh; eigenfrequencies of damped models are complex."""

    def load(self, _: str) -> "Comsol":
        return self

    def evaluate(self, expressions: list[str], dataset: str | None = None) -> list[np.ndarray]:
        at_tip = {"freq": FREQUENCY + 10j, "u": SHAPES[:, 0], "v": SHAPES[:, 1]}
        known = {name: column[:, None] for name, column in at_tip.items()} if dataset == "tip" else {}
        known |= {} if dataset else {"es.Q0_1": CHARGES[:, 0], "es.Q0_2": CHARGES[:, 1]}
        return [known[each] for each in expressions]


class Mapdl:
    """An instance of MAPDL with four nodes, the third of which is the tip."""

    def __init__(self) -> None:
        self.mesh = SimpleNamespace(nnum=np.array([1, 77, 1201, 3001]))
        self.post_processing = self
        self.frequency_values = FREQUENCY
        self._mode = -1

    def resume(self, *_: str) -> None:
        self._mode = -1

    post1 = file = resume

    def set(self, step: int, mode: int) -> None:
        assert step == 1
        self._mode = mode - 1

    def nodal_displacement(self, axis: str) -> np.ndarray:
        return np.array([9.0, 9.0, SHAPES[self._mode, "XY".index(axis)], 9.0])

    def get_value(self, entity: str, node: int, item: str, label: str) -> float:
        assert (entity, item, label) == ("NODE", "RF", "CHRG")
        return float(CHARGES[self._mode, (3001, 3002).index(node)])


@pytest.mark.parametrize("program", ["mph", "ansys"])
def test_the_script_of_a_program_leaves_its_modes(
    program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    parts = {"mph": {"start": Comsol}, "ansys.mapdl.core": {"launch_mapdl": Mapdl}}
    for name, members in {"ansys": {}, "ansys.mapdl": {}, **parts}.items():
        module = ModuleType(name)
        vars(module).update(members)
        monkeypatch.setitem(sys.modules, name, module)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (script,) = (block for block in blocks if re.search(rf"(?:import|from) {program}\b", block))
    exec(compile(script, str(PAGE), "exec"), {})
    modes, length = cl.read_modes("modes.csv", tip_length=2e-3), 2e-3
    assert np.allclose(modes.stiffness, (2.0 * np.pi * FREQUENCY) ** 2, rtol=1e-12)
    assert np.allclose(modes.damping, 2.0 * 0.005 * 2.0 * np.pi * FREQUENCY, rtol=1e-12)
    assert np.allclose(modes.coupling, CHARGES, rtol=1e-12)
    assert np.allclose(modes.tip_displacement, SHAPES[:, 1], rtol=1e-12)
    assert np.allclose(-length * modes.tip_slope, SHAPES[:, 0], rtol=1e-12)
