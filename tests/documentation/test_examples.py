"""The examples in the docstrings of the package give what they say."""

import inspect
from doctest import DocTest, DocTestFinder, DocTestRunner
from importlib import import_module
from pathlib import Path

import made_api
import pytest

import contactlab
from contactlab.laws import LAWS, PARTS

PACKAGE = Path(str(contactlab.__file__)).parent


def examples() -> list[DocTest]:
    """The docstrings that have examples."""
    found: list[DocTest] = []
    for path in sorted(PACKAGE.rglob("*.py")):
        # Importing every module would take longer than all examples.
        if "    >>> " in path.read_text(encoding="utf-8"):
            parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
            module = import_module(".".join(parts))
            found += [each for each in DocTestFinder().find(module) if each.examples]
    return found


def test_all_of_the_front_door_but_laws_parts_and_errors_have_examples() -> None:
    having = {each.name for each in examples()}
    described = {LAWS[name] for name in LAWS} | {part for parts in PARTS.values() for part in parts.values()}
    missing = [
        name
        for name, one in made_api.exported().items()
        # A law's signature is its example, and each has a page with a picture.
        if one not in described and not (inspect.isclass(one) and issubclass(one, Exception))
        if f"{one.__module__}.{one.__qualname__}" not in having
    ]
    assert missing == []


@pytest.mark.parametrize("example", examples(), ids=lambda each: each.name)
def test_an_example_gives_what_it_says(
    example: DocTest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    said: list[str] = []
    outcome = DocTestRunner(verbose=False).run(example, out=said.append)
    assert outcome.failed == 0, "".join(said)
