"""The judge of the random flights sees what an engine does wrong: one that misses, invents or is late."""

from types import SimpleNamespace

import numpy as np
import pytest

from contactlab.testing.flights import randomly
from contactlab.testing.flights.closed import Flight
from contactlab.testing.flights.randomly import DURATION, judge, random_flight

NUMBER = 3


def drawn(touches: bool) -> Flight:
    """The first of the random flights that touches, or that does not."""
    for number in range(100):
        _, flight = random_flight(0, number)
        if (flight.first_touch(DURATION) is not None) == touches:
            return flight
    raise AssertionError("All of a hundred flights are alike.")


def engine_that_finds(
    monkeypatch: pytest.MonkeyPatch, *starts: float, complete: bool = True
) -> None:
    """Put an engine in place that finds touch-downs at these times [s], whatever flies."""
    run = SimpleNamespace(
        contacts={"start_time": np.array(starts)},
        statistics={"flight_steps": 10},
        complete=complete,
        message="It stopped.",
    )
    monkeypatch.setattr(randomly, "simulate", lambda *_, **__: run)


def test_a_touch_down_where_it_is_counts_as_right(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = drawn(touches=True)
    expected = flight.first_touch(DURATION)
    assert expected is not None
    engine_that_finds(monkeypatch, expected, expected + 1e-5)
    tally = judge(flight, NUMBER)
    assert (tally.flights, tally.touched, tally.faults) == (1, 1, 0)


def test_a_touch_down_that_is_not_found_is_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    engine_that_finds(monkeypatch)
    tally = judge(drawn(touches=True), NUMBER)
    assert (tally.touched, tally.missed, tally.invented, tally.late) == (1, 1, 0, 0)
    assert (tally.faults, tally.worst) == (1, NUMBER)


def test_a_touch_down_of_a_flight_that_stays_open_is_invented(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flight = drawn(touches=False)
    engine_that_finds(monkeypatch, 1e-4)
    tally = judge(flight, NUMBER)
    assert (tally.touched, tally.missed, tally.invented, tally.late) == (0, 0, 1, 0)
    assert (tally.faults, tally.worst) == (1, NUMBER)
    engine_that_finds(monkeypatch)
    assert judge(flight, NUMBER).faults == 0


@pytest.mark.parametrize(("error", "counts"), [(1e-9, (0, 1)), (-1e-9, (1, 0))])
def test_a_nanosecond_too_late_is_late_and_too_early_is_invented(
    error: float, counts: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = drawn(touches=True)
    expected = flight.first_touch(DURATION)
    assert expected is not None
    engine_that_finds(monkeypatch, expected + error)
    tally = judge(flight, NUMBER)
    assert (tally.invented, tally.late) == counts
    assert tally.largest_error == pytest.approx(1e-9, rel=1e-6)
    assert (tally.missed, tally.faults, tally.worst) == (0, 1, NUMBER)


def test_a_run_that_gives_up_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    engine_that_finds(monkeypatch, complete=False)
    with pytest.raises(RuntimeError, match=r"Flight 3 did not reach its end\. It stopped\."):
        judge(drawn(touches=False), NUMBER)
