"""Lines of package and tests by row of `ledger.yaml`, with the totals of the products.

python docs/tools/ledger.py [CHECKOUT]
"""

import sys
from collections import Counter
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]
ROWS: list[dict[str, Any]] = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))
PLACES = {
    "package": ("contactlab/**/*.py", "hydra_plugins/**/*.py", "packages/*/contactlab_*/**/*.py"),
    "tests": ("tests/**/*.py", "packages/*/tests/**/*.py", "validation/**/*.py", "conftest.py"),
}
"""Where the files of each column are."""


def row_of(column: str, file: str) -> str:
    """Return the row of a file of a column, empty where none has a pattern that matches."""
    rows = (row["row"] for row in ROWS if any(fnmatch(file, pattern) for pattern in row[column]))
    return next(rows, "")


def lines(root: Path = ROOT) -> Iterator[tuple[str, str, str, int]]:
    """Yield column, file, row and lines of every file of the package and its tests."""
    for column, patterns in PLACES.items():
        for path in sorted(path for pattern in patterns for path in root.glob(pattern)):
            file = path.relative_to(root).as_posix()
            # Kernels are written beside their machine code.
            if "__pycache__" in file:
                continue
            yield column, file, row_of(column, file), len(path.read_text(encoding="utf-8").splitlines())


def main(root: Path = ROOT) -> int:
    """Print the ledger; the exit status is 1 where a file has no row."""
    counted: Counter[tuple[str, str]] = Counter()
    without = []
    for column, file, row, number in lines(root):
        counted[column, row] += number
        without += [] if row else [file]
    products: Counter[tuple[str, str]] = Counter()
    print(" package   tests")
    for row in ROWS:
        print(f"{counted['package', row['row']]:8,}{counted['tests', row['row']]:8,}  {row['row']}")
        for column in PLACES:
            products[column, row["product"]] += counted[column, row["row"]]
    print()
    for product in dict.fromkeys(row["product"] for row in ROWS):
        print(f"{products['package', product]:8,}{products['tests', product]:8,}  {product}")
    print(*(f"{file} has no row" for file in without), sep="\n", end="\n" if without else "")
    return int(bool(without))


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:2])))
