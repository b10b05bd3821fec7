"""A run that goes on from another's state is the run that was never cut, bit for bit."""

import pickle
from functools import cache

import numpy as np
import pytest
from support.motors import case_a, every_law

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, MoreauJean, Newton
from contactlab.laws.composed import Composed
from contactlab.laws.friction import LuGre, Mindlin, Regularised
from contactlab.motor.motor import Motor
from contactlab.trajectory import Trajectory

INTERVAL = 1e-6
WHOLE = 2e-3

FAMILIES = [
    *every_law(),
    MoreauJean(),
    Newton(),
    *(Composed(friction=friction) for friction in (Mindlin(), LuGre(), Regularised())),
]
"""Penalty and multiplier laws, those that project and those that do not, and every kind of friction."""

laws = pytest.mark.parametrize("law", FAMILIES, ids=lambda law: law.title)


def run(law: ContactLaw, duration: float, motor: Motor | None = None, **options: object) -> Trajectory:
    options.setdefault("record_interval", INTERVAL)
    return simulate(motor or case_a(), law, duration=duration, **options)  # type: ignore[arg-type]


@cache
def uncut(law: ContactLaw) -> Trajectory:
    return run(law, WHOLE)


def cuts(law: ContactLaw) -> dict[str, int]:
    """Records at which the run is in flight, in contact, and in stick where the law sticks."""
    modes = uncut(law).contact_mode
    # Not the first of its kind: much has happened before.
    result = {name: np.flatnonzero(modes == mode) for mode, name in enumerate(("flight", "slip", "stick"))}
    return {name: int(at[2 * at.size // 3]) for name, at in result.items() if at.size}


def assert_goes_on(whole: Trajectory, first: Trajectory, second: Trajectory, at: int) -> None:
    assert second.complete
    assert np.array_equal(second.time, whole.time[at:])
    assert np.array_equal(second.contact_mode, whole.contact_mode[at:])
    for name, values in whole.series.items():
        assert np.array_equal(second.series[name], values[at:]), name
    finished = int(np.isfinite(first.contacts["separation_velocity"]).sum())
    for name, values in whole.contacts.items():
        assert np.array_equal(second.contacts[name], values[finished:], equal_nan=True), name
        assert np.array_equal(first.contacts[name][:finished], values[:finished]), name
    assert second.statistics == whole.statistics


@laws
def test_a_run_cut_in_flight_in_contact_and_in_stick_is_the_uncut_run(law: ContactLaw) -> None:
    whole = uncut(law)
    # Impacts that rebound take no time.
    lasts = whole.contacts["duration"].any()
    assert "flight" in cuts(law)
    assert not lasts or len(cuts(law)) > 1
    for at in cuts(law).values():
        first = run(law, at * INTERVAL)
        second = run(law, WHOLE - at * INTERVAL, start=pickle.loads(pickle.dumps(first.state)))
        assert_goes_on(whole, first, second, at)


def test_states_that_cannot_go_on_are_refused() -> None:
    law = every_law()[0]
    state = uncut(law).state
    with pytest.raises(TypeError, match="state"):
        run(law, 1e-5, start={"time": 1.0})
    with pytest.raises(ValueError, match="modes"):
        run(law, 1e-5, start={**state, "q": np.zeros(2), "v": np.zeros(2)})
    with pytest.raises(ValueError, match="state"):
        run(law, 1e-5, start={**state, "ending": 1})
    other = next(each for each in every_law() if each.__class__.__bases__ != law.__class__.__bases__)
    touching = run(law, cuts(law).get("slip", cuts(law).get("stick", 0)) * INTERVAL).state
    with pytest.raises(ValueError, match="law"):
        run(other, 1e-5, start=touching)
