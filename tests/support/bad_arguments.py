"""Bad arguments of public functions, and the checks that each is refused by a sentence."""

import traceback
from collections.abc import Callable
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactlab as cl

OWN = tuple(
    str(Path(spec.origin).parent)
    for name in ("contactlab", "contactlab_data")
    if (spec := find_spec(name)) and spec.origin
)
"""Folders of this project's packages, as far as they are installed."""

NO_NUMBER_OR_OBJECT: list[Any] = [
    *(None, True, 5, -1.0, np.nan, 1j, "newton", "10 mol", b"x", object(), cl.Newton, cl.Newton()),
    *([], [None], (1, 2), {}, {"a": object()}, {1: 2}, cl.build().motor),
    *(np.zeros(1), np.zeros((2, 2, 2)), np.array(["x"])),
]  # fmt: skip
"""Values of every kind: each is a bad one of most arguments."""

DOCUMENTED = (TypeError, ValueError, OSError, RuntimeError)
"""What public functions raise, subclasses of the package's own among them."""


def raised_by(function: Callable[..., Any], arguments: dict[str, Any]) -> Exception | None:
    """Return what a call raises."""
    try:
        function(**arguments)
    except Exception as error:
        return error
    return None


def is_refusal(error: Exception) -> bool:
    """Return whether an exception is raised by a statement of the package, or names a file."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    own = last.filename.startswith(OWN) and (last.line or "").startswith("raise")
    return isinstance(error, DOCUMENTED) and (own or (isinstance(error, OSError) and bool(error.filename)))


def assert_refused_by_a_sentence(function: Callable[..., Any], arguments: dict[str, Any]) -> None:
    """Every bad value of every argument is refused, and the next good call is as before."""
    for argument in arguments:
        for value in NO_NUMBER_OR_OBJECT:
            if error := raised_by(function, arguments | {argument: value}):
                assert is_refusal(error), (argument, value, repr(error))
                assert str(error).strip(), (argument, value)
    good = cl.impact(cl.Newton(restitution=0.8), [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.0])
    assert good["velocity_after"].values.tolist() == [[0.8, 0.0]]
    assert cl.build().motor.geometry.clearance == 1e-6


def laws_of(function: Callable[..., Any]) -> list[tuple[str, Any]]:
    """Return the arguments of a public function that take a law, each with its annotation."""
    annotations = {x.name: str(x.annotation) for x in signature(function).parameters.values()}
    return [(x, text) for x, text in annotations.items() if "ContactLaw" in text]


def assert_name_of_a_law_refused(
    function: Callable[..., Any], arguments: dict[str, Any], argument: str, kind: str
) -> None:
    """A text in place of a law is refused with the call that makes the law."""
    many: list[Any] = [["newton"], [cl.Poisson(), "newton"]] if "Sequence" in kind else []
    many += [{"mine": "newton"}] if "Mapping" in kind else []
    for value in ["newton", *many]:
        with pytest.raises(TypeError, match=rf"{argument}\b.*contactlab\.law\('newton'\)"):
            function(**arguments | {argument: value})
