"""The page of a result: its answer comes first."""

from contactlab.studies.report import _template


def test_findings_stand_above_figures_and_tables() -> None:
    page = _template().render(
        title="title",
        question="question",
        findings=["e = 0.82"],
        tables=[("Evidence", "<table></table>", True)],
        pictures=[("Posterior", "AA==")],
        options="",
        configurations={},
        versions="",
        revision="",
    )
    assert page.index("e = 0.82") < page.index("<img") < page.index("<table")
