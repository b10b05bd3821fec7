"""The benchmark of impacts asks every law it names, and times both ways of asking."""

import benchmark_impacts
import pytest

from contactlab.laws import LAWS


@pytest.mark.long
def test_every_law_of_the_table_is_timed() -> None:
    timings = benchmark_impacts.measure(20, 1e-4)
    assert {each.name for each in timings} == {*LAWS, *benchmark_impacts.COMPOSED} - {"composed"}
    assert all(each.dataset > 0.0 and each.arrays > 0.0 and each.unanswered == 0 for each in timings)
