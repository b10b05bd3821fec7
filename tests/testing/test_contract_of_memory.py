"""The contract of laws that remember can be broken: each that is wrong fails the property that it breaks."""

import numpy as np
import pytest
from support import spoilt_memory
from support.spoilt_memory import Dented, LyingOdometer, Odometer, Solid

from contactlab.laws import ContactLaw
from contactlab.laws.composed import Composed
from contactlab.laws.memory import AT_RELEASE, AT_TOUCH
from contactlab.testing import LawContract, flow_properties, kernel_properties
from contactlab.testing.claim import proofs_of
from contactlab.testing.contract import check
from contactlab.testing.flow_properties import image_of
from contactlab.testing.flows import flow_of
from contactlab.testing.plants import Bench

OF_KERNELS = proofs_of(kernel_properties, flow_properties)


class TestSolid(LawContract):
    law = Solid


class TestDented(LawContract):
    law = Dented


class TestOdometer(LawContract):
    law = Composed(friction=Odometer())


def failing(law: ContactLaw) -> set[str]:
    """The properties of its kernels that the contract finds broken."""
    bench = Bench(law)
    return {name for name in OF_KERNELS if not all(claim.holds for claim in check(bench, name))}


CHEATS = {
    "Overshooting": {"flow_keeps_the_ledger"},
    "Pumping": {"kernel_is_consistent"},
    "Forgetting": {"jumps_lose"},
    "Greedy": {"memory_is_its_own"},
    "Owing": {"jumps_lose"},
    "Stubborn": {"guards_let_go"},
    "Crossed": {"limits_in_order"},
}


@pytest.mark.parametrize("name", CHEATS)
def test_a_law_that_remembers_wrongly_fails_where_it_does(name: str) -> None:
    assert failing(getattr(spoilt_memory, name)) == CHEATS[name]


def test_a_variable_whose_parity_lies_is_seen_in_the_mirror_alone() -> None:
    honest, lying = (Bench(Composed(friction=part())) for part in (Odometer, LyingOdometer))
    assert failing(lying.law) == set()
    assert all(claim.true for claim in image_of(honest).values())
    assert not any(claim.true for claim in image_of(lying).values())
    failed = [str(claim) for claim in check(lying, "mirrors") if not claim.holds]
    assert any("internal_way" in sentence for sentence in failed)


def test_a_solid_followed_along_a_path_has_the_creep_of_its_integral() -> None:
    """dz/dt = (d - z) / tau from the touch-down on: z = int d(s) exp(-(t - s)/tau) ds / tau."""
    flow = flow_of(Bench(Solid))
    touches = [jump.at for jump in flow.jumps if jump.event == AT_TOUCH]
    ends = [jump.at.time for jump in flow.jumps if jump.event == AT_RELEASE]
    first, time = touches[0], spoilt_memory.TIME
    checked = 0
    for at in flow.instants:
        if at.path is first.path and first.time < at.time < ends[0]:
            s = np.linspace(first.time, at.time, 20_001)
            depth = np.array([max(-at.path.at(t)[0], 0.0) for t in s.tolist()])
            creep = np.trapezoid(depth * np.exp((s - at.time) / time), s) / time
            assert at.kept[0] == pytest.approx(creep, rel=1e-6)
            checked += 1
    assert checked > 5


def test_a_dented_spring_followed_along_a_path_is_dented_by_the_deepest_less_its_elastic_part() -> None:
    flow, elastic = flow_of(Bench(Dented)), spoilt_memory.YIELD / spoilt_memory.STIFF
    releases = [jump.at for jump in flow.jumps if jump.event == AT_RELEASE]
    touches = [jump.at for jump in flow.jumps if jump.event == AT_TOUCH]
    dents = []
    for touch in touches:
        ends = [each for each in releases if each.path is touch.path and each.time > touch.time]
        if ends and touch.kept[0] == 0.0:
            s = np.linspace(touch.time, ends[0].time, 20_001).tolist()
            deepest = max(-touch.path.at(t)[0] for t in s)
            assert ends[0].kept[0] == pytest.approx(max(deepest - elastic, 0.0), rel=1e-6, abs=1e-15)
            dents.append(ends[0].kept[0])
    assert max(dents) > elastic
