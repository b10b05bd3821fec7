"""The benchmark compares like with like: its short form agrees with SciPy, untimed."""

import importlib.util
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "experiments" / "benchmark_engine.py"


def test_engine_and_scipy_reach_the_same_state() -> None:
    spec = importlib.util.spec_from_file_location("benchmark_engine", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    scipy_timings, engine_timings = benchmark.measure(duration=5e-4, repeats=1)
    # Two contacts. The judge, DOP853, steps over the corners of the force at touch-down and release,
    # which costs it the ninth digit.
    assert min(t.error for t in scipy_timings) < 1e-8
    assert engine_timings[-1].error < 1e-8
