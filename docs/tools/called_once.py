"""Private functions and methods that are called in one place, which may as well stand there.

python docs/tools/called_once.py [CHECKOUT]

A function `_name` of a module or a class counts where its name is used once in the package outside of its own
definition, and that is a call: what is given to another function, or has a decorator (a cache, a property, a
kernel), has to be a function. The exit status is 1 where there are more than `ratchets.yaml` admits.
"""

import ast
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
RATCHETS = Path(__file__).with_name("ratchets.yaml")
PLACES = ("contactlab", "packages/*/contactlab_*")

Function = ast.FunctionDef | ast.AsyncFunctionDef


def functions_of(tree: ast.Module) -> Iterator[Function]:
    """Yield the private functions of a module and the private methods of its classes."""
    bodies = [tree.body]
    while bodies:
        for node in bodies.pop():
            if isinstance(node, ast.ClassDef):
                bodies.append(node.body)
            elif isinstance(node, Function) and node.name.startswith("_") and not node.name.endswith("__"):
                yield node


def uses_in(tree: ast.AST) -> Counter[str]:
    """Count the names that are used below a node, those of imports and attributes too."""
    used: Counter[str] = Counter()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            used[node.id] += 1
        elif isinstance(node, ast.Attribute):
            used[node.attr] += 1
    return used


def called_in(tree: ast.AST) -> set[str]:
    """Return the names that are called below a node."""
    calls = (node.func for node in ast.walk(tree) if isinstance(node, ast.Call))
    return {name for call in calls for name in uses_in(call)}


def called_once(root: Path = ROOT) -> Iterator[tuple[str, str, int]]:
    """Yield file, name and lines of each private function that is used once.

    A module's own names are its own: another `_name` elsewhere is another function, unless it is imported.
    """
    files = {
        path: ast.parse(path.read_text(encoding="utf-8"))
        for place in PLACES
        for folder in root.glob(place)
        for path in sorted(folder.rglob("*.py"))
        if "__pycache__" not in path.parts
    }
    imported = Counter(
        alias.name
        for tree in files.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    )
    called = {name for tree in files.values() for name in called_in(tree)}
    for path, tree in files.items():
        used, functions = uses_in(tree), [*functions_of(tree)]
        # Methods of several classes that share a name are one interface.
        names = Counter(function.name for function in functions)
        for function in functions:
            name = function.name
            outside = used[name] - uses_in(function)[name] + imported[name]
            if outside == 1 and names[name] == 1 and name in called and not function.decorator_list:
                assert function.end_lineno is not None
                first = min([function.lineno, *(each.lineno for each in function.decorator_list)])
                yield path.relative_to(root).as_posix(), name, function.end_lineno - first + 1


def main(root: Path = ROOT) -> int:
    """Print the functions and return the exit status."""
    most = yaml.safe_load(RATCHETS.read_text(encoding="utf-8"))["private functions called once"]
    every = [*called_once(root)]
    for file, name, lines in every:
        print(f"{lines:4}  {file}: {name}")
    print(f"{len(every)} functions of {sum(lines for *_, lines in every)} lines; at most {most}.")
    return int(len(every) > most)


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:2])))
