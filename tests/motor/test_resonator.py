"""The resonator is the paper's: Table 1, the symmetries, and the misprints that Table 1 rules out."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import references
from support.motors import PLACEMENT_1, PLACEMENT_2, default_resonator

import contactlab as cl
from contactlab.motor import FiniteElementResonator, NormalModes, RitzMatrices, RitzResonator
from contactlab.motor.patched_beam import PiezoceramicDatasheet
from contactlab.motor.ritz import ClampedBeam

COUPLING_DIGIT = 0.5e-3
FREQUENCY_DIGIT = 5.0
"""Half a unit of the last printed digit of Table 1: N/V, and Hz."""

TABLE_1 = [
    (PLACEMENT_1, *references.TABLE_1["placement 1"]),
    (PLACEMENT_2, *references.TABLE_1["placement 2"]),
]


def table_1_faults(resonator: RitzResonator, row: int) -> list[str]:
    """The numbers of a row of Table 1 that a resonator misses by more than their rounding."""
    _, couplings, frequencies = TABLE_1[row]
    modes = resonator.modes
    faults = []
    for i, printed in enumerate(couplings):
        if abs(modes.shape_coupling[i, 0] - printed) > COUPLING_DIGIT:
            faults.append(f"G{i + 1}1")
    for i, printed in enumerate(frequencies):
        if abs(modes.natural_frequency[i] - printed) > FREQUENCY_DIGIT:
            faults.append(f"f{i + 1}")
    return faults


@pytest.mark.parametrize("row", [0, 1])
def test_table_1_is_met_within_its_rounding(row: int) -> None:
    assert table_1_faults(default_resonator(**TABLE_1[row][0]), row) == []


@pytest.mark.parametrize(
    ("changes", "frequencies", "couplings"),
    [
        (PLACEMENT_1, [2019.861, 5380.508], [-0.01558, -0.05710, 0.00605]),
        (PLACEMENT_2, [3210.121, 5460.688, 13202.46, 17786.32], [0.02069, 0.02727, 0.00492]),
        ({"shapes": 8}, [2692.0, 4606.0], []),
    ],
)
def test_identified_numbers_are_met(
    changes: dict[str, float], frequencies: list[float], couplings: list[float]
) -> None:
    modes = default_resonator(**changes).modes
    result = modes.natural_frequency[: len(frequencies)]
    assert result == pytest.approx(frequencies, rel=2e-4 if "shapes" in changes else 1e-6)
    assert modes.shape_coupling[: len(couplings), 0] == pytest.approx(couplings, abs=5e-6)


def test_more_shapes_never_raise_a_frequency_and_stay_above_the_converged_ones() -> None:
    # Rayleigh and Ritz: every basis gives an upper bound, and a larger basis a better one.
    # 2137.5 and 3766.3 Hz are converged finite elements of the same beam.
    bases = [default_resonator(shapes=n).modes.natural_frequency[:2] for n in (4, 8, 16, 28, 40)]
    for fewer, more in pairwise(bases):
        assert np.all(more < fewer)
    assert bases[-1][0] > 2137.5
    assert bases[-1][1] > 3766.3


@pytest.mark.parametrize("placement", [PLACEMENT_1, PLACEMENT_2])
def test_the_mirrored_set_couples_with_the_parity_of_each_shape(placement: dict[str, float]) -> None:
    coupling = default_resonator(shapes=12, **placement).matrices.coupling
    parity = (-1.0) ** np.arange(12)
    assert coupling[:, 1] == pytest.approx(parity * coupling[:, 0], rel=1e-9, abs=1e-14)


def with_patch_mass(factor: float, row: int) -> RitzResonator:
    """The resonator with the mass of its patches multiplied."""
    resonator = default_resonator(**TABLE_1[row][0])
    piezoceramic = replace(resonator.piezoceramic, density=7700.0 * factor)
    return replace(resonator, piezoceramic=piezoceramic)


def test_one_layer_of_patch_mass_misses_table_1() -> None:
    # Eq. 28 prints A_p of one layer; there are two on every set.
    misses = [table_1_faults(with_patch_mass(0.5, row), row) for row in (0, 1)]
    assert misses[0] + misses[1] != []
    assert all(fault.startswith("f") for fault in misses[0] + misses[1])


def test_printed_sign_of_the_coupling_contradicts_table_1_in_every_entry() -> None:
    # Eq. 31 prints the opposite sign: -(coupling modulus) at the same geometry.
    for row, (placement, *_) in enumerate(TABLE_1):
        resonator = default_resonator(piezo_bending_coupling=-9.196, **placement)
        assert table_1_faults(resonator, row) == ["G11", "G21", "G31"]


def test_datasheet_pz26_fits_table_1_visibly_worse() -> None:
    faults = []
    for row, (placement, *_) in enumerate(TABLE_1):
        resonator = replace(default_resonator(**placement), piezoceramic=PiezoceramicDatasheet().in_bending())
        faults += table_1_faults(resonator, row)
    assert len(faults) >= 6


def test_coupling_lever_is_half_of_both_thicknesses() -> None:
    # The middle of a layer lies (t_s + t_p)/2 from the axis: t_s/2 where the paper prints t_p/2.
    thin = default_resonator(piezo_thickness=0.5e-3).matrices.coupling
    thick = default_resonator(piezo_thickness=2e-3).matrices.coupling
    assert thick == pytest.approx(thin * (3.0 / 1.5), rel=1e-12)
    wide = default_resonator(beam_thickness=3e-3, piezo_thickness=1e-3).matrices.coupling
    assert wide == pytest.approx(thin * (4.0 / 1.5), rel=1e-12)


def test_layers_bend_about_the_middle_of_the_beam() -> None:
    # I_p of both layers by quadrature of y^2 from t_s/2 to t_s/2 + t_p.
    ts, tp, width = 1.3e-3, 0.7e-3, 16e-3
    common = {"beam_thickness": ts, "piezo_thickness": tp, "shapes": 3}
    soft, stiff = (default_resonator(piezo_bending_modulus=modulus, **common) for modulus in (1e9, 2e9))
    y = np.linspace(0.5 * ts, 0.5 * ts + tp, 10001)
    inertia = 2.0 * width * np.trapezoid(y**2, y)
    beam = ClampedBeam(soft.length, 3)
    gram = sum(beam.integrate(a, b, 2) for a, b in soft.patches)
    change = (stiff.matrices.stiffness - soft.matrices.stiffness) / 1e9
    # The trapezoid over 10^4 intervals.
    assert change == pytest.approx(inertia * gram, rel=1e-8)


def test_a_bare_beam_gives_way_like_a_clamped_beam_under_a_central_load() -> None:
    # u = F L^3 / (192 E I); the series of shapes converges with the third power of their number.
    bare = default_resonator(piezo_bending_modulus=1e-3, shapes=40)
    matrices = bare.matrices
    tip = matrices.tip_displacement
    flexibility = tip @ np.linalg.solve(matrices.stiffness, tip)
    rigidity = bare.steel.bending_modulus * 16e-3 * 1e-9 / 12.0
    assert flexibility == pytest.approx(57e-3**3 / (192.0 * rigidity), rel=1e-4)


def test_capacitance_is_that_of_both_layers_side_by_side() -> None:
    resonator = RitzResonator()
    permittivity = resonator.piezoceramic.permittivity
    expected = 2.0 * permittivity * 16e-3 * (10.146e-3 - 0.914e-3) / 1e-3
    assert resonator.matrices.capacitance == pytest.approx(expected * np.eye(2), rel=1e-12)


def response(matrices: RitzMatrices, modes: NormalModes, omega: float) -> tuple[np.ndarray, ...]:
    """Response of (u, theta) to both voltages, in shapes and in modes, at a frequency."""
    dynamic = matrices.stiffness - omega**2 * matrices.mass + 1j * omega * matrices.damping
    rows = np.stack([matrices.tip_displacement, matrices.tip_slope])
    in_shapes = rows @ np.linalg.solve(dynamic, matrices.coupling)
    scalar = modes.stiffness - omega**2 + 1j * omega * modes.damping
    tips = np.stack([modes.tip_displacement, modes.tip_slope])
    return in_shapes, (tips / scalar) @ modes.coupling


@pytest.mark.parametrize("frequency", [1.0, 3210.0, 5460.0, 40e3])
@pytest.mark.parametrize("shapes", [4, 12])
def test_modes_answer_as_the_matrices_do(frequency: float, shapes: int) -> None:
    matrices = default_resonator(shapes=shapes).matrices
    direct, modal = response(matrices, matrices.modes(), 2.0 * np.pi * frequency)
    errors = np.abs(modal - direct).max(axis=1)
    assert np.all(errors < 1e-10 * np.abs(direct).max(axis=1))


@pytest.mark.parametrize(("start", "end"), [(-1e-3, 5e-3), (5e-3, 5e-3), (8e-3, 5e-3), (20e-3, 28.6e-3)])
def test_patches_that_leave_the_beam_or_meet_their_mirror_are_refused(start: float, end: float) -> None:
    with pytest.raises(ValueError, match="start"):
        default_resonator(patch_start=start, patch_end=end)


@pytest.mark.parametrize("resonator", [RitzResonator, FiniteElementResonator])
def test_a_damping_ratio_is_that_of_every_mode(resonator: type[RitzResonator]) -> None:
    modes = resonator(damping_ratio=0.01).modes
    np.testing.assert_allclose(modes.damping_ratio, 0.01, rtol=1e-9)
    plain = resonator().modes
    np.testing.assert_array_equal(modes.stiffness, plain.stiffness)
    # The paper's alpha and beta: ratios of 20 and 34 % on four shapes.
    expected = 0.5 * (7.5 / np.sqrt(plain.stiffness) + 2e-5 * np.sqrt(plain.stiffness))
    np.testing.assert_allclose(plain.damping_ratio, expected, rtol=1e-9)


def test_the_matrix_of_a_damping_ratio_is_that_of_rayleigh_where_both_agree() -> None:
    """With two shapes alpha and beta can have one ratio in both modes."""
    squares = RitzResonator(shapes=2).modes.stiffness
    first, second = np.sqrt(squares)
    ratio = 0.02
    alpha, beta = 2.0 * ratio * first * second / (first + second), 2.0 * ratio / (first + second)
    rayleigh = RitzResonator(shapes=2, mass_damping=alpha, stiffness_damping=beta).matrices.damping
    modal = RitzResonator(shapes=2, damping_ratio=ratio).matrices.damping
    np.testing.assert_allclose(modal, rayleigh, rtol=0.0, atol=1e-12 * np.abs(rayleigh).max())


def test_a_damping_ratio_beside_other_damping_is_refused() -> None:
    with pytest.raises(ValueError, match="stiffness_damping"):
        RitzResonator(damping_ratio=0.01, stiffness_damping=1e-6)
    with pytest.raises(ValueError, match="tip_inertia"):
        FiniteElementResonator(rod_length=19e-3, tip_inertia=1e-7)


def test_free_vibration_decays_by_the_damping_ratio() -> None:
    """q(t) = e^(-zeta omega t) (cos w t + zeta omega / w sin w t), w = omega sqrt(1 - zeta^2)."""
    modes = RitzResonator(shapes=1, damping_ratio=0.02).modes
    start = cl.ModalState(np.array([1e-9]), np.zeros(1))
    silent = cl.Drive.two_mode(0.0, 0.0, frequency=1000.0)
    far = cl.ContactGeometry(clearance=1e-3)
    run = cl.simulate(cl.Motor(modes, silent, far, start=start), cl.Newton(), duration=2e-3)
    omega = np.sqrt(modes.stiffness[0])
    w, time = omega * np.sqrt(1.0 - 0.02**2), run["time"].values
    expected = np.exp(-0.02 * omega * time) * (np.cos(w * time) + 0.02 * omega / w * np.sin(w * time))
    displacement = modes.tip_displacement[0] * 1e-9 * expected
    scale = np.abs(displacement).max()
    np.testing.assert_allclose(run["tip_normal_displacement"], displacement, rtol=0.0, atol=1e-9 * scale)
