"""The contract of a contact law: what has to be true of every one, and what it may declare to break.

A property is a function from a bench to claims. A law breaks one honestly by naming it in
`ContactLaw.violations` (tension and inexact stick have declarations of their own); then it must be
broken, or the declaration is wrong.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from itertools import chain
from math import floor
from types import MappingProxyType
from typing import Any, ClassVar, cast

import xarray

from contactlab.laws import ContactLaw, law_class, law_names
from contactlab.laws.bare import Bare
from contactlab.metrics import INVARIANTS, NOT_APPLICABLE, assess
from contactlab.testing import declaration_properties, flow_properties, kernel_properties, run_properties
from contactlab.testing.claim import Claim, Claims, at_most, proofs_of
from contactlab.testing.plants import Bench, paper_motor


def declares_what_it_breaks(bench: Bench) -> Claims:
    """A violation is declared by the name of a property, and with a reason."""
    values = bench.law.violations
    odd = sorted(name for name in values if name not in PROPERTIES or not values[name])
    yield at_most(f"declared violations without property or reason {odd}", len(odd), 0)


PROPERTIES = proofs_of(kernel_properties, declaration_properties, flow_properties, run_properties)
PROPERTIES["declares_what_it_breaks"] = declares_what_it_breaks
"""The contract of a law: its properties by their names, each a function of a `Bench`."""


def claims_of(proof: Callable[[], Claims], excuse: str = "") -> list[Claim]:
    """Return the claims of a proof, an excuse put to those that it is for: the broken ones, or all.

    A law that is refused, raises, or whose run does not reach its end breaks the proof, excuse or not.
    """
    try:
        claims = list(proof())
    # The kernel is called without the engine around it, and may raise anything.
    except Exception as error:
        known = isinstance(error, RuntimeError | ValueError | TypeError)
        text = str(error) if known else f"{type(error).__name__}: {error}"
        return [at_most(f"runs that fail: {' '.join(text.split())}", 1, 0)]
    broken = any(not claim.true for claim in claims)
    return [c if broken and c.true else c.excused(excuse) for c in claims]


def check(bench: Bench, name: str) -> list[Claim]:
    """Return the claims of one property, with the reason why the law declares to break it, if it does."""
    law = bench.law
    excuse = law.violations.get(name, "")
    if name == "no_tension" and law.allows_tension:
        excuse = "it allows tension."
    if name == "stick_is_exact" and not law.exact_stick:
        excuse = "its stick is not exact."
    return claims_of(partial(PROPERTIES[name], bench), excuse)


bench_of = lru_cache(maxsize=8)(Bench)
"""One bench for all tests of a law."""


class LawContract:
    """The tests of one contact law: one for each property, `test_no_tension` and so on.

        class TestMyLaw(LawContract):
            law = MyLaw(stiffness=1e9, friction_coefficient=0.3)

    Where the law needs another motor than the paper's, the class has a static `make_motor` as well.
    """

    law: ClassVar[ContactLaw]
    make_motor = staticmethod(paper_motor)

    def __init_subclass__(cls) -> None:
        for name in PROPERTIES:

            def test(self: LawContract, name: str = name) -> None:
                self.assert_property(name)

            if not hasattr(cls, f"test_{name}"):
                setattr(cls, f"test_{name}", test)

    def assert_property(self, name: str) -> None:
        """Fail with the sentences of all claims that are not as they should be."""
        claims = check(bench_of(self.law, self.make_motor), name)
        failed = [str(claim) for claim in claims if not claim.holds]
        assert not failed, "\n".join([f"{self.law.name}, {name}:", *failed])


def declare(law: ContactLaw) -> ContactLaw:
    """Return a law of bare functions that declares what the contract finds.

    Each property that it breaks is one of its `violations`, with the broken claim as the reason; where its
    error falls at a lower order than that of other laws, this is its `convergence_order`.

    Raises:
        TypeError: neither its normal force nor its friction is a bare function.
    """
    part: Any = next((each for each in getattr(law, "parts", ()) if isinstance(each, Bare)), None)
    if part is None:
        raise TypeError(
            f"{law.title} has no part of a bare function; what a class breaks, it declares itself."
        )
    bench, order = Bench(law), part.convergence_order
    broken: dict[str, str] = {}
    for name in PROPERTIES:
        for claim in check(bench, name):
            if name == "converges" and claim.relation == ">=" and 0.0 < claim.value < claim.expected:
                # In tenths, as an order fitted to a few runs is uncertain by more.
                order = floor(10.0 * claim.value) / 10.0
            elif not claim.holds:
                broken.setdefault(name, str(claim))
    declarations = {"violations": MappingProxyType(broken), "convergence_order": order}
    changed: ContactLaw = replace(cast("Any", law), **{part.family: part.declaring(declarations)})
    return changed


def invariants_of(run: xarray.DataTree) -> Claims:
    """Hold a run, see `contactlab.metrics.read_run`, to what no law can excuse.

    Yields a claim for every one of `contactlab.metrics.INVARIANTS` that the run has the numbers for.
    """
    for key, value in assess(run, INVARIANTS).items():
        metric = INVARIANTS[key]
        if metric.verdict(value) != NOT_APPLICABLE:
            yield at_most(f"{key}: {metric.meaning}", value, metric.bound, metric.units)


def all_claims() -> Iterator[tuple[str, Callable[[], Iterable[Claim]]]]:
    """Yield the heading of every law and the function of the claims of its contract."""
    for name in law_names():
        try:
            law = law_class(name)()
        # A law of another package may be broken, or have a parameter that has no default.
        except Exception as error:
            yield f"The contract of {name} is not checked: {error}", tuple
            continue
        checks = map(partial(check, Bench(law)), PROPERTIES)
        yield f"The contract of {law.name}: {law.equation}", partial(chain.from_iterable, checks)
