"""A claim holds where its relation does, a NaN never keeps one, and an excuse must be needed."""

import pytest

from contactlab.testing.claim import at_least, at_most, close

NAN = float("nan")


@pytest.mark.parametrize(("value", "true"), [(0.9, True), (1.0, True), (1.1, False)])
def test_an_upper_bound_may_be_reached_but_not_passed(value: float, true: bool) -> None:
    assert at_most("what is found", value, 1.0).true is true
    assert at_least("what is found", -value, -1.0).true is true


@pytest.mark.parametrize(("value", "true"), [(2.2, True), (1.8, True), (2.21, False), (1.79, False)])
def test_a_value_may_be_off_by_its_share_to_either_side(value: float, true: bool) -> None:
    assert close("what is found", value, 2.0, 0.1001).true is true
    assert close("what is found", value - 2.0, 0.0, 0.1001, scale=2.0).true is true


@pytest.mark.parametrize(("value", "expected"), [(NAN, 1.0), (1.0, NAN), (NAN, NAN)])
def test_a_nan_keeps_no_claim(value: float, expected: float) -> None:
    claims = (
        at_most("a bound", value, expected),
        at_least("a bound", value, expected),
        close("a value", value, expected, 1.0),
    )
    for claim in claims:
        assert not claim.true
        assert not claim.holds
        assert claim.verdict == "FAILS"


def test_an_excuse_holds_where_the_claim_is_broken_and_only_there() -> None:
    broken, kept = at_most("a bound", 2.0, 1.0), at_most("a bound", 0.0, 1.0)
    assert (broken.holds, kept.holds) == (False, True)
    assert (broken.excused("a reason").holds, kept.excused("a reason").holds) == (True, False)
