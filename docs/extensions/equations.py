r"""Equations as the code writes them, "F = -mu N z/Y, dz/dt = v - |v| z/Y", in LaTeX.

Factors stand side by side. A slash divides its two neighbours, `k_1/k_2 v`; before a bracket, `3 mu N/(2 k)`,
and between spaces, `k N |v| / H`, it divides all factors before it. A bracket right behind a name is its
argument. Names of two letters and more that are no symbol, function or differential are words.
"""

import re
from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

GREEK: Final = frozenset(
    re.findall(
        r"\w+",
        "alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau phi chi psi "
        "omega Gamma Delta Theta Lambda Phi Psi Omega",
    )
)
SIGNS: Final = {"sum": r"\sum", "int": r"\int"}
FUNCTIONS: Final = (
    {name: f"\\{name}" for name in ("max", "min", "exp", "ln", "sin", "cos", "tan", "tanh", "sqrt")}
    | {name: rf"\operatorname{{{name}}}" for name in ("sign", "sgn", "asinh", "clip", "mean", "median")}
    | SIGNS
)
RELATIONS: Final = {"=": "=", "<": "<", ">": ">", "<<": r"\ll"} | {
    "<=": r"\le",
    ">=": r"\ge",
    "!=": r"\ne",
    "_|_": r"\perp",
}
PAIRS: Final = {"(": ")", "[": "]", "|": "|"}

LINE: Final = 44
"""Length of text whose formula fits into a line on a phone."""

_TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d+)?(?:e[-+]?\d+)?)"
    r"|(?P<name>[A-Za-z]+(?:-[a-z]{2,})?(?:'+|\*)?(?:_(?:\w+|\(\w+\)))?(?:[-+](?=[\s,^()]|$))?)"
    r"|(?P<mark><<|<=|>=|!=|_\|_|[-+=<>/^|()\[\],;]))"
)
_NAME: Final = re.compile(r"([A-Za-z]+)('+|\*)?(?:_\(?(\w+?)\)?)?([-+])?$")


class Token(NamedTuple):
    """A number, name or mark, and whether a space or the text's end is before and behind it."""

    kind: str
    text: str
    parted: bool = True
    ended: bool = True


class Made(NamedTuple):
    """LaTeX of an expression by itself, and within a fraction or exponent."""

    large: str
    small: str


def lines(text: str) -> list[str]:
    """Return the LaTeX of an equation, with as many of its statements to a line as fit."""
    result: list[str] = []
    room = 0
    for source, statement in _statements(text):
        if len(source) <= room:
            result[-1] += rf",\quad {statement}"
        else:
            room = LINE
            result.append(statement)
        room -= len(source) + 2
    return result


def formula(text: str) -> str:
    """Return the LaTeX of one expression."""
    return r",\quad ".join(statement for _, statement in _statements(text))


def _statements(text: str) -> Iterator[tuple[str, str]]:
    reader = _Reader(text)
    while reader.next.kind != "end":
        first = reader.at
        statement = reader.statement()
        yield " ".join(token.text for token in reader.tokens[first : reader.at]), statement
        if reader.next.kind != "end":
            reader.expect(",", ";")


def _tokens(text: str) -> Iterator[Token]:
    at = 0
    while at < len(text):
        result = _TOKEN.match(text, at)
        if result is None:
            raise ValueError(f"The equation '{text}' has '{text[at:]}', which is no number, name or mark.")
        kind = str(result.lastgroup)
        start, at = result.span(kind)
        yield Token(kind, result[kind], text[start - 1 : start] == " ", text[at : at + 1] in (" ", ""))


