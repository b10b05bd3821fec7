r"""Formulas as MathML, which browsers set themselves: no script, no font and no network.

An equation's number is its own `\tag{...}`, the same in a repository browser; `PAGE.md#equation-N` leads
to it.
"""

import re
from typing import Any, Final

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

_TAG: Final = re.compile(r"\s*\\tag\{([^}]*)\}\s*")
# Bars that stand for themselves would be spaced as relations.
_SIZE: Final = re.compile(r"(?<!left)(?<!right)\|((?:[^|\\]|\\(?!left|right))*)\|")

# The converter has a single upright letter in italics.
_UPRIGHT: Final = re.compile(r"\\mathrm\{([A-Za-z]+)\}")
# A browser takes a minus behind another operator for a difference, and spaces functions as relations.
_SIGN: Final = re.compile(r"(?<=</mo>)(?<!&#x00029;</mo>)<mo>&#x02212;</mo>")
_FUNCTION: Final = re.compile(r"<mo>([a-z]+)</mo>(?=((?:<mrow>)?<mo stretchy)?)")


def formula(text: str, display: str) -> str:
    """Return a formula as MathML."""
    text = _UPRIGHT.sub(r"\\text{\1}", _SIZE.sub(r"\\left|\1\\right|", text.strip()))
    made: str = convert(text, display=display)
    made = _SIGN.sub('<mo form="prefix">&#x02212;</mo>', made)
    return _FUNCTION.sub(
        lambda part: f'<mo lspace="0.17em" rspace="{0 if part[2] else 0.17}em">{part[1]}</mo>', made
    )


def visit_inline(translator: Any, node: nodes.Element) -> None:
    """Write a formula in a line."""
    translator.body.append(formula(node.astext(), "inline"))
    raise nodes.SkipNode


def visit_display(translator: Any, node: nodes.Element) -> None:
    """Write a formula of its own, with its number."""
    text, number = node.astext(), ""
    if result := _TAG.search(text):
        text, number = _TAG.sub(" ", text), result[1]
    anchor = f' id="equation-{number}"' if number else ""
    label = f'<span class="number"><a href="#equation-{number}">({number})</a></span>' if number else ""
    made = formula(text, "block")
    translator.body.append(f'<div class="formula"{anchor}><span>{made}</span>{label}</div>\n')
    raise nodes.SkipNode


def with_equations(app: Sphinx, page: nodes.document) -> None:
    """Add the equations of a page to the headings that links from other pages may lead to."""
    places = app.env.metadata[app.env.docname].setdefault("myst_slugs", {})
    for node in page.findall(nodes.math_block):
        if result := _TAG.search(node.astext()):
            name = f"equation-{result[1]}"
            places[name] = (node.line, name, result[1])


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer."""
    app.connect("doctree-read", with_equations)
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_display, None))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
