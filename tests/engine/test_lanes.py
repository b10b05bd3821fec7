"""Lanes: the same bits as numbers one by one, on any processor, with machine code and without."""

import os
import subprocess
import sys
from functools import reduce
from math import copysign, inf, nan, sqrt
from operator import add
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import contactlab
from contactlab.compiler.kernels import kernel
from contactlab.compiler.lanes import (
    COUNT,
    WIDTH,
    entry,
    fill,
    larger,
    largest,
    largest_of_all,
    load,
    load_all,
    put,
    root,
    set_entry,
    smaller,
    store,
    total_of,
    total_of_all,
    where_less,
)

ANY = st.one_of(st.floats(), st.sampled_from([0.0, -0.0, inf, -inf, nan, 5e-324, 1e308]))
EIGHT = st.lists(ANY, min_size=WIDTH, max_size=WIDTH).map(np.array)
ROWS = 16, WIDTH


@kernel
def _operations(a, b, x, rows):  # type: ignore[no-untyped-def]
    left, right, five = entry(a, 0), entry(b, 0), load(a[0])
    set_entry(rows, 0, left + right)
    set_entry(rows, 1, left - x)
    set_entry(rows, 2, x * right)
    set_entry(rows, 3, left / right)
    set_entry(rows, 4, -left)
    set_entry(rows, 5, abs(left))
    set_entry(rows, 6, root(right))
    set_entry(rows, 7, larger(left, right))
    set_entry(rows, 8, smaller(left, right))
    set_entry(rows, 9, where_less(left, right, left, x))
    set_entry(rows, 10, where_less(left, right, x, right))
    set_entry(rows, 11, put(left, 3, x))
    set_entry(rows, 12, fill(x) + 2)
    store(rows[13], five + fill(x))
    rows[14, 0], rows[14, 1] = largest(five), total_of(five)
    rows[14, 2], rows[14, 3] = largest_of_all(left), total_of_all(left)
    rows[14, 4], rows[14, 5] = left[2], root(x)
    set_entry(rows[14], 6, entry(a[0], 1))
    set_entry(rows, 15, load_all(b[0]))


def _by_numbers(a: np.ndarray, b: np.ndarray, x: float) -> np.ndarray:
    """What `_operations` does, number by number."""
    rows = np.zeros(ROWS)
    with np.errstate(all="ignore"):
        for i, (left, right) in enumerate(zip(a, b, strict=True)):
            rows[:13, i] = (
                left + right,
                left - x,
                x * right,
                left / right,
                -left,
                abs(left),
                sqrt(right) if right >= 0.0 else nan,
                max(left, right),
                min(left, right),
                left if left < right else x,
                x if left < right else right,
                x if i == 3 else left,
                x + 2.0,
            )
        rows[13, :COUNT] = a[:COUNT] + x
        rows[14, :4] = max(a[:COUNT]), reduce(add, a[:COUNT]), max(a), reduce(add, a)
    rows[14, 4:7] = a[2], sqrt(x) if x >= 0.0 else nan, a[1]
    rows[15] = b
    return rows


def _same_bits(left: np.ndarray, right: np.ndarray) -> bool:
    """Whether all numbers are the same, a zero's sign included; any NaN is NaN."""
    signs = np.copysign(1.0, left) == np.copysign(1.0, right)
    return bool(np.all((np.isnan(left) & np.isnan(right)) | ((left == right) & signs)))


@settings(deadline=None, max_examples=300)
@given(EIGHT, EIGHT, ANY)
def test_each_lane_has_the_bits_of_a_float64(a: np.ndarray, b: np.ndarray, x: float) -> None:
    if x == 0.0 and copysign(1.0, x) < 0.0:
        # math.sqrt and IEEE agree on it; the reference asks for x >= 0.
        x = 0.0
    expected, compiled, interpreted = _by_numbers(a, b, x), np.zeros(ROWS), np.zeros(ROWS)
    _operations(a[None], b[None], x, compiled)
    assert _same_bits(compiled, expected)
    if x >= 0.0:
        with np.errstate(all="ignore"):
            _operations.py_func(a[None], b[None], x, interpreted)  # type: ignore[attr-defined]
        assert _same_bits(interpreted, expected)


def test_nothing_beyond_the_lanes_is_read_or_written() -> None:
    a, b = np.full(COUNT + 1, 7.0), np.ones(COUNT)

    @kernel
    def stored(values, lanes_of):  # type: ignore[no-untyped-def]
        store(values, load(lanes_of) + 1.0)

    stored(a, b)
    np.testing.assert_array_equal(a, [2.0] * COUNT + [7.0])


SCRIPT = """
import sys
import numpy as np
from contactlab.engine import simulate
from contactlab.laws import HertzPenalty
from contactlab.testing.plants import paper_motor

made = simulate(paper_motor(), HertzPenalty(), duration=2e-3, record_interval=1e-5)
np.savez(sys.argv[1], **made.series, **made.contacts)
"""


@pytest.mark.long
def test_a_run_has_the_same_bits_on_a_processor_with_narrow_registers(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    path = str(Path(contactlab.__file__).resolve().parents[1])
    # SSE2 alone, as code that comes with the package.
    plain = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": str(tmp_path)}
    for name, options in (("own", {}), ("generic", plain)):
        environment = os.environ | {"PYTHONPATH": path} | options
        command = [sys.executable, "script.py", f"{name}.npz"]
        subprocess.run(command, cwd=tmp_path, env=environment, check=True)
    with np.load(tmp_path / "own.npz") as own, np.load(tmp_path / "generic.npz") as generic:
        assert own["normal_impulse"].size > 2
        for name in own:
            np.testing.assert_array_equal(own[name], generic[name], err_msg=name)
