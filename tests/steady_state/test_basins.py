"""Attractors and where starts go: motors of which it is known that there are one, two or many."""

import numpy as np
import pytest

import contactlab as cl
from contactlab.steady_state.basins import Ball, basins, is_neutral, same, started, touches

HYSTERETIC = ["law=newton", "contact.clearance=3.895 um"]
"""Between the clearance that the tip bridges and the fold of the orbits."""

SYMMETRIC = [
    "law=newton",
    "contact.clearance=2.22 um",
    "drive.frequency=3301",
    "drive.frequency_ratio=1.5",
    "contact.friction_coefficient=0.16",
    "drive.phase=1.463",
]
"""Its mirror image is itself, a period of the first tone later."""


def test_a_motor_with_one_attractor_comes_to_it_from_every_start() -> None:
    setup = cl.build(["law=newton"])
    (only,) = cl.attractors(setup, 4, seed=1)
    assert only.steady.velocity == pytest.approx(cl.steady(setup).velocity, rel=1e-6)


def test_a_symmetric_motor_runs_either_way_as_it_was_started() -> None:
    """The mirror image of a motion is a motion, so that to each velocity belongs the opposite one."""
    result = [cl.steady(cl.build([*SYMMETRIC, f"rotor.initial_velocity={start}"])) for start in (-2.0, 2.0)]
    backward, forward = (each.velocity[0] for each in result)
    # Each comes to the end of a neutral range, or by round-off to an orbit of the range beside it.
    assert forward == pytest.approx(0.79597, rel=2e-4)
    assert backward == pytest.approx(-0.79597, rel=2e-4)
    assert not same(*result)
    assert same(result[1], cl.steady(cl.build([*SYMMETRIC, "rotor.initial_velocity=3"])))


def test_the_basins_of_a_symmetric_motor_are_mirror_images_half_a_period_apart() -> None:
    """So are the attractors: orbits that repeat themselves at any velocity of a range, and those at its ends.

    At an end the derivative has two sides, and round-off decides whether an orbit there is one of the range.
    """
    velocities = np.array([-2.0, -0.5, 0.5, 2.0])
    axes = {"rotor_velocity": velocities, "drive_phase": np.array([0.1, 0.6])}
    result = basins(cl.build(SYMMETRIC), axes)
    assert result.unresolved == 0
    assert sum(result.shares) == 1.0
    reached = np.array([0.0 if is_neutral(each) else each.velocity[0] for each in result.attractors])
    velocity = reached[result.labels]
    assert {*np.sign(velocity).ravel()} == {-1.0, 0.0, 1.0}
    assert not velocity[1:3].any()
    for start, ends in zip(velocities, velocity, strict=True):
        assert ends[ends != 0.0] == pytest.approx(np.copysign(0.79597, start), rel=1e-4)


@pytest.mark.parametrize(("overrides", "kinds"), [(HYSTERETIC, 2), (["law=newton"], 1)])
def test_the_shares_of_all_attractors_add_up_to_one(overrides: list[str], kinds: int) -> None:
    reached = cl.attractors(cl.build(overrides), 4)
    assert len(reached) == kinds
    assert sum(each.share for each in reached) == 1.0


def test_motions_that_begin_in_a_ball_come_to_its_orbit() -> None:
    """At random in it, not where it was checked; in its norm the derivative makes everything shorter."""
    orbit = cl.steady(cl.build(["law=newton"])).orbit
    assert orbit is not None
    ball = Ball.around(orbit)
    assert ball.radius > 0.0
    half = np.linalg.cholesky(ball.norm).T
    shorter = half @ orbit.jacobian @ np.linalg.inv(half)
    assert np.linalg.norm(shorter, 2) < 1.0
    for x in np.random.default_rng(3).normal(size=(3, orbit.state.size)):
        z = orbit.state + 0.9 * ball.radius * np.linalg.solve(half, x / np.linalg.norm(x))
        assert ball.holds(z)
        later = orbit.map.end_of(orbit.map.run(z, 2000))
        np.testing.assert_allclose(later, orbit.state, atol=1e-5 * np.linalg.norm(orbit.state))


def test_a_map_says_of_every_start_what_its_run_says() -> None:
    """Between grazing and fold a motion with contact and one without are both there."""
    axes = {"tip_displacement": np.array([-3e-6, 3e-6]), "tip_velocity": np.array([-0.15, 0.1])}
    result = basins(cl.build([*HYSTERETIC, "rotor.initial_velocity=1.7"]), axes)
    assert result.unresolved == 0
    assert sum(result.shares) == 1.0
    kinds = {each.kind: i for i, each in enumerate(result.attractors)}
    assert kinds.keys() == {"periodic", "without contact"}
    running = result.attractors[kinds["periodic"]]
    assert running.orbit is not None
    assert running.orbit.stable
    assert not is_neutral(running)
    for place in np.ndindex(result.labels.shape):
        start = {name: float(values[i]) for (name, values), i in zip(axes.items(), place, strict=True)}
        section, z = started(result.setup, start)
        late = section.run(z, 1500).contacts["start_time"]
        ran = "periodic" if late.size and late[-1] > 1490 * section.period else "without contact"
        assert result.labels[place] == kinds[ran]
    data = result.to_xarray()
    assert data.label.dims == ("tip_displacement", "tip_velocity")
    assert data.attrs["unresolved"] == 0


def test_starts_inside_the_rotor_are_counted_as_no_start() -> None:
    axes = {"tip_displacement": np.array([0.0, 8e-6]), "rotor_velocity": np.array([-1.0])}
    result = basins(cl.build(["law=newton"]), axes)
    assert result.unresolved == 1
    assert result.shares == (0.5,)


def test_rotors_that_nothing_touches_are_in_one_state_whatever_their_velocity() -> None:
    far = [cl.steady(cl.build(["contact.clearance=9 um", f"rotor.initial_velocity={v}"])) for v in (0.0, 2.0)]
    assert not any(map(touches, far))
    assert same(*far)


def test_what_is_no_pair_of_coordinates_is_refused() -> None:
    with pytest.raises(ValueError, match="must be two of rotor_velocity"):
        basins(cl.build(), {"angle": np.zeros(2), "rotor_velocity": np.zeros(2)})
