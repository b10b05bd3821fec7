"""Laws of bare functions, for a first try: a normal force and a friction of what their arguments name.

Arguments with a default are parameters, all others quantities of the contact, by the names that kernels
have, see `contactlab.laws.base`. What a class declares is derived: the stored energy is the integral of the
force over the depth at rest, the loss the power of what the force has beyond that at rest, stiffness and
slope are differences of the force at rest. What only runs tell, `contactlab.testing.declare` declares.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from inspect import Parameter as Argument, findsource, getsource, signature
from itertools import product
from math import isfinite
from numbers import Real
from textwrap import dedent
from types import FunctionType, MappingProxyType
from typing import Annotated, Any, ClassVar, Final, NoReturn

import numpy as np

from contactlab.checks import shown
from contactlab.compiler.kernels import inner_kernel
from contactlab.foreign import is_own
from contactlab.laws.base import RATE_DEPENDENT, Friction, NormalForce
from contactlab.laws.composed import Composed
from contactlab.laws.consistency import NUDGE, ROUGHLY, ROUND_OFF, loss_is_not_stored
from contactlab.laws.declaration import FRICTION_COEFFICIENT, SHARED
from contactlab.parameter import Parameter
from contactlab.suggestion import suggestion

MOVING: Final = "gap_rate", "depth_rate", "slip"
"""Quantities that are zero at rest."""

QUANTITIES: Final = {
    "normal": ("depth", "gap", *MOVING, "impact_speed"),
    "friction": ("normal", "depth", "gap", *MOVING, "impact_speed"),
}
"""Quantities of the contact that a bare function of a family may name."""

CLASSES: Final = {"normal": "NormalForce, PenaltyLaw or MultiplierLaw", "friction": "Friction"}
"""The classes of `contactlab.laws` that do what a bare function of a family cannot."""

SMALL: Final = 1e-150, 1e-140
"""Slips [m/s] between which a force that jumps at zero does not change; their squares are numbers."""

STATES: Final = [*product((2.0**-10, 0.125, 1.0, 8.0, 2.0**10), (1e-6, 1e-4, 1e-2, 0.1, 1.0, 10.0))]
"""Normal forces [N], which divide without round-off, and slips [m/s] of the checks of a new friction."""

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
NODES, WEIGHTS = 0.5 * (NODES + 1.0), WEIGHTS * 0.5 * (NODES + 1.0)
"""Gauss points t on [0, 1] and weights 2 t w of an integral over x = d t^2, exact for powers of sqrt(x)."""

NORMAL: Final = """
def {kernel}({arguments}):
    force, stored = function({here}), 0.0
    for i in range(nodes.size):
        x = depth * nodes[i] * nodes[i]
        stored += weights[i] * function({there})
    # Five points, at a tenth of a per cent of the depth: exact to the fourth order.
    length = 1e-3 * max(depth, 1e-12)
    x = max(depth, 1e-12)
    middle = function({there})
    x += length
    one = function({there})
    x += length
    two = function({there})
    x -= 3.0 * length
    minus_one = function({there})
    x -= length
    minus_two = function({there})
    stiffness = (minus_two - two + 8.0 * (one - minus_one)) / (12.0 * length)
    slope = (16.0 * (one + minus_one) - minus_two - two - 30.0 * middle) / (12.0 * length * length)
"""
ELASTIC: Final = "    return force, depth * stored, stiffness, slope\n"
LOSSY: Final = """    x = depth
    loss = (force - function({there})) * depth_rate
    return force, depth * stored, stiffness, slope, loss
"""
BOUND: Final = "\ndef bound({arguments}):\n    return function({here})\n"
SIZE: Final = """
def bound({arguments}):
    # At rest a force of the slip has none.
    slip = slip if slip != 0.0 else 1.0
    return abs(function({here}))
