"""Motors whose contact never opens have orbits, multipliers, branches and basins as any other."""

from functools import cache

import numpy as np
import pytest

import contactlab as cl

PRESSED = ("contact.preload=5", "rotor.bearing_damping=300")


@cache
def steady(law: str) -> cl.Steady:
    return cl.steady(cl.build([*PRESSED, f"law={law}"])).details


@pytest.mark.parametrize("law", ["newton", "hertz_penalty"])
def test_the_orbit_is_where_a_long_run_goes(law: str) -> None:
    result = steady(law)
    period = result.period
    run = result.setup.run(duration=400 * period, record_interval=period)
    velocity = np.diff(run.series["rotor_angle"])[-1] / period
    assert result.kind == "periodic"
    assert result.orbit.map.touches
    assert result.velocity.value == pytest.approx(velocity, rel=1e-6)
    assert result.contact_share.value == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("law", ["newton", "hertz_penalty"])
def test_the_multipliers_are_those_by_which_runs_come_to_the_orbit(law: str) -> None:
    """The derivative is that of runs from states beside the orbit, at any step of the differences."""
    orbit = steady(law).orbit
    assert orbit.stable
    assert orbit.roughness < 1e-4
    size = 1e-5 * np.linalg.norm(orbit.state)
    for direction in np.eye(orbit.state.size):
        ahead, behind = (
            orbit.map.end_of(orbit.map.run(orbit.state + side * size * direction)) for side in (1.0, -1.0)
        )
        change = (ahead - behind) / (2.0 * size)
        assert change == pytest.approx(orbit.jacobian @ direction, abs=1e-5)


def test_a_rigid_contact_forgets_what_its_constraint_holds() -> None:
    """Under stick gap, gap rate and slip are held: three multipliers are zero and no state is off the gap."""
    orbit = steady("newton").orbit
    assert np.sort(np.abs(orbit.multipliers))[:3] == pytest.approx(0.0, abs=1e-7)
    run = orbit.map.run(orbit.state + 1e-3 * np.linalg.norm(orbit.state), 1.0, 16)
    assert np.abs(run.series["gap"]).max() < 1e-15


@pytest.mark.parametrize("phase", [0.1, 0.6])
def test_the_orbit_is_the_same_from_any_phase_of_the_drive(phase: float) -> None:
    result = steady("newton")
    run = result.orbit.map.run(result.orbit.state, phase)
    section = result.orbit.map.at_end_of(run, result.orbit.map.phase + phase)
    z = section.end_of(run)
    assert np.linalg.norm(section(z) - z) < 1e-8 * np.linalg.norm(z)


def test_a_rotor_that_stands_has_no_velocity_but_round_off_on_a_branch() -> None:
    """Pressed so hard that all of the period sticks."""
    result = cl.branch(cl.build([*PRESSED, "law=newton"]), "contact.preload", 7.6, 8.0)
    data = result.data.to_dataset()
    assert (np.abs(data["rotor_velocity"]) <= data["rotor_velocity_error"]).all()
    assert (data["rotor_velocity_error"] < 1e-6).all()
    assert result.tables["events"]["rotor velocity"].tolist() == [0.0, 0.0]


def test_its_contact_goes_on_at_finer_steps() -> None:
    """Each step's search begins in the contact that the one before has left."""
    result = cl.steady(cl.build(["contact.preload=5", "rotor.bearing_damping=300"]), refine=True)
    assert result.kind == "periodic"
    value, error = result.velocity
    assert error <= 1e-5 * abs(value)
