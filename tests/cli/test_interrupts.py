"""Ctrl-C comes out where a run can stand it."""

import signal
import subprocess
import sys
import threading
import time

import pytest

from contactlab.cli import terminal


class EndedError(Exception):
    """Stands for the end of the process."""


@pytest.fixture(autouse=True)
def _end_is_an_exception(monkeypatch: pytest.MonkeyPatch) -> None:
    def end(status: int) -> None:
        raise EndedError(status)

    monkeypatch.setattr("os._exit", end)


def press_ctrl_c() -> None:
    signal.raise_signal(signal.SIGINT)


def test_ctrl_c_ends_a_start_at_once_with_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with terminal.ending_at_once(), pytest.raises(EndedError, match="130"):
        press_ctrl_c()
    assert capsys.readouterr().err


def test_ctrl_c_waits_for_the_next_look() -> None:
    with terminal.waiting() as look:
        look()
        press_ctrl_c()
        with pytest.raises(KeyboardInterrupt):
            look()
        look()


def test_ctrl_c_after_the_last_look_is_not_lost() -> None:
    def simulate() -> None:
        with terminal.waiting() as look:
            look()
            press_ctrl_c()

    with pytest.raises(KeyboardInterrupt):
        simulate()


def test_ctrl_c_before_the_first_look_or_twice_ends_at_once() -> None:
    with terminal.waiting() as look:
        with pytest.raises(EndedError):
            press_ctrl_c()
        look()
        press_ctrl_c()
        with pytest.raises(EndedError):
            press_ctrl_c()
        with pytest.raises(KeyboardInterrupt):
            look()


def test_ctrl_c_raises_while_files_are_written() -> None:
    with terminal.ending_at_once(), terminal.raising(), pytest.raises(KeyboardInterrupt):
        press_ctrl_c()


def test_handlers_are_restored_and_an_ignored_ctrl_c_stays_ignored() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with terminal.ending_at_once(), terminal.waiting() as look:
            press_ctrl_c()
            look()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    with terminal.ending_at_once():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before


def test_threads_other_than_the_main_one_leave_ctrl_c_alone() -> None:
    seen = []

    def work() -> None:
        with terminal.waiting() as look:
            look()
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [signal.getsignal(signal.SIGINT)]


AGAIN = """
import atexit, os, signal, sys
from contactlab.cli import main
atexit.register(os.kill, os.getpid(), signal.SIGINT)
def interrupted(*line):
    raise KeyboardInterrupt("Interrupted.")
main._perform = interrupted
refuse = main.refuse
def slowly(*arguments):
    if {meanwhile}:
        os.kill(os.getpid(), signal.SIGINT)
    return refuse(*arguments)
main.refuse = slowly
sys.exit(main.main())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to send.")
@pytest.mark.parametrize("meanwhile", [True, False], ids=["as it ends", "once it has ended"])
def test_a_second_ctrl_c_has_the_status_of_the_first(meanwhile: bool) -> None:
    line = [sys.executable, "-c", AGAIN.format(meanwhile=meanwhile)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 130, done.stderr
    assert "Traceback" not in done.stderr


ENDLESS = """
import time
from contactlab.cli import terminal
from contactlab.compiler.kernels import kernel

@kernel
def endless(x):
    while x > 0.0:
        x += 1.0
    return x

with terminal.ending_stuck(), terminal.ending_at_once():
    endless(-1.0)
    print("begun", flush=True)
    endless(1.0)
"""


def test_a_second_ctrl_c_ends_a_process_whose_compiled_code_does_not_return() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", ENDLESS], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"begun\n"
        for _ in range(2):
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == terminal.INTERRUPTED
    assert err.strip()