class _Reader:
    """Reads an equation from left to right; `closing` has the brackets that are open."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.tokens = [*_tokens(text.strip())]
        self.closing: list[str] = []

    @property
    def next(self) -> Token:
        return self.behind(0)

    def behind(self, places: int) -> Token:
        at = self.at + places
        return self.tokens[at] if at < len(self.tokens) else Token("end", "")

    def take(self) -> str:
        self.at += 1
        return self.tokens[self.at - 1].text

    def expect(self, *marks: str) -> None:
        if self.next.text not in marks:
            raise ValueError(f"The equation '{self.text}' has '{self.next.text}' in the place of {marks[0]}.")
        self.at += 1

    def statement(self) -> str:
        """Read relations, with prose before, between and behind them."""
        parts: list[str] = []
        while self.next.text not in (",", ";", ""):
            if not self.is_word():
                parts.append(self.relations().large)
                continue
            prose = [""][: len(parts)]
            while self.is_word():
                prose.append(self.take())
            prose += [""][: self.next.text not in (",", ";", "")]
            parts.append(rf"\text{{{' '.join(prose)}}}")
        return " ".join(parts)

    def is_word(self) -> bool:
        token = self.next
        symbol = token.text in {*GREEK, *FUNCTIONS, "gdot"} or _is_differential(token.text)
        plain = re.fullmatch(r"[A-Za-z]{2,}(-[a-z]+)?", token.text) is not None
        return plain and not symbol and (token.ended or self.behind(1).text != "(")

    def relations(self) -> Made:
        parts = [self.sum()]
        while self.next.text in RELATIONS:
            parts += [_plain(RELATIONS[self.take()]), self.sum()]
        return _spaced(parts)

    def sum(self) -> Made:
        sign = self.take() if self.next.text in ("-", "+") else ""
        parts = [_set(lambda x: sign + x, self.product())]
        while self.next.text in ("-", "+"):
            parts += [_plain(self.take()), self.product()]
        return _spaced(parts)

    def product(self) -> Made:
        parts = [self.factor()]
        while self.next.text == "/" or self.begins_factor():
            if self.next.text != "/":
                parts.append(self.factor())
                continue
            # A derivative is one factor, whatever is below it.
            derivative = _is_differential(self.behind(-1).text)
            whole = self.next.parted or (self.behind(1).text == "(" and not derivative)
            first = 0 if whole else len(parts) - 1
            self.at += 1
            below = self.factor()
            if below.large in FUNCTIONS.values():
                raise ValueError(f"The equation '{self.text}' divides by a function without brackets.")
            parts[first:] = [_fraction(_spaced(parts[first:]), below)]
        return _spaced(parts)

    def begins_factor(self) -> bool:
        token = self.next
        if token.text == "|":
            return self.closing[-1:] != ["|"]
        return token.text in PAIRS or (token.kind in ("name", "number") and not self.is_word())

    def factor(self) -> Made:
        base = self.atom()
        if self.next.text != "^":
            return base
        self.at += 1
        if re.search(r"\^\{[-+*]+\}$", base.large):
            base = _set(lambda x: rf"\left({x}\right)", base)
        sign = self.take() if self.next.text == "-" else ""
        power = f"^{{{sign}{_bare(self.atom().small)}}}"
        return _set(lambda x: x + power, base)

    def atom(self) -> Made:
        token = self.next
        if token.text in PAIRS:
            return self.bracket()
        if token.kind not in ("name", "number"):
            raise ValueError(
                f"The equation '{self.text}' has '{token.text}' in the place of a number or name."
            )
        if token.kind == "number":
            return _plain(_number(self.take()))
        if self.is_word():
            return _plain(rf"\text{{{self.take()}}}")
        name = _name(self.take())
        if token.ended or self.next.text != "(":
            return _plain(name)
        argument = self.bracket()
        if name == r"\sqrt":
            return _set(lambda x: rf"\sqrt{{{_bare(x)}}}", argument)
        return _set(lambda x: name + x, argument)

    def bracket(self) -> Made:
        opening = self.take()
        self.closing.append(PAIRS[opening])
        parts = [self.relations()]
        while self.next.text == ",":
            self.at += 1
            parts.append(self.relations())
        self.expect(self.closing.pop())
        return _set(lambda *x: rf"\left{opening}{', '.join(x)}\right{PAIRS[opening]}", *parts)


def _plain(latex: str) -> Made:
    return Made(latex, latex)


def _set(rule: Callable[..., str], *parts: Made) -> Made:
    return Made(rule(*(part.large for part in parts)), rule(*(part.small for part in parts)))


def _spaced(parts: list[Made]) -> Made:
    return _set(lambda *x: " ".join(x), *parts)


def _fraction(above: Made, below: Made) -> Made:
    large = rf"\frac{{{_bare(above.small)}}}{{{_bare(below.small)}}}"
    return Made(large, f"{above.small}/{below.small}")


def _bare(latex: str) -> str:
    """Return an expression without round brackets around all of it."""
    depth = 0
    for result in re.finditer(r"\\left(.)|\\right(.)", latex):
        depth += 1 if result[1] else -1
        if depth == 0:
            whole = result.end() == len(latex) and latex.startswith(r"\left(")
            return latex[6:-7] if whole else latex
    return latex


def _number(text: str) -> str:
    """Return a number, "2.5e-06", with its power of ten."""
    digits, _, power = text.partition("e")
    if not power:
        return text
    return ("" if digits == "1" else rf"{digits} \cdot ") + f"10^{{{int(power)}}}"


def _is_differential(name: str) -> bool:
    base = name.partition("_")[0]
    return base.startswith("d") and (len(base) == 2 or base[1:] in GREEK)


def _name(text: str) -> str:
    """Return a name with its subscript, and with what stands above it."""
    result = _NAME.match(text)
    if result is None:
        raise ValueError(f"'{text}' is no name of an equation.")
    base, over, below, sign = (group or "" for group in result.groups())
    primes, star = (over, "") if "'" in over else ("", over)
    index = f"_{{{_index(below)}}}" if below else ""
    return _letter(base) + primes + index + (f"^{{{star}{sign}}}" if star or sign else "")


def _index(text: str) -> str:
    if text == "inf":
        return r"\infty"
    return text if len(text) < 3 and text not in GREEK else _name(text)


def _letter(text: str) -> str:
    if text == "gdot":
        return r"\dot{g}"
    if text in GREEK or len(text) == 1:
        return text if len(text) == 1 else f"\\{text}"
    if text in FUNCTIONS:
        return FUNCTIONS[text]
    return rf"\mathrm{{d}}{_letter(text[1:])}" if _is_differential(text) else rf"\mathrm{{{text}}}"
