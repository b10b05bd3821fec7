"""The scripts that measure sweeps do what they measure: their short forms, untimed."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

EXPERIMENTS = Path(__file__).parents[2] / "experiments"


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXPERIMENTS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # A dataclass looks its module up.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def test_every_way_to_run_is_timed() -> None:
    benchmark = script("benchmark_sweep")
    rows = benchmark.in_batches(benchmark.plan_with(9), repeats=1)
    assert [row.way for row in rows] == [
        "bare engine",
        "batch, one process",
        "batch, two processes",
        "bare engine, two independent processes",
    ]
    assert all(row.seconds > 0.0 for row in rows)


# The short form is the sweep that tests/sweeps/test_metrics.py kills.
@pytest.mark.long
def test_a_sweep_that_is_killed_on_the_way_ends_the_same(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    endurance = script("sweep_endurance")
    monkeypatch.setattr(sys, "argv", ["sweep_endurance", "--runs=400", "--kills=1", "--workers=2"])
    assert endurance.main() == 0
    out = capsys.readouterr().out
    assert "400 runs of 0.002 s by 2 processes" in out
    assert "The two files are the same." in out
