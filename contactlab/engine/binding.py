"""A law bound to the engine: one function of one signature for each kernel, whatever the kernel names.

The engine evaluates every law by eight functions of fixed signatures. Here each is written from the names of
the law's own kernel, as a dataclass writes its methods, for example

    def force(gap, gap_rate, slip, impact_speed, row):
        normal, bound, stored, loss = law_force(-gap, row[6], row[7])
        return normal, -bound, bound, stored, loss

so that one compiled loop serves all laws. `row` holds, in this order,

    impact speed [m/s], internal variables, NaN, coefficients

with NaN between the coefficients of the parts of a composed law, whose own are the last. A law without a
kernel has one that does nothing.

What is written for the package's own laws is kept as a source file beside its machine code, in the folder of
exactly these sources, and found again by later processes. Code for other laws is compiled in the session.
"""

import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, lru_cache, partial
from traceback import extract_tb
from typing import Any, Final, NamedTuple, final

import numba
import numpy as np
from numba import types

from contactlab.arrays import Array
from contactlab.checks import shown
from contactlab.compiler.ahead import Signature
from contactlab.compiler.kernels import INTERPRETED, fleeting_kernel, generated_kernel, remade
from contactlab.engine.state import HEAD, NODES, SPEED, STEP
from contactlab.foreign import compiled_constants, is_own
from contactlab.interrupts import is_of_a_signal
from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.declaration import LawError, names_of

Callback = tuple[str, Callable[..., Any]]
"""The name of a kernel, and the Python function that is in its place within `law_errors`."""

_standing: ContextVar[dict[str, Callable[..., Any]]] = ContextVar("_standing")
"""The functions behind the stand-ins by name."""


@contextmanager
def law_errors(name: str, *callbacks: Callback) -> Iterator[None]:
    """Run functions as a law's kernels, and raise exceptions of its code as a `LawError`."""
    token = _standing.set(dict(callbacks))
    try:
        yield
    # What a law raises passes through the loop, which raises nothing itself; a law that leaves the program
    # is no run that ended well.
    except (Exception, SystemExit) as error:
        if isinstance(error, LawError) or is_of_a_signal(error):
            raise
        frames = [frame for frame in extract_tb(error.__traceback__) if frame.filename != __file__]
        place = ""
        # The loop itself is called from here too, and compiled code has no lines.
        if frames and frames[-1].name != "simulate":
            place = f" ({frames[-1].filename}, line {frames[-1].lineno})"
        raise LawError(
            f"The run ended because the law {name} raised {type(error).__name__}: {error}{place}. "
            "A law must answer every state of a contact; mend the law."
        ) from error
    finally:
        _standing.reset(token)


def _interpreted(name: str, signature: Any, arguments: tuple[Any, ...]) -> Any:
    """Return the numbers that the function behind a name returns."""
    result = _standing.get()[name](*arguments)
    if isinstance(signature.return_type, numba.types.Float):
        return float(result)
    result, count = tuple(result), len(signature.return_type)
    if len(result) != count:
        raise TypeError(f"it returned {len(result)} numbers, not {count}")
    return tuple(map(float, result))


@cache
def stand_in(name: str, signature: Any) -> Any:
    """Return the compiled kernel that calls the function behind a name."""
    names = ", ".join(f"a{i}" for i in range(len(signature.args)))
    source = (
        f"def stand_in({names}):\n"
        "    with objmode(result=kinds):\n"
        f"        result = evaluate(({names}))\n"
        "    return result\n"
    )
    known: dict[str, Any] = {
        "objmode": numba.objmode,
        "kinds": signature.return_type,
        "evaluate": partial(_interpreted, name, signature),
    }
    exec(source, known)
    # It allocates, as no other kernel does.
    kernel: Any = numba.njit(error_model="numpy")(known["stand_in"])
    kernel.compile(signature)
    return kernel


_real, _whole = types.float64, types.int64
_row = types.Array(types.float64, 1, "C", readonly=True)
_state = (_real,) * 4

SIGNATURES: Final = {
    "force": types.UniTuple(_real, 5)(*_state, _row),
    "friction_force": types.UniTuple(_real, 4)(*_state, _row),
    "impact": types.UniTuple(_real, 2)(*[_real] * 5, _row),
    "bound": _real(_real, _real, _row),
    "rate": _real(_whole, *_state, _row),
    "guard": _real(_whole, *_state, _row),
    "jump": _real(_whole, _whole, *_state, _row),
    "limits": types.UniTuple(_real, 2)(_real, _row),
}
"""Signatures of the bound kernels by name."""


