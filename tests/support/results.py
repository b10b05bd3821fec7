"""Results of studies as their files, notebooks and terminals show them: what tests of studies share."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import contactlab as cl


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def assert_read_again(make: Callable[[Path], cl.Result], name: str, folder: Path) -> None:
    """The file alone of a study gives its result, and the same files."""
    made = make(folder / "made")
    again = cl.load(folder / "made" / f"{name}.nc")
    assert isinstance(again, cl.Result)
    assert again.study.name == name
    assert again.configurations == made.configurations
    assert {label: setup.configuration for label, setup in again.setups.items()} == made.configurations
    np.testing.assert_equal(again.numbers, made.numbers)
    assert again.findings == made.findings
    for table, other in zip(made.tables.values(), again.tables.values(), strict=True):
        pd.testing.assert_frame_equal(table, other)
    again.save(folder / "again")
    assert files(folder / "again") == files(folder / "made")
    assert {*filter(str.isidentifier, made.numbers)} <= {*dir(again)}
    assert again._repr_html_().count("<li>") == len(made.findings)


def assert_quantity_first(result: cl.Result, quantity: str) -> None:
    """The first line is the first finding, states the quantity, and stands above all tables."""
    first, *_ = repr(result).splitlines()
    number, percent = result.numbers[quantity].value, 100.0 * result.numbers[quantity].value
    written = [float(each.rstrip(".")) for each in re.findall(r"-?\d[\d.]*(?:e[-+]?\d+)?", first)]
    prefixes = [10.0**power for power in (-9, -6, -3, 0, 3)]
    assert any(
        x == pytest.approx(y, rel=5e-3) for x in written for y in (percent, *(number / p for p in prefixes))
    )
    assert first == result.findings[0]
    captions = [table.attrs["caption"] for table in result.tables.values() if len(table)]
    assert all(repr(result).index(first) < repr(result).index(caption) for caption in captions)
    page = result._repr_html_()
    assert page.index("<li>") < page.index("<table")
