"""The kernels of a law, compiled where that can be done: once for all that is made of the same.

What was compiled is found again by its fingerprint, the digest of all that it refers to, so that a
function that is made anew around equal values costs no second compilation, and one whose helpers or
constants have changed gets new code.
"""

import sys
import warnings
from collections import Counter
from typing import Any, Final
from weakref import WeakKeyDictionary

from contactlab.compiled import INTERPRETED, fleeting_kernel, keep_code, remade
from contactlab.engine.callback import Callback
from contactlab.engine.obstacle import obstacle
from contactlab.fingerprint import fingerprint, is_own
from contactlab.laws.declaration import LawError

MOST: Final = 256
"""Kernels that are kept in memory beside those of this package."""

OFTEN: Final = 8
"""Compilations of one function in a process that are worth a word."""

_made_from: WeakKeyDictionary[Any, str] = WeakKeyDictionary()
"""Fingerprints of the compiled functions that a law's kernels call, when their code was made."""
_kernels: dict[object, Any] = {}
"""Compiled kernels by fingerprint and signature; the obstacle, in words, where there is one."""
_callbacks: dict[object, Callback] = {}
"""Interpreted kernels, by the function itself and by what it is made of."""
_compilations: Counter[object] = Counter()
_told: set[object] = set()


def compiled(function: Any, signature: Any) -> tuple[Any, Callback | None]:
    """Give a kernel with this signature, and the callback behind it where the function is interpreted.

    Args:
        function: a compiled kernel, which is given back, or any callable.
        signature: what the engine calls it with.

    Raises:
        LawError: it writes to the law's parameters.
    """
    if INTERPRETED:
        return function, None
    plain = getattr(function, "py_func", function)
    if plain is not function and is_own(plain) and not plain.__closure__:
        if function not in _made_from:
            _compile(function, signature)
            _made_from[function] = ""
        return function, None
    callback = _callbacks.get((id(plain), signature))
    if callback is None:
        key = fingerprint(function).digest, signature
        if key not in _kernels:
            _remember(_kernels, key, _make(function, *key))
        made = _kernels[key]
        if not isinstance(made, str):
            return made, None
        callback = _called_back(plain, signature, made)
    return callback.kernel, callback


def forget() -> None:
    """Forget what was compiled and said, as a new process would."""
    for store in (_made_from, _kernels, _callbacks, _compilations, _told):
        store.clear()


def _make(function: Any, digest: str, signature: Any) -> Any:
    """Give the compiled function, or the obstacle in words.

    Raises:
        LawError: it writes to the law's parameters.
    """
    try:
        kernel = _without_code(function)
        _renew_callees(kernel)
        keep_code(kernel, digest)
        _compile(kernel, signature)
    # The compiler lets errors of every kind through, the function's own language among them.
    except Exception as error:
        reason = obstacle(error, function, signature)
        if _writes(function, signature):
            raise LawError(
                f"{_name(function)} writes to the law's parameters ({reason}). They hold for the whole "
                "run; let it write to variables of its own."
            ) from error
        return reason
    _count(function)
    return kernel


def _without_code(function: Any) -> Any:
    """Give a kernel that is nobody else's: whatever code a user's own has may be of other values."""
    return remade(function) if hasattr(function, "py_func") else fleeting_kernel(function)


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


def _writes(function: Any, signature: Any) -> bool:
    """Tell whether a function that cannot be compiled could be if its parameters were no constants."""
    *states, parameters = signature.args
    try:
        changing = parameters.copy(readonly=False)
        _compile(_without_code(function), signature.return_type(*states, changing))
    except Exception:
        return False
    return True


def _compile(kernel: Any, signature: Any) -> None:
    if tuple(signature.args) not in kernel.overloads:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            kernel.compile(signature)


def _called_back(function: Any, signature: Any, reason: str) -> Callback:
    """Give the callback of a function that cannot be compiled; say so once for its code."""
    # Of what can change, the interpreter sees the object itself.
    key = fingerprint(function, identities=True).digest, signature
    callback = _callbacks.get(key)
    if callback is None:
        callback = Callback(function, signature)
        _remember(_callbacks, key, callback)
        _count(function)
    _remember(_callbacks, (id(callback.function), signature), callback)
    code = _code(function)
    if code not in _told:
        _told.add(code)
        _say(
            f"{callback.name} cannot be compiled ({reason}), so the Python interpreter runs it: a call "
            f"takes {callback.slowness()}."
        )
    return callback


def _count(function: Any) -> None:
    """Say it once if the same code of a user's is compiled again and again."""
    code = _code(function)
    _compilations[code] += 1
    if _compilations[code] == OFTEN and not is_own(getattr(function, "py_func", function)):
        _say(
            f"{_name(function)} has been compiled {OFTEN} times, because it is made anew around other "
            "values every time; let it read what varies from the law's parameters."
        )


def _code(function: Any) -> object:
    """Give what is the same in functions that are made by the same lines."""
    function = getattr(function, "py_func", function)
    return getattr(function, "__code__", type(function))


def _name(function: Any) -> str:
    return str(getattr(function, "__qualname__", type(function).__qualname__))


def _say(sentence: str) -> None:
    print(f"contactlab: {sentence}", file=sys.stderr, flush=True)


def _remember(store: dict[object, Any], key: object, value: Any) -> None:
    store[key] = value
    while len(store) > MOST:
        del store[next(iter(store))]
