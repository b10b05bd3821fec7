"""Every part of a composed law reads its own coefficients, and no other's."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pytest
from support.command_line import cases

from contactlab.compiled import kernel
from contactlab.engine.preparation import take_in
from contactlab.laws import FRICTION_COEFFICIENT, Composed, Friction, LawError, NormalForce, Parameter
from contactlab.laws.damping import DAMPINGS
from contactlab.laws.friction import FRICTIONS
from contactlab.testing.asking import Asked
from contactlab.testing.contract import check
from contactlab.testing.plants import Bench

SHORT = ("coulomb", "ageing_stick", "mindlin", "lugre", "stribeck")
"""Frictions of every kind: set-valued and not, with a memory and without."""

Array = np.ndarray
Forces = tuple[float, float, float, float]


@kernel
def polynomial(depth: float, p: Array, at: int) -> Forces:
    """N = k d (1 + a x + b x^2 + c x^3), x = d/h."""
    k, a, b, c, h = p[at], p[at + 1], p[at + 2], p[at + 3], p[at + 4]
    x = depth / h
    force = k * depth * (1.0 + x * (a + x * (b + x * c)))
    energy = k * depth**2 * (0.5 + x * (a / 3.0 + x * (b / 4.0 + x * c / 5.0)))
    stiffness = k * (1.0 + x * (2.0 * a + x * (3.0 * b + x * 4.0 * c)))
    slope = k / h * (2.0 * a + x * (6.0 * b + x * 12.0 * c))
    return force, energy, stiffness, slope


@dataclass(frozen=True)
class Polynomial(NormalForce):
    """An elastic force of five parameters."""

    name = "polynomial"
    equation = "N = k d (1 + a x + b x^2 + c x^3), x = d/h"
    source = "this test"

    k: Annotated[float, Parameter("k", "N m-1", "stiffness", above=0.0)] = 1e7
    a: Annotated[float, Parameter("a", "1", "first", at_least=0.0)] = 0.1
    b: Annotated[float, Parameter("b", "1", "second", at_least=0.0)] = 0.2
    c: Annotated[float, Parameter("c", "1", "third", at_least=0.0)] = 0.3
    h: Annotated[float, Parameter("h", "m", "depth", above=0.0)] = 1e-6

    elastic = staticmethod(polynomial)


@dataclass(frozen=True)
class Forgetful(Polynomial):
    """Gives one coefficient too few."""

    def coefficients(self) -> tuple[float, ...]:
        return super().coefficients()[:-1]


@dataclass(frozen=True)
class Short(Friction):
    """Set-valued friction that leaves out mu_s / mu, which its cone reads."""

    name = "short"
    equation = "|F| <= mu N"
    source = "this test"

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    def coefficients(self) -> tuple[float, ...]:
        return (self.friction_coefficient,)


@pytest.mark.parametrize("damping", cases(DAMPINGS.values(), [DAMPINGS["linear"]]), ids=DAMPINGS)
@pytest.mark.parametrize(
    "friction", cases(FRICTIONS.values(), [FRICTIONS[name] for name in SHORT]), ids=FRICTIONS
)
def test_a_part_has_as_many_coefficients_as_it_wants(damping: Any, friction: Any) -> None:
    law = Composed(Polynomial(), damping(), friction())
    assert all(claim.holds for claim in check(Bench(law), "parts_keep_apart"))
    asked = Asked(law)
    assert asked.force(-1e-6, 0.0, 0.0, 0.0, asked.initial)[0] == pytest.approx(16.0, rel=1e-14)


def test_a_part_that_is_overwritten_by_another_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    law = Composed(Polynomial(), DAMPINGS["flores"]())
    whole = law.parameters()
    overwritten = whole.copy()
    overwritten[4] = whole[6]
    monkeypatch.setattr(Composed, "parameters", lambda _: overwritten.copy())
    bench = Bench(law)
    assert all(claim.holds for claim in check(bench, "kernel_is_consistent"))
    assert not all(claim.holds for claim in check(bench, "parts_keep_apart"))


def test_a_part_that_reads_what_is_anothers_is_refused() -> None:
    law = Composed(Forgetful(), DAMPINGS["flores"]())
    with pytest.raises(LawError, match="A part may have read beyond its own coefficients"):
        take_in(law)
    assert not all(claim.holds for claim in check(Bench(law), "parts_keep_apart"))


def test_a_part_that_reads_past_the_end_is_refused() -> None:
    with pytest.raises(LawError, match="reads parameters that there are not"):
        take_in(Composed(friction=Short()))