@cache
def signatures_of_loop() -> tuple[Any, ...]:
    """Return the signatures of what the loops take of a law, `Bound.of_loop`."""
    at_nodes = types.void(numba.from_dtype(STEP), _real, types.Array(_real, 1, "C"), _row)
    return at_nodes, *SIGNATURES.values()


_AT_NODES: Final = """
from contactlab.compiler.lanes import fill, put, store

def at_nodes(step, impact_speed, row, parameters):
    normals = least = most = losses = fill(0.0)
    for i in range({nodes}):
        for k in range({variables}):
            row[{head} + k] = step.memory[i, k]
        normal, lower, upper, _, loss = force(
            step.closed[i], step.gap_rate[i], step.seen[i], impact_speed, parameters
        )
        normals, losses = put(normals, i, normal), put(losses, i, loss)
        least, most = put(least, i, lower), put(most, i, upper)
    store(step.normal, normals)
    store(step.least, least)
    store(step.most, most)
    store(step.loss, losses)
"""
"""Source of the kernel that evaluates the force at all nodes; row and parameters are the same memory."""

_AS_PART: Final = "from contactlab.compiler.kernels import inner_kernel\n\n\n@inner_kernel\n"
"""What makes the kernel of a force that follows part of that at all nodes."""

LIMITS, FORCE, FRICTION = map(list(SIGNATURES).index, ("limits", "force", "friction_force"))

_STATE: Final = "gap, gap_rate, slip, normal"
_ARGUMENTS: Final = {
    "force": "gap, gap_rate, slip, impact_speed, row",
    "friction_force": f"{_STATE}, row",
    "impact": "approach, slip, d_nn, d_nt, d_tt, row",
    "bound": "normal, slip, row",
    "rate": f"which, {_STATE}, row",
    "guard": f"which, {_STATE}, row",
    "jump": f"which, event, {_STATE}, row",
    "limits": "gap_rate, row",
}
_IDLE: Final = {
    "force": "0.0, 0.0, 0.0, 0.0, 0.0",
    "friction_force": "0.0, 0.0, 0.0, 0.0",
    "impact": "0.0, 0.0",
    "bound": "0.0",
    "rate": "0.0",
    "guard": "1.0",
    "jump": f"row[{HEAD} + which]",
    "limits": "0.0, 0.0",
}
"""What a kernel returns that a law lacks: nothing acts, and internal variables keep their values."""

_OF_FEW: Final = ("rate", "guard", "jump", "limits")
"""Kernels that few laws have: without any of them a law is plain."""

_FROM_ROW: Final = {"impact_speed": f"row[{SPEED}]"}
_TYPES: Final = {"which": _whole, "event": _whole}
"""Types of arguments that are no real numbers."""


@final
class Bound(NamedTuple):
    """A law's bound kernels.

    Args:
        kernels: in the order of `SIGNATURES`; None for all kernels that few laws have of a plain law.
        callbacks: functions that the Python interpreter runs in place of some of them.
        plain: whether it has no rates, guards, jumps and limits.
        at_nodes: evaluates the force at all nodes of a step, each with the internal variables there, in one
            call.
    """

    kernels: tuple[Any, ...]
    callbacks: tuple[Callback, ...]
    plain: bool
    at_nodes: Any

    @property
    def of_loop(self) -> tuple[Any, ...]:
        """What the loops take of a law."""
        return self.at_nodes, *self.kernels

    @property
    def may_raise(self) -> bool:
        """Whether a kernel is another package's, whose exceptions are to reach the caller."""
        return any(hasattr(each, "py_func") for each in self.of_loop)


def row_of(law: ContactLaw) -> Array:
    """Return the row of a law before any contact."""
    head = [0.0, *(v.initial for v in law.internal_variables)]
    values = [np.array(head, np.float64)]
    for part in _parts(law):
        coefficients = np.asarray(_coefficients(law, part)[1])
        if coefficients.dtype.kind not in "biuf":
            raise LawError(
                f"{law.name}: coefficients() returns {shown(coefficients.tolist())}; it must return numbers."
            )
        # NaN between two parts: a kernel that reads beyond its own coefficients returns no number.
        values += [np.array([np.nan]), coefficients.astype(np.float64)]
    return np.concatenate(values)


