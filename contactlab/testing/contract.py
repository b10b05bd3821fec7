"""The contract of a contact law: what has to be true of every one, and what it may declare to break.

A property is a function from a bench to claims. A law breaks one honestly by naming it in
`ContactLaw.violations` (tension and inexact stick have declarations of their own); then it must be
broken, or the declaration is wrong.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from itertools import chain
from typing import ClassVar, final

import xarray
from scipy.optimize import brentq

from contactlab.engine.simulation import take_in
from contactlab.laws import ContactLaw, MultiplierLaw, PenaltyLaw, law_class, law_names
from contactlab.metrics import INVARIANTS, NOT_APPLICABLE, assess
from contactlab.motor.motor import Motor
from contactlab.testing.claim import (
    CLOSED_FORMS,
    PROPERTIES,
    REFERENCES,
    Claim,
    Claims,
    Proof,
    at_most,
    heading,
)
from contactlab.testing.plants import attempt, block, completed, paper_motor, run
from contactlab.trajectory import Trajectory

MOTOR_DURATION = 1.5e-3
"""Of the run of the motor [s]: five contacts of the paper's."""

MASS, BELT_MASS, WEIGHT = 2e-3, 1e-2, 5.0
"""Of the skipping block [kg], [kg], [N]: about a motor's tip, and a rotor as light as to answer."""

NUDGE = 0.4
"""Push over what friction can hold."""


@final
@dataclass(frozen=True, eq=False)
class Bench:
    """Hold a law and the runs that its contract is checked on, each made once.

    The motor is one that the law can drive at its default contact step.
    """

    law: ContactLaw
    make_motor: Callable[[], Motor] = field(default=paper_motor)

    @property
    def rigid(self) -> bool:
        """Whether the law is a `MultiplierLaw`."""
        return isinstance(self.law, MultiplierLaw)

    @property
    def balance(self) -> float:
        """What energy and momentum may miss, as a share, at default steps: the order-one laws more."""
        return 1e-3 if self.rigid else 1e-6

    @cached_property
    def motor(self) -> Motor:
        """The motor of `motor_run`."""
        return self.make_motor()

    @property
    def motor_run(self) -> Trajectory:
        """The law in the motor, recorded finely."""
        return completed(self._motor_run)

    @property
    def skipping(self) -> Trajectory:
        """A block that is thrown onto a moving belt at a slant and pressed on by its weight."""
        return completed(self._skipping)

    @property
    def runs(self) -> tuple[tuple[str, Trajectory], ...]:
        """Both with a word for each."""
        return (("motor", self.motor_run), ("block", self.skipping))

    def attempt_motor(self, law: ContactLaw, motor: Motor) -> Trajectory:
        """Make a run as `motor_run` of another law or motor, whatever becomes of it."""
        step = self.law.default_contact_step
        # Finer than the steps of a rigid law, fine against a contact of a compliant one.
        interval = 0.4 * step if self.rigid else 1e-7
        return attempt(motor, law, MOTOR_DURATION, step, interval)

    # A run that fails may take long to do so: it is made once, and every property told of it.
    @cached_property
    def _motor_run(self) -> Trajectory:
        return self.attempt_motor(self.law, self.motor)

    @cached_property
    def _skipping(self) -> Trajectory:
        thrown = {"height": 1e-6, "gap_rate": -0.1, "velocity": 0.05, "belt_velocity": -0.02}
        motor = block(MASS, weight=WEIGHT, belt_mass=BELT_MASS, **thrown)
        return attempt(motor, self.law, 1e-3, record_interval=1e-6)

    @cached_property
    def nudged(self) -> Trajectory:
        """A block that lies on a belt at rest and is pushed with less than friction can hold."""
        push = NUDGE * self.law.friction_limit * WEIGHT
        motor = block(MASS, height=self._balanced_gap(), weight=WEIGHT, push=push)
        # An interval that no number of steps fills, or a chatter of two steps could hide in it.
        return run(motor, self.law, 2e-3, record_interval=1.03e-6)

    def _balanced_gap(self) -> float:
        """Gap [m] at which the law carries the weight without motion; a rigid one at zero."""
        if not isinstance(self.law, PenaltyLaw):
            return 0.0
        # A law that reads beyond its parameters answers with what happens to lie there.
        parameters, (force, *_), law_errors = take_in(self.law)

        def missing(exponent: float) -> float:
            with law_errors():
                normal: float = force(-(10.0**exponent), 0.0, 0.0, 0.0, parameters)[0]
            return normal - WEIGHT

        # From shallow to deep: how deep the law is valid is not known.
        depths = (0.5 * k for k in range(-30, 1))
        enough = next((e for e in depths if not missing(e) < 0.0), 0.0)
        if not missing(enough) >= 0.0:
            raise RuntimeError(
                f"{self.law.name}: its normal force does not carry {WEIGHT:g} N at any penetration."
            )
        return -float(10.0 ** brentq(missing, -15.0, enough, xtol=1e-15))

    def converging(self) -> tuple[list[float], list[Trajectory]]:
        """Give tolerances or contact steps [s], and their runs with a much finer one at the end."""
        # A law whose default run does not end is not asked for finer ones.
        completed(self._motor_run)
        motor, step, end = self.motor, self.law.default_contact_step, MOTOR_DURATION
        if self.rigid:
            sizes = [step * 2.0**k for k in range(5, -1, -1)]
            return sizes, [run(motor, self.law, end, size) for size in (*sizes, step / 16.0)]
        sizes = [10.0**-k for k in range(2, 7)]
        runs = [run(motor, self.law, end, 2.0 * step, tolerance=size) for size in sizes]
        return sizes, [*runs, run(motor, self.law, end, 0.5 * step, tolerance=1e-10)]


