"""Laws of bare functions: the numbers of the classes that they stand for, what is found of them, refusals."""

import json
import pickle
from collections.abc import Callable
from math import sqrt
from typing import Any

import numpy as np
import pytest

import contactlab as cl
from contactlab.foreign import is_own
from contactlab.metrics import read_run
from contactlab.testing import declare
from contactlab.testing.contract import PROPERTIES, check
from contactlab.testing.plants import Bench, paper_motor


def hertz(depth: float, stiffness: float = 1e10) -> float:
    return stiffness * depth * sqrt(depth)


def interpreted(depth: float, stiffness: float = 1e10) -> float:
    # A text is nothing that a kernel may make.
    return {f"{depth}": stiffness * depth * sqrt(depth)}[f"{depth}"]


def lossy(depth: float, depth_rate: float, stiffness: float = 1e7, time: float = 1e-6) -> float:
    return stiffness * (depth + time * max(depth_rate, 0.0))


def creep(normal: float, slip: float, mu: float = 0.3, velocity: float = 1e-3) -> float:
    return -mu * normal * slip / sqrt(slip * slip + velocity**2)


def pushing(normal: float, slip: float, mu: float = 0.3, velocity: float = 1e-3) -> float:
    return mu * normal * slip / sqrt(slip * slip + velocity**2)


def cone(normal: float, friction_coefficient: float = 0.3) -> float:
    return friction_coefficient * normal


def run(law: cl.ContactLaw) -> Any:
    return cl.simulate(paper_motor(), law, duration=1e-3)


@pytest.mark.parametrize(
    ("bare", "known"),
    [
        (lambda: cl.law(hertz), cl.HertzPenalty),
        (lambda: cl.law(hertz, friction=cl.friction(cone)), cl.HertzPenalty),
        (lambda: cl.law(interpreted), cl.HertzPenalty),
        (lambda: cl.law(hertz, stiffness=2e10, damping="none"), lambda: cl.HertzPenalty(stiffness=2e10)),
        (lambda: cl.Composed(friction=cl.friction(creep)), lambda: cl.Composed(friction=cl.Regularised())),
    ],
    ids=["normal force", "friction too", "interpreted", "parameter", "force of the slip"],
)
def test_a_function_has_the_bits_of_the_class_whose_formula_it_is(bare: Any, known: Any) -> None:
    made, expected = run(bare()), run(known())
    assert made.contacts["start_time"].size > 1
    for name in ("normal_force", "friction_force", "rotor_velocity", "contact_loss"):
        assert np.array_equal(made[name], expected[name])
    # A quadrature in place of 2/5 K d^(5/2).
    np.testing.assert_allclose(made["contact_energy"], expected["contact_energy"], rtol=1e-13, atol=1e-25)


def test_stiffness_and_slope_are_those_of_the_formula() -> None:
    part, known = cl.law(hertz).normal, cl.HertzPoint(1e10)
    for depth in (1e-9, 1e-7, 1e-5):
        made, expected = (each.evaluate("elastic", depth=depth) for each in (part, known))
        np.testing.assert_allclose(made, expected, rtol=1e-8)


def test_a_loss_is_what_the_force_has_beyond_that_at_rest() -> None:
    force, stored, _, _, loss = cl.law(lossy).normal.evaluate("force", depth=1e-6, depth_rate=0.2)
    np.testing.assert_allclose((force, stored, loss), (12.0, 5e-6, 0.4), rtol=1e-12)


@pytest.mark.parametrize(
    ("law", "broken"),
    [
        (lambda: cl.law(hertz), set()),
        (lambda: cl.law(lossy), set()),
        (lambda: cl.Composed(friction=cl.friction(creep)), set()),
        (lambda: cl.Composed(friction=cl.friction(pushing)), {"friction_opposes_slip", "dissipates"}),
    ],
    ids=["elastic", "lossy", "creeps", "pushes"],
)
def test_the_contract_tells_a_law_that_makes_energy(law: Callable[[], Any], broken: set[str]) -> None:
    declared: Any = declare(law())
    about_energy = {"friction_opposes_slip", "dissipates", "ledger_closes", "flow_keeps_the_ledger"}
    assert about_energy & set(declared.violations) == broken


