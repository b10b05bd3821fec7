"""An oscillator beside a stop that swings free or hits it, by closed forms: branch, fold, saddle and basins.

The motions of one impact a period are the two roots of a quadratic equation for the impact's speed. They meet
in a fold, beyond the stop that the free motion just reaches; between both stops the faster one and the free
motion are stable, and the slower one is a saddle.
"""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from oscillator_with_stop import ImpactOscillator

import contactlab as cl
from contactlab.laws import ContactLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import LinearDamping, damping_coefficient
from contactlab.laws.friction import Coulomb
from contactlab.laws.normal import Linear
from contactlab.steady_state.basins import basins, is_neutral
from contactlab.steady_state.continuation import Followed, Mark, follow
from contactlab.steady_state.period_map import PeriodMap
from contactlab.steady_state.shooting import Orbit, orbit_from

FAST, SLOW = 0, 1
"""Motions of one impact, by their place in `ImpactOscillator.impacts`."""

BETWEEN = 0.9
"""A stop at which there are all three [m]."""


def plant(stop: float) -> ImpactOscillator:
    return ImpactOscillator(stop, restitution=0.8, force=1.0, frequency=1.7, damping=0.1)


def folds_at() -> float:
    """The stop at which the quadratic equation of `ImpactOscillator.impacts` has one root [m]."""
    it = plant(0.0)
    after = (np.eye(2) + it.restitution * it.flow)[:, 1]
    place, rate = np.linalg.solve(it.flow - np.eye(2), after)
    return float(abs(it.response) * np.hypot(1.0, it.frequency * place / rate))


def orbit_of(it: ImpactOscillator, number: int) -> Orbit:
    phase, z = it.impacts()[number].later(0.5)
    section = PeriodMap(it.setup(), phase=phase, belt=0.0)
    return orbit_from(section, z * np.append(section.scale, 1.0))


def start_of(it: ImpactOscillator, number: int) -> tuple[float, float]:
    """Displacement [m] and velocity [m/s] of a motion of one impact at phase zero of the drive."""
    impact = it.impacts()[number]
    _, (displacement, velocity) = impact.later(-impact.angle / (2.0 * pi) % 1.0)
    return displacement, velocity


@pytest.fixture(scope="module", params=[FAST, SLOW], ids=["from the fast one", "from the slow one"])
def loop(request: pytest.FixtureRequest) -> tuple[int, Followed]:
    """The branch from 0.6 m through the fold and back to it, begun with either of its ends."""
    first = orbit_of(plant(0.6), request.param)
    return request.param, follow(lambda s: PeriodMap(plant(s).setup(), belt=0.0), first, 0.6, 1.5, step=0.1)


def test_every_orbit_of_the_branch_is_a_motion_of_the_closed_form(loop: tuple[int, Followed]) -> None:
    """Its speed and its multipliers; beyond the fold it is the other one of the two."""
    number, branch = loop
    (fold,) = (i for i, point in enumerate(branch.points) if point.mark is Mark.FOLD)
    for i, point in enumerate(branch.points):
        if i == fold:
            continue
        impact = plant(point.value).impacts()[number if i < fold else 1 - number]
        assert point.softest == pytest.approx(impact.speed, rel=1e-8)
        assert np.sum(point.orbit.multipliers).real == pytest.approx(np.trace(impact.jacobian), rel=1e-5)
    assert branch.points[-1].value == pytest.approx(0.6, rel=1e-12)
    other = orbit_of(plant(0.6), 1 - number)
    speed = plant(0.6).impacts()[1 - number].speed
    assert branch.points[-1].softest == pytest.approx(speed, rel=1e-8)
    assert np.sort_complex(branch.points[-1].orbit.multipliers) == pytest.approx(
        np.sort_complex(other.multipliers), rel=1e-5
    )


