"""Bending moduli and couplings follow from the full tensors."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from contactlab.motor.patched_beam import VACUUM_PERMITTIVITY, PiezoceramicDatasheet, Steel
from contactlab.motor.ritz import RitzResonator


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


def test_datasheet_numbers_are_the_quadratic_and_linear_form_written_out() -> None:
    pz26 = PiezoceramicDatasheet().in_bending()
    c11, c13, c33, e31, e33, ratio = 168e9, 99.9e9, 123e9, -2.8, 14.7, 0.334
    expected = c11 - 2.0 * ratio * c13 + ratio**2 * c33
    assert pz26.bending_modulus == pytest.approx(expected, rel=1e-14)
    assert pz26.bending_coupling == pytest.approx(ratio * e33 - e31, rel=1e-14)


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


def test_the_loss_of_a_data_sheet_is_that_of_the_free_permittivity() -> None:
    """With s^E and d real, eps_p = eps^T - (a real number) for a complex eps^T."""
    pz26 = PiezoceramicDatasheet(loss_tangent=0.003)
    layer = pz26.in_bending()
    free = layer.free_permittivity * (1.0 - 0.003j)
    clamped = free - (layer.free_permittivity - layer.permittivity)
    assert layer.capacitive_loss_tangent == pytest.approx(-clamped.imag / clamped.real, rel=1e-14)
    assert RitzResonator(piezoceramic=layer).modes.loss_tangent == layer.capacitive_loss_tangent
