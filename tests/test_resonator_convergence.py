"""The experiment on convergence runs, and its rows say what the resonators are."""

import csv
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).parents[1] / "experiments" / "resonator_convergence.py"


@pytest.fixture
def experiment(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The script as a module, with few resonators."""
    spec = importlib.util.spec_from_file_location("resonator_convergence", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "SHAPES", (4,))
    monkeypatch.setattr(module, "KEPT", (1, 6))
    return module


def test_table_has_a_row_a_resonator_and_the_correction_completes_the_compliance(
    experiment: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert experiment.main(["--csv", str(tmp_path / "table.csv")]) == 0
    with (tmp_path / "table.csv").open(newline="") as file:
        rows = {row["resonator"]: row for row in csv.DictReader(file)}
    assert len(capsys.readouterr().out.splitlines()) == 1 + len(rows) == 6
    compliance = {name: float(row["tip_compliance"]) for name, row in rows.items()}
    few, many = compliance["finite_element 1 corrected"], compliance["finite_element 6 corrected"]
    assert few == pytest.approx(many, rel=1e-11)
    assert compliance["ritz 4"] < compliance["finite_element 1 truncated"] < few
    assert float(rows["finite_element 1 truncated"]["rotor_velocity"]) == pytest.approx(0, abs=1e-9)
    assert float(rows["ritz 4"]["rotor_velocity"]) < -0.3
