"""The contract of a contact law: what has to be true of every one, and what it may declare to break.

A property is a function from a bench to claims. A law breaks one honestly by naming it in
`ContactLaw.violations` (tension and inexact stick have declarations of their own); then it must be
broken, or the declaration is wrong.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache, partial
from typing import ClassVar

import xarray

# The modules that fill the catalogues, in the order in which their claims are shown.
from contactlab.laws import ContactLaw, law_class, law_names
from contactlab.metrics import INVARIANTS, NOT_APPLICABLE, assess
from contactlab.motor.motor import Motor
from contactlab.testing import (  # noqa: F401
    closed_forms,
    kernel_properties,
    random_flights,
    references,
    run_properties,
)
from contactlab.testing.claim import (
    CLOSED_FORMS,
    PROPERTIES,
    REFERENCES,
    Claim,
    Claims,
    at_most,
    heading,
)
from contactlab.testing.plants import paper_motor
from contactlab.testing.runs import Bench


def excuse_of(law: ContactLaw, name: str) -> str:
    """Give the reason why a law declares to break a property, empty where it keeps it."""
    if name == "no_tension" and law.allows_tension:
        return "it allows tension."
    if name == "stick_is_exact" and not law.exact_stick:
        return "its stick is not exact."
    return law.violations.get(name, "")


def check(bench: Bench, name: str) -> list[Claim]:
    """Give the claims of one property, an excuse put to those that it is for: the broken ones, or all.

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
    if not (excuse := excuse_of(bench.law, name)):
        return claims
    broken = any(not claim.true for claim in claims)
    return [c if broken and c.true else c.excused(excuse) for c in claims]


@lru_cache(maxsize=8)
def bench_of(law: ContactLaw, make_motor: Callable[[], Motor]) -> Bench:
    """Give one bench for all tests of a law."""
    return Bench(law, make_motor)


class LawContract:
    """The tests of one contact law: one for each property, `test_no_tension` and so on.

        class TestMyLaw(LawContract):
            law = MyLaw(stiffness=1e9, friction_coefficient=0.3)

    Where the law needs another motor than the paper's, the class has a static `make_motor` as well.
    """

    law: ClassVar[ContactLaw]

    @staticmethod
    def make_motor() -> Motor:
        """Give the paper's motor."""
        return paper_motor()

    def assert_property(self, name: str) -> None:
        """Fail with the sentences of all claims that are not as they should be."""
        claims = check(bench_of(self.law, self.make_motor), name)
        failed = [str(claim) for claim in claims if not claim.holds]
        assert not failed, "\n".join([f"{self.law.name}, {name}:", *failed])


def _test_of(name: str) -> Callable[[LawContract], None]:
    def test(self: LawContract) -> None:
        self.assert_property(name)

    test.__doc__ = heading(PROPERTIES[name])
    return test


for _name in PROPERTIES:
    setattr(LawContract, f"test_{_name}", _test_of(_name))


def invariants_of(run: xarray.DataTree) -> Claims:
    """Hold a recorded run to what no law can excuse: closed books, no contact without length, none missed.

    Args:
        run: in the layout of a run.nc, see `contactlab.metrics.read_run`.

    Yields:
        A claim for every one of `contactlab.metrics.INVARIANTS` that the run has the numbers for.
    """
    for key, value in assess(run, INVARIANTS).items():
        metric = INVARIANTS[key]
        if metric.verdict(value) != NOT_APPLICABLE:
            yield at_most(f"{key}: {metric.meaning}", value, metric.bound, metric.units)


def all_claims() -> Iterator[tuple[str, Callable[[], Iterable[Claim]]]]:
    """Give every heading and the function of its claims: the catalogues, then the contract of every law."""
    yield from ((heading(made), made) for made in (*CLOSED_FORMS.values(), *REFERENCES.values()))
    for name in law_names():
        try:
            law = law_class(name)()
        # A law of another package may be broken, or have a parameter that has no default.
        except Exception as error:
            yield f"The contract of {name} is not checked: {error}", tuple
            continue
        yield f"The contract of {law.name}: {law.equation}", partial(_contract, Bench(law))


def _contract(bench: Bench) -> Claims:
    for name in PROPERTIES:
        yield from check(bench, name)
