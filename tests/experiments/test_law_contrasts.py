"""Claims on the estimators of when laws matter, in worlds whose truth is known."""

from math import inf, nan

import numpy as np
from contrast_map import BAR, Judged
from law_contrasts import MEASURED, POINTS, contrast, half_widths, interval, map_sentence, shares
from motor_population import FAMILIES, KNOWN, RANGES, drawn


def test_a_contrast_is_the_logarithm_of_a_ratio_and_infinite_where_the_sign_turns() -> None:
    value = np.array([[2.0, 2.0, 2.0, 1e-9, nan], [1.0, -1.0, 1e-9, 1e-10, 1.0]])
    error = np.full((2, 5), 1e-6)
    np.testing.assert_allclose(contrast(value, error), [np.log(2.0), inf, inf, 0.0, nan])


def test_shares_of_a_table_without_an_interaction_are_those_of_its_rows_and_columns() -> None:
    law, motor = np.array([-1.0, 0.0, 1.0]), np.linspace(-3.0, 3.0, 7)
    both = np.array([(law**2).mean(), (motor**2).mean(), 0.0])
    np.testing.assert_allclose(shares(motor[:, None] + law), both / both.sum(), atol=1e-15)


def test_the_interval_of_a_share_covers_the_truth() -> None:
    """100 populations of 64 motors, with variances of 1 of law, 4 of motor and 0.25 of both together."""
    rng, covered = np.random.default_rng(1), 0
    law = np.array([-1.0, 1.0])
    # Under two laws half of the interaction's variance is left over, the rest is the motor's.
    truth = 0.125 / (1.0 + 4.0 + 0.125 + 0.125)
    for _ in range(100):
        table = law + 2.0 * rng.standard_normal((64, 1)) + 0.5 * rng.standard_normal((64, 2))
        _, low, high = interval(shares, table)
        covered += bool(low[2] <= truth <= high[2])
    assert 86 <= covered <= 99


def test_what_is_measured_narrows_the_prediction_as_a_gaussian_model_does() -> None:
    """One unknown input that acts alike on all points: two measurements leave s^2 m^2 / (2 s^2 + m^2)."""
    s = 0.3
    secant = np.zeros((1, len(KNOWN), len(POINTS)))
    secant[0, 0] = s
    first = next(iter(KNOWN.values()))
    after = s**2 * MEASURED**2 / (2.0 * s**2 + MEASURED**2)
    expected = 1.96 * np.array([s * first.catalogue / first.bench, s, np.sqrt(after)])
    np.testing.assert_allclose(half_widths(secant)[0], expected, rtol=1e-12)


def test_motors_are_drawn_one_by_one_within_their_ranges() -> None:
    motors = [drawn(number) for number in range(200)]
    assert drawn(7) == motors[7]
    assert {motor["family"] for motor in motors} == {*FAMILIES}
    for name, (low, high, _) in RANGES.items():
        values = np.array([motor[name] for motor in motors if name != "angle" or motor[name]])
        assert low <= values.min() < values.max() <= high
    assert 60 < sum(motor["pressed"] for motor in motors) < 140


def test_the_sentence_of_the_map_is_said_by_the_lower_end_of_its_r2() -> None:
    low, high = (Judged(0.6, BAR + by, 0.9, 0.9, 64) for by in (-0.01, 0.01))
    assert "0.90" in map_sentence({("rotor_velocity", "a"): low})
    both = map_sentence({("rotor_velocity", "a"): low, ("stall_torque", "b"): high})
    assert "b (stall torque" in both
    assert "a (" not in both
