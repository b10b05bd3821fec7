"""The kernels of a law, compiled where that can be done: once for all that is made of the same.

What was compiled is found again by its fingerprint, the digest of all that it refers to, so that a
function that is made anew around equal values costs no second compilation, and one whose helpers or
constants have changed gets new code.
"""

import sys
import warnings
from functools import cache, lru_cache
from typing import Any, Final
from weakref import WeakKeyDictionary

from contactlab.compiled import INTERPRETED, fleeting_kernel, keep_code, kernel, remade
from contactlab.engine.callback import Callback, law_errors, stand_in
from contactlab.engine.obstacle import obstacle
from contactlab.engine.rows import SIGNATURES, own_signature, reading_row
from contactlab.fingerprint import Fingerprint, is_own
from contactlab.laws.base import ContactLaw, PenaltyLaw
from contactlab.laws.intake import function_of, has_row, is_plain

_made_from: WeakKeyDictionary[Any, str] = WeakKeyDictionary()
"""Fingerprints of the compiled functions that a law's kernels call, when their code was made."""


IDLE: Final = {
    "force": kernel(lambda _1, _2, _3, _4, _5: (0.0, 0.0, 0.0, 0.0)),
    "friction_force": kernel(lambda _1, _2, _3, _4, _5, _6: (0.0, 0.0, 0.0, 0.0)),
    "solve": kernel(lambda _1, _2, _3, _4, _5, _6, _7, _8: (0.0, 0.0, 0)),
    "rate": kernel(lambda _1, _2, _3, _4, _5, _6: 0.0),
    "guard": kernel(lambda _1, _2, _3, _4, _5, _6: 1.0),
    "jump": kernel(lambda k, _1, _2, _3, _4, _5, row: row[k]),
    "limits": kernel(lambda _: (0.0, 0.0)),
    "moment": kernel(lambda _1, _2, _3, _4, _5: (0.0, 0.0, 0.0)),
}
"""Kernels that stand for those that a law lacks: nothing acts, and what is remembered stays."""

OF_PLAIN = 3
"""Of them, those of a plain law."""


def kernels_of(law: ContactLaw) -> tuple[tuple[Any, ...], tuple[Callback, ...]]:
    """Give the law's kernels, idle ones for those that it lacks, and the callbacks of interpreted ones.

    Of a plain law these are the first three alone.
    """
    kernels: list[Any] = []
    callbacks: list[Callback] = []
    needed = "force" if isinstance(law, PenaltyLaw) else "solve"
    for name, nothing in [*IDLE.items()][: OF_PLAIN if is_plain(law) else None]:
        with law_errors(law.name):
            own = name == needed or getattr(law, name, None) is not None
            function = function_of(law, name) if own else None
        if function is None:
            kernels.append(_idle(name, nothing))
            continue
        found, callback = _compiled_form(law, name, function)
        kernels.append(found)
        callbacks += [callback] if callback else []
    return tuple(kernels), tuple(callbacks)


def _compiled_form(law: ContactLaw, name: str, function: Any) -> tuple[Any, Callback | None]:
    """Give one of a law's kernels as the loop takes it, and the callback behind it if that is interpreted.

    The function is a compiled kernel of this package, which is given back unless it has to be asked through
    a row, or any callable.
    """
    signature, rows = SIGNATURES[name], has_row(law)
    shape = len(law.remembered), law.friction_remembers
    if INTERPRETED:
        return (reading_row(name, function, *shape) if rows else function), None
    kernel = _compiled(function, own_signature(law, name))
    if isinstance(kernel, str):
        plain = getattr(function, "py_func", function)
        _say_once(
            f"{getattr(plain, '__qualname__', type(plain).__qualname__)} cannot be compiled ({kernel}), so "
            "the Python interpreter runs it: a call takes microseconds, that of a compiled kernel some ns."
        )
        return stand_in(name, signature), (name, reading_row(name, plain, *shape) if rows else plain)
    return (_reading_row(name, kernel, *shape) if rows else kernel), None


def _idle(name: str, kernel: Any) -> Any:
    """Give a kernel of this package that stands for one that a law lacks."""
    if not INTERPRETED:
        _compile(kernel, SIGNATURES[name])
    return kernel


@lru_cache(maxsize=256)
def _reading_row(name: str, kernel: Any, count: int, of_three: bool) -> Any:
    made = fleeting_kernel(reading_row(name, kernel, count, of_three))
    _compile(made, SIGNATURES[name])
    return made


def _compiled(function: Any, signature: Any) -> Any:
    """Give the compiled function; where there is an obstacle, give that in words."""
    plain = getattr(function, "py_func", function)
    if plain is not function and is_own(plain) and not plain.__closure__:
        _compile(function, signature)
        return function
    return _made(Fingerprint(function), signature)


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
