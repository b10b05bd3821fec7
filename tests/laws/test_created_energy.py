"""Impact laws on bodies where they create energy say so, for an impact by itself and in a run."""

from math import sqrt

import numpy as np
import pytest
from support.impacts import double_pendulum

import contactlab as cl
from contactlab.metrics import METRICS, assess
from contactlab.motor import Motor
from contactlab.motor.bodies import FLAT, HEAVY
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, NormalModes, Rotor

RATE, SLIP, (D_NN, D_NT, D_TT) = double_pendulum()


def rods() -> Motor:
    """Return two coordinates whose contact has that matrix, just before the impact."""
    a = sqrt(D_NN)
    b = D_NT / a
    c = sqrt(D_TT - b * b)
    height, rates = 1e-5, np.array([RATE / a, (SLIP - b * RATE / a) / c])
    modes = NormalModes(
        stiffness=np.zeros(2),
        damping=np.zeros(2),
        coupling=np.zeros((2, 2)),
        tip_displacement=np.array([-a, 0.0]),
        tip_slope=np.array([-b, -c]) / FLAT,
    )
    start = ModalState(np.array([height / a, -b * height / a / c]), rates)
    return Motor(
        modes=modes,
        geometry=ContactGeometry(FLAT, FLAT, 0.0),
        rotor=Rotor(inertia=HEAVY * FLAT**2),
        start=start,
    )


def energy_of(rate: float, slip: float) -> float:
    u = np.array([rate, slip])
    return float(0.5 * u @ np.linalg.solve([[D_NN, D_NT], [D_NT, D_TT]], u))


@pytest.mark.parametrize("friction", [0.1, 0.5, 0.6])
@pytest.mark.parametrize("name", ["newton", "poisson", "stronge"])
def test_an_impact_says_whether_its_law_creates_energy(name: str, friction: float) -> None:
    law = cl.law(name, restitution=0.7, friction_coefficient=friction)
    made = cl.impact(law, [[D_NN, D_NT], [D_NT, D_TT]], [RATE, SLIP])
    expected = energy_of(*made["velocity_after"].values[0]) / energy_of(RATE, SLIP)
    assert made["energy_ratio"].item() == pytest.approx(expected, rel=1e-9)
    assert bool(made.attrs["message"]) == (expected > 1.0 + 1e-9)
    assert name == "newton" or expected <= 1.0


def test_a_run_says_how_much_energy_its_impacts_created() -> None:
    law = cl.law("newton", restitution=0.7, friction_coefficient=0.5)
    run = cl.simulate(rods(), law, duration=1e-3, record_interval=1e-5)
    before, after = energy_of(RATE, SLIP), energy_of(*_rates_after(run))
    assert after > 1.01 * before
    assert run.contacts["impact_energy_gain"].sum() == pytest.approx(after - before, rel=1e-6)
    assert METRICS["impact_gain"].verdict(assess(run.tree)["impact_gain"]) == "fail"
    kept = cl.simulate(rods(), cl.law("poisson", restitution=0.7, friction_coefficient=0.5), duration=1e-3)
    assert kept.contacts["impact_energy_gain"].sum() == 0.0
    # One line more than the run of a law that creates none.
    assert len(repr(run).splitlines()) == len(repr(kept).splitlines()) + 1


def _rates_after(run: cl.Solution) -> tuple[float, float]:
    gap, slip = run["gap"].values, run["slip_velocity"].values
    return float((gap[-1] - gap[-2]) / 1e-5), float(slip[-1])
