"""Bending moduli and couplings follow from the full tensors."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from contactlab.motor.patched_beam import (
    VACUUM_PERMITTIVITY,
    Piezoceramic,
    PiezoceramicDatasheet,
    Steel,
    bending_vector,
)
from contactlab.motor.ritz import RitzResonator


def test_steel_bends_with_235_442_gpa() -> None:
    # Half a unit of the last printed digit.
    assert Steel().bending_modulus == pytest.approx(235.442e9, abs=0.0005e9)


@settings(deadline=None)
@given(modulus=st.floats(1e9, 1e12), ratio=st.floats(0.0, 0.49))
def test_isotropic_modulus_is_the_strain_energy_of_unit_curvature(modulus: float, ratio: float) -> None:
    # 2 W = sum of stress times strain for strains -1 along the beam and +nu through it.
    shear = modulus / (2.0 * (1.0 + ratio))
    bulk = modulus / (3.0 * (1.0 - 2.0 * ratio))
    along, through = -1.0, ratio
    trace = along + through
    deviator = along**2 + through**2 - trace**2 / 3.0
    expected = bulk * trace**2 + 2.0 * shear * deviator
    assert Steel(modulus, ratio).bending_modulus == pytest.approx(expected, rel=1e-12)


def test_without_lateral_contraction_the_bending_modulus_is_youngs() -> None:
    assert Steel(210e9, 0.0).bending_modulus == pytest.approx(210e9, rel=1e-15)


def test_a_beam_free_in_both_directions_would_bend_with_youngs_modulus() -> None:
    # The paper leaves the width strain at zero; with it free as well the modulus is E, 12 % less.
    ratio, modulus = 0.3, 210e9
    compliance = np.full((3, 3), -ratio / modulus) + np.eye(3) * (1.0 + ratio) / modulus
    strain = np.linalg.solve(compliance, np.eye(3)) @ np.array([ratio, -1.0, ratio])
    assert strain[1] * -1.0 == pytest.approx(modulus, rel=1e-12)
    assert Steel().bending_modulus / modulus == pytest.approx(1.1212, abs=1e-4)


def test_pz26_of_the_datasheet_bends_with_115_gpa_and_couples_with_7_7() -> None:
    pz26 = PiezoceramicDatasheet().in_bending()
    assert pz26.bending_modulus == pytest.approx(115e9, abs=0.5e9)
    assert abs(pz26.bending_coupling) == pytest.approx(7.7, abs=0.05)


def test_datasheet_numbers_are_the_quadratic_and_linear_form_written_out() -> None:
    pz26 = PiezoceramicDatasheet().in_bending()
    c11, c13, c33, e31, e33, ratio = 168e9, 99.9e9, 123e9, -2.8, 14.7, 0.334
    expected = c11 - 2.0 * ratio * c13 + ratio**2 * c33
    assert pz26.bending_modulus == pytest.approx(expected, rel=1e-14)
    assert pz26.bending_coupling == pytest.approx(ratio * e33 - e31, rel=1e-14)


def test_c12_takes_no_part_in_bending() -> None:
    weak, strong = (PiezoceramicDatasheet(c12=c12).in_bending() for c12 in (0.0, 200e9))
    assert weak.bending_modulus == strong.bending_modulus
    assert weak.bending_coupling == strong.bending_coupling


def test_identified_material_differs_from_the_datasheet_only_in_modulus_and_coupling() -> None:
    identified, datasheet = Piezoceramic(), PiezoceramicDatasheet().in_bending()
    assert identified.bending_modulus == 94.295e9
    assert identified.bending_coupling == 9.196
    assert identified.density == datasheet.density == 7700.0
    assert identified.permittivity == datasheet.permittivity
    assert identified.free_permittivity == pytest.approx(datasheet.free_permittivity, rel=1e-14)


def solved_permittivity(material: PiezoceramicDatasheet, free: list[int]) -> float:
    """D3/E3 by the constitutive relations, some normal directions stress-free, the others clamped."""
    c11, c12, c13, c33 = material.c11, material.c12, material.c13, material.c33
    c = np.array([[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]])
    e = np.array([material.e31, material.e31, material.e33])
    # Unknowns S1 to S3 and D3 at E3 = 1.
    matrix, right = np.zeros((4, 4)), np.zeros(4)
    for i in range(3):
        matrix[i, :3] = c[i] if i in free else np.eye(3)[i]
        right[i] = e[i] if i in free else 0.0
    matrix[3], right[3] = [*-e, 1.0], material.permittivity
    scale = np.array([1e-11, 1e-11, 1e-11, 1e-9])
    return float((scale * np.linalg.solve(matrix * scale, right))[3])


def test_permittivity_of_a_layer_lies_between_clamped_and_free_as_the_relations_have_it() -> None:
    pz26 = PiezoceramicDatasheet()
    layer = pz26.in_bending()
    assert solved_permittivity(pz26, []) == pytest.approx(pz26.permittivity, rel=1e-12)
    assert layer.permittivity == pytest.approx(solved_permittivity(pz26, [2]), rel=1e-9)
    assert layer.free_permittivity == pytest.approx(solved_permittivity(pz26, [0, 1, 2]), rel=1e-9)
    assert layer.permittivity / pz26.permittivity == pytest.approx(1.283, abs=1e-3)
    # The catalogue's 1300 eps0, to the accuracy of such constants.
    assert layer.free_permittivity == pytest.approx(1300.0 * VACUUM_PERMITTIVITY, rel=0.03)


def test_without_coupling_through_the_thickness_the_layer_has_the_clamped_permittivity() -> None:
    layer = PiezoceramicDatasheet(e33=0.0).in_bending()
    assert layer.permittivity == PiezoceramicDatasheet().permittivity


def test_the_loss_of_a_data_sheet_is_that_of_the_free_permittivity() -> None:
    """With s^E and d real, eps_p = eps^T - (a real number) for a complex eps^T."""
    pz26 = PiezoceramicDatasheet(loss_tangent=0.003)
    layer = pz26.in_bending()
    free = layer.free_permittivity * (1.0 - 0.003j)
    clamped = free - (layer.free_permittivity - layer.permittivity)
    assert layer.capacitive_loss_tangent == pytest.approx(-clamped.imag / clamped.real, rel=1e-14)
    assert RitzResonator(piezoceramic=layer).modes.loss_tangent == layer.capacitive_loss_tangent


def test_bending_vector_strains_beam_and_thickness_only() -> None:
    assert bending_vector(0.25).tolist() == [0.0, -1.0, 0.25, 0.0, 0.0, 0.0]
