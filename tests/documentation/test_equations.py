"""Equations of the declarations are set as formulas, which contain what the text contains, in its order."""

import html
import re
import unicodedata
from xml.etree import ElementTree

import equations
import law_page
import pytest

from contactlab.laws import LAWS, PARTS
from contactlab.laws.declaration import members_of
from contactlab.metrics import METRICS, SENSITIVITIES, STEP_METRICS

math_markup = pytest.importorskip("math_markup", reason="needs Sphinx", exc_type=ImportError)
docstrings = pytest.importorskip("docstrings", reason="needs Sphinx", exc_type=ImportError)

OWNERS = {
    f"{family}/{name}": kind for family, table in {"": LAWS, **PARTS}.items() for name, kind in table.items()
}
TEXTS = {
    name: [owner.equation, *law_page.formulas_of(owner), *symbols]
    for name, owner in OWNERS.items()
    for symbols in [[m.parameter.symbol for m in members_of(owner).values() if m.parameter]]
}
TEXTS |= {key: [m.symbol] for key, m in {**METRICS, **STEP_METRICS, **SENSITIVITIES}.items()}
SIGNS = {"∑": "sum", "∫": "int", "∞": "inf", "≤": "<=", "≥": ">=", "≠": "!=", "⊥": "_|_", "≪": "<<"} | {
    "\N{MINUS SIGN}": "-",
    "\N{PRIME}": "'",
    "\N{DOUBLE PRIME}": "''",
    "\N{ASTERISK OPERATOR}": "*",
    "\N{PERPENDICULAR}": "_|_",
}


def letters_of_text(text: str) -> str:
    """Return a text without what a formula shows by places and sizes: slashes, brackets, powers, indices."""
    text = re.sub(r"(\d)e-0*(\d+)", lambda part: f"{part[1] * (part[1] != '1')}10-{part[2]}", text)
    return re.sub(r"[\s/^()]|(?<!_)_(?!\|)|sqrt|(?<=_\|)_(?=\w)", "", text.replace("_|_", "⊥")).replace(
        "⊥", "_|_"
    )


def letters_of_formula(latex: str) -> str:
    """Return the same of what a browser is given to show."""
    markup = math_markup.formula(latex, "block")
    text = html.unescape("".join(ElementTree.fromstring(markup).itertext()))
    text = re.sub(r"(\w)[˙\u0307]", r"\1dot", text)
    for character in {*text}:
        name = unicodedata.name(character, "")
        if name.startswith("GREEK"):
            _, size, _, letter = name.replace("LAMDA", "LAMBDA").split()
            text = text.replace(character, letter.lower() if size == "SMALL" else letter.capitalize())
    for sign, plain in SIGNS.items():
        text = text.replace(sign, plain)
    return re.sub(r"[\s/()]", "", text.replace("\xa0", ""))


@pytest.mark.parametrize("name", TEXTS)
def test_a_formula_has_the_symbols_of_its_text_in_their_order(name: str) -> None:
    for text in TEXTS[name]:
        shown = ",".join(letters_of_formula(line) for line in equations.lines(text))
        assert shown == letters_of_text(text).replace(";", ",")


@pytest.mark.parametrize("name", TEXTS)
def test_the_formulas_of_a_law_are_whole(name: str) -> None:
    for latex in (line for text in TEXTS[name] for line in equations.lines(text)):
        assert latex.count("{") == latex.count("}")
        assert latex.count(r"\left") - latex.count(r"\leftarrow") == latex.count(r"\right")
        # A command that the renderer does not know would stand in the page as it is.
        assert "\\" not in math_markup.formula(latex, "block")


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("2.5e-06 E", r"2.5 \cdot 10^{-6} E"),
        ("1/2 k d", r"\frac{1}{2} k d"),
        ("3 mu N/(2 k)", r"\frac{3 \mu N}{2 k}"),
        ("a b / c d", r"\frac{a b}{c} d"),
        ("a^(1/2)", "a^{1/2}"),
        ("c dz_1/dt", r"c \frac{\mathrm{d}z_{1}}{\mathrm{d}t}"),
        ("a + sqrt(b)", r"a + \sqrt{b}"),
        ("|z| |v|^n v", r"\left|z\right| \left|v\right|^{n} v"),
        ("gdot-^2", r"\left(\dot{g}^{-}\right)^{2}"),
        ("f (d)", r"f \left(d\right)"),
        ("0 where v = 0", r"0 \text{ where } v = 0"),
    ],
)
def test_a_text_means_what_its_formula_does(text: str, latex: str) -> None:
    assert equations.formula(text) == latex


@pytest.mark.parametrize("text", ["N = (k d", "N = k d)", "N = k $ d", "N = / d", "|v", "N = ", "a / sum b"])
def test_a_text_that_is_no_equation_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"equation"):
        equations.formula(text)


@pytest.mark.parametrize(
    ("text", "signs"),
    [("F = -mu N", 1), ("max(-g, 0)", 1), ("(a) - b", 0), ("a - |b|", 0), ("|a| - b", 0), ("a^2 - b", 0)],
)
def test_a_minus_is_a_sign_behind_an_operator_and_a_difference_behind_a_number(text: str, signs: int) -> None:
    markup = math_markup.formula(equations.formula(text), "inline")
    assert (
        markup.count('<mo form="prefix">\N{MINUS SIGN}') + markup.count('<mo form="prefix">&#x02212;')
        == signs
    )


def test_a_function_is_set_close_to_its_bracket_and_a_derivative_with_upright_letters() -> None:
    markup = math_markup.formula(equations.formula("a max(dz/dt, 0) sgn v"), "inline")
    assert '<mo lspace="0.17em" rspace="0em">max</mo>' in markup
    assert '<mo lspace="0.17em" rspace="0.17em">sgn</mo>' in markup
    assert markup.count("<mtext>d</mtext>") == 2


def test_a_block_of_a_docstring_that_is_nothing_but_equations_is_set_as_formulas() -> None:
    made = docstrings.translated(["Return N.", "", "    N = K d^1.5,  d = -g", "", "Further."])
    assert [line.strip() for line in made if line.strip()] == [
        "Return N.", ".. math::", "N = K d^{1.5},\\quad d = -g", "Further."
    ]  # fmt: skip
    for text in ("solution.save('run.nc')", "drive_work = N v", "key=value pairs", "a column of the table"):
        assert docstrings.translated(["A text.", "", f"    {text}"])[-1] == f"    {text}"
