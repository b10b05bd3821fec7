"""Laws of the literature from a package of their own: as published, and with their contracts kept."""

import tomllib
from importlib import import_module
from pathlib import Path

import published_numbers
import pytest
from compliant_laws import Tsuji
from frictions import SmoothCone
from rigid_laws import TurningImpact, ViscoelasticImpact

from contactlab.laws import Composed
from contactlab.testing import LawContract
from contactlab.testing.claim import proofs_of

PROJECT = tomllib.loads(Path(__file__).with_name("pyproject.toml").read_text(encoding="utf-8"))
ENTRIES = {name: at for group in PROJECT["project"]["entry-points"].values() for name, at in group.items()}
NUMBERS = proofs_of(published_numbers)


class TestTsuji(LawContract):
    law = Tsuji()


@pytest.mark.long
class TestSmoothCone(LawContract):
    law = Composed(friction=SmoothCone())


@pytest.mark.long
class TestTurningImpact(LawContract):
    law = TurningImpact()


class TestViscoelasticImpact(LawContract):
    law = ViscoelasticImpact()


@pytest.mark.parametrize("name", NUMBERS)
def test_it_is_as_published(name):
    failed = [str(claim) for claim in NUMBERS[name]() if not claim.holds]
    assert not failed, "\n".join(failed)


def test_every_law_has_a_number_and_is_what_its_entry_names():
    assert set(ENTRIES) == set(NUMBERS)
    for name, entry in ENTRIES.items():
        module, _, owner = entry.partition(":")
        assert getattr(import_module(module), owner).name == name
