"""The page of simulators is that of its results."""

import simulator_page

from contactlab.studies.bench.questions import questions


def test_the_page_is_that_of_the_results() -> None:
    page = simulator_page.PAGE.read_text(encoding="utf-8")
    assert page == simulator_page.page(), "python benchmarks/simulators/simulator_page.py"
    rows = simulator_page.results()["rows"]
    assert {len(row["values"]) for row in rows} == {len(questions()[0])}
    lines = [line for line in page.splitlines() if line.startswith(tuple(f"| {r['entrant']}:" for r in rows))]
    assert len(lines) == 2 * len(rows) > 20
