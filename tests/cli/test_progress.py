"""What a terminal shows while one waits, and what long computations tell of themselves."""

import os
import pty
import sys
from collections.abc import Callable
from contextlib import suppress
from math import isfinite
from pathlib import Path
from time import sleep

import pytest
from hypothesis import given, strategies as st
from support.measured_impacts import drawn_impacts

import contactlab as cl
from contactlab.cli import terminal
from contactlab.cli.main import main
from contactlab.inference.free_parameters import FreeParameter
from contactlab.inference.least_squares import LOOKS, Optimum, best_fit
from contactlab.inference.nested_sampling import _Left
from contactlab.measured.files import write_impacts
from contactlab.parameter import Parameter
from contactlab.progress import part_of_progress, shown_by, tell_progress, untold_progress
from contactlab.studies.study import Task
from contactlab.studies.sweep import collection

LONG = 1.6
"""Time that an injected task takes [s]."""

BEGUN, ENDED = "<it begins>", "<it ends>"


def on_terminal(work: Callable[[], object]) -> str:
    """Return what a forked process writes to a terminal of its own."""
    written = []
    process, terminal_end = pty.fork()
    if process == 0:
        # pytest has replaced them.
        for number, name in enumerate(("stdin", "stdout", "stderr")):
            setattr(sys, name, os.fdopen(number, "w" if number else "r"))
        try:
            work()
        finally:
            sys.stderr.flush()
            os._exit(0)
    # Reading fails where the terminal has no other end any more.
    with suppress(OSError):
        while data := os.read(terminal_end, 65536):
            written.append(data)
    os.waitpid(process, 0)
    os.close(terminal_end)
    return b"".join(written).decode(errors="replace")


def slow(*_: object, **__: object) -> None:
    """Take long, and end what is done with it."""
    print(BEGUN, file=sys.stderr, flush=True)
    sleep(LONG)
    print(ENDED, file=sys.stderr, flush=True)
    raise ValueError("It ends here.")


POINTS = "rotor.load_torque [N m],rotor_velocity [rad/s]\n-1e-4,-2\n-1e-3,-1\n"


# The child runs the command at once, and no thread is left in it.
@pytest.mark.filterwarnings("ignore:.*forkpty:DeprecationWarning")
@pytest.mark.parametrize(
    "arguments",
    [
        ["basins", "count=2"],
        ["branch", "contact.clearance=1e-6..1.1e-6"],
        ["characterise"],
        ["compare", "law=newton,poisson"],
        ["validate", "impacts.csv", "law=newton"],
        ["fit", "points.csv", "law=hertz_penalty", "contact.friction_coefficient=0.1..0.5"],
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
    Path("points.csv").write_text(POINTS)
    Path("runs").mkdir()
    write_impacts(drawn_impacts(60, 1), Path("impacts.csv"))
    monkeypatch.setattr(Task, "__call__", slow)
    monkeypatch.setattr(collection, "collect", slow)
    monkeypatch.setattr("contactlab.config.setup.simulate", slow)
    monkeypatch.setattr(sys, "argv", ["contactlab", *arguments])
    text = on_terminal(main)
    before, begun, during = text.partition(BEGUN)
    assert begun, before
    assert "so far" in during.partition(ENDED)[0]


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


def reports_of(work: Callable[[], object]) -> list[tuple[str, float]]:
    reports: list[tuple[str, float]] = []
    with shown_by(lambda what, share: reports.append((what, share))):
        work()
    return reports


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


def test_least_squares_tell_every_evaluation_and_have_the_same_bits() -> None:
    free = [FreeParameter("x", 0.0, 1.0, False, Parameter("x", "1", "any number"))]
    optima: list[Optimum] = []

    def search() -> None:
        optima.append(best_fit(lambda values: values**2 - 0.3, free, 3, 0))

    reports = reports_of(search)
    shares = [share for _, share in reports]
    assert len(reports) > 3 * LOOKS
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] <= shares[-1] <= 1.0
    search()
    assert optima[0].values == optima[1].values


@given(st.floats(1e-6, 1e9), st.integers(25, 1000))
def test_evidence_left_has_an_estimate_that_ends_with_it(grows: float, points: int) -> None:
    left = _Left(points)

    class Results:
        delta_logz = grows

    ((text, share),) = reports_of(lambda: left(Results, 100, 500, dlogz=0.1))
    assert "500 evaluations" in text
    assert isfinite(share)
    assert 0.0 < share <= 1.0
    assert (share == 1.0) == (grows <= 0.1)


def test_the_runs_of_a_sweep_are_told() -> None:
    over, short = {"contact.clearance": [1e-6, 2e-6]}, ["solver.duration=1e-4"]
    reports = reports_of(lambda: cl.sweep(over, short, metrics=["contact_count"], workers=1))
    assert [what for what, _ in reports] == ["run 1: ", "run 2: "]
