"""Closed forms of small plants, and the published results of every law and part."""

from collections.abc import Callable, Iterator
from math import exp, pi, sqrt

import pytest
from support import closed_forms, published
from support.closed_forms import dashpot_impacts, hertz_impact, modal_impacts, restitution
from support.published import PUBLISHED
from support.tensile_dashpot import TensileDashpot

from contactlab.laws import LAWS, PARTS
from contactlab.testing import Claim
from contactlab.testing.claim import proofs_of
from contactlab.testing.plants import block, first, run

Form = Callable[..., Iterator[Claim]]


def assert_all(claims: Iterator[Claim]) -> None:
    failed = [str(claim) for claim in claims if not claim.holds]
    assert not failed, "\n".join(failed)


OF_LAWS = proofs_of(published)
FORMS = proofs_of(closed_forms) | OF_LAWS


@pytest.mark.parametrize("form", FORMS.values(), ids=list(FORMS))
def test_closed_form(form: Form) -> None:
    assert_all(form())


def test_every_published_result_is_of_a_law_or_part() -> None:
    parts = {f"{family}_{name}" for family, table in PARTS.items() for name in table}
    assert {*LAWS, *parts, *(name for table in PARTS.values() for name in table)} >= set(PUBLISHED)
    assert {proof for proofs in PUBLISHED.values() for proof in proofs} >= set(OF_LAWS.values())


OTHER_VALUES = [
    *((hertz_impact, (1e-2, speed, k)) for speed in (1e-3, 0.05, 2.0) for k in (1e7, 1e12)),
    *((dashpot_impacts, (1e-2, 0.5, ratio)) for ratio in (0.01, 0.1, 0.6, 0.9)),
    *((modal_impacts, (seed,)) for seed in range(2, 12)),
]
"""Closed forms and their arguments: mass, speed and stiffness or damping ratio; seed of a body."""


@pytest.mark.parametrize(("form", "values"), OTHER_VALUES)
def test_closed_form_at_other_values(form: Form, values: tuple[float, ...]) -> None:
    assert_all(form(*values))


@pytest.mark.parametrize("ratio", [0.01, 0.3, 0.9])
def test_a_dashpot_that_pulls_is_released_where_the_gap_opens(ratio: float) -> None:
    # d = exp(-b t) sin(w t) v/w, b = ratio w_0, w = w_0 sqrt(1 - ratio^2)
    mass, stiffness, speed = 1e-2, 1e7, 0.5
    rate = sqrt(stiffness / mass)
    b, w = ratio * rate, rate * sqrt(1.0 - ratio**2)
    law = TensileDashpot(stiffness, 2.0 * b * mass)
    ball = block(mass, height=1e-6, gap_rate=-speed)
    result = run(ball, law, 1e-6 / speed + 2.0 * pi / w)
    assert restitution(result) == pytest.approx(exp(-pi * b / w), rel=0.0, abs=1e-6)
    assert first(result, "duration") == pytest.approx(pi / w, rel=1e-6)