"""
STATE: Final = "\ndef state({arguments}):\n    return function({here}), 0.0, 0.0, 0.0\n"


class Bare:
    """A part that a bare function makes."""

    text: ClassVar[str]
    """Source text of the function."""
    bare_label: ClassVar[str]
    """What messages call the function: its name, or its text where it has none."""
    bare_arguments: ClassVar[frozenset[str]]
    """Arguments of the function."""

    def declaring(self, declared: Mapping[str, Any]) -> Any:
        """Return the part with other declarations."""
        kind: Any = type(self)
        places = {name: getattr(kind, name) for name in ("__module__", "__qualname__")}
        made: Any = dataclass(frozen=True)(type(kind.__name__, (kind,), {**places, **declared}))
        return made(**{each.name: getattr(self, each.name) for each in fields(kind)})

    def __reduce__(self) -> NoReturn:
        part: Any = self
        raise TypeError(
            f"The {part.family} {part.name} is a bare function, {self.text}, which another process cannot "
            "import. Run it in this process, with one worker, or write it as a class of contactlab.laws, "
            f"{CLASSES[part.family]}, in a module."
        )


def law_of(function: Callable[..., float], values: Mapping[str, Any]) -> Composed:
    """Return a composed law whose normal force is a function; values that are not its own are other parts.

    Raises:
        TypeError: what is no function, or a value that neither the function nor a composed law has.
        ValueError: a function that names or does what only a class can.
    """
    parts = ("damping", "friction", "viscous_friction")
    own = _own_parameters(function, "normal", values, parts)
    return Composed(normal_force(function, **own), **{k: x for k, x in values.items() if k not in own})


def normal_force(function: Callable[..., float], /, **parameters: float) -> NormalForce:
    """Return the normal force [N] of a function, with other values of its parameters than the defaults."""
    part: Any = _class_of_normal(function)(**parameters)
    word = "elastic" if part.force is None else "force"
    at_once = dict.fromkeys((*MOVING, "impact_speed"), 0.0)
    for depth in np.geomspace(1e-9, 1e-6, 31).tolist():

        def stored(gap: float) -> float:
            return float(_evaluated(part, word, {**at_once, "depth": -gap, "gap": gap})[1])

        force = float(_evaluated(part, word, {**at_once, "depth": depth, "gap": -depth})[0])
        claim = loss_is_not_stored(stored, (force, 0.0), -depth, 1.0, NUDGE * depth, ROUGHLY)
        # Where its domain ends the run says so.
        if isfinite(force) and not claim.true:
            raise ValueError(
                f"{_label(function)} has no integral that 16 Gauss points resolve at a depth of {depth:g} m: "
                "it has a kink or jumps. Write a class NormalForce with its stored energy."
            )
    return part  # type: ignore[no-any-return]


def friction(function: Callable[..., float], /, **parameters: float) -> Friction:
    """Return the friction part of a bare function, for a first try.

    A function that is odd in the slip v is the friction force F(v) [N]; one that is even in it, or does not
    name it, is the bound of set-valued friction: |F| <= f, F = -f sign(v) where it slips. Where the normal
    force pulls, `normal` is zero.

        >>> import contactlab as cl
        >>> dry = cl.friction(lambda normal, mu=0.3: mu * normal, mu=0.2)
        >>> law = cl.law(lambda depth, stiffness=1e10: stiffness * depth**1.5, friction=dry)
        >>> law.friction_limit, law.describe()
        (0.2, {'normal.stiffness': 10000000000.0, 'friction.mu': 0.2})

    Args:
        function: of quantities of the contact, by the names that kernels have; defaults are parameters.
        parameters: other values than the defaults.

    Raises:
        TypeError: what is no function, or a parameter that it has not.
        ValueError: a function that names or does what only a class `Friction` can.
    """
    _own_parameters(function, "friction", parameters)

    part: Friction = _class_of_friction(function, False)(**parameters)
    # The slip of contacts that stick.
    _bound_at(part, 1.0, 0.0)
    results = np.array([[_bound_at(part, normal, v) for v in (slip, -slip)] for normal, slip in STATES])
    round_off = ROUND_OFF * np.abs(results).sum(axis=1)
    if (np.abs(results[:, 0] - results[:, 1]) <= round_off).all() and (results >= 0.0).all():
        return part
    if (np.abs(results[:, 0] + results[:, 1]) <= round_off).all():
        odd: Friction = _class_of_friction(function, True)(**parameters)
        least, less = (_bound_at(odd, 1.0, slip) for slip in SMALL)
        if least > 0.5 * less:
            raise ValueError(
                f"{_label(function)} jumps at v = 0: leave out the sign and return the magnitude, a bound."
            )
        return odd
    raise ValueError(
        f"{_label(function)} is neither odd in the slip, as a force, nor even and not negative, as a bound. "
        "Write a class Friction; its kernel bounds may differ in both directions."
    )


def _bound_at(part: Friction, normal: float, slip: float) -> float:
    """Return the kernel bound [N] at a normal force [N] and a slip [m/s]."""
    here = {"normal": normal, "slip": slip, "depth": 1e-6, "gap": -1e-6}
    return float(_evaluated(part, "bound", dict.fromkeys(QUANTITIES["friction"], 0.0) | here))


def _evaluated(part: Any, kernel: str, state: Mapping[str, float]) -> Any:
    """Return what a kernel gives at a state; a ValueError names function and state where that raises."""
    try:
        return part.evaluate(kernel, **state)
    # The function is somebody else's.
    except Exception as error:
        where = ", ".join(
            f"{name} = {value:g}" for name, value in state.items() if name in part.bare_arguments
        )
        raise ValueError(f"{part.bare_label} raises {type(error).__name__} ({error}) at {where}.") from error


def _largest_ratio(part: Friction) -> float:
    return max(_bound_at(part, normal, v) / normal for normal, slip in STATES for v in (0.0, slip))


def _own_parameters(
    function: Any, family: str, values: Mapping[str, Any], others: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return which values are those of a function's own parameters, or refuse what a class alone can do."""
    if not isinstance(getattr(function, "py_func", function), FunctionType):
        raise TypeError(f"A bare law takes a function; this is {shown(function)}.")
    text, own = _label(function), []
    quantities = ", ".join(QUANTITIES[family])
    for name, argument in signature(function).parameters.items():
        if argument.kind is not Argument.POSITIONAL_OR_KEYWORD:
            raise ValueError(f"{text}: *, ** and / have no meaning for kernels; name each argument.")
        if argument.default is Argument.empty and name not in QUANTITIES[family]:
            hint = suggestion(name, QUANTITIES[family], f"There are {quantities}.")
            raise ValueError(
                f"{text} names {name!r}, which is no quantity of a contact. {hint} A parameter has a "
                f"default, {name}=1.0; for anything else, such as internal variables, write a class "
                f"{CLASSES[family]}."
            )
        if argument.default is not Argument.empty:
            if isinstance(argument.default, bool) or not isinstance(argument.default, Real):
                raise TypeError(f"{text}: {name} is {shown(argument.default)}; it must be a number.")
            own.append(name)
    for name in values:
        if name not in (known := [*own, *others]):
            hint = suggestion(name, known, f"It has {', '.join(known) or 'none'}.")
            raise TypeError(f"{text} has no parameter {name!r}. {hint}")
    return {name: value for name, value in values.items() if name in own}


