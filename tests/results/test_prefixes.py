"""Numbers for people have a handy unit."""

import pytest

from contactlab.results.prefixes import prefixed, prefixed_unit


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (2.0, "2 s"),
        (5e-3, "5 ms"),
        (1e-3, "1 ms"),
        (0.9999999e-3, "1 ms"),
        (248.31e-6, "248.3 µs"),
        (3e-9, "3 ns"),
        (-2e-3, "-2 ms"),
        (0.0, "0 s"),
    ],
)
def test_a_time_is_read_in_its_own_unit(size: float, text: str) -> None:
    assert prefixed(size, "s") == text


def test_a_smaller_number_is_kept_in_the_larger_unit_on_request() -> None:
    assert prefixed_unit(0.5e-6, "m", smallest=0.1) == ("µm", 1e-6)
    assert prefixed_unit(0.5e-6, "m") == ("nm", 1e-9)
