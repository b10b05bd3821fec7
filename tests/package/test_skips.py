"""A test that is skipped says what it lacks, and how that is had."""

import ast
from collections.abc import Iterator
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]

WAYS_OUT = ("install ", "run the tests ", "put ")
"""Of which one stands in every reason."""


def reasons(source: Path) -> Iterator[tuple[int, str | None]]:
    """The lines where tests are skipped, with their reasons: None for none, no line for one made later."""
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        called = ast.unparse(node.func)
        named = {word.arg: word.value for word in node.keywords}
        if called.endswith("mark.skipif") or called == "pytest.importorskip":
            said = named.get("reason")
        elif "pytest.skip" in called:
            said = node.args[0] if node.args else named.get("reason")
        else:
            continue
        if isinstance(said, ast.Constant | ast.JoinedStr | None):
            yield node.lineno, ast.unparse(said) if said else None


def test_every_skip_names_a_way_out() -> None:
    found = [(path, *each) for path in sorted(TESTS.rglob("*.py")) for each in reasons(path)]
    assert len(found) > 10
    assert [
        f"{path.relative_to(TESTS)}:{line}: {reason}"
        for path, line, reason in found
        if reason is None or not any(way in reason for way in WAYS_OUT)
    ] == []
