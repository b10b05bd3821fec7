"""docs/writing_laws.md is right: every block runs, and every law of it keeps its contract."""

from contextlib import chdir
from typing import Any

import pytest
from support.pages import DOCS, blocks, names_of

from contactlab.laws import Composed, ContactLaw, Friction, NormalForce
from contactlab.testing.contract import PROPERTIES, check
from contactlab.testing.plants import Bench

PAGE = DOCS / "writing_laws.md"
QUICK = ("declares_its_parameters", "kernel_is_consistent", "declares_what_it_breaks")


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What stands in the namespace of the page at its end, which may write files."""
    with chdir(tmp_path_factory.mktemp("guide")):
        return names_of(PAGE)


def laws_of(names: dict[str, Any]) -> dict[str, ContactLaw]:
    """The laws of the page, parts in a composed one."""
    result: dict[str, ContactLaw] = {}
    for word, made in names.items():
        if isinstance(made, type) and made.__module__ == "writing_laws":
            if issubclass(made, ContactLaw):
                result[word] = made()
            elif issubclass(made, NormalForce | Friction):
                result[word] = Composed(**{made.family: made()})
    return result


def test_every_block_of_the_guide_runs_in_order(names: dict[str, Any]) -> None:
    assert len(blocks(PAGE)) >= 15
    assert sum(block.count("assert ") for _, block in blocks(PAGE)) >= 14
    assert len(laws_of(names)) == 9


@pytest.mark.parametrize(
    "property_name", [p if p in QUICK else pytest.param(p, marks=pytest.mark.long) for p in PROPERTIES]
)
def test_the_laws_of_the_guide_keep_their_contract(names: dict[str, Any], property_name: str) -> None:
    for law in laws_of(names).values():
        failed = [str(claim) for claim in check(Bench(law), property_name) if not claim.holds]
        assert not failed, "\n".join([law.title, *failed])
