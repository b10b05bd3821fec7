"""A rigid law that cannot be is refused when it is taken in."""

from dataclasses import dataclass
from typing import Any

import pytest
from support.made_laws import TWO, flowing, short_run

from contactlab.compiled import kernel
from contactlab.laws import LawError, MultiplierLaw
from contactlab.laws.base import SLIP


@kernel
def nowhere(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return -normal_rate / d_nn, 0.0, 7


@kernel
def endless(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return 0.1 / d_nn, -1e-3 * slip / abs(slip), SLIP


@kernel
def halfway(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return -0.5 * normal_rate / d_nn, 0.0, SLIP


@kernel
def bouncing(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return -normal_rate / d_nn, 0.0, SLIP


@pytest.mark.parametrize(
    "words", [{}, {"rate": staticmethod(flowing)}, {"told": True}], ids=["none", "rate", "told"]
)
def test_a_rigid_law_that_remembers_without_being_told_is_refused(words: dict[str, Any]) -> None:
    @dataclass(frozen=True)
    class Rigid(MultiplierLaw):
        name = "rigid"
        equation = "g = 0"
        source = "this test"
        default_contact_step = 5e-8
        internal_variables = TWO[1:]

        solve = staticmethod(bouncing)

    remembering = dataclass(frozen=True)(type("Remembering", (Rigid,), words))
    with pytest.raises(LawError, match="no kernel rate or jump, or does not say told = True"):
        short_run(remembering())


@pytest.mark.parametrize("name", ["limits", "guard"])
def test_a_rigid_law_with_limits_or_guards_is_refused(name: str) -> None:
    @dataclass(frozen=True)
    class Rigid(MultiplierLaw):
        name = "rigid"
        equation = "g = 0"
        source = "this test"
        default_contact_step = 5e-8

        solve = staticmethod(bouncing)

    limited = dataclass(frozen=True)(type("Limited", (Rigid,), {name: staticmethod(flowing)}))
    with pytest.raises(LawError, match="a rigid contact begins and ends at a gap of zero"):
        short_run(limited())


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (nowhere, "the mode is 7"),
        (endless, "its kernel solve gives"),
        (halfway, "leaves an approach of 0.005 m/s in an impact with a gap rate of -0.01 m/s"),
    ],
)
def test_a_rigid_law_that_cannot_be_is_refused(function: Any, words: str) -> None:
    @dataclass(frozen=True)
    class Rigid(MultiplierLaw):
        name = "rigid"
        equation = "g = 0"
        source = "this test"
        default_contact_step = 5e-8

        @property
        def solve(self) -> Any:
            return function

    with pytest.raises(LawError, match=words):
        short_run(Rigid())