def bind(law: ContactLaw) -> Bound:
    """Return the bound kernels of a law, compiled where that can be done.

    Raises:
        LawError: a kernel is missing, is no function or names what there is not.
    """
    with law_errors(law.name):
        parts = _parts(law)
        if all(is_own(type(part)) for part in parts):
            return _bound_own(_Shape(law))
        return _bound(_Shape(law))


class _Shape:
    """A law up to the values of its coefficients: equal shapes have the same kernels."""

    def __init__(self, law: ContactLaw) -> None:
        self.law = law
        parts = [
            (type(p), _coefficients(law, p)[0], getattr(p, "internal_variables", ())) for p in _parts(law)
        ]
        self.key = type(law), *parts

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Shape) and other.key == self.key

    def __hash__(self) -> int:
        return hash(self.key)


def _parts(law: ContactLaw) -> tuple[Any, ...]:
    """Return who has coefficients: the law, of a composed one its parts before it."""
    return (*law.parts, law) if isinstance(law, Composed) else (law,)


def _coefficients(law: ContactLaw, part: Any) -> tuple[tuple[tuple[str, int], ...], list[Any]]:
    """Return names and lengths of the coefficients, zero for a number, and the numbers."""
    coefficients: Any = part.coefficients()
    if isinstance(law, Composed) and part is law.damping:
        coefficients = part.solved(law.normal)
    if not isinstance(coefficients, Mapping):
        raise LawError(
            f"{part.name}: coefficients() returns {shown(coefficients)}; it must return numbers by name."
        )
    shape: list[tuple[str, int]] = []
    numbers: list[Any] = []
    for name, value in coefficients.items():
        several = not isinstance(value, float) and np.ndim(value) > 0
        shape.append((name, np.size(value) if several else 0))
        numbers += np.ravel(value).tolist() if several else [value]
    return tuple(shape), numbers


class _Part:
    """A law, or a part of one, with the expressions that its kernels' arguments stand for."""

    def __init__(self, word: str, owner: Any, shape: Any, at: int, first: int) -> None:
        self.word, self.owner = word, owner
        self.functions: dict[str, Any] = {}
        self.kinds: dict[str, tuple[Any, ...]] = {}
        variables = getattr(owner, "internal_variables", ())
        self.count, self.coupled = len(variables), getattr(owner, "coupled", 0)
        self._known = {v.name: f"row[{HEAD + first + i}]" for i, v in enumerate(variables)}
        self._known["z"] = f"row[{HEAD + first}:{HEAD + first + self.count}]"
        begin = at
        for name, size in shape:
            if name in self._known:
                raise LawError(f"{owner.name}: {name} is a coefficient and an internal variable.")
            self._known[name] = f"row[{at}:{at + size}]" if size else f"row[{at}]"
            at += size or 1
        self._known["parameters"] = f"row[{begin}:{at}]"
        self.end = at
        self._coefficients = {name for name, _ in shape}

    def has(self, kernel: str) -> bool:
        """Return whether there is such a kernel."""
        return getattr(self.owner, kernel, None) is not None

    def expression(self, name: str) -> str:
        """Return what a coefficient or internal variable stands for."""
        return self._known[name]

    def has_coefficient(self, name: str) -> bool:
        """Return whether there is such a coefficient."""
        return name in self._coefficients

    def names(self, kernel: str, *wanted: str) -> bool:
        """Return whether a kernel names one of some quantities."""
        return self.has(kernel) and not {*names_of(self._function(kernel))}.isdisjoint(wanted)

    def _function(self, kernel: str) -> Any:
        function = getattr(self.owner, kernel)
        if not callable(function):
            raise LawError(f"{self.owner.name}: its {kernel} is {shown(function)}; it must be a function.")
        return function

    def call(self, kernel: str, quantities: Mapping[str, str]) -> str:
        """Return the expression that evaluates a kernel, its quantities being expressions."""
        function, arguments, kinds = self._function(kernel), [], []
        known = {**_FROM_ROW, **quantities, **self._known}
        for name in names_of(function):
            if name not in known:
                raise LawError(
                    f"{self.owner.name}: its kernel {kernel} names {name!r}; there are "
                    f"{', '.join(sorted(known))}."
                )
            if name in quantities and name in self._coefficients:
                raise LawError(
                    f"{self.owner.name}: its kernel {kernel} names {name!r}, a quantity of the contact and a "
                    "parameter; derive another name for the parameter in coefficients()."
                )
            arguments.append(known[name])
            kinds.append(_row if ":" in known[name] else _TYPES.get(name, _real))
        word = f"{self.word}_{kernel}"
        self.functions[word], self.kinds[word] = function, tuple(kinds)
        return f"{word}({', '.join(arguments)})"


