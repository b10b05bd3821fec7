"""Faulty lines of fit, validate and bench are refused by their keys; files and ranges go to their options."""

from pathlib import Path

import pytest
from support.command_line import Command, left_behind
from support.declared import TABLES, declare

from contactlab.cli.study import as_overrides


@pytest.mark.parametrize(
    ("arguments", "keys"),
    [
        (["bench"], ["law"]),
        (["fit", "none.csv", "law=newton"], ["data", "none.csv"]),
        (["validate", "/dev/zero"], ["/dev/zero"]),
        (["fit", "impacts.csv", "points=1000000000"], ["points"]),
    ],
)
def test_bad_input_is_refused_by_its_keys_and_nothing_is_written(
    command: Command, arguments: list[str], keys: list[str]
) -> None:
    status, out, err = command(*arguments)
    assert (status, out) == (2, "")
    assert all(key in err for key in keys)
    assert "Traceback" not in err
    assert left_behind() == []


@pytest.mark.parametrize("file", TABLES)
@pytest.mark.parametrize("verb", ["fit", "validate"])
def test_a_small_file_that_declares_many_rows_is_refused_unread(
    command: Command, verb: str, file: str
) -> None:
    declare(Path(file), TABLES[file])
    status, out, err = command(verb, file)
    assert (status, out) == (2, "")
    assert file in err
    assert "GB" in err
    assert left_behind() == [Path(file)]


def test_files_and_ranges_go_to_the_options_that_take_them() -> None:
    overrides = as_overrides("fit", ["a.csv", "b.csv", "law=newton", "contact.clearance=1e-6..2e-6"])
    assert "study.data=['a.csv','b.csv']" in overrides
    assert "study.free=['contact.clearance=1e-6..2e-6']" in overrides
