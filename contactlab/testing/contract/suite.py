"""The contract as tests: subclass `LawContract`, name a law, and pytest runs every property."""

from collections.abc import Callable
from functools import lru_cache
from typing import ClassVar

from contactlab.laws import ContactLaw
from contactlab.motor.motor import Motor
from contactlab.testing.contract.bench import Bench, paper_motor
from contactlab.testing.contract.properties import check


@lru_cache(maxsize=8)
def bench_of(law: ContactLaw, make_motor: Callable[[], Motor]) -> Bench:
    """One bench for all tests of a law."""
    return Bench(law, make_motor)


class LawContract:
    """The tests of one contact law.

        class TestMyLaw(LawContract):
            law = MyLaw(stiffness=1e9, friction_coefficient=0.3)

    Where the law needs another motor than the paper's, the class has a static `make_motor` as well.
    """

    law: ClassVar[ContactLaw]

    @staticmethod
    def make_motor() -> Motor:
        """The paper's motor."""
        return paper_motor()

    def assert_property(self, name: str) -> None:
        """Fail with the sentences of all claims that are not as they should be."""
        claims = check(bench_of(self.law, self.make_motor), name)
        failed = [str(claim) for claim in claims if not claim.holds]
        assert not failed, "\n".join([f"{self.law.name}, {name}:", *failed])

    def test_declares_its_parameters(self) -> None:
        """Every field has a symbol, a unit and a range; name, equation and source are given."""
        self.assert_property("declares_its_parameters")

    def test_declares_what_it_breaks(self) -> None:
        """A declared violation names a property and gives a reason."""
        self.assert_property("declares_what_it_breaks")

    def test_kernel_is_consistent(self) -> None:
        """Force and stored energy, or impulse and velocity, agree; no state is answered against the law."""
        self.assert_property("kernel_is_consistent")

    def test_parts_keep_apart(self) -> None:
        """The parts of a composed law do in it what they do alone."""
        self.assert_property("parts_keep_apart")

    def test_no_force_when_open(self) -> None:
        """Between contacts there is no force at all."""
        self.assert_property("no_force_when_open")

    def test_no_tension(self) -> None:
        """The contact never pulls."""
        self.assert_property("no_tension")

    def test_inside_the_cone(self) -> None:
        """Friction stays inside its cone in every step."""
        self.assert_property("inside_the_cone")

    def test_friction_opposes_slip(self) -> None:
        """Friction never does positive work on the slip."""
        self.assert_property("friction_opposes_slip")

    def test_dissipates(self) -> None:
        """No contact gives energy."""
        self.assert_property("dissipates")

    def test_stick_is_exact(self) -> None:
        """What friction can hold does not move."""
        self.assert_property("stick_is_exact")

    def test_ledger_closes(self) -> None:
        """Every joule is accounted for."""
        self.assert_property("ledger_closes")

    def test_impulse_is_momentum(self) -> None:
        """Recorded impulses are the changes of momentum, a contact each and in all."""
        self.assert_property("impulse_is_momentum")

    def test_converges(self) -> None:
        """The error falls at least with the declared order."""
        self.assert_property("converges")

    def test_repeats_bit_for_bit(self) -> None:
        """The same run twice is the same bits."""
        self.assert_property("repeats_bit_for_bit")

    def test_calls_leave_no_trace(self) -> None:
        """Asking the law more often changes no bit: only a committed step is remembered."""
        self.assert_property("calls_leave_no_trace")

    def test_mirrors(self) -> None:
        """The mirrored motor runs mirrored."""
        self.assert_property("mirrors")
