"""A sound law is taken in, however narrow its domain and whatever it remembers."""

from math import log
from typing import Any

import numpy as np
import pytest
from support.made_laws import honest, made, variable

from contactlab.compiled import kernel
from contactlab.engine import simulate
from contactlab.laws import LAWS
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.laws.composed import Composed
from contactlab.laws.damping import DAMPINGS
from contactlab.laws.friction import FRICTIONS
from contactlab.laws.memory import EVEN
from contactlab.laws.normal import NORMAL_FORCES
from contactlab.testing.contract import check
from contactlab.testing.plants import Bench, block, paper_motor


@kernel
def thin_layer(gap):
    # N = -P log(1 - d/h): no number from the depth h on.
    load, thickness = 1e2, 1e-5
    left = 1.0 + gap / thickness
    energy = load * (thickness * left * np.log(left) - gap)
    normal = -load * np.log(left)
    return normal, 0.3 * normal, energy, 0.0


def interpreted_layer(gap):
    # It raises from the depth h on, as Python does.
    left = 1.0 + gap / 1e-5
    state: dict[str, Any] = {"log": log(left), "text": [f"{gap}"]}
    normal, energy = -1e2 * state["log"], 1e-3 * (left * log(left) - left + 1.0)
    return normal, 0.0, energy, 0.0


@pytest.mark.parametrize("function", [thin_layer, interpreted_layer])
def test_a_law_that_has_an_end_of_its_domain_is_taken(function: Any) -> None:
    law = made(function, friction_limit=0.3)
    run = simulate(paper_motor(), law, duration=3e-4, record_interval=1e-6)
    assert run.complete
    assert run.series["normal_force"].max() > 0.0


@pytest.mark.parametrize(
    "law",
    [
        *(law() for law in LAWS.values()),
        *(Composed(normal=part()) for part in NORMAL_FORCES.values()),
        *(Composed(damping=part()) for part in DAMPINGS.values()),
        *(Composed(friction=part()) for part in FRICTIONS.values()),
    ],
    ids=lambda law: law.title,
)
def test_every_law_of_the_package_is_taken(law: Any) -> None:
    still = block(height=1.0)
    assert simulate(still, law, duration=1e-6, record_interval=1e-6).complete


@kernel
def ageing(slip, normal, age):
    """The longer contact lasts without slip, the more it drags; its age [s] is the same in a mirror."""
    share = slip / np.sqrt(slip * slip + 1e-6)
    strength = 1.0 + 0.2 * age / (age + 1e-5)
    return -0.3 * normal * share * strength, 1.0 - 1e4 * abs(slip) * age, 0.0, 0.0


@pytest.mark.parametrize("parity", [EVEN, -EVEN])
def test_what_friction_remembers_may_be_even_in_a_mirror(parity: int) -> None:
    law = made(
        honest,
        friction=ageing,
        friction_kind=RATE_DEPENDENT,
        internal_variables=(variable(parity=parity),),
        exact_stick=False,
        friction_limit=0.36,
    )
    assert all(claim.holds for claim in check(Bench(law), "mirrors")) == (parity == EVEN)
