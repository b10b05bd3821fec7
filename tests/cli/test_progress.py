"""What a terminal shows while one waits, and what long computations tell of themselves."""

import sys
from contextlib import nullcontext
from io import StringIO
from pathlib import Path
from time import sleep
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, strategies as st
from support.terminals import assert_terminal_is_written_to, reports_of, slow

import contactlab as cl
from contactlab.cli import terminal
from contactlab.cli.main import main
from contactlab.compiler.notice import Compiled
from contactlab.progress import part_of_progress, shown_by, tell_progress, untold_progress
from contactlab.studies.study import Task
from contactlab.studies.sweep import collection


# The child runs the command at once, and no thread is left in it.
@pytest.mark.filterwarnings("ignore:.*forkpty:DeprecationWarning")
@pytest.mark.parametrize(
    "arguments",
    [
        ["basins", "count=2"],
        ["branch", "contact.clearance=1e-6..1.1e-6"],
        ["characterise"],
        ["compare", "law=newton,poisson"],
        ["solver.duration=1e-3"],
        ["-m", "contact.clearance=1 um,2 um", "sweep.keep=metrics"],
        ["collect", "runs"],
    ],
    ids=" ".join,
)
def test_a_terminal_is_written_to_while_a_task_takes_long(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("runs").mkdir()
    monkeypatch.setattr(Task, "__call__", slow)
    monkeypatch.setattr(collection, "collect", slow)
    monkeypatch.setattr("contactlab.config.setup.simulate", slow)
    monkeypatch.setattr(sys, "argv", ["contactlab", *arguments])
    assert_terminal_is_written_to(main)


class Terminal(StringIO):
    """A stream that a bar is drawn on."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("waited_for", [False, True])
def test_the_compiler_has_a_bar_where_no_other_line_tells_of_it(
    waited_for: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stderr", screen := Terminal())
    made: Any = SimpleNamespace(data={"dispatcher": len})
    reports = list[str]()
    with shown_by(lambda what, _: reports.append(what)) if waited_for else nullcontext():
        compiled = Compiled("loops", 10.0)
        compiled.on_start(made)
        compiled.on_end(made)
        compiled.close()
    drawn = "%|" in screen.getvalue().replace(" ", "")
    assert (drawn, bool(reports)) == (not waited_for, waited_for)


def test_nothing_but_a_terminal_is_drawn_on(capfd: pytest.CaptureFixture[str]) -> None:
    with terminal.progress(2.0, "tasks") as show:
        show(1.0)
        sleep(1.5 * terminal.BAR_AFTER)
    assert capfd.readouterr() == ("", "")


@given(
    st.floats(1e-3, 1e6), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.1, 10.0)
)
def test_a_line_counts_what_there_was_as_done_in_no_time(
    total: float, kept: float, done: float, share: float, size: float
) -> None:
    line = terminal._Line(total, "runs", size)
    line.show(kept * total)
    line.show(max(kept, done) * total)
    line.tell("part: ", share)
    text = str(line)
    assert "part" in text
    assert int(text.split("%")[0]) <= 100
    grown = min(line.done + share * size, total) > kept * total
    assert grown or "left" not in text


@given(st.floats(1.0, 1e6), st.floats(0.01, 1.0), st.floats(0.0, 1e6))
def test_the_time_left_stands_before_what_a_narrow_screen_cuts_off(
    total: float, share: float, elapsed: float
) -> None:
    line = terminal._Line(total, "tasks", total)
    line.show(0.0)
    line.began -= elapsed
    line.tell("hertz_point + dahl: nested sampling: 123456 evaluations, evidence left 1.23e+04", share)
    assert (" left |" in str(line)[:40]) == (" left |" in str(line))


def test_parts_are_shares_of_the_whole_and_evaluations_are_silent() -> None:
    def work() -> None:
        with part_of_progress(0.5, 1.0, "second: "):
            tell_progress("half", 0.5)
            with untold_progress():
                tell_progress("one of many")
            with part_of_progress(0.5, 1.0):
                tell_progress("end", 1.0)

    assert reports_of(work) == [("second: half", 0.75), ("second: end", 1.0)]
    work()
    assert reports_of(lambda: tell_progress("alone"))[0][0] == "alone"


def test_the_runs_of_a_sweep_are_told() -> None:
    over, short = {"contact.clearance": [1e-6, 2e-6]}, ["solver.duration=1e-4"]
    reports = reports_of(lambda: cl.sweep(over, short, metrics=["contact_count"], workers=1))
    assert [what for what, _ in reports] == ["run 1: ", "run 2: "]
