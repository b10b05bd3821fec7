"""What a law is asked when it is taken in: whether it contradicts itself where every contact passes.

The contract of `contactlab.testing` asks more, and lets the law run; this costs a run next to nothing.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import product
from math import isfinite, nan
from numbers import Real
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import shown
from contactlab.fingerprint import is_own
from contactlab.laws import base
from contactlab.laws.base import (
    ELASTOPLASTIC,
    RATE_DEPENDENT,
    SET_VALUED,
    ContactLaw,
    MultiplierLaw,
    NormalForce,
    PenaltyLaw,
)
from contactlab.laws.declaration import LawError
from contactlab.laws.memory import EVEN, EVENTS, MOST_VARIABLES, ODD, InternalVariable

Kernel = Callable[..., Any]

KINDS = ("SET_VALUED", "ELASTOPLASTIC", "RATE_DEPENDENT")
"""Kinds of friction in words, in their order."""

HEAD = 5
"""Place in a law's row where the internal variables begin: before them is what the engine writes there."""

CANARIES, VALUES = 16, (nan, 1.0, -1.0)
"""Numbers on either side of a law's row, where no kernel has any business, and what they are: a result that
changes with them was made from them."""

DEPTHS, SPEEDS = (1e-12, 1e-9), (-0.01, 0.0, 0.01)
"""Penetrations that every contact begins and ends with [m], and gap rates and slips [m/s]."""

COUPLINGS = (-50.0, 0.0, 50.0)
"""Off the diagonal of the Delassus matrix of a motor's tip [1/kg]; 1000 and 2000 are on it."""

ROUND_OFF = 1e-9

BALANCE_DEPTHS, PROBE_SPEED = (1e-9, 1e-7, 1e-6), 0.01
"""Penetrations [m] and speed [m/s] at which stored energies and stiffnesses are differentiated."""

NUDGE, DIFFERENCE = 1e-4, 1e-3
"""Step of a central difference over the depth or stretch, and what may be missing beyond its error [1]."""

AT_REST = ("gap_rate", "depth_rate", "slip", "impact_speed", "tilt", "spin")
"""Quantities of a contact at rest."""

COUNTS = {"force": 5, "friction_force": 4, "solve": 3, "limits": 2, "rate": 1, "jump": 1, "guard": 1}
"""Numbers that kernels answer with."""


def guarded(row: Array, canary: float = nan) -> Array:
    """Copy a row between canaries, read-only, so that a kernel that reads beyond it finds no number."""
    copied = np.pad(row, CANARIES, constant_values=canary)[CANARIES:-CANARIES]
    copied.flags.writeable = False
    return copied


def check_words(law: ContactLaw) -> None:
    """Refuse a law that contradicts itself in what it says by a LawError with a sentence on each fault."""
    limit, offset = (getattr(law, name) for name in ("friction_limit", "friction_offset"))
    for name, given in (("friction_limit", limit), ("friction_offset", offset)):
        if not isinstance(given, Real) or not float(given) >= 0.0:
            faults = [f"{name} is {shown(given)}; it must be a number and not negative."]
            break
    else:
        if not isinstance(law.violations, Mapping):
            faults = [f"violations is {shown(law.violations)}; it must give reasons by name."]
        else:
            faults = [*misfits(law)]
    if faults:
        raise LawError(" ".join(f"{law.name}: {words}" for words in faults))


def misfits(law: ContactLaw) -> Iterator[str]:
    """Give what a law says of its friction and its memory and contradicts, in sentences."""
    kept = law.internal_variables
    if not isinstance(kept, tuple) or not all(isinstance(one, InternalVariable) for one in kept):
        yield (
            f"internal_variables is {shown(kept)}; it must be a tuple of contactlab.laws.InternalVariable."
        )
        return
    names = [one.name for one in kept]
    if len(set(names)) < len(names) or not all(name.isidentifier() for name in names):
        yield f"its internal variables are called {', '.join(names)}; each must have one word of its own."
    for one in kept:
        sound = isinstance(one.initial, Real) and isfinite(one.initial)
        if not (sound and one.life in ("contact", "run") and one.parity in (ODD, EVEN)):
            yield (
                f"its internal variable {one.name} begins at {shown(one.initial)}, lives for "
                f"{shown(one.life)} and has the parity {shown(one.parity)}; it must begin at a number, live "
                "for 'contact' or 'run', and be ODD or EVEN."
            )
    if isinstance(law, PenaltyLaw):
        yield from _misfits_of_friction(law)
    elif isinstance(law, MultiplierLaw):
        yield from _misfits_of_a_rigid_law(law)
    if (count := len(law.internal_variables)) > MOST_VARIABLES:
        yield f"it has {count} internal variables; it can have {MOST_VARIABLES} at most."
    if law.guards and (law.guard is None or law.jump is None):
        yield f"it says that it has {law.guards} guards; it needs a kernel guard and a kernel jump for them."
    if law.guard is not None and not law.guards:
        yield "it has a kernel of guards and says that it has none; say how many in guards."


