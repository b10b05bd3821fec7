"""Every verb is in every list: help, completion, suggestions and reference."""

from pathlib import Path

import made_verbs
import pytest
import yaml
from support.command_line import Command, Elsewhere

from contactlab.cli import verbs
from contactlab.cli.completion import candidates
from contactlab.studies.docstrings import question_in
from contactlab.studies.registry import OWN, SIMULATE, question_of, study_class

PROBED = '''
from contactlab.studies import Study

class Probed(Study):
    """What is measured
    without a motor?

    A module that cannot be imported is no fault of a list.
    """

raise RuntimeError("imported")
'''


@pytest.mark.parametrize("verb", verbs.names())
def test_a_verb_is_completed_meant_and_in_the_reference(verb: str, command: Command) -> None:
    assert {verb} <= {*candidates(verb[:2])} & {*candidates(f"help {verb[:2]}")}
    status, _, err = command(f"{verb.replace('-', '_')}_")
    assert status == 2
    assert f" {verb}?" in err
    reference = made_verbs.verbs().partition(f"## `contactlab {verb}`\n\n{verbs.purpose_of(verb)}\n")
    assert reference[2].lstrip("\n").startswith(f"```text\nusage: contactlab {verb}")


def test_both_helps_list_every_verb_with_what_it_does(command: Command) -> None:
    purposes = {verb: verbs.purpose_of(verb) for verb in verbs.names()}
    assert all(purposes.values())
    for flag in ("help", "--help"):
        status, out, _ = command(flag)
        assert status == 0
        listed = {tuple(line.split(maxsplit=1)) for line in out.splitlines()}
        assert {*purposes.items()} <= listed


@pytest.mark.parametrize("name", sorted({*OWN} - {SIMULATE}))
def test_the_question_of_a_study_is_that_of_its_class(name: str) -> None:
    assert question_of(name) == question_in(study_class(name).__doc__)


def test_the_verb_of_another_package_is_listed_without_an_import(tmp_path: Path) -> None:
    here = Elsewhere(tmp_path / "packages", tmp_path)
    groups = {"contactlab.studies": {"probed": "probed:Probed", "missing": "nowhere:Missing"}}
    here.install(here.wheel("other", "1.0", {}, {"probed": PROBED}, groups))
    status, out, err = here.command("help")
    assert (status, err) == (0, "")
    assert "  probed        What is measured without a motor?\n" in out
    assert "  missing       " in out


def test_several_laws_and_parts_are_described_at_once(command: Command) -> None:
    status, out, _ = command("laws", "iwan", "newton")
    assert status == 0
    assert [line for line in out.splitlines() if line and line[0] != " "] == ["newton", "friction/iwan"]


def test_the_version_and_the_citation_are_those_of_the_files(command: Command) -> None:
    stated = yaml.safe_load(Path(__file__).parents[2].joinpath("CITATION.cff").read_text(encoding="utf-8"))
    status, out, _ = command("version")
    assert (status, out.split()[:2]) == (0, ["contactlab", stated["version"]])
    status, out, _ = command("cite")
    assert status == 0
    for text in (stated["title"], stated["version"], *(work["title"] for work in stated["references"])):
        assert f"{{{text}}}" in out
