"""The kernels of a law, compiled where that can be done: once for all that is made of the same.

What was compiled is found again by its fingerprint, the digest of all that it refers to, so that a
function that is made anew around equal values costs no second compilation, and one whose helpers or
constants have changed gets new code.
"""

import sys
import warnings
from collections import Counter
from functools import cache, lru_cache
from typing import Any, Final
from weakref import WeakKeyDictionary

from contactlab.compiled import INTERPRETED, fleeting_kernel, keep_code, remade
from contactlab.engine.callback import Callback, stand_in
from contactlab.engine.obstacle import obstacle
from contactlab.fingerprint import Fingerprint, fingerprint, is_own

OFTEN: Final = 8
"""Compilations of one function in a process that are worth a word."""

_made_from: WeakKeyDictionary[Any, str] = WeakKeyDictionary()
"""Fingerprints of the compiled functions that a law's kernels call, when their code was made."""
_compilations: Counter[object] = Counter()
"""Compilations by code: functions that are made by the same lines have the same."""


def compiled(function: Any, signature: Any) -> tuple[Any, Callback | None]:
    """Give a kernel with this signature, and the callback behind it where the function is interpreted.

    Args:
        function: a compiled kernel of this package, which is given back, or any callable.
        signature: what the engine calls it with.
    """
    if INTERPRETED:
        return function, None
    plain = getattr(function, "py_func", function)
    if plain is not function and is_own(plain) and not plain.__closure__:
        _compile(function, signature)
        return function, None
    kernel = _made(fingerprint(function), signature)
    if not isinstance(kernel, str):
        return kernel, None
    _say_once(
        f"{_name(plain)} cannot be compiled ({kernel}), so the Python interpreter runs it: a call takes "
        "microseconds, that of a compiled kernel some ns."
    )
    return stand_in(signature), Callback(plain, signature)


@lru_cache(maxsize=256)
def _made(found: Fingerprint, signature: Any) -> Any:
    """Give the compiled function; where there is an obstacle, give that in words."""
    function: Any = found.subject
    try:
        # A user's own kernel may have code of other values.
        kernel = remade(function) if hasattr(function, "py_func") else fleeting_kernel(function)
        _renew_callees(kernel)
        keep_code(kernel, found.digest)
        _compile(kernel, signature)
    # The compiler lets errors of every kind through, the function's own language among them.
    except Exception as error:
        return obstacle(error, function, signature)
    code = getattr(kernel.py_func, "__code__", type(function))
    _compilations[code] += 1
    if _compilations[code] == OFTEN and not is_own(kernel.py_func):
        _say_once(
            f"{_name(function)} has been compiled {OFTEN} times, because it is made anew around other "
            "values every time; let it read what varies from the law's parameters."
        )
    return kernel


def _renew_callees(kernel: Any) -> None:
    """See to it that the code of what a kernel calls is of the sources and values that stand now."""
    callees = [(each, fingerprint(each)) for each in fingerprint(kernel).kernels]
    # What another one calls comes before it.
    for each, found in sorted(callees, key=lambda pair: len(pair[1].kernels)):
        if _made_from.get(each) != found.digest:
            # Of code that is kept by the compiler's own rules, this does away with the index.
            if each.overloads or each.stats.cache_path is not None:
                each.recompile()
            _made_from[each] = found.digest


def _compile(kernel: Any, signature: Any) -> None:
    if tuple(signature.args) not in kernel.overloads:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            kernel.compile(signature)


def _name(function: Any) -> str:
    return str(getattr(function, "__qualname__", type(function).__qualname__))


@cache
def _say_once(sentence: str) -> None:
    print(f"contactlab: {sentence}", file=sys.stderr, flush=True)
