"""Claims on how a number is written with its error: no value whose error is not below its size."""

from re import fullmatch

import numpy as np
import pytest
from hypothesis import given, strategies as st

import contactlab as cl
from contactlab.estimate import EXACT_DIGITS, MOST_DIGITS, ROUND_OFF
from contactlab.quantity import to_si
from contactlab.studies.tables import UNIT, as_html, as_latex, as_text, table, with_unit

SIZES = st.floats(-300.0, 300.0).map(lambda exponent: 10.0**exponent)

VALUES = st.one_of(st.just(0.0), SIZES, SIZES.map(lambda x: -x))

NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?"

ONE_UNIT = st.floats(-15.0, 11.0).map(lambda exponent: 10.0**exponent)


def digits_of(text: str) -> int:
    """The significant digits of a number, zeros at its end included."""
    return len(text.lstrip("-").partition("e")[0].replace(".", "").lstrip("0"))


@given(VALUES, SIZES)
def test_a_value_is_printed_only_if_its_error_is_below_its_size(value: float, error: float) -> None:
    text = cl.Estimate(value, error).text()
    if bound := fullmatch(f"0 within ({NUMBER})", text):
        assert error >= abs(value)
        exact = abs(value) + error
        assert (1.0 - 1e-8) * exact <= float(bound[1]) <= 1.1 * exact
        assert digits_of(bound[1]) in (2, 3)
    elif parts := fullmatch(rf"({NUMBER}) \+- ({NUMBER})", text):
        assert error < abs(value)
        assert float(parts[2]) == pytest.approx(error, rel=0.051)
        assert abs(float(parts[1]) - value) <= max(
            0.051 * error, 0.51 * 10.0 ** (1 - MOST_DIGITS) * abs(value)
        )
    else:
        assert fullmatch(NUMBER, text)
        assert error <= ROUND_OFF * abs(value)
        assert float(text) == pytest.approx(value, rel=10.0**-EXACT_DIGITS * 5.1)


@given(SIZES, st.floats(-0.99, 0.0).map(lambda exponent: 10.0 ** (8.0 * exponent)))
def test_the_last_digit_of_a_value_is_that_of_its_error(value: float, share: float) -> None:
    text, error = cl.Estimate(value, share * value).text().replace("0 within", "0 +-").split(" +- ")
    decimals = [len((x.partition("e")[0] + ".").split(".")[1]) for x in (text, error)]
    if "e" not in text + error and text != "0":
        assert decimals[0] == decimals[1] or digits_of(text) >= MOST_DIGITS


@pytest.mark.parametrize("value", [0.0, -0.0, 5.0, -1.0 / 3.0, np.inf])
def test_an_exact_number_has_no_error(value: float) -> None:
    for error in (0.0, np.nan, 1e-16 * abs(value)):
        assert "+-" not in cl.Estimate(value, error).text()
        assert cl.Estimate(value, error).text() != "-0"


def test_a_number_without_a_limit_is_none() -> None:
    texts = {cl.Estimate(x, np.inf).text() for x in (3.0, np.inf)} | {cl.Estimate(1e308, 1.5e308).text()}
    assert len(texts) == 1
    assert not fullmatch(f".*{NUMBER}.*", texts.pop())


@pytest.mark.parametrize("written", [as_text, as_html, as_latex])
@given(value=st.one_of(st.just(0.0), ONE_UNIT), error=ONE_UNIT)
def test_a_table_has_the_same_rule_in_each_of_its_forms(written, value: float, error: float) -> None:
    text = written(table([{UNIT: "N m", "value": cl.Estimate(value, error)}]))
    assert ("0 within" in text) == (error >= value)
    assert not ("within" in text and any(sign in text for sign in ("+-", "pm", "\u00b1")))


UNITS = ("N", "m s-1", "rad s-1", "s", "kg", "kg m2", "m2", "s-1", "N m-1.5", "Pa", "1", "s m-1", "N s2 m-1")


@given(st.sampled_from(UNITS), ONE_UNIT)
def test_a_number_with_a_handy_unit_is_the_same_number(units: str, value: float) -> None:
    text = with_unit(value, units)
    assert to_si(text, cl.Parameter("x", units, "number").unit) == pytest.approx(value, rel=1e-4)


def test_a_number_without_a_value_has_no_say_in_the_prefix() -> None:
    row = {UNIT: "N m", "newton": cl.Estimate(5e-3, 1e-5), "poisson": cl.Estimate(2e-3, 6e7)}
    assert "mN m" in as_text(table([row]))
