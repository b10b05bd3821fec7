"""The benchmarks compute what they time: their short forms, untimed."""

import sys
from pathlib import Path

import accuracy_tables
import benchmark_engine
import benchmark_impacts
import benchmark_paths
import benchmark_sweep
import benchmark_waits
import pytest
import work_precision
from history import times

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


def test_the_work_precision_diagram_has_every_family_and_its_convergence(tmp_path: Path) -> None:
    timings = work_precision.measure(duration=5e-4, repeats=1)
    for law in work_precision.LAWS:
        errors = [each.error for each in timings if (each.law, each.method) == (law, "collocated")]
        assert errors[-1] < 1e-8, law
        assert errors[-1] <= errors[0], law
    stepped = [each.error for each in timings if each.method == "time stepping"]
    assert min(stepped) > 1e-8
    work_precision.draw(timings, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.long
def test_what_users_wait_for_is_timed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["benchmark_waits", "1", "--only=help", f"--other={sys.executable}"])
    benchmark_waits.main()
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["help", "--help"]


@pytest.mark.parametrize("motor", [times.Motor, times.ConvergedBeam])
def test_what_is_timed_over_the_history_runs(motor: type[times.Motor]) -> None:
    timed = motor()
    timed.setup("newton")
    for name in dir(timed):
        if name.startswith("time_"):
            getattr(timed, name)("newton")


def test_kept_times_of_waits_become_differences_on_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(benchmark_waits, "KEPT", tmp_path / "waits.csv")
    benchmark_waits.keep({"501 runs of 2 ms, newton": 3.0, "1 motor seconds, newton": 1.0})
    benchmark_waits.keep({"501 runs of 2 ms, newton": 2.5, "1 runs of 2 ms, newton": 2.0})
    # In the order of the benchmark, whatever was kept first.
    assert [*benchmark_waits.kept()] == [
        "1 motor seconds, newton",
        "1 runs of 2 ms, newton",
        "501 runs of 2 ms, newton",
    ]
    newton = [line.split("|")[-2].strip() for line in accuracy_tables.waits().splitlines()]
    assert newton == ["`newton`", "---", "not timed", "1", "not timed", "not timed"]


@pytest.mark.parametrize("name", benchmark_paths.CASES)
def test_a_path_and_lsoda_are_as_near_to_a_third_method(name: str) -> None:
    row = benchmark_paths.measured(benchmark_paths.CASES[name](), 1)
    assert 0.0 < row["error of LSODA"] <= row["error"] < 1e-8


def test_kept_times_of_paths_become_ratios_on_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(benchmark_paths, "KEPT", tmp_path / "paths.csv")
    row = {"evaluation": 1e-3, "call": 8e-3, "LSODA": 4e-3, "error": 3e-9, "error of LSODA": 2e-9}
    benchmark_paths.keep({"dahl, on the path": row})
    assert benchmark_paths.kept() == {"dahl, on the path": row}
    last = [cell.strip() for cell in accuracy_tables.paths().splitlines()[-1].strip("|").split("|")]
    assert last == ["`dahl`, on the path", "1", "8", "4", "0.5", "3e-09", "2e-09"]
