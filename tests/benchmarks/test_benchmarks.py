"""The benchmarks compute what they time: their short forms, untimed."""

import sys

import benchmark_engine
import benchmark_impacts
import benchmark_sweep
import pytest
import sweep_endurance

from contactlab.laws import LAWS


def test_engine_and_scipy_reach_the_same_state() -> None:
    scipy_timings, engine_timings = benchmark_engine.measure(duration=5e-4, repeats=1)
    # Two contacts. DOP853 steps over the corners of the force at touch-down and release, which costs it the
    # ninth digit.
    assert min(timing.error for timing in scipy_timings) < 1e-8
    assert engine_timings[-1].error < 1e-8


@pytest.mark.long
def test_impacts_of_every_law_are_timed() -> None:
    timings = benchmark_impacts.measure(20, 1e-4)
    assert {timing.name for timing in timings} == {*LAWS, *benchmark_impacts.COMPOSED} - {"composed"}
    assert all(min(timing.dataset, timing.arrays) > 0.0 == timing.unanswered for timing in timings)


def test_every_way_to_run_a_batch_is_timed() -> None:
    rows = benchmark_sweep.in_batches(benchmark_sweep.plan_with(9), repeats=1)
    assert len(rows) == 4
    assert all(row.seconds > 0.0 for row in rows)


# The short form is the sweep that tests/sweeps kills.
@pytest.mark.long
def test_a_sweep_that_is_killed_has_the_same_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["sweep_endurance", "--runs=400", "--kills=1", "--workers=2"])
    assert sweep_endurance.main() == 0
