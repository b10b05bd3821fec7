"""Claims about a law's declarations and kernels.

Before the first run of a law they are checked in a few contacts, at next to no cost, and the first broken one
refuses it. The contract of `contactlab.testing` checks the same in drawn states, more accurately, and more,
and runs the law.
"""

from collections.abc import Callable, Generator, Iterator, Mapping
from functools import partial
from itertools import product
from math import inf, isfinite, isnan, nan
from numbers import Real
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import shown
from contactlab.foreign import is_own
from contactlab.laws.base import ELASTOPLASTIC, SET_VALUED, ContactLaw, Kernel, NormalForce, PenaltyLaw
from contactlab.laws.claim import Claim, Claims, at_most
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
"""Share of the quantities that take part; the claims subtract numbers of their size."""

TINY = 1e-300
"""Added to what is divided by, and may be zero."""

BALANCE_DEPTHS, PROBE_SPEED = (1e-9, 1e-7, 1e-6), 0.01
"""Penetrations [m] and speed [m/s] at which stored energies and stiffnesses are differentiated."""

NUDGE, ROUGHLY, ACCURATELY = 1e-4, 1e-3, 1e-6
"""Step of a central difference over the depth or stretch, and what it may miss beyond its error before a run,
where a law's own quadrature is admitted, and in the contract [1]."""

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

Evaluation = Generator[Claim, None, Any]
"""Yields a broken claim where the answer of a kernel, which it returns, is impossible."""


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
    """Evaluate the bound kernels of a law in a few contacts; raise a LawError on the first broken claim.

    See `contactlab.engine.binding` for the kernels, in their order, and the parameter vector.
    """
    for claim in claims_of_kernels(law, parameters, *kernels):
        # An answer that is no number refuses nothing here: it ends the run where it occurs, which says so.
        if not (claim.true or isnan(claim.value)):
            raise LawError(f"{law.name}: {claim.refusal()}")


def claims_of_kernels(law: ContactLaw, parameters: Array, *kernels: Kernel) -> Claims:
    """Yield claims about the bound kernels of a law in a few contacts, but for what it declares to break.

    An answer that is impossible for any law is a broken claim; behind it there may be no others.
    """
    evaluate = partial(_evaluated, [guarded(parameters, canary) for canary in VALUES])
    force, friction_force, impact, bound, rate, guard, jump, limits = kernels
    begin = 0.0
    if limits is not None:
        begin, end = yield from evaluate("limits", limits, "at first", 0.0)
        yield ends_behind_its_beginning(float(begin), float(end))

    def of_variables(where: str, *state: float) -> Evaluation:
        for k in range(law.coupled, len(law.internal_variables)):
            yield from evaluate("rate", rate, where, k, *state)
            for event in (*EVENTS, *range(law.guards)):
                yield from evaluate("jump", jump, where, k, event, *state)
        for k in range(law.guards):
            yield from evaluate("guard", guard, where, k, *state)

    if isinstance(law, PenaltyLaw):
        yield from _of_forces(law, force, friction_force, float(begin), evaluate, of_variables)
        yield from _of_energy(law, force, friction_force, guarded(parameters), float(begin))
        yield from _of_stiffness(law)
    else:
        yield from _of_impacts(law, impact, bound, evaluate, of_variables)


def _of_forces(
    law: PenaltyLaw, force: Kernel, friction_force: Kernel, begin: float, evaluate: Any, of_variables: Any
) -> Claims:
    for depth, gap_rate, slip in product(DEPTHS, SPEEDS, SPEEDS):
        gap = begin - depth
        where = f"at a gap of {gap:g} m, a gap rate of {gap_rate:g} m/s and a slip of {slip:g} m/s"
        normal, least, most, *_ = yield from evaluate(
            "force", force, where, gap, gap_rate, slip, abs(gap_rate)
        )
        # The largest is for the contract to judge.
        yield bound_in_cone(0.5 * (most - least), inf, abs(normal) + TINY, where)
        if law.friction_kind != SET_VALUED:
            # At the initial value only: which others there are, the law alone determines.
            yield from evaluate("friction_force", friction_force, where, gap, gap_rate, slip, normal)
        yield from of_variables(where, gap, gap_rate, slip, normal)


