"""The shapes are the eigenshapes of a clamped-clamped Bernoulli-Euler beam, up to forty of them."""

import numpy as np
import pytest

from contactlab.motor.ritz import MOST_SHAPES, ClampedBeam

LENGTH = 57e-3
COUNTS = [1, 2, 4, 11, 12, 25, MOST_SHAPES]

CATALOGUE = [4.730040744862704, 7.853204624095838, 10.995607838001671, 14.137165491257464]
"""b L of the first four shapes as any textbook lists them."""


def quadrature(start: float, end: float, panels: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights of a composite Gauss rule, other than the package's single panel."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(start, end, panels + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (nodes + 1.0)).ravel(), (half * weights).ravel()


@pytest.mark.parametrize("count", COUNTS)
def test_shapes_are_orthogonal_with_the_square_of_the_length_as_scale(count: int) -> None:
    beam = ClampedBeam(LENGTH, count)
    assert np.abs(beam.integrate(0.0, LENGTH) / LENGTH - np.eye(count)).max() < 1e-10
    x, weights = quadrature(0.0, LENGTH, 60)
    values = beam.evaluate(x)
    assert np.abs((values * weights) @ values.T / LENGTH - np.eye(count)).max() < 1e-10


@pytest.mark.parametrize("count", COUNTS)
def test_both_ends_are_clamped(count: int) -> None:
    beam = ClampedBeam(LENGTH, count)
    ends = np.array([0.0, LENGTH])
    assert np.abs(beam.evaluate(ends)).max() < 1e-10
    slopes = beam.evaluate(ends, 1) / beam.wave_numbers[:, None]
    assert np.abs(slopes).max() < 1e-10


@pytest.mark.parametrize("count", COUNTS)
def test_curvatures_are_orthogonal_with_the_fourth_power_of_the_wave_number(count: int) -> None:
    # int psi'' phi'' = int psi'''' phi + boundary terms that the clamps kill, and psi'''' = b^4 psi.
    beam = ClampedBeam(LENGTH, count)
    b = beam.wave_numbers
    scaled = beam.integrate(0.0, LENGTH, 2) / (LENGTH * np.outer(b**2, b**2))
    assert np.abs(scaled - np.eye(count)).max() < 1e-10


def test_low_shapes_are_the_textbook_form_and_its_derivatives() -> None:
    beam = ClampedBeam(LENGTH, 4)
    x = np.linspace(0.0, LENGTH, 101)
    assert beam.wave_numbers * LENGTH == pytest.approx(CATALOGUE, rel=1e-14)
    for row, root in enumerate(CATALOGUE):
        z, b = root * x / LENGTH, root / LENGTH
        s = (np.cosh(root) - np.cos(root)) / (np.sinh(root) - np.sin(root))
        textbook = [
            np.cosh(z) - np.cos(z) - s * (np.sinh(z) - np.sin(z)),
            b * (np.sinh(z) + np.sin(z) - s * (np.cosh(z) - np.cos(z))),
            b**2 * (np.cosh(z) + np.cos(z) - s * (np.sinh(z) + np.sin(z))),
        ]
        for derivative, expected in enumerate(textbook):
            error = np.abs(beam.evaluate(x, derivative)[row] - expected).max()
            # cosh(14) times round-off is what the textbook form itself loses.
            assert error < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("count", [0, -1, MOST_SHAPES + 1])
def test_a_number_of_shapes_out_of_range_is_refused_with_the_range(count: int) -> None:
    with pytest.raises(ValueError, match=str(count)):
        ClampedBeam(LENGTH, count)
