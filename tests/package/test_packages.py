"""Names that other packages add, and what is said where a package of this project is missing."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.command_line import Command

import contactlab as cl
from contactlab.packages import names
from contactlab.studies.registry import OWN


@pytest.fixture(autouse=True)
def looked_up_anew() -> Iterator[None]:
    """Entry points of this test's own."""
    names.cache_clear()
    yield
    names.cache_clear()


def test_a_package_adds_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    about = tmp_path / "strokes-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: strokes\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[contactlab.names]\nstroke = json:dumps\nsimulate = json:loads\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    assert cl.stroke is json.dumps
    assert "stroke" in dir(cl)
    # The package's own names cannot be taken.
    assert cl.simulate is not json.loads


def test_a_package_that_is_missing_is_named(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("contactlab.packages.names", dict)
    monkeypatch.setattr("contactlab.cli.main.studies", lambda: OWN)
    with pytest.raises(AttributeError, match="contactlab-data"):
        _ = cl.fit
    status, out, errors = command("fit", "impacts.csv")
    assert (status, out) == (2, "")
    assert "contactlab-data" in errors
