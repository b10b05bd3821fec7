"""An orbit alone: its series, impacts and powers are those of the study, and a search can be stopped."""

import threading

import numpy as np
import pytest

import contactlab as cl
from contactlab.interrupts import raise_if_stopped, stopped_by

RIGID = cl.build(["law=newton"])


@pytest.fixture(scope="module")
def state() -> cl.steady_state.Steady:
    return cl.orbit(RIGID)


def test_the_orbit_is_that_of_the_study(state: cl.steady_state.Steady) -> None:
    result = cl.steady(RIGID)
    assert state.velocity.value == result.velocity.value
    assert np.array_equal(state.multipliers, result.details.multipliers)


def test_energy_flows_of_an_orbit_balance(state: cl.steady_state.Steady) -> None:
    lost = sum(power for name, power in state.energy.items() if name != "drive_work")
    assert state.energy["drive_work"] == pytest.approx(lost, rel=1e-6)


def test_an_impact_has_the_impulse_that_the_velocities_of_the_gap_take(state: cl.steady_state.Steady) -> None:
    impacts, series = state.impacts, state.series(2000)
    assert impacts["phase"].size == 1
    # The mean force over an orbit is its impulse over its period.
    assert impacts["normal_impulse"].sum() == pytest.approx(
        state.average("normal_force").value * state.period, rel=1e-9
    )
    # Where it lies the gap is closed, and nowhere else.
    closed = series["phase"][series["gap"].argmin()]
    assert abs(closed - impacts["phase"][0]) < 1e-3


def test_series_are_one_period_that_closes(state: cl.steady_state.Steady) -> None:
    series = state.series(300)
    assert series["phase"].size == series["gap"].size == 301
    assert np.ptp(series["phase"]) == pytest.approx(1.0, rel=1e-12)
    for name in ("gap", "tip_tangential_displacement", "rotor_velocity"):
        scale = np.abs(series[name]).max()
        assert series[name][-1] == pytest.approx(series[name][0], abs=1e-6 * scale)


def test_without_an_orbit_there_are_no_multipliers() -> None:
    state = cl.orbit(RIGID.with_({"contact.clearance": 1e-4}))
    assert state.kind == "without contact"
    assert state.multipliers.size == state.impacts["phase"].size == 0


def test_a_stop_ends_a_search_a_study_and_a_branch() -> None:
    event = threading.Event()
    event.set()
    for compute in (cl.orbit, cl.steady):
        with pytest.raises(cl.StoppedError):
            compute(RIGID, stop=event)
    looks = []
    # A hundred looks later it is in the middle of the branch.
    with pytest.raises(cl.StoppedError):
        cl.branch(RIGID, "drive.phase", -0.6, 0.6, stop=lambda: looks.append(0) or len(looks) > 100)
    assert len(looks) == 101


def test_a_stopped_run_keeps_what_there_is() -> None:
    run = cl.simulate(RIGID, duration=10.0, record_interval=1e-3, stop=lambda: True)
    assert run.ending is cl.Ending.INTERRUPTED
    assert 0.0 < run["time"][-1] < 1.0
    whole = cl.simulate(RIGID, duration=2e-3, stop=lambda: False)
    assert whole.ending is cl.Ending.COMPLETE


def test_a_stop_counts_within_its_body_and_thread() -> None:
    with stopped_by(lambda: True):
        with pytest.raises(cl.StoppedError):
            raise_if_stopped()
        other = threading.Thread(target=raise_if_stopped)
        other.start()
        other.join()
    raise_if_stopped()
    with pytest.raises(TypeError, match="stop"), stopped_by("now"):  # type: ignore[arg-type]
        pass


def test_a_law_that_is_warm_compiles_nothing() -> None:
    cl.warm(cl.Newton())
    shown: list[object] = []
    assert cl.warm(cl.Newton(), progress=lambda *what: shown.append(what)) == []
    with pytest.raises(TypeError, match="law"):
        cl.warm("newton")  # type: ignore[arg-type]
