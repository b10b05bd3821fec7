"""Bending moduli and couplings follow from the full tensors."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from contactlab.motor.patched_beam import Piezoceramic, PiezoceramicDatasheet, Steel, bending_vector


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


def test_bending_vector_strains_beam_and_thickness_only() -> None:
    assert bending_vector(0.25).tolist() == [0.0, -1.0, 0.25, 0.0, 0.0, 0.0]
