"""The contract of a contact law, for tests of packages with laws of their own.

A law that is written elsewhere is put to the same tests as the package's own in three lines:

    from contactlab.testing import LawContract

    class TestMyLaw(LawContract):
        law = MyLaw(stiffness=1e9, friction_coefficient=0.3)

`declare` gives a law of bare functions what the contract finds. `invariants_of` holds any recorded run to
what no law can excuse. The command `contactlab verify` prints the contract of every law that is installed, or
the invariants of a run.
"""

from contactlab.testing.claim import Claim, at_least, at_most, close
from contactlab.testing.contract import LawContract, all_claims, declare, invariants_of

__all__ = ["Claim", "LawContract", "all_claims", "at_least", "at_most", "close", "declare", "invariants_of"]
