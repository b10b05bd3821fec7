"""Claims on tables: one unit a row, in every form of a table, and no digits that nothing carries."""

from html import unescape
from re import findall, sub

import pytest

import contactlab as cl
from contactlab.quantity import to_si
from contactlab.studies.tables import UNIT, AtMost, as_csv, as_html, as_latex, as_text, shown, table

STIFFNESS = {"best": 2.0083e10, "mean": cl.Estimate(2.007e10, 1.7e8), "5 %": 1.9789e10, "truth": 2.0e10}


def cells_of(form: str, frame) -> list[str]:
    """Return the cells of the only row, errors left out."""
    if form == "text":
        return sub(r" \+- \S+", "", as_text(frame).splitlines()[1]).split()
    if form == "latex":
        row = as_latex(frame).splitlines()[4].removesuffix(r" \\").replace(r"\^{}", "^").split(" & ")
    else:
        row = [unescape(x) for x in findall(r"<td[^>]*>(.*?)</td>", as_html(frame))]
    return [sub(r" (\$\\pm\$|\u00b1) .*", "", cell) for cell in row]


@pytest.mark.parametrize("form", ["html", "latex", "text"])
def test_all_numbers_of_a_row_are_in_its_unit(form: str) -> None:
    unit, *numbers = cells_of(form, table([{UNIT: "N m-1.5", **STIFFNESS}]))
    expected = [x.value if isinstance(x, cl.Estimate) else x for x in STIFFNESS.values()]
    assert [to_si(f"{x} {unit}", "N/m^1.5") for x in numbers] == pytest.approx(expected, rel=1e-3)
    assert unit != "N/m^1.5"


def test_a_bound_is_in_the_unit_of_what_it_bounds() -> None:
    row = {UNIT: "m s-1", "must be": AtMost.of_text("<= 0.04"), "newton": cl.Estimate(0.0274, 0.0)}
    assert cells_of("html", table([row])) == ["mm/s", "<= 40", "27.4"]
    assert "<= 0.04" in as_csv(table([row]))


def test_a_csv_is_in_si_units() -> None:
    text = as_csv(table([{UNIT: "N m-1.5", **STIFFNESS}])).splitlines()[1]
    assert [float(x) for x in text.split(",")[1:]] == [2.0083e10, 2.007e10, 1.7e8, 1.9789e10, 2.0e10]


def test_an_error_of_round_off_is_not_shown() -> None:
    assert shown(cl.Estimate(1.0 / 3.0, 6.2e-16)) == shown(1.0 / 3.0)
    assert float(shown(cl.Estimate(-2.19110625, 1.2e-8)).split(" +- ")[1]) == 1.2e-8


@pytest.mark.parametrize("width", [30, 40, 80, 120])
def test_a_table_for_a_terminal_is_no_wider_and_loses_no_word(width: int) -> None:
    rows = [
        {"metric": f"largest normal force of the contact number {i}", UNIT: "N", "key": f"force_{i}"}
        | {f"law_{j}": cl.Estimate(1.0 + i + 0.1 * j, 1e-3) for j in range(9)}
        for i in range(3)
    ]
    text, whole = as_text(table(rows), width), as_text(table(rows))
    assert max(map(len, text.splitlines())) <= width < max(map(len, whole.splitlines()))
    assert {*text.split()} == {*whole.split()}
    assert as_text(table(rows), 10_000) == whole
