"""Means of long runs have an error that holds, and the kinds of known motions are distinguished."""

import numpy as np
import pytest

import contactlab as cl
from contactlab.settling.statistics import (
    chaos_indicator,
    cycle_of,
    kind_without_period,
    mean_with_error,
    trend,
)


def autoregressive(memory: float, size: int, seed: int) -> np.ndarray:
    """A sequence of mean 1 whose correlation falls by e over `memory` values."""
    rng, share = np.random.default_rng(seed), np.exp(-1.0 / memory)
    values = np.empty(size)
    values[0] = rng.normal() / np.sqrt(1.0 - share**2)
    for i, kick in enumerate(rng.normal(size=size - 1)):
        values[i + 1] = share * values[i] + kick
    return 1.0 + values


@pytest.mark.parametrize("cycle", [1, 2, 3, 4])
def test_a_cycle_is_seen_through_a_drift(cycle: int) -> None:
    places = np.arange(60)
    drift = np.exp(-places / 100.0)[:, None]
    # One of the cycle's states differs from the others by a fifth of what the drift has left.
    states = drift + np.where(places % cycle == 0, 0.2, 0.0)[:, None]
    assert cycle_of(states, 1e-3) == cycle


@pytest.mark.parametrize("memory", [0.1, 5.0, 40.0])
def test_the_error_of_a_mean_holds_in_nineteen_of_twenty_cases(memory: float) -> None:
    result = [mean_with_error(autoregressive(memory, 2000, seed)) for seed in range(200)]
    inside = np.mean([abs(mean - 1.0) <= error for mean, error in result])
    assert inside > 0.88
    # And is no larger than it has to be.
    share = np.exp(-1.0 / memory)
    spread = 1.0 / (1.0 - share) / np.sqrt(2000)
    assert np.median([error for _, error in result]) < 3.0 * spread


def test_a_constant_has_no_error_and_a_line_has_its_slope() -> None:
    assert mean_with_error(np.full(100, 3.0)) == (3.0, 0.0)
    change, error = trend(np.linspace(0.0, 2.0, 400) + 1e-3 * np.random.default_rng(0).normal(size=400))
    assert change == pytest.approx(2.0, abs=3.0 * error)
    assert error < 1e-3


def test_what_stands_still_is_regular() -> None:
    with np.errstate(all="raise"):
        assert chaos_indicator(np.zeros(1000)) == chaos_indicator(np.full(1000, 1.7)) == 0.0


@pytest.mark.parametrize("count", [240, 480, 1000, 2000])
@pytest.mark.parametrize("beat", [30.1, 60.1, 100.1])
def test_a_slow_beat_is_never_called_chaotic(count: int, beat: float) -> None:
    steps = 2.0 * np.pi * np.arange(count)
    values = np.sin((np.sqrt(5.0) - 1.0) * steps + 3.0 * np.sin(steps / beat))
    assert kind_without_period(values[:, None]) != "chaotic"


@pytest.mark.parametrize("still", [0, 1])
def test_the_kind_is_that_of_what_moves_most(still: int) -> None:
    """A quantity that stands still, but for round-off, has no say."""
    steps = np.arange(2000)
    states = np.column_stack([np.sin(np.pi * (np.sqrt(5.0) - 1.0) * steps), np.zeros(2000)])
    states[:, 1] = 1e-12 * np.random.default_rng(0).normal(size=2000)
    assert kind_without_period(states[:, [still, 1 - still]]) == "quasi-periodic"


@pytest.mark.filterwarnings("error")
def test_an_oscillator_that_does_not_slide_has_the_kind_of_its_motion() -> None:
    """Driven and undamped, on an elastic stop: the free vibration is never forgotten, two tones stay."""
    motor = cl.oscillator(gap=0.1, force=1.0, frequency=2.8 / (2.0 * np.pi))
    assert cl.steady(motor, cl.HertzPenalty(), longest=2000).details.kind == "quasi-periodic"


@pytest.mark.long
def test_means_of_an_irregular_motor_hold_against_a_run_ten_times_as_long() -> None:
    setup = cl.build(["law=lagrange_slip", "solver.contact_step=2e-7"])
    short = cl.steady(setup, longest=1500)
    assert short.orbit is None
    mean, error = short.velocity
    periods, period = short.motion.time.size - 1, short.period
    long = setup.run(duration=11 * periods * period, record_interval=period).series["rotor_angle"]
    better = (long[-1] - long[periods]) / (10 * periods * period)
    assert 0.0 < error < 0.01 * abs(mean)
    assert abs(mean - better) < error
