"""The best impulses there are, against closed forms and a general optimiser."""

from dataclasses import replace

import numpy as np
import pytest
from data_support.measured_impacts import drawn_bodies, drawn_impacts, kinetic
from scipy.optimize import minimize

from contactlab_data.measured.floors import best_admissible_impulses, best_impulses, velocities_after
from contactlab_data.measured.impacts import MeasuredImpacts, noise_from_outside

IMPACTS = drawn_impacts(60, 1)


def admitted(impacts: MeasuredImpacts, place: int, mu: float | None, impulse: np.ndarray) -> list[float]:
    """What must not be negative, each over its own size."""
    delassus, before = impacts.delassus[place], impacts.velocity_before[place]
    after = before + delassus @ impulse
    loss = kinetic(delassus, before) - kinetic(delassus, after)
    scale = np.sqrt(2.0 * kinetic(delassus, before))
    cone = [] if mu is None else [mu * impulse[0] - impulse[1], mu * impulse[0] + impulse[1]]
    return [impulse[0] / scale, after[0] / scale, loss / scale**2, *(each / scale for each in cone)]


@pytest.mark.parametrize("mu", [None, 0.0, 0.2, 1.0])
def test_the_best_admissible_impulse_is_that_of_a_general_optimiser(mu: float | None) -> None:
    result = best_admissible_impulses(IMPACTS, mu)
    free = best_impulses(IMPACTS)
    for place in range(len(IMPACTS)):
        delassus = IMPACTS.delassus[place]
        start = np.array([-IMPACTS.velocity_before[place, 0] / delassus[0, 0], 0.0])
        oracle = minimize(
            lambda p, at=place, d=delassus: (p - free[at]) @ d @ (p - free[at]),
            start,
            jac=lambda p, at=place, d=delassus: 2.0 * d @ (p - free[at]),
            constraints={
                "type": "ineq",
                "fun": lambda p, at=place: np.array(admitted(IMPACTS, at, mu, np.asarray(p))),
            },
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 300},
        )
        mine = (result[place] - free[place]) @ delassus @ (result[place] - free[place])
        assert min(admitted(IMPACTS, place, mu, result[place])) >= -2e-9
        assert mine <= oracle.fun + 1e-7
        # The optimiser keeps the bounds to its own tolerance alone.
        assert mine >= oracle.fun - 1e-5


def test_the_floors_lie_one_above_the_other() -> None:
    errors = [
        IMPACTS.errors(velocities_after(IMPACTS, impulses)).mean()
        for impulses in (
            best_impulses(IMPACTS),
            best_admissible_impulses(IMPACTS),
            best_admissible_impulses(IMPACTS, 0.5),
            best_admissible_impulses(IMPACTS, 0.0),
        )
    ]
    assert errors == sorted(errors)
    least = np.sqrt(IMPACTS.outside / IMPACTS.kinetic_energy)
    assert errors[0] == pytest.approx(least.mean(), rel=1e-12)


@pytest.mark.parametrize("mu", [-0.1, float("nan"), float("inf")])
def test_a_cone_that_is_none_is_refused(mu: float) -> None:
    with pytest.raises(ValueError, match="friction coefficient"):
        best_admissible_impulses(IMPACTS, mu)


def test_the_noise_that_was_put_in_is_estimated_from_what_no_impulse_makes() -> None:
    """From one direction of three, s^2 to 7 % of 2000 impacts: the median's error is 1.9/sqrt(n) of it."""
    bodies = drawn_bodies(2000, 3, noise=0.05)
    impacts = drawn_impacts(2000, 3)
    made = replace(impacts, delassus=bodies.delassus(), outside=bodies.outside())
    put_in = 0.05**2 * bodies.mass[0, 0, 0]
    result = noise_from_outside(made, 3)[:, 0, 0] / made.delassus[:, 0, 0]
    assert result == pytest.approx(np.full(2000, put_in), rel=0.15)
    with pytest.raises(ValueError, match="2 coordinates"):
        noise_from_outside(made, 2)
