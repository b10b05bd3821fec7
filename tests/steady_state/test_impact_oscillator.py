"""Period maps, branches and events against what is published of the oscillator with a stop."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from oscillator_with_stop import ImpactOscillator, doubling_between
from scipy.optimize import brentq

from contactlab.steady_state.continuation import Followed, Mark, follow
from contactlab.steady_state.period_map import PeriodMap
from contactlab.steady_state.shooting import Orbit, orbit_from


def oscillator(frequency: float) -> ImpactOscillator:
    return ImpactOscillator(stop=0.0, restitution=0.8, force=1.0, frequency=frequency)


def damped(stop: float) -> ImpactOscillator:
    return ImpactOscillator(stop, restitution=0.8, force=1.0, frequency=2.8, damping=0.1)


def ball(force: float) -> ImpactOscillator:
    return ImpactOscillator(0.0, restitution=0.5, force=force, frequency=1.0, stiffness=0.0, weight=1.0)


def orbit_of(plant: ImpactOscillator, number: int = 0) -> Orbit:
    phase, z = plant.impacts()[number].later(0.5)
    section = PeriodMap(plant.setup(), phase=phase, belt=0.0)
    return orbit_from(section, z * np.append(section.scale, 1.0))


def branch(family: Callable[[float], ImpactOscillator], start: float, end: float) -> Followed:
    first = orbit_of(family(start))
    return follow(lambda value: PeriodMap(family(value).setup(), belt=0.0), first, start, end, step=0.1)


@pytest.fixture(scope="module")
def bouncing() -> Followed:
    return branch(ball, 1.9, 1.0)


def only(branch: Followed, mark: Mark) -> float:
    (event,) = [point for point in branch.points if point.mark is mark]
    return event.value


@pytest.mark.parametrize(
    ("plant", "number"),
    [(oscillator(2.55), 0), (oscillator(2.9), 0), (damped(0.05), 0), (ball(1.3), 0), (ball(1.3), 1)],
)
def test_a_motion_of_one_impact_has_the_multipliers_of_the_closed_form(
    plant: ImpactOscillator, number: int
) -> None:
    """Trace and determinant, of stable motions and of others; an impact is as sharp as its step."""
    impact, orbit = plant.impacts()[number], orbit_of(plant, number)
    trace, determinant = np.trace(impact.jacobian), np.linalg.det(impact.jacobian)
    assert np.sum(orbit.multipliers).real == pytest.approx(trace, rel=1e-6)
    assert np.prod(orbit.multipliers).real == pytest.approx(determinant, rel=1e-6)
    (speed,) = -orbit.map.run(orbit.state).contacts["approach_velocity"]
    assert speed == pytest.approx(impact.speed, rel=1e-7)


def test_the_period_of_the_oscillator_doubles_where_shaw_and_holmes_say() -> None:
    """Where 1 + tr + det = 0, and the other multiplier is e^2 there, without damping, negative."""
    result = branch(oscillator, 2.6, 2.7)
    published = doubling_between(oscillator, 2.6, 2.7)
    assert only(result, Mark.PERIOD_DOUBLING) == pytest.approx(published, rel=1e-6)
    assert published == pytest.approx(2.653348, abs=1e-6)
    event = next(point for point in result.points if point.mark)
    assert np.sort(event.orbit.multipliers.real) == pytest.approx([-1.0, -(0.8**2)], abs=1e-6)


def test_motions_beside_an_orbit_grow_from_the_doubling_on() -> None:
    """By runs alone: how fast a deviation along the multiplier at -1 grows passes through zero there."""

    def growth(frequency: float) -> float:
        orbit = orbit_of(oscillator(frequency))
        values, vectors = np.linalg.eig(orbit.jacobian)
        z = orbit.state + 1e-6 * np.linalg.norm(orbit.state) * vectors[:, np.argmin(values.real)].real
        ends = (orbit.map.end_of(orbit.map.run(z, periods)) for periods in (21, 41))
        early, late = (float(np.linalg.norm(end - orbit.state)) for end in ends)
        return np.log(late / early)

    event = only(branch(oscillator, 2.64, 2.66), Mark.PERIOD_DOUBLING)
    assert brentq(growth, 2.64, 2.66, xtol=1e-9) == pytest.approx(event, rel=1e-6)


def test_a_pair_of_multipliers_leaves_the_circle_where_the_oscillator_gains_what_its_impact_loses() -> None:
    """With a negative damping c, at det = e^2 exp(-c T) = 1: a torus begins (Neimark and Sacker)."""

    def driven(frequency: float) -> ImpactOscillator:
        return replace(oscillator(frequency), damping=-0.15)

    result = branch(driven, 2.2, 2.09)
    assert only(result, Mark.NEIMARK_SACKER) == pytest.approx(np.pi * -0.15 / np.log(0.8), rel=1e-9)
    for point in result.points:
        determinant = 0.8**2 * np.exp(0.15 * driven(point.value).period)
        assert np.abs(point.orbit.multipliers) == pytest.approx(np.sqrt(determinant), rel=1e-6)
        assert point.mark or point.orbit.stable == (determinant < 1.0)


def test_the_ball_doubles_its_period_and_folds_where_the_closed_form_says(bouncing: Followed) -> None:
    """The fold is that of Guckenheimer and Holmes, the doubling that of a table that moves on meanwhile."""
    assert only(bouncing, Mark.PERIOD_DOUBLING) == pytest.approx(ball(1.0).ball_doubles_at, rel=1e-6)
    assert only(bouncing, Mark.FOLD) == pytest.approx(ball(1.0).ball_begins_at, rel=1e-6)


def test_a_branch_goes_through_a_fold_and_comes_back_unstable(bouncing: Followed) -> None:
    """It ends at the force where it began, in the other motion of the closed form."""
    last = bouncing.points[-1]
    assert last.value == pytest.approx(1.9, rel=1e-12)
    expected = np.linalg.eigvals(ball(1.9).impacts()[1].jacobian)
    assert np.sort(last.orbit.multipliers.real) == pytest.approx(np.sort(expected), rel=1e-6)
    assert bouncing.end.startswith("It ends where the range of the parameter does, at 1.9")


def test_a_branch_of_impacts_ends_in_the_grazing_of_the_motion_without() -> None:
    """The impact loses its speed where the stop stands at the amplitude |X| of the response."""
    result = branch(damped, 0.1, 0.16)
    grazing = damped(0.0).grazing_stop
    assert result.points[-1].value == pytest.approx(grazing, rel=1e-2)
    assert "1 contact a period, 0 within 0.0001 of its state" in result.end
    reported = float(result.end.partition("without speed at ")[2].partition(":")[0])
    assert reported == pytest.approx(grazing, rel=1e-6)


def test_a_motion_that_swings_free_ends_where_it_reaches_the_stop() -> None:
    """The orbit without impact is no orbit any more, to the digits that the sentence has."""
    section = PeriodMap(damped(0.2).setup(), belt=0.0)
    response = damped(0.2).response
    free = orbit_from(section, np.array([response.real, -2.8 * response.imag]))
    result = follow(lambda stop: PeriodMap(damped(stop).setup(), belt=0.0), free, 0.2, 0.1)
    assert "0 contacts a period before and would have 1 beyond" in result.end
    reported = float(result.end.partition("ends at ")[2].partition(" ")[0])
    assert reported == pytest.approx(damped(0.0).grazing_stop, rel=1e-6)
