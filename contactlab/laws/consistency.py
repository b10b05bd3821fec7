"""Consistency checks of a law's declarations and kernels, made once before its first run.

The contract of `contactlab.testing` checks more and runs the law; this costs a run next to nothing.
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
from contactlab.foreign import is_own
from contactlab.laws.base import ELASTOPLASTIC, SET_VALUED, ContactLaw, Kernel, NormalForce, PenaltyLaw
from contactlab.laws.declaration import LawError
from contactlab.laws.memory import EVEN, EVENTS, MOST_VARIABLES, ODD, InternalVariable

KINDS = ("SET_VALUED", "ELASTOPLASTIC", "RATE_DEPENDENT")
"""Names of the kinds of friction, in their order."""

HEAD = 1
"""Place in a law's parameter vector where the internal variables begin, behind what the engine writes."""

CANARIES, VALUES = 16, (nan, 1.0, -1.0)
"""Numbers on either side of a parameter vector, which no kernel may read, and their values: a result that
changes with them depends on them."""

DEPTHS, SPEEDS = (1e-12, 1e-9), (-0.01, 0.0, 0.01)
"""Penetrations that every contact begins and ends with [m], and gap rates and slips [m/s]."""

COUPLINGS = (-50.0, 0.0, 50.0)
"""Off-diagonal entries of the Delassus matrix [1/kg]; 1000 and 2000 are on its diagonal."""

NORMALS = (1e-3, 1.0)
"""Normal forces at which the bound of a rigid law is evaluated [N]."""

ROUND_OFF = 1e-9

BALANCE_DEPTHS, PROBE_SPEED = (1e-9, 1e-7, 1e-6), 0.01
"""Penetrations [m] and speed [m/s] at which stored energies and stiffnesses are differentiated."""

NUDGE, DIFFERENCE = 1e-4, 1e-3
"""Step of a central difference over the depth or stretch, and relative tolerance beyond its error [1]."""

AT_REST = ("gap_rate", "depth_rate", "slip", "impact_speed")
"""Quantities of a contact at rest."""

COUNTS = {
    "force": 5,
    "friction_force": 4,
    "impact": 2,
    "bound": 1,
    "limits": 2,
    "rate": 1,
    "jump": 1,
    "guard": 1,
}
"""How many numbers each kernel returns."""


def guarded(row: Array, canary: float = nan) -> Array:
    """Copy a parameter vector between canaries, read-only."""
    around = np.full(row.size + 2 * CANARIES, canary)
    copied = around[CANARIES:-CANARIES]
    copied[:] = row
    copied.flags.writeable = False
    return copied


def check_declarations(law: ContactLaw) -> None:
    """Raise a LawError with every contradiction among the declarations of a law."""
    if faults := [*contradictions(law)]:
        raise LawError(" ".join(f"{law.name}: {fault}" for fault in faults))


def contradictions(law: ContactLaw) -> Iterator[str]:
    """Yield the contradictions among the declarations of a law, in sentences."""
    for name in ("friction_limit", "friction_offset"):
        value = getattr(law, name)
        if not isinstance(value, Real) or not float(value) >= 0.0:
            yield f"{name} is {shown(value)}; it must be a number and not negative."
            return
    if not isinstance(law.violations, Mapping):
        yield f"violations is {shown(law.violations)}; it must give reasons by name."
        return
    variables = law.internal_variables
    if not isinstance(variables, tuple) or not all(isinstance(v, InternalVariable) for v in variables):
        yield f"internal_variables is {shown(variables)}; it must be a tuple of InternalVariable."
        return
    yield from _contradictions_of_variables(variables)
    if law.guards and (law.guard is None or law.jump is None):
        yield f"guards is {law.guards}; that needs a kernel guard and a kernel jump."
    if law.guard is not None and not law.guards:
        yield "guards is 0, but there is a kernel guard; declare their number."
    flows = law.rate is not None or law.jump is not None
    if isinstance(law, PenaltyLaw):
        yield from _contradictions_of_friction(law, flows)
        return
    if variables and not flows:
        yield "it has internal variables, but no kernel rate or jump."
    if law.limits is not None or law.guard is not None:
        yield "it has limits or guards; a rigid contact begins and ends at a gap of zero."


def _contradictions_of_variables(variables: tuple[InternalVariable, ...]) -> Iterator[str]:
    names = [variable.name for variable in variables]
    if len(set(names)) < len(names) or not all(name.isidentifier() for name in names):
        yield f"internal_variables are called {', '.join(names)}; each must have an identifier of its own."
    if len(names) > MOST_VARIABLES:
        yield f"internal_variables has {len(names)} entries; {MOST_VARIABLES} is the most."
    for variable in variables:
        sound = isinstance(variable.initial, Real) and isfinite(variable.initial)
        if not (sound and variable.life in ("contact", "run") and variable.parity in (ODD, EVEN)):
            yield (
                f"its internal variable {variable.name} has initial {shown(variable.initial)}, life "
                f"{shown(variable.life)} and parity {shown(variable.parity)}; they must be a finite number, "
                "'contact' or 'run', and ODD or EVEN."
            )