def test_the_branch_changes_its_stability_where_a_multiplier_passes_through_one(
    loop: tuple[int, Followed],
) -> None:
    number, branch = loop
    (fold,) = (point for point in branch.points if point.mark)
    assert fold.value == pytest.approx(folds_at(), rel=1e-8)
    assert np.abs(fold.orbit.multipliers - 1.0).min() < 1e-4
    at = branch.points.index(fold)
    for i, point in enumerate(branch.points):
        if i != at:
            fast = (number == FAST) == (i < at)
            assert point.orbit.stable == fast
            assert (np.abs(point.orbit.multipliers) > 1.0).sum() == (not fast)


def test_motions_hit_the_stop_for_ever_up_to_the_fold_and_no_further() -> None:
    """By runs alone, bisected; beside a fold a motion that ends lasts as 1/sqrt of the distance from it."""
    phase, z = plant(1.234).impacts()[FAST].later(0.5)

    def hits(stop: float) -> bool:
        section = PeriodMap(plant(stop).setup(), phase=phase, belt=0.0)
        starts = section.run(z * np.append(section.scale, 1.0), 3000).contacts["start_time"]
        return bool(starts.size and starts[-1] > 2990.0 * section.period)

    low, high = 1.234, 1.24
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if hits(middle) else (low, middle)
    assert low == pytest.approx(folds_at(), rel=1e-5)


def test_the_fold_under_a_compliant_stop_tends_to_that_of_the_rigid_one() -> None:
    """With the time that a contact takes, 1/sqrt(k): what two stiffnesses leave is extrapolated."""

    def fold(stiffness: float) -> float:
        law = Composed(Linear(stiffness), LinearDamping(0.8, 1.0, 4.0), Coulomb(0.0))

        def section(stop: float) -> PeriodMap:
            it = plant(stop)
            return PeriodMap(cl.Setup.of(it.setup().motor, law, it.period), belt=0.0)

        phase, z = plant(1.15).impacts()[FAST].later(0.5)
        first = replace(section(1.15), phase=phase)
        settled = first.end_of(first.run(z * np.append(first.scale, 1.0), 30))
        branch = follow(section, orbit_from(first, settled), 1.15, 1.4, step=0.1)
        (event,) = (point for point in branch.points if point.mark)
        assert event.mark is Mark.FOLD
        return event.value

    soft, stiff = fold(6.4e7), fold(2.56e8)
    assert folds_at() - stiff == pytest.approx(0.5 * (folds_at() - soft), rel=1e-3)
    assert 2.0 * stiff - soft == pytest.approx(folds_at(), rel=1e-6)


def test_motions_leave_the_saddle_by_its_multiplier_to_either_stable_motion() -> None:
    it = plant(BETWEEN)
    saddle, fast = orbit_of(it, SLOW), orbit_of(it, FAST)
    values, vectors = np.linalg.eig(saddle.jacobian)
    away, rate = vectors[:, np.argmax(values.real)].real, values.real.max()
    size, section = 1e-6 * np.linalg.norm(saddle.state), saddle.map
    ends = []
    for side in (1.0, -1.0):
        z = saddle.state + side * size * away
        for periods in (4, 8):
            moved = section.end_of(section.run(z, periods)) - saddle.state
            assert moved == pytest.approx(side * size * rate**periods * away, abs=1e-2 * size * rate**periods)
        run = section.run(z, 200)
        ends.append(run.contacts["approach_velocity"][run.contacts["start_time"] > 199.0 * it.period])
    free, hitting = sorted(ends, key=np.size)
    assert free.size == 0
    assert -hitting == pytest.approx([it.impacts()[FAST].speed], rel=1e-9)
    assert fast.stable


@pytest.mark.parametrize("number", [FAST, SLOW])
def test_a_motion_that_starts_on_an_orbit_stays_on_it(number: int) -> None:
    """On a stable one for ever; on the saddle as long as what round-off leaves of it has not grown."""
    orbit = orbit_of(plant(BETWEEN), number)
    size = np.linalg.norm(orbit.state)
    for periods in (1, 5, 500) if number == FAST else (1, 5):
        left = orbit.map.end_of(orbit.map.run(orbit.state, periods)) - orbit.state
        assert np.linalg.norm(left) <= 1e-10 * size * max(1.0, orbit.largest**periods)


