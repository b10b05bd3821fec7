"""The fingerprint of a function changes with all that the function is made of, and with nothing else."""

import subprocess
import sys
from collections import deque
from collections.abc import Callable
from functools import partial
from importlib import import_module
from math import sin, sqrt
from pathlib import Path
from types import FunctionType, MappingProxyType
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from contactlab.fingerprint import Fingerprint

FILES = {
    "top.py": """
        import functools
        from types import SimpleNamespace
        import numba
        import pack.middle
        import pack.constants as constants
        from pack.middle import imported
        from pack import lookup

        HERE = 1.5
        TABLE = (1.0, (2.0, 3.0))
        ARRAY = lookup.ARRAY
        CHOICE = {"force": lookup.chosen}
        WORDS = SimpleNamespace(k=lookup.WORD)

        class Values:
            SLOPE = lookup.SLOPE

            def bound(self):
                return lookup.bound()

        @numba.njit
        def compiled(x):
            return imported(x)

        def around(factor):
            def inner(x):
                return factor * x
            return inner

        captured = around(lookup.CAPTURED)
        fixed = functools.partial(around, lookup.FIXED)

        def force(x, default=lookup.DEFAULT):
            import pack.late
            y = [constants.DEEP.value * each for each in (x, HERE)]
            y = pack.middle.called(x) + compiled(x) + captured(x) + fixed()(x) + TABLE[1][0]
            y += ARRAY[0] + CHOICE["force"](x) + WORDS.k + Values.SLOPE + Values().bound()
            return y + pack.late.at_last(x) + (lambda z: lookup.hidden(z))(x)

        def other(x):
            return lookup.unused(x)
        """,
    "pack/__init__.py": "",
    "pack/middle.py": """
        from numba import njit
        from pack.leaf import leaf

        @njit
        def imported(x):
            return leaf(x)

        def called(x):
            return 2.0 * x
        """,
    "pack/leaf.py": """
        from numba import njit
        GRAVITY = 9.81

        @njit(fastmath=False)
        def leaf(x):
            # A word.
            return GRAVITY * x
        """,
    "pack/late.py": """
        def at_last(x):
            return 4.0 * x
        """,
    "pack/constants.py": """
        from enum import Enum
        class DEEP(Enum):
            value = 1.0
        """,
    "pack/lookup.py": """
        import numpy as np
        ARRAY = np.array([1.0, 2.0])
        WORD, SLOPE, CAPTURED, FIXED, DEFAULT = 1.0, 2.0, 3.0, 4.0, 5.0
        def chosen(x):
            return 6.0 * x
        def bound():
            return 7.0
        def hidden(x):
            return 8.0 * x
        def unused(x):
            return 9.0 * x
        """,
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The modules above, written and on the path."""
    (tmp_path / "pack").mkdir()
    for name, text in FILES.items():
        lines = [line.removeprefix(" " * 8) for line in text.splitlines()]
        (tmp_path / name).write_text("\n".join(lines) + "\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    return tmp_path


def loaded() -> FunctionType:
    """The function `force` of what stands in the files now."""
    for name in [name for name in sys.modules if name.partition(".")[0] in ("top", "pack")]:
        del sys.modules[name]
    force: FunctionType = import_module("top").force
    return force


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("top.py", "HERE = 1.5", "HERE = 1.6"),
        ("top.py", "(2.0, 3.0)", "(2.5, 3.0)"),
        ("top.py", "factor * x", "factor + x"),
        ("top.py", "@numba.njit", "@numba.njit(fastmath=True)"),
        ("pack/middle.py", "2.0 * x", "2.1 * x"),
        ("pack/middle.py", "return leaf(x)", "return -leaf(x)"),
        ("pack/leaf.py", "return GRAVITY * x", "return GRAVITY - x"),
        ("pack/leaf.py", "GRAVITY = 9.81", "GRAVITY = 1.62"),
        ("pack/leaf.py", "fastmath=False", "fastmath=True"),
        ("pack/late.py", "4.0", "4.1"),
        ("pack/constants.py", "1.0", "1.1"),
        ("pack/lookup.py", "[1.0, 2.0]", "[1.0, 2.1]"),
        *(("pack/lookup.py", f" {number}.0", f" {number}.25") for number in (1, 2, 3, 4, 5, 6, 7, 8)),
    ],
)
def test_it_changes_with_all_that_is_called_and_read(folder: Path, file: str, old: str, new: str) -> None:
    before = Fingerprint(loaded())
    sources = before.sources()
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1))
    after = Fingerprint(loaded())
    assert after.digest != before.digest
    assert after.sources() != sources


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [("pack/leaf.py", "# A word.", "# Another word.\n"), ("pack/lookup.py", "9.0", "9.1")],
)
def test_it_changes_with_nothing_else(folder: Path, file: str, old: str, new: str) -> None:
    before = Fingerprint(loaded()).digest
    (folder / file).write_text((folder / file).read_text().replace(old, new, 1))
    assert Fingerprint(loaded()).digest == before


@pytest.mark.long
def test_it_is_the_same_in_every_process(folder: Path) -> None:
    code = "import top; from contactlab.fingerprint import Fingerprint as F; print(F(top.force).digest)"
    package = str(Path(Fingerprint.__init__.__code__.co_filename).parents[1])

    def digest(seed: str) -> str:
        variables = {"PYTHONHASHSEED": seed, "PYTHONPATH": package}
        line = [sys.executable, "-c", code]
        found = subprocess.run(line, cwd=folder, env=variables, capture_output=True, text=True)
        assert found.returncode == 0, found.stderr
        return found.stdout.strip()

    assert digest("1") == digest("2") == Fingerprint(loaded()).digest


def factory(value: Any) -> Callable[[float], Any]:
    def made(x: float) -> Any:
        return value, x

    return made


def test_closures_are_the_same_by_the_values_that_they_capture() -> None:
    for same, other in [
        (1.0, 2.0),
        ((1, "a"), (1, "b")),
        (np.arange(3), np.arange(4)),
        ({"a": [1]}, {"a": [2]}),
        (frozenset("abc"), frozenset("abd")),
        (partial(int, base=2), partial(int, base=3)),
        (deque([1.0]), deque([2.0])),
        (MappingProxyType({"a": 1}), MappingProxyType({"a": 2})),
        ("a".join, "b".join),
        (sqrt, sin),
        (CubicSpline([0.0, 1.0], [0.0, 1.0]), CubicSpline([0.0, 1.0], [0.0, 2.0])),
        (0.0, -0.0),
        (1, 1.0),
    ]:
        first, again, changed = (Fingerprint(factory(value)) for value in (same, same, other))
        assert first.digest == again.digest != changed.digest


def test_what_refers_to_itself_comes_to_an_end() -> None:
    def again(x: float) -> float:
        return again(x - 1.0) if x > 0.0 else x + len(ring)

    ring: list[Any] = [again]
    ring.append(ring)
    assert len(Fingerprint(again).digest) == 64
