"""Code that a result depends on: the definitions that ran while it was made, and those that they name.

A definition is a constant, function, class body or method of a module of contactlab or of experiments/. What
ran is recorded, and which kernels of laws were bound to the engine. Other compiled kernels cannot be watched:
those that a definition names count, and with them all that kernels, constants and class bodies name in turn.
A function or method that did not run does not count, as it has decided nothing. Nor do the kernels of a class
that were not bound, the tables in which every law stands, and texts of exceptions. The digest of a definition
does not depend on the module in which it stands.
"""

import ast
import re
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from hashlib import sha256
from io import StringIO
from os import fsdecode
from pathlib import Path
from tokenize import COMMENT, generate_tokens
from types import CodeType, FrameType
from typing import Any, ClassVar, Final, NamedTuple

import yaml

ROOT: Final = Path(__file__).resolve().parents[1]

PACKAGES: Final = {"contactlab": "", "contactlab_data": "packages/contactlab-data"}
"""Packages, with the folder that has each; scripts stand in experiments/."""

TABLES: Final = {"contactlab.laws.registry:LAWS", "contactlab.laws.registry:PARTS"}
"""Constants that name every law."""

OWN: Final = {"dependencies", "remake", "results_store", "sections"}
"""Modules that make and keep results, and decide no number."""

DECORATOR: Final = re.compile(r"(?:\w+_)?kernel\b")
"""Decorators of kernels."""

BINDING: Final = "_Part.call"
"""What runs where a kernel of a law is bound to the engine."""

USING: Final = {"Kernel.compiled", "Kernel.__call__"}
"""What runs where a kernel is used from Python."""

CO_FUNCTION: Final = 0x1
"""Flag of the code of a function; that of a module or of a class body lacks it."""

IMPORT: Final = ast.Import | ast.ImportFrom

REST: Final = ""
"""Name of the statements of a module that define nothing."""


FUNCTION, KERNEL, CLASS, OTHER = "function", "kernel", "class", "other"
"""Kinds of definitions."""


class Definition(NamedTuple):
    """A definition: its code, the chains of names in it, and its kind."""

    text: str
    names: tuple[tuple[str, ...], ...]
    kind: str

    def needs(self, other: "Definition") -> bool:
        """Return whether a definition that is named here counts."""
        return other.kind != FUNCTION and (self.kind, other.kind) != (CLASS, KERNEL)


class Module(NamedTuple):
    """Definitions of a module, and from where its other names are: module and name, which may be empty."""

    definitions: dict[str, Definition]
    imports: dict[str, tuple[str, str]]


def code_of(source: str) -> list[str]:
    """Return the lines of a module without what is no code: comments, docstrings, texts of exceptions."""
    lines = source.splitlines()
    for token in generate_tokens(StringIO(source).readline):
        if token.type == COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Expr(value=ast.Constant(value=str())):
                left = ""
            case ast.Raise(exc=ast.Call(func=kind, args=texts, keywords=[])) if all(map(is_text, texts)):
                left = f"{lines[node.lineno - 1][: node.col_offset]}raise {ast.unparse(kind)}"
            case _:
                continue
        first, *rest = rows_of(node)
        lines[first] = left
        for row in rest:
            lines[row] = ""
    return [line.rstrip() for line in lines]


def is_text(node: ast.expr) -> bool:
    """Return whether an expression is a literal text."""
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def names_in(nodes: Iterable[ast.AST]) -> Iterator[tuple[str, ...]]:
    """Yield the chains of names in some nodes: of `a.b.c` all three."""
    for node in (each for outer in nodes for each in ast.walk(outer)):
        chain: list[str] = []
        while isinstance(node, ast.Attribute):
            chain.insert(0, node.attr)
            node = node.value
        if isinstance(node, ast.Name):
            yield (node.id, *chain)


def is_kernel(node: ast.FunctionDef) -> bool:
    """Return whether a function is compiled."""
    return any(DECORATOR.match(ast.unparse(each)) for each in node.decorator_list)


def rows_of(node: ast.stmt) -> range:
    """Return the lines of a statement, from 0, decorators included."""
    first = min([node.lineno, *(each.lineno for each in getattr(node, "decorator_list", ()))])
    return range(first - 1, node.end_lineno or first)