_CONTACT: Final = {
    "gap": "gap",
    "depth": "-gap",
    "gap_rate": "gap_rate",
    "depth_rate": "-gap_rate",
    "slip": "slip",
}
_IN_CONTACT: Final = {**_CONTACT, "normal": "normal"}
_OF_FORCE: Final = {**_CONTACT, "impact_speed": "impact_speed"}
_WHICH, _EVENT = {"which": "which"}, {"which": "which", "event": "event"}
_IMPACT: Final = {name: name for name in _ARGUMENTS["impact"].split(", ")[:-1]}
_BOUND: Final = {"normal": "normal", "slip": "slip"}
_LIMITS: Final = {"gap_rate": "gap_rate", "depth_rate": "-gap_rate"}


def _of_law(law: ContactLaw, part: _Part) -> dict[str, list[str]]:
    if isinstance(law, MultiplierLaw):
        # Without a coefficient of friction the default bound is none.
        frictionless = {} if part.has_coefficient("friction_coefficient") else {"friction_coefficient": "0.0"}
        made = {
            "impact": [f"return {part.call('impact', _IMPACT)}"],
            "bound": [f"return {part.call('bound', _BOUND | frictionless)}"],
        }
    else:
        made = {"force": [f"normal, bound, stored, loss = {part.call('force', _OF_FORCE)}", *_bounds(part)]}
    of_three = part.count > part.coupled
    if isinstance(law, PenaltyLaw) and part.has("friction_force"):
        made["friction_force"] = _four(part.call("friction_force", _IN_CONTACT), of_three)
    for name, more in (("rate", _WHICH), ("guard", _WHICH), ("jump", _EVENT)):
        if part.has(name):
            made[name] = [f"return {part.call(name, {**_IN_CONTACT, **more})}"]
    if part.has("limits"):
        made["limits"] = [f"return {part.call('limits', _LIMITS)}"]
    return made


def _four(call: str, of_three: bool, viscous: str = "") -> list[str]:
    """Return friction, rate of its own variable, stored energy and stiffness; some kernels have no rate."""
    if of_three:
        return [f"force, stored, stiffness = {call}", f"return force{viscous}, 0.0, stored, stiffness"]
    return [f"force, flow, stored, stiffness = {call}", f"return force{viscous}, flow, stored, stiffness"]


def _bounds(part: _Part, viscous: str = "") -> list[str]:
    if not part.has("bounds"):
        return [f"return normal, -bound{viscous}, bound{viscous}, stored, loss"]
    call = part.call("bounds", {**_OF_FORCE, **_IN_CONTACT})
    return [f"least, largest = {call}", f"return normal, least{viscous}, largest{viscous}, stored, loss"]


