"""The scripts that measure sweeps do what they measure: their short forms, untimed."""

import sys

import benchmark_sweep
import pytest
import sweep_endurance


def test_every_way_to_run_is_timed() -> None:
    rows = benchmark_sweep.in_batches(benchmark_sweep.plan_with(9), repeats=1)
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
    monkeypatch.setattr(sys, "argv", ["sweep_endurance", "--runs=400", "--kills=1", "--workers=2"])
    assert sweep_endurance.main() == 0
    out = capsys.readouterr().out
    assert "400 runs of 0.002 s by 2 processes" in out
    assert "The two files are the same." in out
