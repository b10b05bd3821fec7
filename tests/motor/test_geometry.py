"""Gap, directions and accelerations of the contact are those of a tip end and a circle."""

from math import cos, hypot, sin

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from contactlab.motor.geometry import SMALL_ANGLE, ContactGeometry, sine_and_versine

TIP, RADIUS = 19e-3, 25e-3

displacement = st.floats(-1e-4, 1e-4)
slope = st.floats(-0.3, 0.3)
clearance = st.floats(0.0, 1e-4)
angle = st.sampled_from([0.0]) | st.floats(-1.5, 1.5)


def tip_end(u: float, th: float) -> np.ndarray:
    """The tip's end (eq. 35) [m]."""
    return np.array([-TIP * sin(th), TIP * cos(th) + u])


def rotor_centre(open_by: float, beside: float) -> np.ndarray:
    """The rotor's centre [m]."""
    return np.array([0.0, TIP]) + (open_by + RADIUS) * np.array([sin(beside), cos(beside)])


def geometry(open_by: float, beside: float = 0.0) -> ContactGeometry:
    return ContactGeometry(TIP, RADIUS, open_by, beside)


@settings(deadline=None)
@given(displacement, slope, clearance, angle)
def test_gap_is_the_distance_to_the_circle(u: float, th: float, open_by: float, beside: float) -> None:
    expected = np.hypot(*(tip_end(u, th) - rotor_centre(open_by, beside))) - RADIUS
    # The plain formula subtracts lengths of some 50 mm: 2e-17 m.
    assert geometry(open_by, beside).frame(u, th)[0] == pytest.approx(expected, abs=4e-17)


def test_gap_keeps_its_digits_far_below_the_round_off_of_the_radius() -> None:
    # 1e-22 m of gap beside a radius of 25 mm: |d| - R would know nothing below 3e-18 m.
    for tiny in (1e-15, 1e-19, 1e-22):
        assert geometry(tiny).frame(0.0, 0.0)[0] == pytest.approx(tiny, rel=1e-15)
        assert geometry(1e-6 + tiny).frame(1e-6, 0.0)[0] == pytest.approx((1e-6 + tiny) - 1e-6, rel=1e-12)
        assert geometry(tiny, 0.7).frame(0.0, 0.0)[0] == pytest.approx(tiny, rel=1e-15)


@settings(deadline=None)
@given(displacement, slope, clearance, angle)
def test_normal_and_tangent_are_unit_vectors_a_quarter_turn_apart(
    u: float, th: float, open_by: float, beside: float
) -> None:
    _, n_u, n_th, t_u, t_th = geometry(open_by, beside).frame(u, th)
    d = tip_end(u, th) - rotor_centre(open_by, beside)
    n = d / np.hypot(*d)
    t = np.array([-n[1], n[0]])
    along_slope = TIP * np.array([-cos(th), -sin(th)])
    assert (n_u, t_u) == pytest.approx((n[1], t[1]), abs=1e-14)
    assert (n_th, t_th) == pytest.approx((n @ along_slope, t @ along_slope), abs=1e-16)


@given(clearance, angle)
def test_the_way_to_touch_closes_the_gap(open_by: float, beside: float) -> None:
    """A tip that rises by it touches, and one that would pass by the rotor never does."""
    made = geometry(open_by, beside)
    if (RADIUS + open_by) * abs(sin(beside)) > RADIUS:
        assert made.way_to_touch == np.inf
    else:
        way = made.way_to_touch
        assert made.frame(way, 0.0)[0] == pytest.approx(0.0, abs=1e-15 * hypot(RADIUS, way))
        assert made.frame(0.999 * way, 0.0)[0] >= 0.0


def test_sine_and_versine_are_good_to_the_last_digit_on_either_side_of_a_small_angle() -> None:
    edge = SMALL_ANGLE * np.array([1.0 - 1e-15, 1.0, 1.0 + 1e-15])
    for angle in (*edge, *-edge, *np.logspace(-300, 0, 601), *-np.logspace(-9, 0, 50)):
        # The reference has eleven more bits where the platform's long double does.
        exact = np.longdouble(angle)
        expected = np.sin(exact), 2.0 * np.sin(0.5 * exact) ** 2
        for value, reference in zip(sine_and_versine(float(angle)), expected, strict=True):
            assert abs(value - reference) <= 2.0 * np.finfo(np.float64).eps * abs(reference) + 1e-320
