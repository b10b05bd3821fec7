"""The examples in the docstrings of the package give what they say."""

from doctest import DocTest, DocTestFinder, DocTestRunner
from importlib import import_module
from pathlib import Path

import pytest

import contactlab

PACKAGE = Path(str(contactlab.__file__)).parent


def examples() -> list[DocTest]:
    """The docstrings that have examples."""
    result: list[DocTest] = []
    for path in sorted(PACKAGE.rglob("*.py")):
        # Importing every module would take longer than all examples.
        if "    >>> " in path.read_text(encoding="utf-8"):
            parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
            module = import_module(".".join(parts))
            result += [each for each in DocTestFinder().find(module) if each.examples]
    return result


@pytest.mark.parametrize("example", examples(), ids=lambda each: each.name)
def test_an_example_gives_what_it_says(
    example: DocTest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text: list[str] = []
    outcome = DocTestRunner(verbose=False).run(example, out=text.append)
    assert outcome.failed == 0, "".join(text)
