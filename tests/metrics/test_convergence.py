"""What is said of a ladder of steps and of variants: orders, limits and sensitivities."""

from math import isnan

import numpy as np
import pytest
import xarray
from support.configurations import case_a_tree

from contactlab.metrics import NOT_APPLICABLE, SENSITIVITIES, STEP_METRICS, assess_steps, assess_variants

RIGID_STEPS = (2e-7, 1e-7, 5e-8)


def test_a_ladder_needs_three_steps_in_one_ratio_for_an_order() -> None:
    trees = {h: case_a_tree("lagrange_stick", h, 1e-6) for h in (*RIGID_STEPS, 2.5e-7)}
    two = assess_steps([(h, trees[h]) for h in RIGID_STEPS[:2]])
    assert not isnan(two["peak_force_exponent"])
    uneven = assess_steps([(h, trees[h]) for h in (2.5e-7, 1e-7, 5e-8)])
    for result in (two, uneven):
        for key in ("velocity_order", "extrapolated_rotor_velocity", "velocity_error"):
            assert STEP_METRICS[key].verdict(result[key]) == NOT_APPLICABLE
    for few in ([], [(1e-7, trees[1e-7])]):
        assert all(isnan(value) for value in assess_steps(few).values())


@pytest.mark.parametrize("steps", [(1e-7, 2e-7), (1e-7, 1e-7), (1e-7, 0.0), (1e-7, -1e-8)])
def test_steps_that_do_not_fall_are_refused(steps: tuple[float, ...]) -> None:
    tree = case_a_tree("lagrange_stick", 1e-7, 1e-6)
    with pytest.raises(ValueError, match="must be positive and fall from run to run"):
        assess_steps([(step, tree) for step in steps])


def turning(velocity: float) -> xarray.DataTree:
    time = np.linspace(0.0, 1.0, 9)
    angle = ("time", velocity * time)
    return xarray.DataTree(xarray.Dataset({"rotor_angle": angle}, coords={"time": time}))


def test_the_order_of_a_power_is_its_exponent_and_its_limit_is_exact() -> None:
    runs = [(h, turning(-3.0 + 5.0 * h**1.5)) for h in (0.4, 0.2, 0.1)]
    result = assess_steps(runs)
    assert result["velocity_order"] == pytest.approx(1.5)
    assert result["extrapolated_rotor_velocity"] == pytest.approx(-3.0)
    fine = -3.0 + 5.0 * 0.1**1.5
    assert result["velocity_error"] == pytest.approx(abs((fine + 3.0) / fine))


@pytest.mark.parametrize("velocities", [(1.0, 1.2, 1.1), (1.0, 1.1, 1.3), (1.1, 1.1, 1.1)])
def test_differences_that_change_sign_or_grow_have_no_order_but_a_range(
    velocities: tuple[float, ...],
) -> None:
    runs = [(h, turning(v)) for h, v in zip((0.4, 0.2, 0.1), velocities, strict=True)]
    result = assess_steps(runs)
    assert isnan(result["velocity_order"])
    assert isnan(result["extrapolated_rotor_velocity"])
    span = max(velocities) - min(velocities)
    assert result["velocity_error"] == pytest.approx(span / velocities[-1], abs=1e-14)


def test_sensitivities_are_relative_changes() -> None:
    base = turning(2.0)
    result = assess_variants(base, basis=(1.0, turning(1.5)), friction=(0.1, turning(2.1)))
    assert list(result) == list(SENSITIVITIES)
    assert result["rotor_velocity_by_basis"] == pytest.approx(-0.25)
    assert result["rotor_velocity_by_friction"] == pytest.approx(0.5)
    assert isnan(result["peak_force_by_basis"])
    assert all(isnan(value) for value in assess_variants(base).values())
    assert isnan(assess_variants(base, friction=(0.0, base))["rotor_velocity_by_friction"])
