"""Gap, directions and accelerations of the contact are those of a tip end and a circle."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from contactlab.motor.geometry import contact_frame

TIP, RADIUS = 19e-3, 25e-3

displacement = st.floats(-1e-4, 1e-4)
slope = st.floats(-0.3, 0.3)
clearance = st.floats(0.0, 1e-4)


def tip_end(u: float, th: float) -> np.ndarray:
    """The tip's end (eq. 35) [m]."""
    return np.array([-TIP * np.sin(th), TIP * np.cos(th) + u])


def rotor_centre(open_by: float) -> np.ndarray:
    """The rotor's centre [m]."""
    return np.array([0.0, TIP + open_by + RADIUS])


def frame(u: float, th: float, open_by: float) -> tuple[float, float, float, float, float]:
    return contact_frame(u, th, TIP, RADIUS, open_by)


@settings(deadline=None)
@given(displacement, slope, clearance)
def test_gap_is_the_distance_to_the_circle(u: float, th: float, open_by: float) -> None:
    expected = np.hypot(*(tip_end(u, th) - rotor_centre(open_by))) - RADIUS
    # The plain formula subtracts lengths of 25 mm: 1e-17 m.
    assert frame(u, th, open_by)[0] == pytest.approx(expected, abs=2e-17)


def test_gap_keeps_its_digits_far_below_the_round_off_of_the_radius() -> None:
    # 1e-22 m of gap beside a radius of 25 mm: |d| - R would know nothing below 3e-18 m.
    for tiny in (1e-15, 1e-19, 1e-22):
        assert frame(0.0, 0.0, tiny)[0] == pytest.approx(tiny, rel=1e-15)
        assert frame(1e-6, 0.0, 1e-6 + tiny)[0] == pytest.approx((1e-6 + tiny) - 1e-6, rel=1e-12)


@settings(deadline=None)
@given(displacement, slope, clearance)
def test_normal_and_tangent_are_unit_vectors_a_quarter_turn_apart(
    u: float, th: float, open_by: float
) -> None:
    _, n_u, n_th, t_u, t_th = frame(u, th, open_by)
    d = tip_end(u, th) - rotor_centre(open_by)
    n = d / np.hypot(*d)
    t = np.array([-n[1], n[0]])
    along_slope = TIP * np.array([-np.cos(th), -np.sin(th)])
    assert (n_u, t_u) == pytest.approx((n[1], t[1]), abs=1e-14)
    assert (n_th, t_th) == pytest.approx((n @ along_slope, t @ along_slope), abs=1e-16)
