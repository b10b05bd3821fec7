"""Docstrings of the code as reStructuredText: what is indented or in backticks is meant to the letter.

In the code they are plain text in Google's form, in which a formula `|F| <= mu N` needs no escapes.
"""

import builtins
import dataclasses
import inspect
import re
import sys
import typing
from collections.abc import Iterable
from enum import Enum
from importlib import import_module
from typing import Any, Final

import equations
import made_api
from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.ext.napoleon import Config, GoogleDocstring

from contactlab.laws.declaration import Declared
from contactlab.parameter import DeclaredField, declared_fields

GOOGLE: Final = Config(napoleon_use_rtype=False, napoleon_use_ivar=True)
SECTION: Final = re.compile(r"(Args|Attributes|Returns|Raises|Yields|Example|Examples|Note):$")
HEADS: Final = ["field", "meaning", "default", "range"]

_ARRAY: Final = (
    r"~?(?:numpy\.)?ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?(?:numpy\.)?dtype\[~?(?:numpy\.)?{}\]\]"
)
_READABLE: Final = {
    _ARRAY.format("float64"): "Array",
    _ARRAY.format(r"\w+"): "NDArray",
    r"[~\w.]*_Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]": "ArrayLike",
    r"<class '(\w+)'>": r"\1",
    # Of a declared number its range stands in the docstring.
    r"~?(?:typing\.|types\.)?Annotated\[(\w+(?: \| None)?), .*?\)\]": r"\1",
}
"""What annotations are expanded to, and how the code writes them."""
_LONG: Final = re.compile(r"=( ?)(\d{5,}\.\d+|\d\.\d{6,}e[-+]\d+)")
SYMBOLS: Final = {*equations.GREEK, *equations.FUNCTIONS}
_NAMED: Final = re.compile(r"\b([a-z]{3,})_(?=[a-z])")
_LITERAL: Final = re.compile(r"`+[^`]+`+")
_SPECIAL: Final = re.compile(r"([*|\\])|(?<=\w)_(?=\W|$)")