def assigned(node: ast.Assign | ast.AnnAssign) -> set[str]:
    """Return the names that a statement assigns to."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return {each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)}


def imports_of(tree: ast.Module) -> dict[str, tuple[str, str]]:
    """Return module and name of what a module imports, by the name that it has there."""
    imports: dict[str, tuple[str, str]] = {}
    for each in ast.walk(tree):
        if isinstance(each, ast.Import):
            for alias in each.names:
                imports[alias.asname or alias.name.partition(".")[0]] = (alias.name, "")
        elif isinstance(each, ast.ImportFrom):
            for alias in each.names:
                imports[alias.asname or alias.name] = (str(each.module), alias.name)
    return imports


@cache
def parsed(path: Path) -> Module:
    """Return the definitions of a file."""
    source = path.read_text(encoding="utf-8")
    lines, tree = code_of(source), ast.parse(source)
    definitions: dict[str, Definition] = {}

    def put(name: str, nodes: list[ast.stmt], kind: str, without: Iterable[ast.stmt] = ()) -> None:
        imports = [each for node in nodes for each in ast.walk(node) if isinstance(each, IMPORT)]
        hidden = {row for node in (*without, *imports) for row in rows_of(node)}
        rows = (row for node in nodes for row in rows_of(node) if row not in hidden)
        text = "\n".join(lines[row] for row in rows if lines[row])
        parts = [part for node in nodes for part in ast.iter_child_nodes(node) if part not in {*without}]
        old = definitions.get(name, Definition("", (), kind))
        names = {*old.names, *names_in(parts)}
        definitions[name] = Definition(f"{old.text}{text}\n", tuple(sorted(names)), kind)

    def put_function(name: str, node: ast.FunctionDef) -> None:
        put(name, [node], KERNEL if is_kernel(node) else FUNCTION)

    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            put_function(node.name, node)
        elif isinstance(node, ast.ClassDef):
            methods = [each for each in node.body if isinstance(each, ast.FunctionDef)]
            put(node.name, [node], CLASS, methods)
            for method in methods:
                put_function(f"{node.name}.{method.name}", method)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            for name in assigned(node):
                put(name, [node], OTHER)
        elif not isinstance(node, IMPORT):
            put(REST, [node], OTHER)
    return Module(definitions, imports_of(tree))


@cache
def file_of(module: str, root: Path = ROOT) -> Path | None:
    """Return the file of a module of contactlab or of experiments/; None of any other."""
    place = root / PACKAGES.get(module.partition(".")[0], "experiments") / module.replace(".", "/")
    files = (place.with_suffix(".py"), place / "__init__.pyi", place / "__init__.py")
    return next((path for path in files if path.is_file()), None)


@cache
def modules(root: Path) -> tuple[str, ...]:
    """Return the names of all modules of contactlab and of experiments/."""
    folders = [*(root / above / name for name, above in PACKAGES.items()), root / "experiments"]
    files = (str(file) for folder in folders for file in folder.rglob("*.py"))
    return tuple(filter(None, (module_of(file, root) for file in files)))


@cache
def present(module: str, root: Path = ROOT) -> str:
    """Return the name of a module; of one that is gone, that of the only one with the longest end of it."""
    if file_of(module, root) is None:
        parts = module.split(".")
        for first in range(len(parts)):
            end = ".".join(("", *parts[first:]))
            if alike := [name for name in modules(root) if f".{name}".endswith(end)]:
                return alike[0] if len(alike) == 1 else module
    return module


def target_of(module: str, chain: tuple[str, ...], root: Path) -> str | None:
    """Return the definition "MODULE:NAME" that a chain of names in a module begins with, if it is ours."""
    path = file_of(module, root)
    if path is None or not chain:
        return None
    own, (head, *tail) = parsed(path), chain
    if head in own.definitions:
        member = own.definitions.get(".".join(chain[:2]))
        return f"{module}:{'.'.join(chain[:2]) if member and member.kind == KERNEL else head}"
    if head not in own.imports:
        return target_of(f"{module}.{head}", tuple(tail), root)
    source, name = own.imports[head]
    chain = (name, *tail) if name else tuple(tail)
    if (source, name) == (module, head):
        return None
    return target_of(source, chain, root)


@cache
def counting_with(here: str, root: Path) -> tuple[str, ...]:
    """Return what counts with a definition: its module's and class's statements, and what it names."""
    module, _, name = here.partition(":")
    if (path := file_of(module, root)) is None:
        return ()
    counting = [f"{module}:{REST}"]
    if "." in name:
        counting.append(f"{module}:{name.partition('.')[0]}")
    definition = parsed(path).definitions.get(name)
    for chain in definition.names if definition else ():
        target = target_of(module, chain, root)
        if definition and target is not None:
            there, _, what = target.partition(":")
            file = file_of(there, root)
            if file is not None and definition.needs(parsed(file).definitions[what]):
                counting.append(target)
    return tuple(counting)


def reached(ran: Iterable[str], root: Path = ROOT) -> set[str]:
    """Return definitions that ran, and what counts of all that they name."""
    counted: set[str] = set()
    waiting = [*ran]
    while waiting:
        here = waiting.pop()
        if here not in counted and here not in TABLES:
            counted.add(here)
            waiting += counting_with(here, root)
    return counted


def imported(definition: Definition, imports: Mapping[str, tuple[str, str]], root: Path) -> str:
    """Return what a definition has by imports: names of ours, of others with their modules."""
    sources = {head: imports[head] for head, *_ in definition.names if head in imports}
    return " ".join(
        f"{head}={'' if file_of(source, root) else source}.{name}"
        for head, (source, name) in sorted(sources.items())
    )


def digests(ran: Iterable[str], files: Iterable[str], root: Path = ROOT) -> dict[str, str]:
    """Return the digests of the definitions that are reached from some, by module, and of configurations.

    Args:
        ran: definitions.
        files: configurations that were read.
        root: of the repository.
    """
    texts: dict[str, list[str]] = {}
    for each in sorted(reached(ran, root)):
        module, _, name = each.partition(":")
        path = file_of(module, root)
        definition = None if path is None else parsed(path).definitions.get(name)
        if path is not None and definition is not None:
            imports = imported(definition, parsed(path).imports, root)
            texts.setdefault(module, []).append(f"{name}\0{definition.text}\0{imports}\0")
    content = {module: "".join(own) for module, own in texts.items()}
    content |= {name: f"{name}\0{keys_of(root / name)}" for name in files}
    return {name: sha256(text.encode()).hexdigest()[:16] for name, text in content.items()}


@cache
def digest_of(*paths: str, root: Path = ROOT) -> str:
    """Return the digest of the code in files and folders of the repository, 16 hexadecimal digits."""
    files = [file for path in paths for file in [root / path, *(root / path).rglob("*")]]
    value = sha256()
    for name, file in sorted((file.relative_to(root).as_posix(), file) for file in files):
        if file.suffix == ".py":
            text = "\n".join(filter(None, code_of(file.read_text(encoding="utf-8"))))
            value.update(f"{name}\0{text}\0".encode())
        elif file.suffix == ".yaml":
            value.update(f"{name}\0{keys_of(file)}\0".encode())
    return value.hexdigest()[:16]


def keys_of(path: Path) -> str:
    """Return what counts of a configuration: its keys and values."""
    return repr(yaml.safe_load(path.read_text(encoding="utf-8"))) if path.is_file() else ""


class Recorder:
    """A record of the definitions that run, and of the configurations that are read, in this process."""

    _codes: ClassVar[set[tuple[CodeType, type | None]]] = set()
    _ours: ClassVar[dict[CodeType, bool]] = {}
    _files: ClassVar[set[str]] = set()

    @classmethod
    def start(cls) -> None:
        """Begin to record."""
        sys.addaudithook(cls._audited)
        threading.settrace(cls._called)
        sys.settrace(cls._called)

    @classmethod
    def stop(cls) -> None:
        """End the record."""
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]

    @classmethod
    def _called(cls, frame: FrameType, *_: object) -> None:
        code = frame.f_code
        ours = cls._ours.get(code)
        if ours is None:
            ours = code.co_flags & CO_FUNCTION != 0 and module_of(code.co_filename) is not None
            cls._ours[code] = ours
        if ours and code.co_varnames[:1] == ("self",) and code.co_argcount:
            own = frame.f_locals["self"]
            cls._codes.add((code, type(own)))
            if code.co_qualname in USING:
                cls._used(own)
            elif code.co_qualname == BINDING:
                cls._used(getattr(own.owner, frame.f_locals["kernel"]))
        elif ours:
            cls._codes.add((code, None))

    @classmethod
    def _used(cls, kernel: Any) -> None:
        code = getattr(getattr(kernel, "py_func", kernel), "__code__", None)
        if code is not None and module_of(code.co_filename) is not None:
            cls._codes.add((code, None))

    @classmethod
    def _audited(cls, event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open" and not isinstance(arguments[0], int):
            path = fsdecode(arguments[0])
            if path.endswith(".yaml"):
                cls._files.add(path)

    @classmethod
    def ran(cls) -> list[str]:
        """Return the definitions that ran, and the classes of the objects whose methods ran."""
        result = set()
        for code, owner in tuple(cls._codes):
            name = code.co_qualname.partition(".<locals>")[0]
            result.add(f"{module_of(code.co_filename)}:{REST if '<' in name else name}")
            for base in owner.__mro__ if owner is not None else ():
                if file_of(base.__module__) is not None:
                    result.add(f"{base.__module__}:{base.__qualname__.partition('.')[0]}")
        return sorted(result)

    @classmethod
    def files(cls) -> list[str]:
        """Return the configurations of the repository that were read."""
        paths = (Path(each).resolve() for each in cls._files)
        return sorted(path.relative_to(ROOT).as_posix() for path in paths if path.is_relative_to(ROOT))


@cache
def module_of(file: str, root: Path = ROOT) -> str | None:
    """Return the module of a file of contactlab or of experiments/ that may decide a number; else None."""
    path = Path(file)
    if path.is_relative_to(root / "experiments"):
        return None if path.stem in OWN else path.stem
    for name, above in PACKAGES.items():
        if path.is_relative_to(root / above / name) and "__pycache__" not in path.parts:
            parts = path.relative_to(root / above).with_suffix("").parts
            return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
    return None