def _contradictions_of_friction(law: PenaltyLaw, flows: bool) -> Iterator[str]:
    kind, kernel, coupled = law.friction_kind, law.friction_force, law.coupled
    if kind not in range(len(KINDS)):
        yield f"friction_kind is {shown(kind)}; it must be {', '.join(KINDS)} of contactlab.laws.base."
        return
    declared = f"friction_kind is {KINDS[kind]}"
    if kind == SET_VALUED and kernel is not None:
        yield f"{declared}, which has no kernel of friction; declare ELASTOPLASTIC or RATE_DEPENDENT."
    if kind != SET_VALUED and kernel is None:
        yield f"{declared}, but it has no kernel of friction; add one, or declare SET_VALUED."
    if len(law.internal_variables) > 1 and not flows:
        yield "more than one of its internal_variables needs a kernel rate or jump."
    elif kind in (SET_VALUED, ELASTOPLASTIC) and (kind == ELASTOPLASTIC) != bool(coupled):
        yield (
            f"{declared} with {coupled} internal variables of the friction; a spring has one, its stretch, "
            "and set-valued friction needs a kernel rate or jump."
        )


def check_kernels(law: ContactLaw, parameters: Array, *kernels: Kernel) -> None:
    """Evaluate the bound kernels of a law in a few contacts; raise a LawError on the first impossible result.

    See `contactlab.engine.binding` for the kernels, in their order, and the parameter vector.
    """
    evaluate = partial(_evaluated, law.name, [guarded(parameters, canary) for canary in VALUES])
    force, friction_force, impact, bound, rate, guard, jump, limits = kernels
    begin, end = (0.0, 0.0) if limits is None else evaluate("limits", limits, "at first", 0.0)
    if begin > end:
        raise LawError(
            f"{law.name}: limits are {begin:g} m at the beginning of a contact and {end:g} m at its end; the "
            "second must not be less."
        )

    def check_variables(where: str, *state: float) -> None:
        for k in range(law.coupled, len(law.internal_variables)):
            evaluate("rate", rate, where, k, *state)
            for event in (*EVENTS, *range(law.guards)):
                evaluate("jump", jump, where, k, event, *state)
        for k in range(law.guards):
            evaluate("guard", guard, where, k, *state)

    if isinstance(law, PenaltyLaw):
        _check_forces(law, force, friction_force, float(begin), evaluate, check_variables)
        _check_energy(law, force, friction_force, guarded(parameters), float(begin))
        _check_stiffness(law)
    else:
        _check_impacts(law, impact, bound, evaluate, check_variables)


def _check_forces(
    law: PenaltyLaw, force: Kernel, friction_force: Kernel, begin: float, evaluate: Any, check_variables: Any
) -> None:
    for depth, gap_rate, slip in product(DEPTHS, SPEEDS, SPEEDS):
        gap = begin - depth
        where = f"at a gap of {gap:g} m, a gap rate of {gap_rate:g} m/s and a slip of {slip:g} m/s"
        normal, least, most, *_ = evaluate("force", force, where, gap, gap_rate, slip, abs(gap_rate))
        bound = 0.5 * (most - least)
        if bound < -ROUND_OFF * abs(normal):
            raise LawError(
                f"{law.name}: the friction bound is {bound:g} N {where}; it must not be negative. Where "
                "the normal force pulls there is no friction."
            )
        if law.friction_kind != SET_VALUED:
            # At the initial value only: which others there are, the law alone determines.
            evaluate("friction_force", friction_force, where, gap, gap_rate, slip, normal)
        check_variables(where, gap, gap_rate, slip, normal)


def _check_impacts(
    law: ContactLaw, impact: Kernel, bound: Kernel, evaluate: Any, check_variables: Any
) -> None:
    """Reject an impact of a rigid law that does not stop the approach, and a negative friction bound."""
    approach = SPEEDS[0]
    for slip, d_nt in product(SPEEDS, COUPLINGS):
        where = f"at an approach of {approach:g} m/s and a slip of {slip:g} m/s"
        p_n, p_t = evaluate("impact", impact, where, approach, slip, 1e3, d_nt, 2e3)
        after = approach + 1e3 * p_n + d_nt * p_t
        # Without an impulse there is no solution, which ends a run.
        if p_n > 0.0 and after < ROUND_OFF * approach and "kernel_is_consistent" not in law.violations:
            raise LawError(
                f"{law.name}: its kernel impact leaves {-after:g} m/s of the approach {where}; it must "
                "stop it."
            )
        check_variables(where, 0.0, approach, slip, p_n / law.default_contact_step)
    for normal, slip in product(NORMALS, SPEEDS):
        where = f"at a normal force of {normal:g} N and a slip of {slip:g} m/s"
        (most,) = evaluate("bound", bound, where, normal, slip)
        if most < 0.0:
            raise LawError(f"{law.name}: the friction bound is {most:g} N {where}; it must not be negative.")