def _misfits_of_a_rigid_law(law: MultiplierLaw) -> Iterator[str]:
    if law.internal_variables and law.rate is None and law.jump is None:
        yield "it has internal variables, but no kernel rate or jump."
    if law.limits is not None or law.guard is not None:
        yield "it has limits or guards; a rigid contact begins and ends at a gap of zero, and has neither."


def _misfits_of_friction(law: PenaltyLaw) -> Iterator[str]:
    kind, kernel, coupled = law.friction_kind, law.friction_force, law.coupled
    if kind not in (SET_VALUED, ELASTOPLASTIC, RATE_DEPENDENT):
        yield (f"friction_kind is {shown(kind)}; it must be {', '.join(KINDS)} of contactlab.laws.base.")
        return
    said = f"its friction_kind is {KINDS[kind]}"
    if kind == SET_VALUED and kernel is not None:
        yield (
            f"it has a kernel of friction, but {said}, which has none. Say ELASTOPLASTIC or "
            "RATE_DEPENDENT, or leave the kernel out."
        )
    if kind != SET_VALUED and kernel is None:
        yield f"{said}, but it has no kernel of friction. Give it one, or say SET_VALUED."
    flows = law.rate is not None or law.jump is not None
    if len(law.internal_variables) > 1 and not flows:
        yield (
            f"it remembers {', '.join(map(str, law.internal_variables))}; more than one quantity needs a "
            "kernel rate or jump."
        )
    elif kind != RATE_DEPENDENT and (kind == ELASTOPLASTIC) != bool(coupled):
        names = [one.name for one in law.internal_variables[:coupled]]
        yield (
            f"{said} and what its friction remembers {shown(names)}; set-valued friction "
            "remembers by a kernel rate or jump, and a spring its stretch."
        )


def check_answers(law: ContactLaw, parameters: Array, *kernels: Kernel) -> None:
    """Refuse a law whose kernels answer to a contact what cannot be, by a LawError on the first answer.

    The kernels are bound, see `contactlab.engine.binding`, and read its row.
    """
    ask = partial(_answer, law.name, [guarded(parameters, canary) for canary in VALUES])
    force, friction_force, solve, *others = kernels
    of_memory = others if others[0] is not None else []
    if isinstance(law, PenaltyLaw):
        begin = _first_limit(law, ask, of_memory[3]) if of_memory else 0.0
        for depth, rate, slip in product(DEPTHS, SPEEDS, SPEEDS):
            gap = begin - depth
            where = f"at a gap of {gap:g} m, a gap rate of {rate:g} m/s and a slip of {slip:g} m/s"
            normal, _, bound, *_ = ask("force", force, where, gap, rate, slip, abs(rate))
            if bound < -ROUND_OFF * abs(normal):
                raise LawError(
                    f"{law.name}: the friction bound is {bound:g} N {where}; it must not be negative. Where "
                    "the normal force pulls there is no friction."
                )
            if law.friction_kind != SET_VALUED:
                # What else the variable may be than at first, the law alone knows.
                ask("friction_force", friction_force, where, gap, rate, slip, normal)
            _check_memory(law, ask, of_memory, where, gap, rate, slip, normal)
        _check_energy(law, force, friction_force, guarded(parameters), begin)
        _check_stiffness(law)
        return
    approach = SPEEDS[0]
    for slip, d_nt in product(SPEEDS, COUPLINGS):
        where = f"in an impact with a gap rate of {approach:g} m/s and a slip of {slip:g} m/s"
        p_n, p_t, mode = ask("solve", solve, where, *(approach, slip) * 2, 1e3, d_nt, 2e3)
        left = approach + 1e3 * p_n + d_nt * p_t
        if mode not in (base.SLIP, base.STICK):
            fault = f"the mode is {mode} {where}; it must be SLIP or STICK of contactlab.laws.base."
            raise LawError(f"{law.name}: {fault}")
        # Without an impulse there is no answer, of which a run tells.
        stops = left >= ROUND_OFF * approach or "kernel_is_consistent" in law.violations
        if p_n > 0.0 and not stops:
            fault = f"leaves an approach of {-left:g} m/s {where}; the impulse must stop it."
            raise LawError(f"{law.name}: its kernel solve {fault}")
        _check_memory(law, ask, of_memory, where, 0.0, approach, slip, p_n / law.default_contact_step)