def _kernel(
    function: Any,
    word: str,
    source: str,
    needed: tuple[str, ...] = (),
    here: Mapping[str, str] = MappingProxyType({}),
    there: Mapping[str, str] = MappingProxyType({}),
) -> Any:
    """Return a kernel around a function, which it calls with expressions for some quantities."""
    names = [*signature(function).parameters]
    calls = {
        place: ", ".join(of.get(n, n) for n in names) for place, of in (("here", here), ("there", there))
    }
    text = source.format(kernel=word, arguments=", ".join(dict.fromkeys((*names, *needed))), **calls)
    inner = function if hasattr(function, "py_func") else inner_kernel(function)
    known = {"function": inner, "nodes": NODES, "weights": WEIGHTS, "__name__": _module_of(function)}
    exec(text, known)
    return staticmethod(known[word])


def _module_of(function: Any) -> str:
    # Code of this package is imported where it is compiled, which a bare function cannot be.
    return "__main__" if is_own(function) else str(function.__module__)


# Once for each function: its code is compiled for its class.
@lru_cache(maxsize=64)
def _class_of_normal(function: Any) -> Any:
    lossy = any(name in MOVING for name in signature(function).parameters)
    word, source, needed = ("force", LOSSY, ("depth_rate",)) if lossy else ("elastic", ELASTIC, ())
    at_rest = {"depth": "x", "gap": "-x", **dict.fromkeys(MOVING, "0.0")}
    kernel = _kernel(function, word, NORMAL + source, ("depth", *needed), there=at_rest)
    return _class(function, NormalForce, {"smooth_stiffness": False, word: kernel})


