"""A law by itself: impacts against closed forms, against the whole engine, and against themselves."""

from dataclasses import dataclass, replace
from itertools import product
from math import gamma, pi, sqrt
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from support.pages import DOCS, names_of

import contactlab as cl
from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.impacts import Impacts, velocities_after
from contactlab.laws import LAWS, PARTS
from contactlab.laws.base import SLIP, STICK
from contactlab.motor.bodies import FLAT, HEAVY, block
from contactlab.testing.plants import coupled_body
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


def test_newton_on_a_decoupled_body_is_restitution_and_a_cone() -> None:
    matrices, rates = drawn(50, coupling=0.0)
    e = 0.6
    made = cl.impact(cl.Newton(MU, e), matrices, rates)
    nn, tt = matrices[:, 0, 0], matrices[:, 1, 1]
    normal = (1.0 + e) * -rates[:, 0] / nn
    friction = np.clip(-rates[:, 1] / tt, -MU * normal, MU * normal)
    assert_allclose(made.impulse, np.column_stack([normal, friction]), rtol=1e-13)
    slides = abs(friction) == MU * normal
    assert 0 < slides.sum() < 50
    assert_array_equal(made.mode, np.where(slides, SLIP, STICK))
    assert made.released.all()
    assert (made.duration == 0.0).all()
    assert made.peak_normal_force.isnull().all()


def test_poisson_that_slides_all_through_has_its_closed_form() -> None:
    (nn, nt), (_, tt) = COUPLED
    e, before = 0.7, np.array([-0.1, 2.0])
    normal = (1.0 + e) * -before[0] / (nn - MU * nt)
    expected = before + np.array([nn - MU * nt, nt - MU * tt]) * normal
    assert expected[1] > 0.0
    assert_allclose(velocities_after(cl.Poisson(MU, e), COUPLED, before)[0], expected, rtol=1e-13)


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
    alone = [velocities_after(law, *one)[0] for one in zip(matrices, rates, strict=True)]
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


def test_twice_the_mass_on_twice_the_stiffness_rebounds_alike() -> None:
    matrices, rates = drawn(12, seed=3)
    for factor in (2.0, 1e6):
        one, other = (
            cl.impact(cl.HertzPenalty(1e9 * scale, MU), matrices / scale, rates) for scale in (1.0, factor)
        )
        assert_allclose(other.velocity_after, one.velocity_after, rtol=0.0, atol=1e-11)
        assert_allclose(other.duration, one.duration, rtol=1e-9)
        assert_allclose(other.impulse, factor * one.impulse, rtol=1e-9, atol=1e-12 * factor)


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
        found = cl.impact(law, rows @ rows.T, before, **tight)
        run = simulate(motor, law, duration=1e-3, record_interval=1e-3, contact_step=1.3e-6, **tight)
        assert run.complete
        assert run.contacts["duration"].size == 1
        for name in ("duration", "peak_normal_force", "max_penetration"):
            assert_allclose(found[name], run.contacts[name], rtol=1e-7)
        assert_allclose(found.velocity_after[0, 0], run.contacts["separation_velocity"][0], rtol=1e-8)
        assert_allclose(found.velocity_after[0, 1], run.series["slip_velocity"][-1], rtol=0.0, atol=1e-8)


def test_answers_converge_with_the_tolerance() -> None:
    matrices, rates = drawn(12, seed=4)
    exact = velocities_after(SMOOTH[1], matrices, rates, 1e-12)
    missed = [
        abs(velocities_after(SMOOTH[1], matrices, rates, tolerance) - exact).max()
        for tolerance in (1e-3, 1e-6, 1e-9)
    ]
    assert missed[0] < 1e-3
    assert missed[1] < 1e-6
    assert missed[2] < 1e-9


@pytest.mark.parametrize("name", sorted(LAWS))
def test_every_registered_law_answers(name: str) -> None:
    assert np.isfinite(velocities_after(cl.law(name), COUPLED, [[-0.1, 0.05], [-0.01, -0.3]])).all()


@pytest.mark.long
@pytest.mark.parametrize(("family", "name"), [(family, name) for family in PARTS for name in PARTS[family]])
def test_every_part_of_a_composed_law_answers(family: str, name: str) -> None:
    matrices, rates = drawn(5)
    found = cl.impact(cl.law("composed", **{family: name}), matrices, rates, tolerance=1e-4)
    assert (found.status == Ending.COMPLETE).all()
    assert found.released.all()


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


def test_painleves_paradox_leaves_no_number_and_says_so() -> None:
    matrix = [[1.0, 2.0], [2.0, 5.0]]
    made = cl.impact(cl.LagrangeSlip(0.9), [COUPLED, matrix, matrix], [[-0.1, 1.0]] * 3)
    assert made.status.values.tolist() == [Ending.COMPLETE, Ending.INCONSISTENT, Ending.INCONSISTENT]
    assert np.isnan(made.velocity_after.values).all(axis=1).tolist() == [False, True, True]
    assert made.released.values.tolist() == [True, False, False]
    assert "Painleve's paradox" in str(made.reason.values[1])
    assert "0.5" in str(made.reason.values[1])
    assert str(made.reason.values[2]) == "As impact 1."


