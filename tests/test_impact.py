"""A law by itself: impacts against closed forms, against the whole engine, and against themselves."""

import cmath
from dataclasses import replace
from math import gamma, pi, sqrt
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from support.closed_forms import coupled_body
from support.pages import DOCS, names_of

import contactlab as cl
from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.impacts import Impacts, velocities_after
from contactlab.laws import LAWS
from contactlab.laws.damping import LinearDamping
from contactlab.motor.bodies import FLAT, block
from contactlab.trajectory import Ending

MU = 0.3
COUPLED = [[1000.0, 250.0], [250.0, 2500.0]]
MASS = 2e-3

REMEMBERING = (cl.Composed(normal=cl.Thornton()), cl.Composed(friction=cl.Mindlin()))
SMOOTH = (cl.HertzPenalty(1e9, MU), cl.Composed(normal=cl.HertzPoint(), damping=cl.HuntCrossley()))
SOME = (cl.Poisson(MU, 0.7), cl.LagrangeAgeing(), *SMOOTH, *REMEMBERING)
"""Laws of all kinds: rigid, told of its step, compliant, lossy, remembering in each direction."""


def drawn(count: int, seed: int = 0, coupling: float = 0.5) -> tuple[Array, Array]:
    """Matrices [1/kg] and velocities before [m/s] of a motor's size."""
    rng = np.random.default_rng(seed)
    nn, tt = rng.uniform(500.0, 2000.0, count), rng.uniform(500.0, 5000.0, count)
    nt = coupling * rng.uniform(-1.0, 1.0, count) * np.sqrt(nn * tt)
    matrices = np.stack([nn, nt, nt, tt], axis=1).reshape(-1, 2, 2)
    return matrices, np.column_stack([-rng.uniform(0.01, 0.5, count), rng.normal(0.0, 0.3, count)])


def energy(matrices: Array, rates: Array) -> Array:
    """u' D^-1 u / 2 [J]."""
    return np.asarray(0.5 * np.einsum("ni,ni->n", rates, np.linalg.solve(matrices, rates[..., None])[..., 0]))


