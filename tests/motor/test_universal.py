"""Claims on universal files: the modes are those that were written, and faults have a name."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactlab as cl

pyuff = pytest.importorskip("pyuff")
NODES = [3, 7, 9]
SHAPES = np.array([[[1.0, 2.0, 0.0], [0.5, 4.0, 0.0], [0.0, 0.0, 1.0]], [[2.0, 0.1, 0.0]] * 3])
COUPLING = np.array([[0.2, 0.2], [0.1, -0.1]])


def written(path: Path, **changes: Any) -> Path:
    for number, (frequency, mass) in enumerate(((39e3, 0.02), (38e3, 0.5))):
        numbers = {"freq": frequency, "modal_m": mass, "modal_damp_vis": 0.004} | changes
        data = pyuff.prepare_55(
            id1="x", id2="x", id3="x", id4="x", id5="x", model_type=1, analysis_type=2, data_ch=2,
            spec_data_type=8, data_type=2, n_data_per_node=3, node_nums=NODES, load_case=1,
            mode_n=number + 1, modal_damp_his=0.0, **numbers,
            **{f"r{i + 1}": SHAPES[number, :, i] for i in range(3)},
        )  # fmt: skip
        pyuff.UFF(str(path)).write_sets(data, "add")
    return path


def test_modes_of_a_universal_file_are_those_that_were_written(tmp_path: Path) -> None:
    modes = cl.read_universal(written(tmp_path / "modes.uff"), 7, COUPLING, tip_length=0.02)
    assert modes.natural_frequency == pytest.approx([38e3, 39e3], rel=1e-5)
    assert modes.damping_ratio == pytest.approx([0.004, 0.004], rel=1e-4)
    root = np.sqrt([0.5, 0.02])
    assert modes.tip_displacement == pytest.approx(np.array([0.1, 4.0]) / root, rel=1e-4)
    assert -0.02 * modes.tip_slope == pytest.approx(np.array([2.0, 0.5]) / root, rel=1e-4)
    assert modes.coupling == pytest.approx(COUPLING[::-1] / root[:, None], rel=1e-4)


def test_directions_are_those_of_the_rotor(tmp_path: Path) -> None:
    modes = cl.read_universal(
        written(tmp_path / "modes.uff"), 9, COUPLING, towards=(0, 0, 1), along=(0, 1, 0)
    )
    assert modes.tip_displacement == pytest.approx([0.0, 1.0 / np.sqrt(0.02)], rel=1e-4)


@pytest.mark.parametrize(("changes", "named"), [({"freq": -1.0}, "frequency"), ({"modal_m": 0.0}, "mass")])
def test_impossible_numbers_are_refused_by_name(
    tmp_path: Path, changes: dict[str, float], named: str
) -> None:
    with pytest.raises(cl.MeasurementError, match=named):
        cl.read_universal(written(tmp_path / "modes.uff", **changes), 7, COUPLING)


def test_what_is_no_such_file_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "modes.uff")
    with pytest.raises(cl.MeasurementError, match="node 8"):
        cl.read_universal(path, 8, COUPLING)
    with pytest.raises(ValueError, match="coupling"):
        cl.read_universal(path, 7, COUPLING[:1])
    with pytest.raises(OSError, match="absent"):
        cl.read_universal(tmp_path / "absent.uff", 7, COUPLING)
    empty = tmp_path / "empty.uff"
    empty.write_text("nothing\n")
    with pytest.raises(cl.MeasurementError, match=r"empty\.uff"):
        cl.read_universal(empty, 7, COUPLING)