def _of_composed(normal: _Part, damping: _Part, friction: _Part, law: _Part) -> dict[str, list[str]]:
    pressed, viscous = {**_OF_FORCE}, f" - {law.expression('viscous_friction')} * slip"
    if not normal.has("limits"):
        # Evaluated at the instant of a release too, where the gap may be open by round-off.
        pressed["depth"] = "max(-gap, 0.0)"
    flowing = {**_CONTACT, "depth": pressed["depth"]}

    def spring(quantities: Mapping[str, str]) -> str:
        if normal.has("force"):
            return f"alone, alone_stored, stiffness, slope, lost = {normal.call('force', quantities)}"
        return f"alone, alone_stored, stiffness, slope = {normal.call('elastic', quantities)}"

    pushed = {
        **pressed,
        "elastic_force": "alone",
        "elastic_energy": "alone_stored",
        "elastic_stiffness": "stiffness",
    }
    loss = "(alone - normal) * gap_rate"
    bound = [f"bound = {friction.call('bound', {**_OF_FORCE, **_IN_CONTACT})}"]
    made = {
        "force": [
            spring(pressed),
            "stored = alone_stored",
            f"normal = {damping.call('damped', pushed)}",
            f"loss = lost + {loss}" if normal.has("force") else f"loss = {loss}",
            *([] if friction.has("bounds") else bound),
            *_bounds(friction, viscous),
        ]
    }
    swept = {**_IN_CONTACT, "normal_stiffness": "stiffness", "normal_stiffness_rate": "(-slope * gap_rate)"}

    def over(kernel: str) -> list[str]:
        return (
            [spring(flowing)] if friction.names(kernel, "normal_stiffness", "normal_stiffness_rate") else []
        )

    if friction.has("state"):
        made["friction_force"] = [
            *over("state"),
            *_four(friction.call("state", swept), friction.count > friction.coupled, viscous),
        ]
    counts = {"rate": friction.count, "guard": getattr(friction.owner, "guards", 0)}
    for name, count in counts.items():
        if not (friction.has(name) or normal.has(name)):
            continue
        theirs = (
            normal.call(name, {**flowing, "which": f"which - {count}"}) if normal.has(name) else _IDLE[name]
        )
        ours = friction.call(name, {**swept, **_WHICH}) if friction.has(name) else _IDLE[name]
        made[name] = [f"if which >= {count}:", f"    return {theirs}", *over(name), f"return {ours}"]
    if friction.has("jump") or normal.has("jump"):
        guards, of_normal = (
            counts["guard"],
            {**flowing, "which": f"which - {friction.count}", "event": "mine"},
        )
        theirs = normal.call("jump", of_normal) if normal.has("jump") else _IDLE["jump"]
        ours = friction.call("jump", {**swept, **_EVENT}) if friction.has("jump") else _IDLE["jump"]
        made["jump"] = [
            # A guard of one part is no event of the other's.
            f"if event >= 0 and (event < {guards}) != (which < {friction.count}):",
            f"    return {_IDLE['jump']}",
            f"if which >= {friction.count}:",
            f"    mine = event if event < 0 else event - {guards}",
            f"    return {theirs}",
            *over("jump"),
            f"return {ours}",
        ]
    if normal.has("limits"):
        made["limits"] = [f"return {normal.call('limits', _LIMITS)}"]
    return made


def _written(law: ContactLaw) -> tuple[dict[str, tuple[str, dict[str, Any]]], list[_Part]]:
    """Return the source of every bound kernel and the functions that it calls, and the law's parts."""
    names, parts = ("normal", "damping", "friction", "law"), []
    at = HEAD + len(law.internal_variables) + 1
    owners = _parts(law)
    # The friction's internal variables come first.
    offsets = (len(law.friction.internal_variables), 0, 0, 0) if isinstance(law, Composed) else (0,)
    for word, owner, first in zip(names[-len(owners) :], owners, offsets, strict=True):
        part = _Part(word, owner, _coefficients(law, owner)[0], at, first)
        parts.append(part)
        at = part.end + 1
    bodies = _of_composed(*parts) if isinstance(law, Composed) else _of_law(law, *parts)
    functions = {word: function for part in parts for word, function in part.functions.items()}
    sources = {}
    for name, arguments in _ARGUMENTS.items():
        lines = bodies.get(name, [f"return {_IDLE[name]}"])
        source = "".join([f"def {name}({arguments}):\n", *(f"    {line}\n" for line in lines)])
        sources[name] = source, {word: each for word, each in functions.items() if f"{word}(" in source}
    return sources, parts


def functions_of(law: ContactLaw) -> dict[str, Callable[..., Any]]:
    """Return the bound kernels of a law as Python functions, by name."""
    return {name: _executed(name, *each) for name, each in _written(law)[0].items()}


def _bound(shape: _Shape) -> Bound:
    law = shape.law
    sources, parts = _written(law)
    kinds = {word: kind for part in parts for word, kind in part.kinds.items()}
    owners = {word: part.owner for part in parts for word in part.functions}
    plain = all(getattr(law, name, None) is None for name in _OF_FEW)
    kernels: list[Any] = []
    callbacks: list[Callback] = []
    for name, signature in SIGNATURES.items():
        if plain and name in _OF_FEW:
            kernels.append(None)
            continue
        kernel, callback = _compiled(name, *sources[name], kinds, owners, signature)
        kernels.append(kernel)
        callbacks += [callback] if callback else []
    over = _AT_NODES.format(nodes=NODES, head=HEAD, variables=len(law.internal_variables))
    source, used = sources["force"]
    # Around a law that the Python interpreter runs stands its compiled stand-in.
    if any(name == "force" for name, _ in callbacks):
        at_nodes = _session("at_nodes", over, (("force", kernels[FORCE]),), signatures_of_loop()[0])
    else:
        whole = f"{_AS_PART}{source}\n{over}"
        at_nodes, _ = _compiled("at_nodes", whole, used, kinds, owners, signatures_of_loop()[0])
    return Bound(tuple(kernels), tuple(callbacks), plain, at_nodes)


