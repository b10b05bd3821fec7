"""Spheres that rebound at a slant: closed forms, and what Kharaz et al. (2001) measured."""

from math import cos, radians, sin, tan
from pathlib import Path

import numpy as np
import pytest
import sphere_rebounds as spheres
from oblique_spheres import DIP, RIGID_STICK, WITHIN, ObliqueSpheres
from sphere_laws import ALUMINA_ON_GLASS, Pair
from support.measurements import SPHERES

import contactlab as cl
from contactlab.laws.damping import Flores
from contactlab.laws.normal import HertzPoint

present = pytest.mark.skipif(
    not SPHERES.is_file(),
    reason=f"The impacts of Kharaz et al. are not here; "
    f"docs/measurements.md says which figures show them. Then put them into {SPHERES}.",
)

ANGLES = np.linspace(1.0, 85.0, 43)


def law(friction: cl.Friction) -> cl.Composed:
    return cl.Composed(HertzPoint(ALUMINA_ON_GLASS.hertz), Flores(spheres.RESTITUTION), friction)


def predicted(chosen: cl.ContactLaw, incidence: np.ndarray) -> dict[str, np.ndarray]:
    return spheres.law_predictions(lambda _: chosen)(incidence)


@pytest.fixture(scope="module")
def rebounds() -> spheres.Rebounds:
    return spheres.read_rebounds(SPHERES)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("mu", [0.0, 0.092, 0.6])
@pytest.mark.parametrize("rigid", [cl.Newton, cl.MoreauJean, cl.Poisson, cl.Stronge, cl.Brach])
def test_a_rigid_law_leaves_five_sevenths_in_stick_and_never_less(
    rigid: type[cl.Newton], mu: float, e: float
) -> None:
    """Friction that ends with the slip has D <= 2/7 v_t; that of sliding is mu (1 + e) v_n."""
    result = predicted(rigid(mu, e), ANGLES)["tangential_restitution"]
    sliding = 1.0 - mu * (1.0 + e) / np.tan(np.radians(ANGLES))
    np.testing.assert_allclose(result, np.maximum(RIGID_STICK, sliding), rtol=1e-12)


def test_the_experiment_takes_its_file() -> None:
    assert ObliqueSpheres(path="rebounds.csv").path == "rebounds.csv"


def test_sliding_is_that_of_the_closed_form_with_microslip_too() -> None:
    steep = np.array([40.0, 55.0, 80.0])
    sliding = 1.0 - spheres.FRICTION * (1.0 + spheres.RESTITUTION) / np.tan(np.radians(steep))
    patch = spheres.microslip(ALUMINA_ON_GLASS.effective, ALUMINA_ON_GLASS.stiffness_ratio)
    for result, within in ((patch(steep), 1e-4), (predicted(law(cl.Mindlin(spheres.FRICTION)), steep), 1e-6)):
        np.testing.assert_allclose(result["tangential_restitution"], sliding, rtol=within)


def test_mindlins_ratio_is_that_of_equal_bodies_and_lies_between_theirs() -> None:
    for nu in (0.0, 0.23, 0.5):
        equal = Pair((1e9, 1e9), (nu, nu)).stiffness_ratio
        assert equal == pytest.approx(2.0 * (1.0 - nu) / (2.0 - nu), rel=1e-14)
    assert 2.0 * 0.75 / 1.75 < ALUMINA_ON_GLASS.stiffness_ratio < 2.0 * 0.77 / 1.77


def test_each_of_the_three_quantities_tells_the_other_two() -> None:
    angle, taken = 25.0, 0.4
    v_n, v_t = spheres.SPEED * cos(radians(angle)), spheres.SPEED * sin(radians(angle))
    after = np.array([[0.98 * v_n, v_t - 3.5 * taken]])
    result = spheres.quantities(spheres.approach(np.array([angle])), after)
    left = float(result["tangential_restitution"][0])
    assert v_t * (1.0 - left) == pytest.approx(taken)
    rebound = float(result["rebound_angle_deg"][0])
    assert tan(radians(rebound)) == pytest.approx(left * tan(radians(angle)) / 0.98)
    assert result["spin_rad_per_s"] * spheres.RADIUS * 0.4 == pytest.approx(taken)