def _of_impacts(law: ContactLaw, impact: Kernel, bound: Kernel, evaluate: Any, of_variables: Any) -> Claims:
    approach = SPEEDS[0]
    for slip, d_nt in product(SPEEDS, COUPLINGS):
        where = f"at an approach of {approach:g} m/s and a slip of {slip:g} m/s"
        p_n, p_t = yield from evaluate("impact", impact, where, approach, slip, 1e3, d_nt, 2e3)
        # Without an impulse there is no solution, which ends a run.
        if p_n > 0.0 and "kernel_is_consistent" not in law.violations:
            yield approach_is_stopped(approach + 1e3 * p_n + d_nt * p_t, -approach, where)
        yield from of_variables(where, 0.0, approach, slip, p_n / law.default_contact_step)
    for normal, slip in product(NORMALS, SPEEDS):
        where = f"at a normal force of {normal:g} N and a slip of {slip:g} m/s"
        (most,) = yield from evaluate("bound", bound, where, normal, slip)
        yield bound_in_cone(most, inf, normal, where)


def _of_energy(law: PenaltyLaw, force: Kernel, friction: Kernel, row: Array, begin: float) -> Claims:
    """Claim that a stored energy without internal variables in z agrees with the force.

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

        if "kernel_is_consistent" not in law.violations:
            yield loss_is_not_stored(stored, (normal, loss), gap, rate, NUDGE * depth, ROUGHLY)
        if law.coupled:
            yield from _of_stretch(law, partial(_friction_with, friction, row), gap, float(normal))


def _friction_with(friction: Kernel, row: Array, *state: float) -> Any:
    """Evaluate friction with a value of its coupled variable, the last number."""
    first: Any = row.base
    first[CANARIES + HEAD] = state[-1]
    return friction(*state[:-1], row)


def _of_stretch(law: PenaltyLaw, friction: Kernel, gap: float, normal: float) -> Claims:
    """Claim that a stored energy of friction agrees with its force at a small stretch."""
    first = law.internal_variables[0].initial
    if law.friction_kind == ELASTOPLASTIC:
        z = first + NUDGE * abs(gap)
        drag, _, stored, stiffness = friction(gap, 0.0, 0.0, normal, z)
        if "kernel_is_consistent" not in law.violations:
            yield spring_is_linear(drag, stored, stiffness, z, abs(drag) + stiffness * abs(z) + TINY)
        return
    if "friction_stores_what_it_gives" in law.violations:
        return
    way = 1e-3 * abs(gap)
    for outward in (-PROBE_SPEED, PROBE_SPEED):
        z = first + friction(gap, 0.0, outward, normal, first)[1] * way / PROBE_SPEED
        for slip in (outward, -outward) if z != first else ():
            drag, rate, _, _ = friction(gap, 0.0, slip, normal, z)

            def stored_at(x: float, slip: float = slip) -> float:
                return float(friction(gap, 0.0, slip, normal, x)[2])

            change = derivative(stored_at, z, NUDGE * abs(z - first))
            yield stretch_gains_nothing((gap, slip, z), drag, rate, change)


def _of_stiffness(law: ContactLaw) -> Claims:
    """Claim that stiffness and slope of a normal force from outside the package are derivatives of it."""
    part = getattr(law, "normal", None)
    # The contract in the package's tests covers its own; here they would only cost time.
    if not isinstance(part, NormalForce) or is_own(type(part)):
        return
    known: dict[str, Any] = {variable.name: variable.initial for variable in part.internal_variables}
    known |= {**dict.fromkeys(AT_REST, 0.0), "z": np.array([*known.values()], dtype=np.float64)}
    for depth in BALANCE_DEPTHS:
        yield from stiffness_is_a_derivative(part, depth, known, ROUGHLY)


def bound_in_cone(bound: float, most: float, size: float, where: str = "") -> Claim:
    """Claim that a friction bound [N] is in [0, most], to round-off of a force [N]."""
    return at_most(
        "friction bound outside of [0, mu (N + C)], over the force",
        max(-bound, bound - most) / size,
        ROUND_OFF,
        refusal=lambda: (
            f"the friction bound is {bound:g} N {where}; it must not be negative. Where the normal force "
            "pulls there is no friction."
        ),
    )


def loss_is_not_stored(
    stored: Callable[[float], float],
    result: tuple[float, float],
    gap: float,
    rate: float,
    step: float,
    accuracy: float,
) -> Claim:
    """Claim that the normal loss is -(N + dV/dgap) gap_rate, of the energy V(gap) and N [N], loss [W]."""
    normal, loss = result
    slope, error = derivative(stored, gap, step)
    power = (abs(normal) + abs(slope)) * abs(rate) + abs(loss) + TINY
    missing = max(abs(loss + (normal + slope) * rate) - error * abs(rate), 0.0)
    return at_most(
        "loss less -(N + dV/dg) gdot, over the power",
        missing / power,
        accuracy,
        refusal=lambda: (
            f"the stored energy V and the normal loss contradict the force at a gap of {gap:g} m and a "
            f"gap rate of {rate:g} m/s: N is {normal:g} N, -dV/dgap {-slope:g} N, the loss {loss:g} W; the "
            "loss must be -(N + dV/dgap) gap_rate."
        ),
    )


def spring_is_linear(drag: float, stored: float, stiffness: float, z: float, size: float) -> Claim:
    """Claim that a spring of friction has F = -k z and E = 1/2 k z^2, to round-off of a force [N]."""
    misses = abs(drag + stiffness * z), abs(stored - 0.5 * stiffness * z**2) / (abs(z) + TINY)
    return at_most(
        "spring less -k z and 1/2 k z^2, over the force",
        max(misses) / size,
        ROUND_OFF,
        refusal=lambda: (
            f"its friction is {drag:g} N, its stored energy {stored:g} J and its stiffness {stiffness:g} "
            f"N/m at a stretch z of {z:g} m; a spring has F = -k z and E = 1/2 k z^2."
        ),
    )


def stretch_gains_nothing(
    state: tuple[float, float, float], drag: float, rate: float, change: tuple[float, float]
) -> Claim:
    """Claim that friction loses -F v - dE/dz dz/dt >= 0 at a gap [m], a slip [m/s] and a stretch z.

    The change is dE/dz and its error.
    """
    gap, slip, z = state
    stored, error = change[0] * rate, change[1] * abs(rate)
    gained = drag * slip + stored - error
    return at_most(
        "energy that friction makes at a held gap, over its power",
        gained / (abs(drag * slip) + abs(stored) + TINY),
        ROUGHLY,
        refusal=lambda: (
            f"friction makes {gained:g} W at a constant gap of {gap:g} m, a slip of {slip:g} m/s and "
            f"an internal variable of {z:g}: its stored energy changes by {stored:g} W, its force does "
            f"{-drag * slip:g} W against the slip, which must not be less."
        ),
    )


def stiffness_is_a_derivative(
    part: NormalForce, depth: float, known: Mapping[str, Any], accuracy: float
) -> tuple[Claim, Claim]:
    """Claim that stiffness and slope of a normal force are derivatives by the depth, all else as known."""
    kernel = "elastic" if part.force is None else "force"

    def result(at: float, place: int) -> float:
        return float(part.evaluate(kernel, **known, depth=at, gap=-at)[place])

    def claim(word: str, place: int, of: int) -> Claim:
        difference, error = derivative(partial(result, place=of), depth, NUDGE * abs(depth) + 1e-14)
        declared = result(depth, place)
        missed = max(abs(declared - difference) - error, 0.0)
        return at_most(
            f"{word} less the difference of the force, relative",
            missed / (abs(declared) + abs(difference) + TINY),
            accuracy,
            refusal=lambda: (
                f"the {word} of its normal force {part.name} is {declared:g} at a depth of "
                f"{depth:g} m, where the derivative is {difference:g}."
            ),
        )

    # Places of stiffness and slope, and of what they are derivatives of.
    return claim("stiffness", 2, 0), claim("slope of the stiffness", 3, 2)


def approach_is_stopped(left: float, size: float, where: str = "") -> Claim:
    """Claim that an impact leaves no approach, to round-off of a velocity: `left` is the gap rate [m/s]."""
    return at_most(
        "approach that is left, over the velocities",
        -left / size,
        ROUND_OFF,
        refusal=lambda: f"its kernel impact leaves {-left:g} m/s of the approach {where}; it must stop it.",
    )


def ends_behind_its_beginning(begin: float, end: float) -> Claim:
    """Claim that a contact ends at no smaller gap [m] than it begins at."""
    return at_most(
        "gap of the beginning over that of the end",
        begin - end,
        0.0,
        "m",
        refusal=lambda: (
            f"limits are {begin:g} m at the beginning of a contact and {end:g} m at its end; the second "
            "must not be less."
        ),
    )


def derivative(function: Callable[[float], float], at: float, step: float) -> tuple[float, float]:
    """Return a central difference over half a step, and its error.

    The error is that of the differences over both steps and of round-off. Where the function has a kink
    within the step, it is at least the change of slope there: the one-sided differences do not come closer.
    """
    values = (float(function(at + share * step)) for share in (-1.0, -0.5, 0.0, 0.5, 1.0))
    behind, before, here, after, ahead = values
    coarse, fine = 0.5 * (ahead - behind) / step, (after - before) / step
    kink = abs(4.0 * (after - 2.0 * here + before) - (ahead - 2.0 * here + behind)) / step
    return fine, 2.0 * abs(coarse - fine) + kink + 1e-13 * abs(here) / step


def _evaluated(rows: list[Array], name: str, kernel: Kernel, where: str, *state: float) -> Evaluation:
    """Return the answer of a kernel; where it is impossible for any law, yield that as a broken claim."""
    # The first vector twice: a kernel with side effects returns something else.
    results = (kernel(*state, row) for row in (rows[0], *rows))
    count = COUNTS[name]
    first, again, *others = ((result,) for result in results) if count == 1 else results
    fault = ""
    if not isinstance(first, tuple) or len(first) != count:
        fault = f"{len(first)} numbers" if isinstance(first, tuple) else shown(first)
        fault = f"returns {fault}; it must return {count} numbers."
    elif not _same(first, again):
        fault = (
            f"returns another result for the same arguments {where}; it must have no side effects. Internal "
            "variables are declared in internal_variables."
        )
    elif not all(_same(first, other) for other in others):
        fault = f"reads parameters beyond the {rows[0].size} that there are."
    elif not all(map(isfinite, first)):
        numbers = ", ".join(f"{number:g}" for number in first)
        # NaN stands between the coefficients of the parts of a composed law.
        hint = " A part may have read beyond its coefficients." if np.isnan(rows[0]).any() else ""
        fault = f"returns {numbers} {where}; all must be finite: contacts begin and end there.{hint}"
    if fault:
        yield at_most(f"impossible answers of {name}", 1, 0, refusal=lambda: f"its kernel {name} {fault}")
    return first


def _same(first: tuple[float, ...], other: tuple[float, ...]) -> bool:
    """Return whether two answers are the same numbers; as text NaN equals NaN."""
    return first == other or repr(first) == repr(other)