def test_a_law_with_what_is_found_keeps_its_contract() -> None:
    bench = Bench(declare(cl.law(hertz, friction=cl.friction(cone))))
    assert [name for name in PROPERTIES if not all(claim.holds for claim in check(bench, name))] == []


def test_a_bare_law_is_held_to_no_units_and_to_its_stiffness_at_rest() -> None:
    # The first example of the page.
    law = cl.law(lambda depth, depth_rate, stiffness=1e7, c=0.1: stiffness * depth * (1 + c * depth_rate))
    bench = Bench(law)
    for name in ("scales_with_units", "part_says_its_stiffness"):
        assert all(claim.holds for claim in check(bench, name))


def test_what_a_function_raises_names_it_and_the_state() -> None:
    with pytest.raises(ValueError, match=r"divided .*ZeroDivisionError.*normal = .*slip = "):
        cl.friction(divided)


def test_a_law_of_classes_declares_itself() -> None:
    with pytest.raises(TypeError, match="composed"):
        declare(cl.Composed())


def test_a_file_has_text_and_parameters_of_the_function(tmp_path: Any) -> None:
    made = run(
        cl.law(lambda depth, k=2e7: k * depth, friction=cl.friction(lambda normal, mu=0.3: mu * normal))
    )
    made.save(tmp_path / "run.nc")
    attributes = read_run(tmp_path / "run.nc").attrs
    assert "lambda depth, k=20000000.0: k * depth" in attributes["law_origin"]
    assert "lambda normal, mu=0.3: mu * normal" in attributes["law_origin"]
    assert json.loads(attributes["law_parameters"]) == {"normal.k": 2e7, "friction.mu": 0.3}
    # As a class of a script, which no name leads to either.
    assert cl.compare([tmp_path / "run.nc"]).data is not None


def test_parts_of_a_function_are_no_code_of_the_package() -> None:
    assert not is_own(type(cl.law(hertz).normal))
    assert cl.law(hertz).changed("normal.stiffness", 2e10).normal.stiffness == 2e10


def test_another_process_is_refused() -> None:
    with pytest.raises(TypeError, match="NormalForce"):
        pickle.dumps(cl.law(hertz))


def kinked(depth: float) -> float:
    return 1e6 * depth if depth < 1e-7 else 2e6 * depth


def one_sided(normal: float, slip: float) -> float:
    return normal if slip > 0.0 else -2.0 * normal


def jumping(normal: float, slip: float, mu: float = 0.3) -> float:
    return -mu * normal * np.sign(slip) / (1.0 + abs(slip))


def divided(normal: float, slip: float) -> float:
    return normal / (slip - slip)


@pytest.mark.parametrize(
    ("make", "error", "named"),
    [
        (lambda: cl.law(lambda depth, rate: depth * rate), ValueError, "depth_rate"),
        (lambda: cl.law(lambda approach, d_nn: approach / d_nn), ValueError, "MultiplierLaw"),
        (lambda: cl.law(kinked), ValueError, "NormalForce"),
        (lambda: cl.law(lambda *depth: depth[0]), ValueError, "depth"),
        (lambda: cl.law(lambda depth, k="stiff": k * depth), TypeError, "stiff"),
        (lambda: cl.law(hertz, stifness=1e9), TypeError, "stiffness"),
        (lambda: cl.law(cl.Newton), TypeError, "Newton"),
        (lambda: cl.law(3), TypeError, "3"),
        (lambda: cl.friction(one_sided), ValueError, "bounds"),
        (lambda: cl.friction(jumping), ValueError, "magnitude"),
        (lambda: cl.friction(lambda normal, age: normal * age), ValueError, "age"),
        (lambda: cl.friction(cone, mu=0.2), TypeError, "mu"),
    ],
)
def test_what_needs_a_class_is_refused(make: Callable[[], Any], error: type[Exception], named: str) -> None:
    with pytest.raises(error, match=named):
        make()
