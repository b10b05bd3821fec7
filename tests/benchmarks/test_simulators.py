"""The page of simulators is that of its results, and blocks by events are exact."""

import sys
from itertools import groupby

import pytest
import simulator_page
from run import Entrant

from contactlab_data.studies.bench.questions import questions


def test_the_page_is_that_of_the_results() -> None:
    page = simulator_page.PAGE.read_text(encoding="utf-8")
    assert page == simulator_page.page(), "python benchmarks/simulators/simulator_page.py"
    rows = simulator_page.results()["rows"]
    assert {len(row["values"]) for row in rows} == {len(questions()[0])}
    lines = [line for line in page.splitlines() if line.startswith(tuple(f"| {r['entrant']}:" for r in rows))]
    assert len(lines) == 2 * len(rows) > 20


def test_stick_and_slip_by_events_are_exact() -> None:
    """The equations that two entrants share, solved by SciPy; the error left is that of reading a series."""
    entrant = Entrant(sys.executable, "with_scipy")
    for (_, _, kind), group in groupby(questions()[0], lambda case: case[:3]):
        if kind == "block":
            cases = [*group]
            response = entrant.reply(entrant.settings[-1], kind, cases[0].numbers)["answers"]
            for case in cases:
                assert response[case.quantity] == pytest.approx(case.exact, rel=1e-6, abs=1e-12), case
    entrant.close()
