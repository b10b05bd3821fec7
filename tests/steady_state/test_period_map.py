"""The period map takes one state or many to the bit where a run takes each."""

import numpy as np
import pytest

from contactlab.config import build
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap


@pytest.mark.parametrize("law", ["hertz_penalty", "lagrange_stick"])
@pytest.mark.parametrize(("phase", "belt"), [(0.0, None), (0.3, None), (0.3, -2.0)])
def test_states_end_where_runs_from_them_end(law: str, phase: float, belt: float | None) -> None:
    section = PeriodMap(build([f"law={law}"]), phase=phase, periods=2, belt=belt)
    start = section.end_of(section.run(np.zeros(8 if belt else 9), 5.0))
    nudged = start * (1.0 + 1e-3 * np.eye(start.size))
    ends = section.ends(nudged)
    for z, end in zip(nudged, ends, strict=True):
        assert np.array_equal(end, section.end_of(section.run(z)))
        assert np.array_equal(end, section(z))


def test_a_state_inside_the_rotor_has_no_end_under_a_rigid_law() -> None:
    section = PeriodMap(build(["law=newton"]))
    row = section.setup.motor.modes.tip_displacement
    inside = np.zeros(9)
    inside[:4] = 2e-6 * section.scale * row / (row @ row)
    assert np.isnan(section.ends(np.stack([0.0 * inside, inside]))).all(axis=1).tolist() == [False, True]
    with pytest.raises(BrokenOffError, match="tip and rotor would overlap"):
        section(inside)
