"""The finite elements are converged: judged by exact transfer matrices and by the paper's own basis."""

from dataclasses import replace

import numpy as np
import pytest
from oracle.stepped_beam import natural_frequencies
from support.motors import PLACEMENT_1, PLACEMENT_2, stepped_beam
from threadpoolctl import threadpool_limits

from contactlab.motor import FiniteElementResonator, PatchedBeam, RitzResonator
from contactlab.motor.finite_element import FREQUENCY_ERROR, HermiteBeam
from contactlab.motor.patched_beam import Piezoceramic

PLACEMENTS = [PLACEMENT_1, PLACEMENT_2]


@pytest.mark.parametrize("kept", [1, 4, 6, 12])
@pytest.mark.parametrize("placement", PLACEMENTS)
def test_every_kept_frequency_is_the_exact_one_from_above_within_the_stated_error(
    placement: dict[str, float], kept: int
) -> None:
    resonator = FiniteElementResonator(kept_modes=kept, **placement)
    exact = natural_frequencies(stepped_beam(resonator), highest=150e3)[:kept]
    error = resonator.modes.natural_frequency[:kept] / exact - 1.0
    assert np.all(error > 0.0)
    assert np.all(error < FREQUENCY_ERROR)


def test_forty_modes_keep_the_stated_error() -> None:
    # Elements of twice the size have sixteen times the error.
    resonator = FiniteElementResonator(kept_modes=40)
    coarse = resonator.discretise(tuple(count // 2 for count in resonator.mesh))
    frequencies = np.sqrt(coarse.lowest(40)[0]) / (2.0 * np.pi)
    difference = frequencies / resonator.modes.natural_frequency[:40] - 1.0
    assert np.all(difference > 0.0)
    assert difference.max() < 15.0 * FREQUENCY_ERROR


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_stepped_frequencies_converge_with_the_fourth_power_of_the_element(
    placement: dict[str, float],
) -> None:
    resonator = FiniteElementResonator(**placement)
    exact = natural_frequencies(stepped_beam(resonator), highest=30e3)[:4]
    errors = []
    for refinement in (1, 2, 4):
        squares, _ = resonator.discretise(tuple(refinement * n for n in (2, 3, 4))).lowest(4)
        errors.append(np.sqrt(squares) / (2.0 * np.pi * exact) - 1.0)
    assert -np.diff(np.log2(errors), axis=0) == pytest.approx(4.0, abs=0.15)


def test_without_patches_and_tip_inertia_both_bases_agree() -> None:
    # Curvature jumps at patch edges and under a tip that resists turning; without either, only the
    # shear force jumps, under the tip's mass, and forty shapes follow that.
    bare = Piezoceramic(bending_modulus=1e-3, density=1e-9)
    value = {"piezoceramic": bare, "tip_inertia": 0.0}
    few = FiniteElementResonator(kept_modes=4, static_correction=False, **value).modes
    many = RitzResonator(shapes=40, **value).modes
    assert few.natural_frequency == pytest.approx(many.natural_frequency[:4], rel=2e-5)
    for name in ("tip_displacement", "tip_slope"):
        ours, theirs = np.abs(getattr(few, name)), np.abs(getattr(many, name)[:4])
        assert ours == pytest.approx(theirs, rel=1e-4, abs=1e-8 * theirs.max())


def test_couplings_without_patch_stiffness_are_those_of_the_papers_basis() -> None:
    # No tip either: then modes and shapes are the same functions, in the same scale.
    smooth = Piezoceramic(bending_modulus=1e-3, density=1e-9)
    value = {"piezoceramic": smooth, "tip_mass": 0.0, "tip_inertia": 0.0}
    modes = FiniteElementResonator(kept_modes=6, static_correction=False, **value).modes
    shapes = RitzResonator(shapes=6, **value).modes.shape_coupling
    assert np.abs(modes.shape_coupling) == pytest.approx(np.abs(shapes), rel=2e-4)


def test_a_mesh_beyond_measure_is_refused() -> None:
    # Where thick patches leave free a little of a light beam, and the first mesh sees little of that.
    extreme = FiniteElementResonator(
        kept_modes=40,
        patch_start=0.0,
        patch_end=27.5e-3,
        patch_thickness=1.0,
        piezoceramic=Piezoceramic(density=2.4),
        tip_mass=0.0,
        tip_inertia=0.0,
    )
    with pytest.raises(ValueError, match="elements"):
        _ = extreme.modes


@pytest.mark.parametrize(
    ("basis", "changes"),
    [
        # Forty modes of patches as heavy as worlds: the highest one's 1 / omega^2 is round-off of the
        # lowest one's, of either sign.
        (
            FiniteElementResonator(kept_modes=40),
            {"piezoceramic": Piezoceramic(density=1e30), "patch_start": 10e-3, "patch_end": 10.1e-3},
        ),
        (FiniteElementResonator(kept_modes=40), {"tip_inertia": 1e6}),
        (RitzResonator(shapes=40), {"tip_inertia": 1e6}),
        (RitzResonator(shapes=40), {"piezoceramic": Piezoceramic(density=1e30)}),
        # Numbers that overflow.
        (FiniteElementResonator(), {"length": 1e-200, "patch_start": 0.0, "patch_end": 1e-201}),
        (RitzResonator(), {"length": 1e-200, "patch_start": 0.0, "patch_end": 1e-201}),
    ],
)
def test_modes_that_round_off_makes_are_refused(basis: PatchedBeam, changes: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="modes"):
        _ = replace(basis, **changes).modes


@pytest.mark.parametrize(
    "basis", [FiniteElementResonator(kept_modes=12), RitzResonator(shapes=40)], ids=["fe", "ritz"]
)
def test_modes_do_not_depend_on_the_number_of_threads(basis: PatchedBeam) -> None:
    result = []
    for threads in (1, 2):
        with threadpool_limits(threads, user_api="blas"):
            result.append(vars(replace(basis).modes))
    for name, values in result[0].items():
        assert np.array_equal(values, result[1][name]), name


@pytest.mark.parametrize("kept", [0, 41])
def test_more_modes_than_are_verified_are_refused(kept: int) -> None:
    with pytest.raises(ValueError, match="kept_modes"):
        FiniteElementResonator(kept_modes=kept)


def test_a_rod_alone_has_the_frequencies_of_a_clamped_free_beam() -> None:
    """cosh x cos x = -1: x = 1.875104, 4.694091, 7.854757."""
    rod = HermiteBeam(np.full(80, 19e-3 / 80), np.full(80, 1.05))
    inverse = rod.cantilever.T @ rod.mass_matrix(np.full(80, 0.062)) @ rod.cantilever
    squares = 1.0 / np.linalg.eigvalsh(inverse)[::-1][:3]
    expected = np.array([1.87510407, 4.69409113, 7.85475744]) ** 4 * 1.05 / (0.062 * 19e-3**4)
    np.testing.assert_allclose(squares, expected, rtol=1e-6)


def test_a_short_rod_is_a_rigid_tip() -> None:
    """A rod of 2 mm is thicker than long: it bends far above these modes, and its inertia is m L^2 / 3."""
    length, mass = 2e-3, FiniteElementResonator().tip_mass
    rod = FiniteElementResonator(rod_length=length, static_correction=False).modes
    rigid = FiniteElementResonator(tip_inertia=mass * length**2 / 3.0, static_correction=False).modes
    np.testing.assert_allclose(rod.natural_frequency[:4], rigid.natural_frequency[:4], rtol=2e-5)
    np.testing.assert_allclose(rod.tip_displacement[:4], rigid.tip_displacement[:4], rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(rod.tip_slope[1:4:2], rigid.tip_slope[1:4:2], rtol=1e-3)


def test_the_identified_tip_as_a_rod_bends_at_the_second_tone() -> None:
    """3.2 mm of steel, clamped-free at 6.36 kHz: in the beam it splits the second mode into two."""
    rigid, rod = (FiniteElementResonator(rod_length=x).modes for x in (None, 19e-3))
    assert rod.natural_frequency[0] == pytest.approx(rigid.natural_frequency[0], rel=1e-9)
    lower, upper = rod.natural_frequency[1:3]
    assert lower < rigid.natural_frequency[1]
    assert upper > 6360.0
    # Static: the flexibility of the end is that of the foot's turn and of the rod, L^3 / (3 E I).
    area = 1.181e-3 / (7850.0 * 19e-3)
    bending = 19e-3**3 / (3.0 * 210e9 * area**2 / (4.0 * np.pi))
    soft, stiff = (19e-3**2 * (each.tip_slope**2 / each.stiffness).sum() for each in (rod, rigid))
    assert soft - stiff == pytest.approx(bending, rel=1e-9)


def test_the_rods_mesh_has_converged() -> None:
    resonator = FiniteElementResonator(rod_length=19e-3)
    coarse = resonator.discretise(resonator.mesh).lowest(6)[0]
    fine = resonator.discretise(tuple(2 * n for n in resonator.mesh)).lowest(6)[0]
    np.testing.assert_allclose(coarse, fine, rtol=3e-6)
