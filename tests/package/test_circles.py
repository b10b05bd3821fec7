"""No two files of a package import each other in a loop: at the top, within functions, or for types alone."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = [file.parent for pattern in ("*", "packages/*/*") for file in ROOT.glob(f"{pattern}/__init__.py")]


def modules(package: Path) -> dict[str, Path]:
    """Return the files of a package by the names of their modules."""
    files = {file.relative_to(package.parent).with_suffix(""): file for file in package.rglob("*.py")}
    return {".".join(path.parts).removesuffix(".__init__"): file for path, file in files.items()}


def imported(file: Path) -> Iterator[str]:
    """Yield what a file imports anywhere: names, each with the module that it is taken from."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (f"{alias.name}." for alias in node.names)


def graph(package: Path) -> dict[str, set[str]]:
    """Return the modules that each module of a package imports."""
    files = modules(package)
    edges = {}
    for name, file in files.items():
        places = {place if place in files else place.rpartition(".")[0] for place in imported(file)}
        edges[name] = (places & files.keys()) - {name}
    return edges


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_no_files_import_each_other_in_a_loop(package: Path) -> None:
    edges = graph(package)
    assert any(edges.values()) or len(edges) < 3
    try:
        TopologicalSorter(edges).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_a_loop_through_a_function_and_an_import_for_types_is_seen(tmp_path: Path) -> None:
    (tmp_path / "__init__.py").touch()
    (tmp_path / "one.py").write_text(
        f"def one():\n    from {tmp_path.name}.two import two\n", encoding="utf-8"
    )
    text = f"if TYPE_CHECKING:\n    from {tmp_path.name} import one\n"
    (tmp_path / "two.py").write_text(text, encoding="utf-8")
    with pytest.raises(CycleError):
        TopologicalSorter(graph(tmp_path)).prepare()
