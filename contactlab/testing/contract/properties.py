"""The contract of a contact law: what has to be true of every one, and what it may declare to break.

A property is a function from a bench to claims. A law breaks one honestly by naming it in
`ContactLaw.violations` (tension and inexact stick have declarations of their own); then it must be
broken, or the declaration is wrong.
"""

from collections.abc import Callable, Iterable, Iterator

from contactlab.laws import ContactLaw
from contactlab.testing.claim import Claim, at_most
from contactlab.testing.contract import forces, kernels, repetition
from contactlab.testing.contract.bench import Bench

Property = Callable[[Bench], Iterator[Claim]]


def declares_what_it_breaks(bench: Bench) -> Iterator[Claim]:
    """A violation is declared by the name of a property, and with a reason."""
    given = bench.law.violations
    odd = sorted(name for name in given if name not in PROPERTIES or not given[name])
    yield at_most(f"declared violations without property or reason {odd}", len(odd), 0)


PROPERTIES: dict[str, Property] = {
    "declares_its_parameters": kernels.declares_its_parameters,
    "declares_what_it_breaks": declares_what_it_breaks,
    "kernel_is_consistent": kernels.kernel_is_consistent,
    "parts_keep_apart": kernels.parts_keep_apart,
    "no_force_when_open": forces.no_force_when_open,
    "no_tension": forces.no_tension,
    "inside_the_cone": forces.inside_the_cone,
    "friction_opposes_slip": forces.friction_opposes_slip,
    "dissipates": forces.dissipates,
    "stick_is_exact": forces.stick_is_exact,
    "ledger_closes": forces.ledger_closes,
    "impulse_is_momentum": forces.impulse_is_momentum,
    "converges": repetition.converges,
    "repeats_bit_for_bit": repetition.repeats_bit_for_bit,
    "calls_leave_no_trace": repetition.calls_leave_no_trace,
    "mirrors": repetition.mirrors,
}
"""Every property by its name."""


def excuse_of(law: ContactLaw, name: str) -> str:
    """The reason why a law declares to break a property, empty where it keeps it."""
    if name == "no_tension" and law.allows_tension:
        return "it allows tension."
    if name == "stick_is_exact" and not law.exact_stick:
        return "its stick is not exact."
    return law.violations.get(name, "")


def judge(claims: Iterable[Claim], excuse: str) -> list[Claim]:
    """Claims of one property with an excuse put to those that it is for: the broken ones, or all."""
    judged = list(claims)
    if not excuse:
        return judged
    broken = any(not claim.true for claim in judged)
    return [c if broken and c.true else c.excused(excuse) for c in judged]


def check(bench: Bench, name: str) -> list[Claim]:
    """The judged claims of one property by its name.

    A law that is refused, raises, or whose run does not reach its end breaks the property, whatever it
    declares.
    """
    try:
        claims = list(PROPERTIES[name](bench))
    # The kernel is asked without the engine around it, and may raise anything.
    except Exception as error:
        known = isinstance(error, RuntimeError | ValueError | TypeError)
        words = str(error) if known else f"{type(error).__name__}: {error}"
        return [at_most(f"runs that fail: {' '.join(words.split())}", 1, 0)]
    return judge(claims, excuse_of(bench.law, name))
