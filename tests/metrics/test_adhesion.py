"""What a law declares is not held against it: adhesion, its reach, and the cohesion in the cone."""

from math import isnan

import numpy as np
import pytest

from contactlab.laws.base import NormalForce
from contactlab.laws.friction import Coulomb
from contactlab.laws.normal import HertzPoint
from contactlab.laws.normal.dmt import Dmt
from contactlab.laws.normal.jkr import Jkr
from contactlab.metrics import METRICS
from contactlab.metrics.catalogue import NOT_APPLICABLE, measured
from contactlab.metrics.constraints import cone
from contactlab.metrics.run import Run, has_limits

FORCES = (0.0, 2.0, 4.0, 2.0, -1.0, -0.5, -0.25)
"""It pulls before it lets go."""


def made(normal: str, friction: str, friction_force: float = 0.0, **parameters: float) -> Run:
    """A run of a composed law with seven records, in contact from the second on."""
    force = np.array(FORCES)
    columns = {
        "time": np.arange(7) * 1e-6,
        "gap": np.array([5e-8, -5e-8, -1e-7, -5e-8, 5e-8, 1.5e-7, 2.5e-7]),
        "normal_force": force,
        "friction_force": np.where(force == 4.0, friction_force, 0.0),
        "tip_normal_displacement": np.array([0.0, 1e-7, 2e-7, 1e-7, 0.0, -1e-7, -2e-7]),
    }
    rows = {"normal_impulse": np.array([force.sum() * 1e-6]), "duration": np.array([6e-6])}
    chosen = {"name": "composed", "normal": {"name": normal}, "friction": {"name": friction}}
    return Run(
        columns=columns,
        rows=rows,
        configuration={"law": chosen, "contact": {"friction_coefficient": 0.3}},
        law="composed",
        law_parameters={f"friction.{name}": value for name, value in parameters.items()},
        contact_step=0.0,
    )


class Dent(NormalForce):
    """Says where its contacts begin."""

    limits = staticmethod(min)


def of_normal(part: type[NormalForce]) -> Run:
    """A run with a normal force by its class and Coulomb's friction."""
    run = made("hertz_point", "coulomb")
    run.__dict__["law_classes"] = {"normal": part, "friction": Coulomb}
    return run


def value_of(run: Run, key: str) -> float:
    return measured(METRICS, run, (key,))[key]


@pytest.mark.parametrize(
    ("normal", "tension", "force_at_distance"),
    [(HertzPoint, True, True), (Dmt, False, True), (Jkr, False, False)],
)
def test_a_pull_is_held_against_a_law_that_declares_none_and_its_reach_likewise(
    normal: type[NormalForce], tension: bool, force_at_distance: bool
) -> None:
    run = of_normal(normal)
    for key, judged in (("tension", tension), ("force_at_distance", force_at_distance)):
        value = value_of(run, key)
        assert isnan(value) != judged
        assert (METRICS[key].verdict(value) == NOT_APPLICABLE) != judged
        if judged:
            assert value > METRICS[key].bound


def test_cohesion_that_is_declared_widens_the_cone() -> None:
    plain, cohesive = made("hertz_point", "coulomb"), made("hertz_point", "cohesive", cohesion=2.0)
    assert (cone(plain), cone(cohesive)) == ((0.3, 0.0), (0.3, 2.0))
    # 0.3 of 4 N, and of 2 N more.
    for friction, narrow, wide in ((1.1, True, True), (1.5, False, True), (2.0, False, False)):
        for name, values, inside in (("coulomb", {}, narrow), ("cohesive", {"cohesion": 2.0}, wide)):
            value = value_of(made("hertz_point", name, friction, **values), "cone_excess")
            assert (value == 0.0) is inside


def test_where_adhesion_begins_to_pull_a_mean_is_not_held_to_the_cone() -> None:
    run = of_normal(Jkr)
    run.columns["friction_force"][[1, 3, 4]] = 10.0
    assert value_of(run, "cone_excess") == 0.0
    run.columns["friction_force"][2] = 10.0
    assert value_of(run, "cone_excess") > METRICS["cone_excess"].bound


def test_an_overlap_that_a_law_says_is_no_contact_is_no_missed_one() -> None:
    for part, judged in ((HertzPoint, True), (Dent, False)):
        run = of_normal(part)
        run.columns["contact_mode"] = np.zeros(7)
        assert isnan(value_of(run, "missed_contact")) != judged
        assert has_limits(part) != judged