def excuse_of(law: ContactLaw, name: str) -> str:
    """Give the reason why a law declares to break a property, empty where it keeps it."""
    if name == "no_tension" and law.allows_tension:
        return "it allows tension."
    if name == "stick_is_exact" and not law.exact_stick:
        return "its stick is not exact."
    return law.violations.get(name, "")


def claims_of(proof: Proof, *given: Bench, excuse: str = "") -> list[Claim]:
    """Give the claims of a proof, an excuse put to those that it is for: the broken ones, or all.

    A law that is refused, raises, or whose run does not reach its end breaks the proof, excuse or not.
    """
    try:
        claims = list(proof(*given))
    # The kernel is asked without the engine around it, and may raise anything.
    except Exception as error:
        known = isinstance(error, RuntimeError | ValueError | TypeError)
        words = str(error) if known else f"{type(error).__name__}: {error}"
        return [at_most(f"runs that fail: {' '.join(words.split())}", 1, 0)]
    broken = any(not claim.true for claim in claims)
    return [c if broken and c.true else c.excused(excuse) for c in claims]


def check(bench: Bench, name: str) -> list[Claim]:
    """Give the claims of one property."""
    return claims_of(PROPERTIES[name], bench, excuse=excuse_of(bench.law, name))


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


def invariants_of(run: xarray.DataTree) -> Claims:
    """Hold a run, see `contactlab.metrics.read_run`, to what no law can excuse.

    Yields a claim for every one of `contactlab.metrics.INVARIANTS` that the run has the numbers for.
    """
    for key, value in assess(run, INVARIANTS).items():
        metric = INVARIANTS[key]
        if metric.verdict(value) != NOT_APPLICABLE:
            yield at_most(f"{key}: {metric.meaning}", value, metric.bound, metric.units)


def all_claims() -> Iterator[tuple[str, Callable[[], Iterable[Claim]]]]:
    """Give every heading and the function of its claims: the catalogues, then the contract of every law."""
    for proof in (*CLOSED_FORMS.values(), *REFERENCES.values()):
        yield heading(proof), partial(claims_of, proof)
    for name in law_names():
        try:
            law = law_class(name)()
        # A law of another package may be broken, or have a parameter that has no default.
        except Exception as error:
            yield f"The contract of {name} is not checked: {error}", tuple
            continue
        checks = map(partial(check, Bench(law)), PROPERTIES)
        yield f"The contract of {law.name}: {law.equation}", partial(chain.from_iterable, checks)