_bound_own = lru_cache(maxsize=256)(_bound)


def _compiled(
    name: str,
    source: str,
    used: dict[str, Any],
    kinds: dict[str, tuple[Any, ...]],
    owners: dict[str, Any],
    signature: Any,
) -> tuple[Any, Callback | None]:
    """Return a bound kernel as the loop takes it, and the callback behind it if that is interpreted."""
    if INTERPRETED:
        return _executed(name, source, used), None
    imports = []
    for word, function in used.items():
        owner, kernel = type(owners[word]), word.partition("_")[2]
        if (
            not is_own(owner)
            or not is_own(getattr(function, "py_func", function))
            or "." in owner.__qualname__
        ):
            break
        imports.append(f"from {owner.__module__} import {owner.__qualname__} as {word}_owner\n")
        imports.append(f"{word} = {word}_owner.{kernel}\n")
    else:
        return _kept(name, "".join(imports) + "\n\n" + source, signature), None
    made = {
        word: _compiled_with(function, kinds[word], compiled_constants(function)[0])
        for word, function in used.items()
    }
    obstacles = [(word, kernel) for word, kernel in made.items() if isinstance(kernel, str)]
    if not obstacles:
        compiled = _session(name, source, tuple(made.items()), signature)
        if not isinstance(compiled, str):
            return compiled, None
        obstacles = [(word, compiled) for word in used]
    plain = getattr(used[obstacles[0][0]], "py_func", used[obstacles[0][0]])
    _say_once(
        f"{getattr(plain, '__qualname__', type(plain).__qualname__)} cannot be compiled ({obstacles[0][1]}), "
        "so the Python interpreter runs it: a call takes microseconds, that of a compiled kernel some ns."
    )
    in_python = {word: getattr(function, "py_func", function) for word, function in used.items()}
    return stand_in(name, signature), (name, _executed(name, source, in_python))


@cache
def _kept(name: str, source: str, signature: Any) -> Any:
    kernel = generated_kernel(name, source)
    _compile(kernel, signature)
    # By its address, which is looked up in every call of the loop otherwise. Its own kernels raise nothing.
    return Signature(kernel, signature).code


@lru_cache(maxsize=512)
def _session(name: str, source: str, used: tuple[tuple[str, Any], ...], signature: Any) -> Any:
    made = fleeting_kernel(_executed(name, source, dict(used)))
    try:
        _compile(made, signature)
    # The compiler lets errors of every kind through, the function's own language among them.
    except Exception as error:
        return _reason(error)
    return made


_NOISE: Final = re.compile(r"Failed in |During: |>>> |File \"|- |\* |\s*$|\^|raised from ", re.IGNORECASE)


def _reason(error: Exception) -> str:
    """Return the line in which the compiler says why it failed."""
    lines = [line.strip() for line in str(error).splitlines() if not _NOISE.match(line.strip())]
    return lines[0] if lines else type(error).__name__


def _executed(name: str, source: str, used: dict[str, Any]) -> Callable[..., Any]:
    known = dict(used)
    exec(source, known)
    made: Callable[..., Any] = known[name]
    return made


@lru_cache(maxsize=256)
def _compiled_with(function: Any, kinds: tuple[Any, ...], constants: tuple[bytes, ...]) -> Any:  # noqa: ARG001 - of the key
    """Return a law's own kernel, compiled with the present values of the constants that it and callees read.

    Where there is an obstacle, it returns that in words.
    """
    kernel = function
    if not hasattr(function, "py_func"):
        kernel = fleeting_kernel(function)
    elif not is_own(function.py_func):
        kernel = remade(function)
    try:
        for callee in compiled_constants(function)[1]:
            if callee.overloads:
                callee.recompile()
        _compile(kernel, kinds)
    # The compiler lets errors of every kind through, the function's own language among them.
    except Exception as error:
        return _reason(error)
    return kernel


def _compile(kernel: Any, signature: Any) -> None:
    arguments = signature if isinstance(signature, tuple) else tuple(signature.args)
    if arguments not in kernel.overloads:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            kernel.compile(signature)


@cache
def _say_once(sentence: str) -> None:
    print(f"contactlab: {sentence}", file=sys.stderr, flush=True)
