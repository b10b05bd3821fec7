"""Numbers of pages that no claim states and no table holds, each beside what it is compared with.

numbers.yaml lists them by page and origin, and an origin is checked: a number that is `shown` stands in a
block of code or output of the page, which the tests of the documentation run; one of `code` is the value of
an expression over constants and configurations; one that is `cited` is of a source that the page names.
"""

import re
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from math import isclose, pi
from typing import Any, Final

import yaml
from dependencies import ROOT

import contactlab as cl
from contactlab.config.nesting import flat
from contactlab.studies.compare.factors import USUAL

LISTED: Final = "experiments/numbers.yaml"
ORIGINS: Final = ("shown", "code", "cited")

BLOCK: Final = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
"""Code and output on a page."""

LITERAL: Final = re.compile(r"(?<![\w.])\d[\d_]*\.?\d*(?:e[-+]?\d+)?", re.IGNORECASE)
PREFIXES: Final = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}
SCALED: Final = re.compile(rf"([{''.join(PREFIXES)}])(?:Hz|s|N|Pa|m|g|W|A|J|V|rad)\b")
"""A unit with a prefix."""


class Literal:
    """A number as it is written, with its unit.

    Args:
        text: such as "-1.39 rad/s", "20 ms", "5 %" or "15 of the".
    """

    def __init__(self, text: str) -> None:
        (number,) = LITERAL.findall(text.replace(",", ""))[:1]
        self.value = float(number)
        mantissa, _, power = number.lower().partition("e")
        decimals = len(mantissa.partition(".")[2])
        # The digits of "16" may be those of 15.8, the one of "5" is that of 5 alone.
        digits = len(mantissa.replace(".", "").strip("0"))
        self.half = 0.5 * 10.0 ** (int(power or 0) - decimals) if digits > 1 else 0.0
        self.unit = text.replace(",", "").partition(number)[2].strip()
        prefix = SCALED.match(self.unit)
        self.scale = 0.01 if self.unit.startswith("%") else 1e-3 if self.unit == "g" else 1.0
        if prefix and self.unit != "kg":
            self.scale = PREFIXES[prefix[1]] * (1e-3 if self.unit.endswith("g") else 1.0)

    def is_of(self, other: float, scale: float | None = None) -> bool:
        """Return whether it is a number in SI units, or on another scale, to its digits."""
        scale, other = self.scale if scale is None else scale, abs(other)
        value = self.value * scale
        return isclose(value, other, rel_tol=1e-9) or abs(value - other) <= self.half * scale

    def stands_in(self, block: str) -> bool:
        """Return whether it stands in code or output, in SI units or with its own."""
        for each in LITERAL.finditer(block):
            own = block[each.end() :].lstrip().startswith(self.unit)
            if self.is_of(float(each[0])) or (own and self.is_of(float(each[0]), 1.0)):
                return True
        return False


# Constants of benchmarks are named as those of experiments are.
sys.path.append(str(ROOT / "benchmarks"))


@cache
def listed() -> dict[str, dict[str, Any]]:
    """Return the numbers without a claim by page and origin."""
    content: dict[str, dict[str, Any]] = yaml.safe_load((ROOT / LISTED).read_text(encoding="utf-8"))
    return content


def of_page(name: str) -> Iterator[str]:
    """Yield the numbers that are listed for a page."""
    own = listed().get(name, {})
    yield from own.get("shown", ())
    yield from (number for each in own.get("code", ()) for number in each)
    yield from (number for numbers in own.get("cited", {}).values() for number in numbers)


def faults(name: str, text: str) -> Iterator[str]:
    """Yield what is wrong with the list of a page."""
    own = listed().get(name, {})
    yield from (f"{name}: '{origin}' is no origin of a number" for origin in own if origin not in ORIGINS)
    blocks = "\n".join(BLOCK.findall(text))
    for number in own.get("shown", ()):
        if not Literal(number).stands_in(blocks):
            yield f"{name}: '{number}' stands in no code block of the page"
    for number, expression in (item for each in own.get("code", ()) for item in each.items()):
        if not Literal(number).is_of(float(eval(expression, EXPRESSIONS))):
            yield f"{name}: '{number}' is not {expression}"
    plain = " ".join(text.split())
    yield from (f"{name}: names no '{source}'" for source in own.get("cited", {}) if source not in plain)


def constant(path: str) -> Any:
    """Return a constant, "MODULE:NAME", of the package, of experiments/ or of benchmarks/."""
    module, _, name = path.partition(":")
    result: Any = import_module(module)
    for part in name.split("."):
        result = getattr(result, part)
    return result


@cache
def key(name: str, *overrides: str) -> Any:
    """Return a value of the default configuration, or of one with overrides."""
    return flat(cl.build(overrides).configuration)[name]


def between(ends: tuple[float, float]) -> float:
    """Return the share between two quantiles."""
    return ends[1] - ends[0]


def varied(name: str) -> float:
    """Return by how much a comparison varies a factor by default."""
    return next(factor.a for factor in USUAL if factor.name == name)


EXPRESSIONS: Final = {"constant": constant, "key": key, "between": between, "varied": varied, "pi": pi}
"""Names of expressions."""