@present
def test_what_is_called_tangential_restitution_is_that_of_the_centre(rebounds: spheres.Rebounds) -> None:
    """The slip of the contact keeps 1 - 7/2 of what the centre loses; at 60 degrees 0.63 of it, not 0.90."""
    here = (rebounds.quantity == "tangential_restitution") & (rebounds.incidence > 45.0)
    sliding = spheres.FRICTION * (1.0 + spheres.RESTITUTION) / np.tan(np.radians(rebounds.incidence[here]))
    np.testing.assert_allclose(rebounds.value[here], 1.0 - sliding, atol=spheres.DIGITISED)
    assert (np.abs(rebounds.value[here] - (1.0 - 3.5 * sliding)) > 20.0 * spheres.DIGITISED).all()


@present
def test_the_three_quantities_agree_among_themselves_to_the_digitising(rebounds: spheres.Rebounds) -> None:
    """One curve that is free at 8 incidences is fitted to 24 numbers: 16 are left to disagree."""
    left = spheres.misfits(rebounds, spheres.floor(rebounds))[0]
    chi_square = float(left @ left)
    # The 0.5 % and 99.5 % points of a chi-square of 16.
    assert 5.1 < chi_square < 34.3


@present
def test_under_mindlin_the_restitution_dips_to_what_is_measured_with_nothing_fitted(
    rebounds: spheres.Rebounds,
) -> None:
    kappa, grid = ALUMINA_ON_GLASS.stiffness_ratio, np.arange(10.0, 31.0)
    mindlin = law(cl.Mindlin(spheres.FRICTION, kappa))
    dip = predicted(mindlin, grid)["tangential_restitution"]
    assert float(dip.min()) == pytest.approx(DIP, abs=WITHIN)
    assert abs(grid[np.argmin(dip)] - 20.0) < 3.0
    measured = rebounds.value[rebounds.quantity == "tangential_restitution"]
    assert float(measured.min()) == pytest.approx(DIP, abs=spheres.DIGITISED)


@present
def test_the_more_of_the_contact_may_slip_by_itself_the_less_is_left_of_the_misfit(
    rebounds: spheres.Rebounds,
) -> None:
    """None of it, all at once on a spring, each place by itself; and no law is below what the data allow."""
    kappa = ALUMINA_ON_GLASS.stiffness_ratio
    models = (
        spheres.law_predictions(lambda _: law(cl.Coulomb(spheres.FRICTION))),
        spheres.law_predictions(lambda _: law(cl.Mindlin(spheres.FRICTION, kappa))),
        spheres.microslip(ALUMINA_ON_GLASS.effective, kappa),
        spheres.floor(rebounds),
    )
    result = [spheres.rms(spheres.misfits(rebounds, model)[0]) for model in models]
    assert result == sorted(result, reverse=True)
    assert result[1] < 0.75 * result[0]
    assert result[2] < 0.5 * result[1]
    rings = spheres.law_predictions(lambda _: law(cl.Microslip(spheres.FRICTION, kappa)))
    assert spheres.rms(spheres.misfits(rebounds, rings)[0]) == pytest.approx(result[2], abs=0.02)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("", "quantity"),
        ("quantity,incidence,value\nspin_rad_per_s,1,2\n", "incidence_deg"),
        ("quantity,incidence_deg,value\nspin,1,2\n", "spin"),
        ("quantity,incidence_deg,value\nspin_rad_per_s,1,two\n", "two"),
        ("quantity,incidence_deg,value\nspin_rad_per_s,95,2\n", "incidence"),
        ("quantity,incidence_deg,value\nspin_rad_per_s,20,nan\n", "finite"),
    ],
)
def test_a_table_of_something_else_is_refused(text: str, key: str, tmp_path: Path) -> None:
    path = tmp_path / "given.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=key):
        spheres.read_rebounds(path)
