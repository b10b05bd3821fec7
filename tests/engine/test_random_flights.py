"""No touch-down of random flights is missed, late or invented, and the judge would see it."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from support import flights
from support.flights import DURATION, FAULTS, KINDS, Flight, judge, judged, random_flight, tally

from contactlab.testing import plants
from contactlab.trajectory import Ending, Trajectory

FLIGHTS = 300


@cache
def rows() -> pd.DataFrame:
    return judged(0, range(FLIGHTS))


@pytest.mark.parametrize("kind", KINDS)
def test_no_touch_down_is_missed_late_or_invented(kind: str) -> None:
    result = tally(rows()).loc[kind]
    assert result["flights"] > 0.1 * FLIGHTS
    # The claim is about both: flights that touch and flights that do not.
    assert 0.2 * result["flights"] < result["touched"] < result["flights"]
    assert [result[fault] for fault in FAULTS] == [0, 0, 0], result


def test_grazes_are_within_a_nanometre_of_touching() -> None:
    depths = []
    for number in range(80):
        kind, flight = random_flight(0, number)
        if kind not in ("any clearance", "resonance"):
            _, gaps = flight.minima(1e-3)
            depths.append(float(abs(gaps).min()))
    assert len(depths) > 20
    assert max(depths) < 1e-9
    assert min(depths) < 1e-12


@cache
def drawn(touches: bool) -> Flight:
    """The first of the random flights that touches, or that does not."""
    several = (random_flight(0, number)[1] for number in range(100))
    return next(f for f in several if (f.first_touch(DURATION) is not None) == touches)


def faults_of(monkeypatch: pytest.MonkeyPatch, flight: Flight, *starts: float) -> set[str]:
    """What the judge finds wrong with an engine that finds touch-downs at these times [s]."""
    made = SimpleNamespace(contacts={"start_time": np.array(starts)}, statistics={"flight_steps": 10})
    monkeypatch.setattr(flights, "run", lambda *_: made)
    result = judge(flight)
    assert result["touched"] == (flight.first_touch(DURATION) is not None)
    return {fault for fault in FAULTS if result[fault]}


def test_the_judge_sees_what_an_engine_does_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    touching, open_gap = drawn(touches=True), drawn(touches=False)
    when = touching.first_touch(DURATION)
    assert when is not None
    assert faults_of(monkeypatch, touching, when, when + 1e-5) == set()
    assert faults_of(monkeypatch, touching) == {"missed"}
    assert faults_of(monkeypatch, touching, when + 1e-9) == {"late"}
    assert judge(touching)["error"] == pytest.approx(1e-9, rel=1e-6)
    assert faults_of(monkeypatch, touching, when - 1e-9) == {"invented"}
    assert faults_of(monkeypatch, open_gap, 1e-4) == {"invented"}
    assert faults_of(monkeypatch, open_gap) == set()


def test_a_flight_whose_run_gives_up_is_named_and_no_verdict_is_made_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    simulate, made = plants.simulate, []

    def gives_the_third_up(*motor_and_law: Any, **named: Any) -> Trajectory:
        run = simulate(*motor_and_law, **named)
        made.append(run)
        if len(made) < 3:
            return run
        return replace(run, ending=Ending.STALLED, message="Its steps do not advance.")

    monkeypatch.setattr(plants, "simulate", gives_the_third_up)
    with pytest.raises(RuntimeError, match="Flight 7 of seed 3"):
        judged(3, range(5, 9))
    assert len(made) == 3