def _first_limit(law: ContactLaw, ask: Any, limits: Kernel) -> float:
    """Give the gap at which a first contact begins [m]; refuse one that ends before."""
    begin, end = ask("limits", limits, "at first", 0.0)
    if begin > end:
        raise LawError(
            f"{law.name}: its limits say that a contact begins at a gap of {begin:g} m and ends at {end:g} "
            "m; it must not end before it begins."
        )
    return float(begin)


def derivative(function: Callable[[float], float], at: float, step: float) -> tuple[float, float]:
    """Return a central difference, and its error from the one-sided ones and from round-off.

    Where the function has a kink within the step, the error is the whole change of slope there.
    """
    behind, here, ahead = (float(function(at + share * step)) for share in (-1.0, 0.0, 1.0))
    error = abs(ahead - 2.0 * here + behind) / step + 1e-14 * (abs(here) + abs(ahead)) / step
    return 0.5 * (ahead - behind) / step, error


def _check_energy(law: PenaltyLaw, force: Kernel, friction: Kernel, row: Array, begin: float) -> None:
    """Refuse a stored energy without internal variables in z that contradicts the force.

    The normal loss is -(N + dV/dgap) gap_rate, a spring has F = -k z and E = 1/2 k z^2, and friction at a
    constant gap loses -F v - dE/dz dz/dt >= 0: a stretched contact gives back no more than it stores.
    """
    if len(law.internal_variables) > law.coupled:
        return
    for depth, rate in product(BALANCE_DEPTHS, SPEEDS):
        gap = begin - depth
        normal, _, _, _, loss = force(gap, rate, 0.0, PROBE_SPEED, row)
        slope, error = derivative(
            lambda g, rate=rate: force(g, rate, 0.0, PROBE_SPEED, row)[3],  # type: ignore[misc]
            gap,
            NUDGE * depth,
        )
        missing = abs(loss + (normal + slope) * rate) - error * abs(rate)
        size = (abs(normal) + abs(slope)) * abs(rate) + abs(loss)
        if missing > DIFFERENCE * size and "kernel_is_consistent" not in law.violations:
            raise LawError(
                f"{law.name}: the stored energy V and the normal loss contradict the force at a gap of "
                f"{gap:g} m and a gap rate of {rate:g} m/s: N is {normal:g} N, -dV/dgap {-slope:g} N, "
                f"the loss {loss:g} W; the loss must be -(N + dV/dgap) gap_rate."
            )
        if law.coupled:
            _check_stretch(law, partial(_friction_with, friction, row), gap, float(normal))


def _friction_with(friction: Kernel, row: Array, *state: float) -> Any:
    """Evaluate friction with a value of its coupled variable, the last number."""
    first: Any = row.base
    first[CANARIES + HEAD] = state[-1]
    return friction(*state[:-1], row)


def _check_stretch(law: PenaltyLaw, friction: Kernel, gap: float, normal: float) -> None:
    """Refuse stored energy of friction that contradicts its force at a small stretch."""
    first = law.internal_variables[0].initial
    if law.friction_kind == ELASTOPLASTIC:
        z = first + NUDGE * abs(gap)
        drag, _, stored, stiffness = friction(gap, 0.0, 0.0, normal, z)
        misses = abs(drag + stiffness * z), abs(stored - 0.5 * stiffness * z * z) / (abs(z) or 1.0)
        wrong = max(misses) > ROUND_OFF * (abs(drag) + stiffness * abs(z))
        if wrong and "kernel_is_consistent" not in law.violations:
            raise LawError(
                f"{law.name}: its friction is {drag:g} N, its stored energy {stored:g} J and its stiffness "
                f"{stiffness:g} N/m at a stretch z of {z:g} m; a spring has F = -k z and E = 1/2 k z^2."
            )
        return
    way = 1e-3 * abs(gap)
    for outward in (-PROBE_SPEED, PROBE_SPEED):
        z = first + friction(gap, 0.0, outward, normal, first)[1] * way / PROBE_SPEED
        if z == first:
            continue
        for slip in (outward, -outward):
            drag, rate, _, _ = friction(gap, 0.0, slip, normal, z)
            slope, error = derivative(
                lambda x, slip=slip: friction(gap, 0.0, slip, normal, x)[2],  # type: ignore[misc]
                z,
                NUDGE * abs(z - first),
            )
            gained = drag * slip + slope * rate - error * abs(rate)
            allowed = DIFFERENCE * (abs(drag * slip) + abs(slope * rate))
            if gained > allowed and "friction_stores_what_it_gives" not in law.violations:
                raise LawError(
                    f"{law.name}: friction makes {gained:g} W at a constant gap of {gap:g} m, a slip of "
                    f"{slip:g} m/s and an internal variable of {z:g}: its stored energy changes by "
                    f"{slope * rate:g} W, its force does "
                    f"{-drag * slip:g} W against the slip, which must not be less."
                )


