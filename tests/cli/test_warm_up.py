"""The engine compiled ahead, and the messages while one waits for the compiler."""

import gc
import sys
from itertools import product
from types import SimpleNamespace
from typing import Any

import pytest
from support.command_line import Command, left_behind

from contactlab.compiler import notice as compilation
from contactlab.compiler.notice import Compiled
from contactlab.engine.compiled_loops import name_of, units_of


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """Times of the wall and of the processor [s]."""
    now = {"wall": 100.0, "processor": 10.0}
    monkeypatch.setattr(compilation, "perf_counter", lambda: now["wall"])
    monkeypatch.setattr(compilation, "process_time", lambda: now["processor"])
    return now


def made(name: str) -> Any:
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(__name__=name)})


@pytest.mark.long
def test_every_kind_of_law_is_warmed_up_and_then_there(command: Command) -> None:
    command("warm-up")
    status, out, err = command("warm-up")
    assert (status, err) == (0, "")
    *kinds, _ = out.splitlines()
    every = (name_of(units_of(*each), plain) for *each, plain in product((True, False), repeat=3))
    assert {line.rpartition("  ")[2] for line in kinds} == {*every}
    assert all(line.startswith("loaded") for line in kinds)
    assert left_behind() == []


def test_the_first_function_announces_what_is_compiled_and_the_end_tells_how_long_it_took(
    clocks: dict[str, float], capsys: pytest.CaptureFixture[str]
) -> None:
    compiled = Compiled("the engine for rigid laws", 20.0)
    assert capsys.readouterr().err == ""
    compiled.on_start(made("one"))
    text = "contactlab: compiling the engine for rigid laws, once for an installation: about 20 s.\n"
    assert capsys.readouterr().err == text
    for name in ("one", "two"):
        clocks["wall"] += 8.0
        compiled.on_start(made(name))
        compiled.on_end(made(name))
    compiled.close()
    assert capsys.readouterr().err == "contactlab: compiled in 16 s.\n"


def test_without_a_compilation_nothing_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    Compiled("the engine", 20.0).close()
    assert capsys.readouterr().err == ""


def test_a_terminal_shows_how_far_it_is_at_the_pace_of_a_shared_processor(
    clocks: dict[str, float], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    compiled = Compiled("the engine", 20.0)
    compiled.on_start(made("step_flight"))
    # Half of the processor: the rest takes twice the time.
    clocks["wall"] += 10.0
    clocks["processor"] += 5.0
    compiled.on_end(made("step_flight"))
    compiled.close()
    assert " 25 %|" in (err := capsys.readouterr().err)
    assert "10 of about 40 s, step_flight" in err


def test_garbage_is_collected_again_when_the_compiler_has_ended() -> None:
    with compilation.telling():
        assert not gc.isenabled()
    assert gc.isenabled()
