"""Every law is what is published of it: closed forms, printed numbers, and where it leaves them."""

import pytest

from contactlab.laws import LAWS, PARTS
from contactlab.testing.claim import Proof
from contactlab.testing.published import SHARED, published

PROOFS = {f"{law}-{name}": proof for law, proofs in published().items() for name, proof in proofs.items()}


@pytest.mark.parametrize("proof", PROOFS.values(), ids=list(PROOFS))
def test_it_is_as_published(proof: Proof) -> None:
    claims = list(proof())
    failed = [str(claim) for claim in claims if not claim.holds]
    assert claims
    assert not failed, "\n".join(failed)


def test_every_module_is_of_a_law_and_proves_something() -> None:
    parts = {f"{family}_{name}" for family, table in PARTS.items() for name in table}
    text = {*LAWS, *parts, *(name for table in PARTS.values() for name in table)}
    assert {*published(), *SHARED} <= text
    assert all(published().values())