def _check_stiffness(law: ContactLaw) -> None:
    """Refuse a normal force from outside the package whose stiffness or slope is no derivative of it."""
    part = getattr(law, "normal", None)
    if not isinstance(part, NormalForce):
        return
    # The package's own are held to the contract by its tests; here they would only cost time.
    if is_own(type(part)):
        return
    name = "elastic" if part.force is None else "force"
    initial = np.array([one.initial for one in part.internal_variables], dtype=np.float64)
    known: dict[str, Any] = {**dict.fromkeys(AT_REST, 0.0), "z": initial}
    known |= {one.name: one.initial for one in part.internal_variables}

    def asked(depth: float) -> tuple[float, float, float]:
        given = part.evaluate(name, **known, depth=depth, gap=-depth)
        return float(given[0]), float(given[2]), float(given[3])

    for depth in BALANCE_DEPTHS:
        for word, order in (("stiffness", 0), ("slope", 1)):
            step = NUDGE * depth
            found, error = derivative(lambda d, k=order: asked(d)[k], depth, step)  # type: ignore[misc]
            declared = asked(depth)[order + 1]
            if abs(declared - found) - error > DIFFERENCE * (abs(declared) + abs(found)):
                raise LawError(
                    f"{law.name}: the {word} of its normal force {part.name} is {declared:g} at a depth of "
                    f"{depth:g} m, where the derivative of the {('force', 'stiffness')[order]} is {found:g}."
                )


def _check_memory(law: ContactLaw, ask: Any, kernels: list[Kernel], where: str, *state: float) -> None:
    """Ask rates, jumps and guards at a state, as `contactlab.laws.memory` has it."""
    for k in range(law.coupled, len(law.internal_variables)):
        ask("rate", kernels[0], where, k, *state)
        for event in (*EVENTS, *range(law.guards)):
            ask("jump", kernels[2], where, k, event, *state)
    for k in range(law.guards):
        ask("guard", kernels[1], where, k, *state)


def _answer(law: str, rows: list[Array], name: str, kernel: Kernel, where: str, *state: float) -> Any:
    """Give the answer to one state, or raise a LawError where it cannot be one, whatever it means."""
    # The first row once more: a kernel with side effects answers otherwise.
    answers = (kernel(*state, row) for row in (rows[0], *rows))
    count = COUNTS[name]
    given, again, *others = ((answer,) for answer in answers) if count == 1 else answers
    said = f"{law}: its kernel {name}"
    if not isinstance(given, tuple) or len(given) != count:
        found = f"{len(given)} numbers" if isinstance(given, tuple) else shown(given)
        raise LawError(f"{said} gives {found}; it must give {count} numbers.")
    if repr(given) != repr(again):
        raise LawError(
            f"{said} gives another answer to the same question {where}; it must have no side effects and no "
            "memory of its own. What a law remembers are its internal_variables."
        )
    # No number is the same as no number.
    if any(repr(given) != repr(other) for other in others):
        raise LawError(
            f"{said} reads parameters that there are not: its answer changes with what lies beyond the "
            f"{rows[0].size} that parameters() gives."
        )
    if not all(map(isfinite, given)):
        numbers = ", ".join(f"{number:g}" for number in given)
        # There are guards between the parts of a composed law.
        parts = bool(np.isnan(rows[0]).any())
        hint = " A part may have read beyond its own coefficients." if parts else ""
        raise LawError(
            f"{said} gives {numbers} {where}; all must be finite, as every contact begins and ends "
            f"there.{hint}"
        )
    return given