@lru_cache(maxsize=64)
def _class_of_friction(function: Any, odd: bool) -> Any:
    sources = {"bound": SIZE, "state": STATE} if odd else {"bound": BOUND}
    pressed = {"normal": "max(normal, 0.0)"}
    members: dict[str, Any] = {w: _kernel(function, w, text, here=pressed) for w, text in sources.items()}
    members["friction_limit"] = cached_property(_largest_ratio)
    if odd:
        members |= {"friction_kind": RATE_DEPENDENT, "exact_stick": False}
    return _class(function, Friction, members)


def _class(function: Any, base: type, members: Mapping[str, Any]) -> Any:
    """Return the class of a part that a function makes."""
    # No name of a part of the package, whatever the function is called.
    text, name = text_of(function), "_".join(("bare", *function.__name__.replace("<lambda>", "").split()))
    hints: dict[str, Any] = {SHARED: ClassVar[float]} if base is Friction else {}
    defaults = {}
    for parameter, argument in signature(function).parameters.items():
        if argument.default is not Argument.empty:
            number = Parameter(parameter, "1", f"{parameter} of a bare function")
            hints[parameter] = Annotated[float, FRICTION_COEFFICIENT if parameter == SHARED else number]
            defaults[parameter] = float(argument.default)
    texts = {"name": name, "equation": text, "source": "a bare function", "text": text}
    facts = {"bare_label": _label(function), "bare_arguments": frozenset(signature(function).parameters)}
    places = {"__module__": _module_of(function), "__qualname__": f"{name}[{text}]", "__annotations__": hints}
    return dataclass(frozen=True)(
        type(name, (Bare, base), {**texts, **facts, **members, **defaults, **places})
    )


def _label(function: Any) -> str:
    """Return the name of a function, or its text where it has none."""
    plain = getattr(function, "py_func", function)
    return text_of(plain) if plain.__name__ == "<lambda>" else str(plain.__name__)


def text_of(function: Any) -> str:
    """Return the source of a function; its name and arguments where there is none, as of one typed in."""
    plain = getattr(function, "py_func", function)
    with suppress(OSError, TypeError):
        if plain.__name__ != "<lambda>":
            return dedent(getsource(plain)).strip()
        lines = [line.encode() for line in findsource(plain)[0]]
        # Where an instruction has no place, or that of the line, its end is None or 0.
        places: list[Any] = [place for place in plain.__code__.co_positions() if place[3]]
        first, begin = min((line, column) for line, _, column, _ in places)
        last, end = max((line, column) for _, line, _, column in places)
        body = b"".join([*lines[first - 1 : last - 1], lines[last - 1][:end]])[begin:]
        return f"lambda {str(signature(plain))[1:-1]}: {' '.join(body.decode().split())}"
    return f"{plain.__name__}{signature(plain)}"
