"""The engine compiled ahead, and what is told while one waits for the compiler."""

import gc
import sys
from types import SimpleNamespace
from typing import Any

import pytest
from numba.core import event
from support.command_line import Command, left_behind

from contactlab import compilation
from contactlab.cli.warm_up import LAWS
from contactlab.compilation import Compiled
from contactlab.compiled import is_compiled
from contactlab.engine import impact, loop
from contactlab.laws import HertzPenalty


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """Times of the wall and of the processor [s]."""
    now = {"wall": 100.0, "processor": 10.0}
    monkeypatch.setattr(compilation, "perf_counter", lambda: now["wall"])
    monkeypatch.setattr(compilation, "process_time", lambda: now["processor"])
    return now


def made(name: str) -> Any:
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(__name__=name)})


def test_every_loop_is_warmed_up_by_a_law_of_its_own() -> None:
    assert {f"{what}_{kind}" for what in ("advance", "strike") for kind in LAWS} == loop.KINDS.keys()
    assert all(hasattr(loop, name) or hasattr(impact, name) for name in loop.KINDS)


@pytest.mark.long
def test_what_is_compiled_already_is_loaded_without_a_word_of_the_compiler(command: Command) -> None:
    if not all(map(is_compiled, loop.KINDS)):
        command("warm-up")
    status, out, err = command("warm-up")
    assert (status, err) == (0, "")
    *loops, last = out.splitlines()
    assert {line.partition("  ")[0] for line in loops} == {words for words, _ in loop.KINDS.values()}
    assert all("was there, loaded in " in line for line in loops)
    assert last.startswith("The engine is ready after ")
    assert left_behind() == []


def test_a_loop_that_is_not_there_is_told_as_compiled(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(overrides: list[str]) -> Any:
        def run(**_: float) -> None:
            if overrides == LAWS["rigid"]:
                event.end_event("numba:compile", made("advance_rigid").data)

        return SimpleNamespace(run=run, law=HertzPenalty())

    monkeypatch.setattr("contactlab.config.build", build)
    _, out, _ = command("warm-up")
    told = [line.partition("  ")[0] for line in out.splitlines() if "compiled in" in line]
    assert told == [loop.KINDS["advance_rigid"][0]]


def test_the_first_function_announces_what_is_compiled_and_the_end_tells_how_long_it_took(
    clocks: dict[str, float], capsys: pytest.CaptureFixture[str]
) -> None:
    compiled = Compiled("the engine for rigid laws", 20.0)
    assert capsys.readouterr().err == ""
    compiled.on_start(made("one"))
    said = "contactlab: compiling the engine for rigid laws, once for an installation: about 20 s.\n"
    assert capsys.readouterr().err == said
    for name in ("one", "two"):
        clocks["wall"] += 8.0
        compiled.on_start(made(name))
        compiled.on_end(made(name))
    compiled.close()
    assert capsys.readouterr().err == "contactlab: compiled 2 functions in 16 s.\n"


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


def test_the_time_that_is_told_is_that_of_what_is_not_there_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    there: set[str] = set()
    monkeypatch.setattr(loop, "is_compiled", there.__contains__)
    alone = {name: loop._usual_time(name) for name in loop.KINDS}
    there.add("advance_compliant")
    assert loop._usual_time("advance_rigid") == alone["advance_rigid"] - loop.SHARED
    with_memory = "advance_rigid_with_memory"
    assert loop._usual_time(with_memory) == alone[with_memory] - loop.SHARED
    there.add("advance_compliant_with_memory")
    assert loop._usual_time(with_memory) == loop.KINDS[with_memory][1]


def test_garbage_is_collected_again_when_the_compiler_has_ended() -> None:
    with compilation.telling():
        assert not gc.isenabled()
    assert gc.isenabled()