def as_text(app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Put the lines of a docstring into reStructuredText, Google's sections among them."""
    # Of an attribute, what stands before a colon would be taken for its type.
    kind = "method" if what in ("attribute", "property", "data") else what
    lines[:] = GoogleDocstring(translated(lines), GOOGLE, app, kind, name, item, options).lines()


def translated(lines: list[str]) -> list[str]:
    """Return a docstring in reStructuredText."""
    made: list[str] = []
    section = literal = example = False
    for line in lines:
        margin = len(line) - len(line.lstrip())
        if not line.strip():
            made.append("")
            example = False
            continue
        if example or line.lstrip().startswith(">>>"):
            made += [] if example else [".. code-block:: pycon", ""]
            made.append(line if margin else f"    {line}")
            example, literal = True, False
            continue
        if margin == 0:
            section, literal = bool(SECTION.match(line)), False
        elif not section and not literal and made and not made[-1]:
            literal = True
            made += ["::", ""]
        elif not section and not literal and margin and made and made[-1]:
            # A table or a formula that goes on from its line: it keeps its form.
            made += ["", "::", ""]
            literal = True
        made.append(line if literal else _escaped(line))
    return _with_formulas(made)


def _with_formulas(lines: list[str]) -> list[str]:
    """Return reStructuredText with those of its literal blocks as formulas that are nothing else."""
    made: list[str] = []
    while lines:
        if lines[0] != "::":
            made.append(lines.pop(0))
            continue
        end = next((i for i, line in enumerate(lines[1:], 1) if line and line[0] != " "), len(lines))
        block, lines = lines[:end], lines[end:]
        texts = [line.strip() for line in block[1:] if line]
        made += [*_math(texts), ""] if all(map(_is_formula, texts)) else block
    return made


def _is_formula(text: str) -> bool:
    """Return whether a line is an equation; names of the code, `drive_work`, are none of its symbols."""
    if "=" not in text or any(base not in SYMBOLS for base in _NAMED.findall(text)):
        return False
    try:
        return bool(equations.lines(text))
    except ValueError:
        return False


def _math(texts: Iterable[str]) -> list[str]:
    """Return equations as formulas of their own."""
    formulas = [formula for text in texts for formula in equations.lines(text)]
    return [part for formula in formulas for part in ("", ".. math::", "", f"    {formula}", "")]


def _escaped(line: str) -> str:
    """Escape what is markup by chance; what stands in backticks is code."""
    margin = line[: len(line) - len(line.lstrip())]
    parts, at = [], 0
    text = line.lstrip()
    bullet = text.startswith("* ")
    if bullet:
        at = 2
    for result in _LITERAL.finditer(text):
        parts.append(_SPECIAL.sub(_backslash, text[at : result.start()]))
        parts.append(f"``{result[0].strip('`')}``")
        at = result.end()
    parts.append(_SPECIAL.sub(_backslash, text[at:]))
    return margin + ("* " if bullet else "") + "".join(parts)


def _backslash(result: re.Match[str]) -> str:
    return "\\" + result[0]


def with_parameters(app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Add to a law, or whatever declares its numbers, what is declared of them."""
    if what != "class" or not dataclasses.is_dataclass(item):
        return
    equation = getattr(item, "equation", "")
    if isinstance(equation, str) and equation:
        lines += _math([equation])
    annotations = [each for kind in item.__mro__ for each in vars(kind).get("__annotations__", {}).values()]
    # Others may be annotated for type checkers alone, with names that are not imported.
    if not any("Annotated" in str(each) for each in annotations):
        return
    declared = {n: f for n, f in declared_fields(item).items() if f.parameter}
    if not declared:
        return
    lines += ["", ".. list-table::", "   :header-rows: 1", "", *_row(HEADS)]
    for key, field in declared.items():
        stated = field.parameter
        assert stated is not None
        meaning = _escaped(stated.meaning)
        if stated.symbol:
            meaning = f":math:`{equations.formula(stated.symbol)}`, {meaning}"
        lines += _row([f"`{key}`", meaning, _default(field), _raised(stated.range)])
    lines.append("")


def _row(cells: list[str]) -> list[str]:
    return [f"   {'*' if i == 0 else ' '} - {cell}" for i, cell in enumerate(cells)]


def _default(field: DeclaredField) -> str:
    if field.default is dataclasses.MISSING or field.parameter is None:
        return ""
    if type(field.default) is not float:
        return _escaped(str(field.default))
    return _raised(f"{field.default:.6g}{field.parameter.label}")


def _raised(text: str) -> str:
    return re.sub(r"\^(-?[\d.]+)", r"\\ :sup:`\1`", text)


def short_signature(
    app: Sphinx, what: str, name: str, item: Any, options: Any, signature: str, returned: str
) -> tuple[str, str] | None:
    """Leave out of a signature what stands elsewhere, as the declarations of a dataclass in its table."""
    if what != "class":
        # A property has none.
        return (_readable(signature), _readable(returned or "")) if signature else None
    if not dataclasses.is_dataclass(item):
        # What an enumeration or the base of laws is called with is called by nobody.
        return ("", "") if issubclass(item, Enum | Declared) else None
    parameters = [
        each.replace(annotation=inspect.Parameter.empty)
        for each in inspect.signature(item).parameters.values()
    ]
    shown = [
        f"{each.name}=..." if "factory" in repr(each.default) or len(repr(each.default)) > 40 else str(each)
        for each in parameters
    ]
    return _readable(f"({', '.join(shown)})"), ""


def _readable(signature: str) -> str:
    """Return a signature in the words of the code: names of arrays, numbers of six digits."""
    for pattern, label in _READABLE.items():
        signature = re.sub(pattern, label, signature)
    return _LONG.sub(lambda result: f"={result[1]}{float(result[2]):.6g}", signature)


def without_fields(app: Sphinx, what: str, name: str, item: Any, skip: bool, options: Any) -> bool | None:
    """Leave out what is said already: fields, as arguments of their class, and what everything has."""
    plain = getattr(item, "__doc__", None)
    return True if what == "class" and not callable(item) and not plain else None


def elsewhere(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, shown: nodes.Element
) -> nodes.Element | None:
    """Lead a name to where the public API has it; one that is there and not explained is plain text.

    A name that is nowhere stays missing, and the build says so.
    """
    if node.get("refdomain") != "py":
        return None
    target = str(node.get("reftarget", ""))
    last = target.rpartition(".")[2]
    result = _result(target)
    if result is not None and made_api.exported().get(last) is result:
        domain = env.domains["py"]
        kind = "class" if inspect.isclass(result) else "func"
        return domain.resolve_xref(env, node["refdoc"], app.builder, kind, f"contactlab.{last}", node, shown)
    return shown if result is not None else None


def _result(target: str) -> Any:
    """Return what a name stands for; None for nothing. One without a module is looked for in ours."""
    module, _, last = target.rpartition(".")
    if not module:
        ours = [sys.modules[name] for name in sorted(sys.modules) if name.startswith("contactlab.")]
        return next((getattr(m, last) for m in (builtins, typing, *ours) if hasattr(m, last)), None)
    try:
        return getattr(import_module(module), last)
    except (ImportError, AttributeError):
        return getattr(_result(module), last, None) if "." in module else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the translation, and what is added to what it makes."""
    app.connect("autodoc-process-docstring", as_text, priority=400)
    app.connect("autodoc-process-docstring", with_parameters, priority=600)
    app.connect("autodoc-process-signature", short_signature)
    app.connect("autodoc-skip-member", without_fields)
    app.connect("missing-reference", elsewhere)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
