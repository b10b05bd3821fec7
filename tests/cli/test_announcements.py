"""What takes long or leaves much is announced; what does not is not."""

import sys
import time
from collections.abc import Callable
from typing import Any

import pytest
from support.command_line import Command
from support.synthetic import synthetic_trajectory

from contactlab.cli import terminal
from contactlab.cli.checking import announce, announce_series


def configuration(duration: float, interval: float = 1e-6) -> dict[str, Any]:
    return {"solver": {"duration": duration}, "record": {"interval": interval}}


@pytest.mark.parametrize(
    ("runs", "words"),
    [
        ([configuration(0.02)], ""),
        ([configuration(1.6)], ""),
        ([configuration(10.0)], "The run leaves about 600 MB: 1e+07 records"),
        ([configuration(10.0)], "3.5 GB of memory"),
        ([configuration(10.0, 1e-4)], ""),
        ([configuration(0.02)] * 10_000, "The 10000 runs leave about 12 GB"),
        ([], ""),
    ],
)
def test_large_datasets_are_announced_with_the_way_out(
    runs: list[dict[str, Any]], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    announce(runs)
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert bool(err) is bool(words)
    assert not err or "A larger record.interval" in err


def test_the_series_of_a_large_sweep_are_announced(capsys: pytest.CaptureFixture[str]) -> None:
    announce_series(100, 1, configuration(2e-3))
    assert capsys.readouterr().err == ""
    announce_series(10_000, 2, configuration(2e-3))
    assert "The series take up to 320 MB: 10000 runs of 2e+03 records" in capsys.readouterr().err


def test_a_run_and_a_sweep_are_announced_before_they_begin(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "contactlab.config.setup.simulate", lambda *_, **__: synthetic_trajectory(duration=1e-3)
    )
    _, _, err = command("solver.duration=2", "record.picture=false")
    assert err.startswith("The run leaves about 120 MB: 2e+06 records")
    _, _, err = command("solver.duration=2e-3", "record.picture=false")
    assert err == ""
    again = ("-m", "solver.duration=1", "drive.phase=0,1", "record.picture=false")
    assert "The 2 runs leave about 120 MB" in command(*again)[2]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Sets the time [s]."""
    now = [1.0]
    monkeypatch.setattr(terminal, "perf_counter", lambda: now[0])

    def set_to(time: float) -> None:
        now[0] = 1.0 + time

    return set_to


@pytest.mark.parametrize(
    ("spent", "done", "words"),
    [
        (4.0, 0.01, ""),
        (5.0, 5.0, ""),
        (5.0, 0.5, "The run: 5.00% is done in 5 s, 01:35 is left.\n"),
        (10.0, 0.001, "The run: 0.01% is done in 10 s, 27:46:30 is left.\n"),
        (10.0, 10.0, ""),
    ],
)
def test_work_that_will_take_long_says_so_once(
    clock: Callable[[float], None], capsys: pytest.CaptureFixture[str], spent: float, done: float, words: str
) -> None:
    with terminal.progress(10.0, "s", "The run") as show:
        # Before the first of it there is the compiler, whose time is no measure.
        clock(90.0)
        show(0.0)
        clock(90.0 + spent)
        show(done)
        show(done)
    assert capsys.readouterr().err == words


def test_a_bar_shows_on_a_terminal_only_and_not_before_its_time(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    for delay, shown in ((60.0, False), (1e-9, True)):
        monkeypatch.setattr(terminal, "BAR_AFTER", delay)
        with terminal.progress(0.02, "s", "The run") as show:
            time.sleep(0.2)
            show(0.01)
        assert ("50 %" in capsys.readouterr().err) is shown