def test_a_hertzian_contact_has_its_duration_depth_and_peak() -> None:
    stiffness, speed = 1e9, 0.3
    made = cl.impact(cl.HertzPenalty(stiffness, 0.0), np.eye(2) / MASS, [-speed, 0.0], tolerance=1e-12)
    deepest = (1.25 * MASS * speed**2 / stiffness) ** 0.4
    lasts = 2.0 * deepest / speed * sqrt(pi) / 2.5 * gamma(0.4) / gamma(0.9)
    assert_allclose(made.duration, lasts, rtol=1e-9)
    assert_allclose(made.max_penetration, deepest, rtol=1e-9)
    assert_allclose(made.peak_normal_force, stiffness * deepest**1.5, rtol=1e-9)
    assert_allclose(made.velocity_after, [[speed, 0.0]], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("law", SOME, ids=lambda law: law.title)
def test_velocities_change_by_the_impulse_and_no_energy_comes_in(law: cl.ContactLaw) -> None:
    matrices, rates = drawn(40)
    made = cl.impact(law, matrices, rates)
    after = made.velocity_after.values
    assert (made.status == Ending.COMPLETE).all()
    assert made.released.all()
    jump = np.einsum("nij,nj->ni", matrices, made.impulse.values)
    assert_allclose(after, rates + jump, rtol=0.0, atol=1e-13)
    lost, before = energy(matrices, rates) - energy(matrices, after), energy(matrices, rates)
    assert_allclose(made.energy_loss, lost, rtol=0.0, atol=1e-12 * before.max())
    # An elastic contact loses nothing but its friction's work; steps make an error of the tolerance.
    assert (lost >= -1e-7 * before).all()


@pytest.mark.parametrize("law", SOME, ids=lambda law: law.title)
def test_many_at_once_are_each_by_itself_in_any_order_to_the_bit(law: cl.ContactLaw) -> None:
    matrices, rates = drawn(12, seed=1)
    many = velocities_after(law, matrices, rates)
    alone = [velocities_after(law, *each)[0] for each in zip(matrices, rates, strict=True)]
    assert_array_equal(many, alone)
    order = np.random.default_rng(0).permutation(12)
    assert_array_equal(velocities_after(law, matrices[order], rates[order]), many[order])
    assert_array_equal(cl.impact(law, matrices, rates).velocity_after, many)


@pytest.mark.parametrize("law", SOME, ids=lambda law: law.title)
def test_a_mirrored_impact_has_the_mirrored_answer(law: cl.ContactLaw) -> None:
    matrices, rates = drawn(12, seed=2)
    mirror = np.array([1.0, -1.0])
    other = velocities_after(law, matrices * np.outer(mirror, mirror), rates * mirror)
    assert_allclose(other * mirror, velocities_after(law, matrices, rates), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("law", [*SMOOTH, *REMEMBERING], ids=lambda law: law.title)
def test_an_impact_is_that_of_the_whole_engine_on_a_body_of_the_same_matrix(law: cl.ContactLaw) -> None:
    for seed in range(3):
        motor = coupled_body(seed)
        modes = motor.modes
        # Free of its springs, over a plate: nothing but the contact acts.
        flat = replace(
            modes,
            stiffness=np.zeros_like(modes.stiffness),
            damping=np.zeros_like(modes.stiffness),
            tip_slope=modes.tip_slope * 19e-3 / FLAT,
        )
        rotor = cl.Rotor(1e-3 * FLAT**2, initial_velocity=0.2 / FLAT)
        motor = replace(motor, modes=flat, geometry=cl.ContactGeometry(FLAT, FLAT, 0.0), rotor=rotor)
        normal, along = -flat.tip_displacement, -FLAT * flat.tip_slope
        rows = np.stack([np.append(normal, 0.0), np.append(along, -FLAT / sqrt(rotor.inertia))])
        assert motor.start is not None
        before = np.array([normal @ motor.start.velocity, along @ motor.start.velocity - 0.2])
        tight = {"tolerance": 1e-10}
        result = cl.impact(law, rows @ rows.T, before, **tight)
        run = simulate(motor, law, duration=1e-3, record_interval=1e-3, contact_step=1.3e-6, **tight)
        assert run.complete
        assert run.contacts["duration"].size == 1
        for name in ("duration", "peak_normal_force", "max_penetration"):
            assert_allclose(result[name], run.contacts[name], rtol=1e-7)
        assert_allclose(result.velocity_after[0, 0], run.contacts["separation_velocity"][0], rtol=1e-8)
        assert_allclose(result.velocity_after[0, 1], run.series["slip_velocity"][-1], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("name", sorted(LAWS))
def test_every_registered_law_answers(name: str) -> None:
    assert np.isfinite(velocities_after(cl.law(name), COUPLED, [[-0.1, 0.05], [-0.01, -0.3]])).all()


def test_a_small_ball_is_caught_by_adhesion_below_the_speed_that_parts_it() -> None:
    law, mass = cl.Composed(normal=cl.Jkr()), 1e-9
    slow, fast = 0.05, 0.5
    made = cl.impact(law, np.diag([1.0, 3.5]) / mass, [[-slow, 0.0], [-fast, 0.0]])
    assert made.released.values.tolist() == [False, True]
    assert np.isfinite(made.velocity_after).all()
    assert (made.status == Ending.COMPLETE).all()
    # What parts them is lost to the neck, whatever the speed was.
    assert 0.0 < made.energy_loss[1] < 0.5 * mass * fast**2


def test_a_history_adds_up_to_the_impulse_and_leaves_the_answer_alone() -> None:
    matrices, rates = drawn(5)
    for law in (SMOOTH[0], REMEMBERING[1]):
        made, plain = cl.impact(law, matrices, rates, history=50), cl.impact(law, matrices, rates)
        assert_array_equal(made.velocity_after, plain.velocity_after)
        assert "gap" not in plain
        assert made.gap.dims == ("impact", "record")
        assert_allclose(made.time[:, -1], made.duration, rtol=1e-14)
        interval = made.duration / 50
        for name, k in (("normal_force", 0), ("friction_force", 1)):
            assert_allclose(made[name].sum("record") * interval, made.impulse[:, k], rtol=1e-9, atol=1e-15)
        assert_allclose(-made.gap.min("record"), made.max_penetration, rtol=1e-2)
        assert_allclose(made.gap[:, -1] / made.max_penetration, 0.0, atol=1e-9)
        assert (made.normal_force < made.peak_normal_force).all()
        assert (made.normal_force > 0.0).all()


def test_painleves_paradox_leaves_no_number() -> None:
    matrix = [[1.0, 2.0], [2.0, 5.0]]
    made = cl.impact(cl.LagrangeSlip(0.9), [COUPLED, matrix, matrix], [[-0.1, 1.0]] * 3)
    assert made.status.values.tolist() == [Ending.COMPLETE, Ending.INCONSISTENT, Ending.INCONSISTENT]
    assert np.isnan(made.velocity_after.values).all(axis=1).tolist() == [False, True, True]
    assert made.released.values.tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("matrix", "before", "more", "text"),
    [
        (COUPLED, [0.1, 0.0], {}, "gap rate"),
        ([[1.0, 2.0], [2.0, 1.0]], [-0.1, 0.0], {}, "positive definite"),
        ([[1.0, 0.2], [0.1, 1.0]], [-0.1, 0.0], {}, "symmetric"),
        ([[-1.0, 0.0], [0.0, 1.0]], [-0.1, 0.0], {}, "D_nn"),
        (COUPLED, [-0.1, np.inf], {}, "inf"),
        (COUPLED, [-0.1, 0.0, 0.0], {}, "shape"),
        ([COUPLED] * 2, [[-0.1, 0.0]] * 3, {}, "Delassus"),
        (COUPLED, [-0.1, 0.0], {"tolerance": 1e-4}, "newton"),
        (COUPLED, [-0.1, 0.0], {"history": 10}, "newton"),
    ],
)
def test_impossible_impacts_are_refused(matrix: Any, before: Any, more: dict[str, Any], text: str) -> None:
    with pytest.raises((ValueError, TypeError), match=text):
        cl.impact(cl.Newton(), matrix, before, **more)


def test_the_page_on_impacts_is_right() -> None:
    names = names_of(DOCS / "impacts.md")
    assert names["many"].sizes["impact"] == 200


@pytest.mark.parametrize("restitution", [0.95, 0.6, 0.2, 0.03, 0.004])
def test_a_contact_under_a_dashpot_ends_where_its_force_does(restitution: float) -> None:
    """Schwager and Poeschel (2007): the spring and the dashpot balance before the gap opens."""
    stiffness, mass, speed = 1e6, 2e-3, 0.1
    normal, damping = cl.Linear(stiffness=stiffness), LinearDamping(restitution, mass, speed)
    c = float(damping.solved(normal)["damping_coefficient"])
    omega, decay = sqrt(stiffness / mass), c / (2.0 * mass)
    root = cmath.sqrt(omega**2 - decay**2)
    # k d + c dd/dt = 0 of d = v exp(-b t) sin(w t)/w.
    expected = abs(cmath.atan(2.0 * decay * root / (2.0 * decay**2 - omega**2)) / root)
    if decay < omega / sqrt(2.0):
        expected = (pi - expected * root.real) / root.real
    law = cl.Composed(normal=normal, damping=damping)
    result = cl.impact(law, [[1.0 / mass, 0.0], [0.0, 3.5 / mass]], [-speed, 0.01])
    assert float(result.duration[0]) == pytest.approx(expected, rel=1e-5)
    assert 0.0 <= float(result.stick_duration[0]) <= float(result.duration[0])
    fall = cl.simulate(block(mass, height=1e-7, gap_rate=-speed), law, duration=1e-3)
    assert float(fall.contacts.duration[0]) == pytest.approx(expected, rel=1e-5)
    assert float(fall.contacts.separation_velocity[0]) == pytest.approx(restitution * speed, rel=1e-5)


def test_no_impact_depends_on_those_before() -> None:
    law = cl.Composed(damping=cl.HuntCrossley())
    speeds = [0.1, 1.0]
    before = cl.normal_impact(law, speeds, mass=1e-3)
    for far in (1e300, 3e8, float("inf")):
        with pytest.raises(ValueError, match=r"speed|velocity"):
            cl.normal_impact(law, [far], mass=1e-3)
        with pytest.raises(ValueError, match=r"velocity|finite"):
            cl.impact(law, np.eye(2), [-1.0, far])
    # At the bound itself forces may overflow; what comes of it stays with this call.
    cl.normal_impact(law, [1e-300, 2.9e8], mass=1e-3)
    assert cl.normal_impact(law, speeds, mass=1e-3).identical(before)
    impacts = Impacts(COUPLED, [-0.3, 0.1])
    first = impacts.velocities_after(law)
    impacts.velocities_after(cl.Composed(cl.HertzPoint(1e300)))
    assert_array_equal(impacts.velocities_after(law), first)