def derivative(function: Callable[[float], float], at: float, step: float) -> tuple[float, float]:
    """Return a central difference, and its error from the one-sided ones and from round-off.

    Where the function has a kink within the step, the error is the whole change of slope there.
    """
    behind, here, ahead = (float(function(at + share * step)) for share in (-1.0, 0.0, 1.0))
    error = abs(ahead - 2.0 * here + behind) / step + 1e-14 * (abs(here) + abs(ahead)) / step
    return 0.5 * (ahead - behind) / step, error


def _check_energy(law: PenaltyLaw, force: Kernel, friction: Kernel, row: Array, begin: float) -> None:
    """Reject a stored energy without internal variables in z that contradicts the force.

    The normal loss is -(N + dV/dgap) gap_rate, a spring has F = -k z and E = 1/2 k z^2, and friction at a
    constant gap loses -F v - dE/dz dz/dt >= 0: a stretched contact returns no more than it stores.
    """
    if len(law.internal_variables) > law.coupled:
        return
    for depth, rate in product(BALANCE_DEPTHS, SPEEDS):
        gap = begin - depth
        normal, _, _, _, loss = force(gap, rate, 0.0, PROBE_SPEED, row)

        def stored(at: float, rate: float = rate) -> float:
            return float(force(at, rate, 0.0, PROBE_SPEED, row)[3])

        slope, error = derivative(stored, gap, NUDGE * depth)
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
    """Reject a stored energy of friction that contradicts its force at a small stretch."""
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
        for slip in (outward, -outward) if z != first else ():
            drag, rate, _, _ = friction(gap, 0.0, slip, normal, z)

            def stored_at(x: float, slip: float = slip) -> float:
                return float(friction(gap, 0.0, slip, normal, x)[2])

            slope, error = derivative(stored_at, z, NUDGE * abs(z - first))
            gained = drag * slip + slope * rate - error * abs(rate)
            allowed = DIFFERENCE * (abs(drag * slip) + abs(slope * rate))
            if gained > allowed and "friction_stores_what_it_gives" not in law.violations:
                raise LawError(
                    f"{law.name}: friction makes {gained:g} W at a constant gap of {gap:g} m, a slip of "
                    f"{slip:g} m/s and an internal variable of {z:g}: its stored energy changes by "
                    f"{slope * rate:g} W, its force does {-drag * slip:g} W against the slip, which must not "
                    "be less."
                )


def _check_stiffness(law: ContactLaw) -> None:
    """Reject a normal force from outside the package whose stiffness or slope is no derivative of it."""
    part = getattr(law, "normal", None)
    # The contract in the package's tests covers its own; here they would only cost time.
    if not isinstance(part, NormalForce) or is_own(type(part)):
        return
    name = "elastic" if part.force is None else "force"
    known: dict[str, Any] = {variable.name: variable.initial for variable in part.internal_variables}
    known |= {**dict.fromkeys(AT_REST, 0.0), "z": np.array([*known.values()], dtype=np.float64)}

    def result(depth: float, place: int) -> float:
        return float(part.evaluate(name, **known, depth=depth, gap=-depth)[place])

    for depth in BALANCE_DEPTHS:
        # Places of stiffness and slope, and of what they are derivatives of.
        for word, place, of in (("stiffness", 2, 0), ("slope", 3, 2)):
            difference, error = derivative(partial(result, place=of), depth, NUDGE * depth)
            declared = result(depth, place)
            if abs(declared - difference) - error > DIFFERENCE * (abs(declared) + abs(difference)):
                raise LawError(
                    f"{law.name}: the {word} of its normal force {part.name} is {declared:g} at a depth of "
                    f"{depth:g} m, where the derivative is {difference:g}."
                )


def _evaluated(law: str, rows: list[Array], name: str, kernel: Kernel, where: str, *state: float) -> Any:
    """Return the result of a kernel, or raise a LawError where it is impossible for any law."""
    # The first vector twice: a kernel with side effects returns something else.
    results = (kernel(*state, row) for row in (rows[0], *rows))
    count = COUNTS[name]
    first, again, *others = ((result,) for result in results) if count == 1 else results
    fault = ""
    if not isinstance(first, tuple) or len(first) != count:
        fault = f"{len(first)} numbers" if isinstance(first, tuple) else shown(first)
        fault = f"returns {fault}; it must return {count} numbers."
    elif repr(first) != repr(again):
        fault = (
            f"returns another result for the same arguments {where}; it must have no side effects. Internal "
            "variables are declared in internal_variables."
        )
    # As text: NaN equals NaN.
    elif any(repr(first) != repr(other) for other in others):
        fault = f"reads parameters beyond the {rows[0].size} that there are."
    elif not all(map(isfinite, first)):
        numbers = ", ".join(f"{number:g}" for number in first)
        # NaN stands between the coefficients of the parts of a composed law.
        hint = " A part may have read beyond its coefficients." if np.isnan(rows[0]).any() else ""
        fault = f"returns {numbers} {where}; all must be finite: contacts begin and end there.{hint}"
    if fault:
        raise LawError(f"{law}: its kernel {name} {fault}")
    return first