@dataclass(frozen=True)
class Spring(cl.PenaltyLaw):
    """A law that only the interpreter runs: the compiler takes no dictionary like this."""

    name = "python_spring"
    equation = "N = k d"
    source = "a test"
    default_contact_step = 4e-6
    stiffness: float = 1e7
    fault: float = 0.0
    """Depth from which on it raises [m]; zero for none."""

    @property
    def force(self) -> Any:
        fault = self.fault

        def spring(gap, gap_rate, slip, impact_speed, parameters):
            kept = {"stiffness": parameters[0], 3: "of another kind"}
            if fault and -gap > fault:
                raise ArithmeticError("too deep")
            normal = kept["stiffness"] * max(-gap, 0.0)
            return normal, 0.3 * normal, -0.5 * normal * gap, 0.0

        return spring


def test_a_law_that_the_interpreter_runs_answers_as_the_compiled_one() -> None:
    linear = cl.Composed(normal=cl.Linear(stiffness=1e7), friction=cl.Coulomb(0.3))
    one, other = (velocities_after(law, COUPLED, [-0.1, 0.05]) for law in (Spring(), linear))
    assert_allclose(one, other, rtol=1e-12)


def test_what_a_law_raises_is_a_sentence_of_its_own() -> None:
    with pytest.raises(cl.LawError, match="python_spring raised ArithmeticError: too deep"):
        cl.impact(Spring(fault=1e-6), COUPLED, [-0.1, 0.05])


def test_prepared_impacts_are_asked_with_any_law() -> None:
    matrices, rates = drawn(8)
    impacts = Impacts(matrices, rates)
    for mu, law in product((0.1, 0.4), (cl.Newton, cl.HertzPenalty)):
        chosen: cl.ContactLaw = law(friction_coefficient=mu)
        assert_array_equal(impacts.velocities_after(chosen), velocities_after(chosen, matrices, rates))


@pytest.mark.parametrize(
    ("matrix", "before", "more", "words"),
    [
        (COUPLED, [0.1, 0.0], {}, "Impact 0, counted from 0, has a gap rate of 0.1 m/s"),
        (COUPLED, [[-0.1, 0.0], [0.0, 1.0]], {}, "Impact 1, counted from 0, has a gap rate of 0 m/s"),
        ([[1.0, 2.0], [2.0, 1.0]], [-0.1, 0.0], {}, "must be positive definite"),
        ([[1.0, 0.2], [0.1, 1.0]], [-0.1, 0.0], {}, "must be symmetric"),
        ([[-1.0, 0.0], [0.0, 1.0]], [-0.1, 0.0], {}, "D_nn must be positive"),
        ([[1.0, 0.0], [0.0, 0.0]], [-0.1, 0.0], {}, "D_tt must be positive"),
        ([[1.0, np.nan], [np.nan, 1.0]], [-0.1, 0.0], {}, "has nan among its numbers"),
        (COUPLED, [-0.1, np.inf], {}, "has inf among its numbers"),
        (COUPLED, [-0.1, 0.0, 0.0], {}, "must have shape"),
        ([1.0, 2.0], [-0.1, 0.0], {}, "must have shape"),
        ([COUPLED] * 2, [[-0.1, 0.0]] * 3, {}, "2 Delassus matrices and 3 velocities"),
        (np.zeros((0, 2, 2)), np.zeros((0, 2)), {}, "There is no impact"),
        (COUPLED, "fast", {}, "must be a NumPy array of numbers"),
        (COUPLED, [-0.1, 0.0], {"tolerance": 1e-4}, "newton has no error control"),
        (COUPLED, [-0.1, 0.0], {"history": 10}, "newton is rigid"),
        (COUPLED, [-0.1, 0.0], {"history": -1}, "The history has -1 records"),
        (COUPLED, [-0.1, 0.0], {"history": 1.5}, "The number of records is 1.5"),
    ],
)
def test_what_is_no_impact_is_refused_in_a_sentence(
    matrix: Any, before: Any, more: dict[str, Any], words: str
) -> None:
    with pytest.raises((ValueError, TypeError), match=words):
        cl.impact(cl.Newton(), matrix, before, **more)


def test_what_is_no_law_and_no_tolerance_is_refused() -> None:
    with pytest.raises(TypeError, match="the text 'newton'"):
        velocities_after("newton", COUPLED, [-0.1, 0.0])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must lie between 0 and 1"):
        velocities_after(cl.HertzPenalty(), COUPLED, [-0.1, 0.0], 2.0)


def test_a_law_leaves_the_motor_alone_that_runs_after_it() -> None:
    motor, law = block(MASS, height=1e-6, gap_rate=-0.1, velocity=0.05, belt_mass=HEAVY), SMOOTH[0]
    one = simulate(motor, law, duration=2e-4, record_interval=1e-6)
    velocities_after(law, *drawn(3))
    other = simulate(motor, law, duration=2e-4, record_interval=1e-6)
    for name, values in one.series.items():
        assert_array_equal(values, other.series[name], strict=True)


def test_the_page_on_impacts_is_right() -> None:
    names = names_of(DOCS / "impacts.md")
    assert names["many"].sizes["impact"] == 200
