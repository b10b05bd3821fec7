"""Hermite elements are exact in statics, of fourth order in frequency, and lose no digits on fine meshes."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from contactlab.motor.finite_element import HermiteBeam

LENGTH, RIGIDITY, MASS = 0.7, 3.0, 0.2


def uniform(count: int) -> HermiteBeam:
    return HermiteBeam(np.full(count, LENGTH / count), np.full(count, RIGIDITY))


def lowest_frequencies(beam: HermiteBeam, count: int) -> np.ndarray:
    """The lowest angular frequencies [rad/s] of a uniform mass, ascending, shape (count,)."""
    mass = beam.mass_matrix(np.full(beam.size.size, MASS))
    inverse = np.linalg.eigvalsh(beam.shapes.T @ mass @ beam.shapes)
    return 1.0 / np.sqrt(inverse[::-1][:count])


def exact_wave_number(i: int) -> float:
    """kappa L of mode i = 1, 2, ...: cos x cosh x = 1."""
    centre = (i + 0.5) * np.pi
    return float(brentq(lambda x: np.cos(x) - 1.0 / np.cosh(x), centre - 0.5, centre + 0.5))


def assembled_stiffness(beam: HermiteBeam) -> np.ndarray:
    """The textbook's stiffness matrix of the nodes between the clamps."""
    count = beam.size.size
    matrix = np.zeros((2 * count + 2, 2 * count + 2))
    for e, (h, ei) in enumerate(zip(beam.size, beam.rigidity, strict=True)):
        element = np.array(
            [
                [12.0, 6.0 * h, -12.0, 6.0 * h],
                [6.0 * h, 4.0 * h**2, -6.0 * h, 2.0 * h**2],
                [-12.0, -6.0 * h, 12.0, -6.0 * h],
                [6.0 * h, 2.0 * h**2, -6.0 * h, 4.0 * h**2],
            ]
        )
        matrix[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += ei / h**3 * element
    return matrix[2:-2, 2:-2]


def test_shapes_times_themselves_invert_the_assembled_stiffness_matrix() -> None:
    beam = HermiteBeam(np.array([0.1, 0.25, 0.05, 0.3]), np.array([2.0, 1.0, 7.0, 3.0]))
    inverse = (beam.shapes @ beam.shapes.T)[:-2, :-2]
    product = inverse @ assembled_stiffness(beam)
    assert product == pytest.approx(np.eye(6), abs=1e-11)


def test_frequencies_are_those_of_the_assembled_matrices() -> None:
    beam = HermiteBeam(np.array([0.1, 0.25, 0.05, 0.3]), np.array([2.0, 1.0, 7.0, 3.0]))
    mass = beam.mass_matrix(np.full(4, MASS))
    squares = eigh(assembled_stiffness(beam), mass[:-2, :-2], eigvals_only=True)
    assert lowest_frequencies(beam, 6) == pytest.approx(np.sqrt(squares), rel=1e-11)


def test_right_clamp_stays_where_it_is() -> None:
    shapes = uniform(12).shapes
    assert np.abs(shapes[-2:]).max() < 1e-14 * np.abs(shapes).max()


@pytest.mark.parametrize("position", [0.1, 0.35, 0.6])
def test_a_load_at_a_node_bends_the_beam_exactly_on_any_mesh(position: float) -> None:
    # w under its own load: F a^3 b^3 / (3 E I L^3).
    beam = HermiteBeam(np.array([position, LENGTH - position]), np.full(2, RIGIDITY))
    dof = beam.node_at(position)
    flexibility = beam.shapes[dof] @ beam.shapes[dof]
    exact = (position * (LENGTH - position) / LENGTH) ** 3 / (3.0 * RIGIDITY)
    assert flexibility == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_frequencies_converge_from_above_with_the_fourth_power_of_the_element(mode: int) -> None:
    x = exact_wave_number(mode)
    exact = (x / LENGTH) ** 2 * np.sqrt(RIGIDITY / MASS)
    counts = np.array([6, 12, 24, 48]) * mode
    errors = [lowest_frequencies(uniform(n), mode)[-1] / exact - 1.0 for n in counts]
    orders = -np.diff(np.log2(errors))
    assert min(errors) > 0.0
    assert orders == pytest.approx(4.0, abs=0.1)
    # The leading term of the element's dispersion.
    assert errors[-1] == pytest.approx((x / counts[-1]) ** 4 / 1440.0, rel=0.01)


def test_four_hundred_elements_cost_the_first_frequency_no_digits() -> None:
    # Assembled, K has a condition number of 4e10 here. What remains is the element's own error, 1e-11.
    x = exact_wave_number(1)
    expected = (x / LENGTH) ** 2 * np.sqrt(RIGIDITY / MASS) * (1.0 + (x / 400) ** 4 / 1440.0)
    assert lowest_frequencies(uniform(400), 1)[0] == pytest.approx(expected, rel=1e-12)


def test_a_tiny_element_beside_long_ones_costs_no_digits() -> None:
    sizes = np.full(40, LENGTH / 40)
    with_sliver = np.concatenate([[1e-9], sizes[:1] - 1e-9, sizes[1:]])
    beam = HermiteBeam(with_sliver, np.full(41, RIGIDITY))
    # The two meshes differ by a node that hardly divides an element.
    expected = lowest_frequencies(uniform(40), 4)
    assert lowest_frequencies(beam, 4) == pytest.approx(expected, rel=1e-11)


def test_mass_matrix_weighs_the_free_beam() -> None:
    # A rigid displacement of all nodes; the left clamp's share is missing from the sum.
    mass = uniform(50).mass_matrix(np.full(50, MASS))
    lift = np.tile([1.0, 0.0], 50)
    missing = MASS * LENGTH / 50 / 420.0 * (156.0 + 2.0 * 54.0)
    assert lift @ mass @ lift + missing == pytest.approx(MASS * LENGTH, rel=1e-12)
