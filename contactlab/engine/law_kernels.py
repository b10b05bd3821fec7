"""The kernels of a law, compiled where that can be done: once for all that is made of the same.

What was compiled is found again by its fingerprint, the digest of all that it refers to, so that a
function that is made anew around equal values costs no second compilation, and one whose helpers or
constants have changed gets new code.
"""

import sys
import warnings
from functools import cache, lru_cache
from typing import Any
from weakref import WeakKeyDictionary

from contactlab.compiled import INTERPRETED, fleeting_kernel, keep_code, remade
from contactlab.engine.callback import Callback, stand_in
from contactlab.engine.obstacle import obstacle
from contactlab.fingerprint import Fingerprint, is_own

_made_from: WeakKeyDictionary[Any, str] = WeakKeyDictionary()
"""Fingerprints of the compiled functions that a law's kernels call, when their code was made."""


def compiled(function: Any, signature: Any) -> tuple[Any, Callback | None]:
    """Give a kernel with this signature, and the callback behind it where the function is interpreted.

    The function is a compiled kernel of this package, which is given back, or any callable.
    """
    if INTERPRETED:
        return function, None
    plain = getattr(function, "py_func", function)
    if plain is not function and is_own(plain) and not plain.__closure__:
        _compile(function, signature)
        return function, None
    kernel = _made(Fingerprint(function), signature)
    if not isinstance(kernel, str):
        return kernel, None
    _say_once(
        f"{getattr(plain, '__qualname__', type(plain).__qualname__)} cannot be compiled ({kernel}), so the "
        "Python interpreter runs it: a call takes microseconds, that of a compiled kernel some ns."
    )
    return stand_in(signature), (signature, plain)


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
    return kernel


def _renew_callees(kernel: Any) -> None:
    """See to it that the code of what a kernel calls is of the sources and values that stand now."""
    callees = [(each, Fingerprint(each)) for each in Fingerprint(kernel).kernels]
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


@cache
def _say_once(sentence: str) -> None:
    print(f"contactlab: {sentence}", file=sys.stderr, flush=True)