def test_the_boundary_of_both_basins_passes_through_the_saddle() -> None:
    """Two coordinates are all of the state, so that a start can be on an orbit, and beside the saddle."""
    it = plant(BETWEEN)
    displacement, velocity = start_of(it, SLOW)
    beside = np.array([-1e-3, -1e-6, 1e-6, 1e-3])
    across = {"tip_displacement": np.array([displacement]), "tip_velocity": velocity + beside}
    result = basins(it.setup(), across)
    kinds = [result.attractors[i].kind for i in result.labels[0]]
    assert sorted({*kinds}) == ["periodic", "without contact"]
    assert kinds[0] == kinds[1] != kinds[2] == kinds[3]

    free = it.response.real, -it.frequency * it.response.imag
    for (x, rate), kind in ((start_of(it, FAST), "periodic"), (free, "without contact")):
        map_of = basins(it.setup(), {"tip_displacement": np.array([x]), "tip_velocity": np.array([rate])})
        assert [each.kind for each in map_of.attractors] == [kind]
        assert map_of.shares == (1.0,)


def test_every_start_of_a_map_goes_where_its_own_run_goes_and_the_shares_add_up_to_one() -> None:
    """Nothing slides, so that no orbit brings the rotor's velocity back: to such a one no ball is drawn."""
    it = plant(BETWEEN)
    axes = {"tip_displacement": np.linspace(-4.0, 0.8, 6), "tip_velocity": np.linspace(-5.0, 5.0, 6)}
    result = basins(it.setup(), axes)
    assert result.unresolved == 0
    assert sum(result.shares) == pytest.approx(1.0, rel=1e-15)
    assert all(map(is_neutral, result.attractors))
    for i, x in enumerate(axes["tip_displacement"]):
        for j, rate in enumerate(axes["tip_velocity"]):
            run = it.setup(x, rate).run(duration=200.0 * it.period, record_interval=it.period)
            late = run.contacts["start_time"] > 190.0 * it.period
            kind = "periodic" if late.any() else "without contact"
            assert result.attractors[result.labels[i, j]].kind == kind
    assert result.to_xarray().identical(basins(it.setup(), axes).to_xarray())


def test_a_mass_that_is_always_pressed_on_follows_its_resonance_curve() -> None:
    """m xdd + c xd + k x = W + F cos(w t) in a contact of spring and dashpot, over the frequency.

    Its multipliers are exp(s T) with m s^2 + c s + k = 0, of every orbit from below the resonance to above.
    """
    it = replace(plant(0.0), stiffness=1e3, damping=1.0, weight=1e3, force=10.0, frequency=950.0)
    spring, dashpot = Linear(1e6), LinearDamping(0.9, 1.0, 0.1)
    law: ContactLaw = Composed(spring, dashpot, Coulomb(0.0))
    damping, stiffness = it.damping + damping_coefficient(dashpot, spring), it.stiffness + 1e6
    low, high = 950.0 / (2.0 * pi), 1050.0 / (2.0 * pi)
    arguments = {"law": law, "belt": 0.0, "step": 0.3}
    branch = cl.branch(it.setup().motor, "drive.frequency", low, high, **arguments).details
    assert len(branch.points) > 5
    assert branch.events == ()
    roots = np.roots([1.0, damping, stiffness])
    for point in branch.points:
        rate = 2.0 * pi * point.value
        phasor = it.force / (stiffness - rate**2 + 1j * damping * rate)
        turn = np.exp(2j * pi * point.orbit.map.phase)
        expected = it.weight / stiffness + (phasor * turn).real
        assert point.run.series["tip_normal_displacement"][0] == pytest.approx(expected, rel=1e-6)
        largest = np.sort_complex(point.orbit.multipliers)[[0, -1]]
        assert largest == pytest.approx(np.sort_complex(np.exp(roots / point.value)), rel=1e-5)
