"""Branches of a motor's orbits: against its steady states, and where they end."""

from pathlib import Path

import numpy as np
import pytest
import xarray

import contactlab as cl
from contactlab.steady_state.continuation import Mark
from contactlab.steady_state.shooting import NEUTRAL


@pytest.fixture(scope="module")
def over_clearance() -> cl.Branch:
    """Up to where contact is lost, under a rigid law."""
    return cl.branch(cl.build(["law=newton"]), "contact.clearance", 3.84e-6, 3.94e-6, step=0.1)


def test_every_point_of_a_branch_is_an_orbit_of_its_own_motor(over_clearance: cl.Branch) -> None:
    for point in over_clearance.points[::4]:
        assert point.orbit.map.setup.configuration["contact"]["clearance"] == point.value
        left = point.orbit.map(point.orbit.state) - point.orbit.state
        assert np.linalg.norm(left) <= 1e-9 * np.linalg.norm(point.orbit.state)


def test_the_branch_folds_beyond_the_clearance_that_the_tip_bridges_without_contact(
    over_clearance: cl.Branch,
) -> None:
    """It comes back unstable, and the last contact loses its speed at that clearance, 3.89247 um."""
    (fold,) = over_clearance.events
    assert fold.mark is Mark.FOLD
    assert fold.value == pytest.approx(3.898714e-6, rel=1e-6)
    assert over_clearance.points[0].orbit.stable
    assert not over_clearance.points[-1].orbit.stable
    reported = float(over_clearance.end.partition("without speed at ")[2].partition(":")[0])
    assert reported == pytest.approx(3.89247e-6, rel=2e-4)


def test_a_branch_passes_through_the_steady_state_of_a_motor() -> None:
    """By shooting from rest, and by continuation over the phase of the drive from another motor."""
    result = cl.branch(cl.build(["law=newton"]), "drive.phase", -0.8, -0.6, step=0.5)
    steady = cl.steady(cl.build(["law=newton", "drive.phase=-0.6"]))
    assert result.points[-1].value == -0.6
    assert result.points[-1].velocity == pytest.approx(steady.velocity[0], rel=1e-6)


def test_a_branch_over_the_frequency_keeps_its_orbits_closed() -> None:
    """Where period and section change with it."""
    result = cl.branch(cl.build(["law=newton"]), "drive.frequency", 3210.0, 3260.0, step=0.5)
    last = result.points[-1]
    assert last.orbit.map.period == pytest.approx(1.0 / 3260.0, rel=1e-12)
    assert last.velocity == pytest.approx(
        cl.steady(cl.build(["law=newton", "drive.frequency=3260"])).velocity[0], rel=1e-6
    )


def test_a_dataset_of_a_branch_says_what_is_in_it(over_clearance: cl.Branch, tmp_path: Path) -> None:
    path = tmp_path / "branch.nc"
    over_clearance.to_xarray().to_netcdf(path)
    with xarray.open_dataset(path) as data:
        assert data["value"].attrs["units"] == "m"
        modulus = np.hypot(data.multiplier_real, data.multiplier_imaginary)
        np.testing.assert_allclose(modulus[:, 0], data.largest_multiplier)
        # At a fold itself a multiplier is one.
        folds = np.abs(data.largest_multiplier - 1.0) <= NEUTRAL
        assert ((data.stable == (data.largest_multiplier < 1.0)) | folds).all()
        assert int((data.mark == Mark.FOLD).sum()) == 1
        assert data.attrs["end"] == over_clearance.end


def test_what_can_be_no_branch_is_refused_in_a_sentence() -> None:
    setup = cl.build()
    with pytest.raises(cl.ConfigurationError, match=r"Did you mean contact\.clearance"):
        cl.branch(setup, "contact.clearnce", 1e-6, 2e-6)
    for motor in (setup, cl.oscillator(1.0, 1e4, gap=1e-4, force=5.0, frequency=12.0)):
        law = None if motor is setup else cl.Newton()
        with pytest.raises(cl.ConfigurationError, match=r"belt, .*rotor\.inertia") as fault:
            cl.branch(motor, "law", 1.0, 2.0, law=law)
        assert "piezoceramic," not in str(fault.value)
    with pytest.raises(cl.ConfigurationError, match=r"contact\.clearance is 0\.1 m"):
        cl.branch(setup, "contact.clearance", 1e-6, 0.1)
    with pytest.raises(ValueError, match="two ends that differ"):
        cl.branch(setup, "contact.clearance", 1e-6, 1e-6)
    with pytest.raises(ValueError, match=r"contact\.clearance=5e-06"):
        cl.branch(cl.build(["law=newton"]), "contact.clearance", 5e-6, 4e-6)
