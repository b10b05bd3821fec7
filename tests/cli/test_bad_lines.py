"""Bad command lines of every verb: refused in sentences, nothing is left, and a good line follows each."""

import re

import pytest
from support.command_line import Command, left_behind

from contactlab.cli.verbs import modules, names

WORDS = (
    *("=", "=5", "law=", "law=nosuch", "law=newton,", "law.restitution=2", "nosuch=1", "drive.phase=[1"),
    *("contact.clearance=nan", "contact.clearance=1 s", "${oc.env:HOME}", "drive.phase=${nosuch}", "-m"),
    *("workers=0", "workers=x", "output=", "nowhere.nc", "hydra.nosuch=1", "~law", "+law=newton", "'"),
    *("law={name: newton}", "\N{GREEK SMALL LETTER MU}", "solver.changes=[1]", "contact.clearance=1 um..x"),
    *("law@x=newton", "--nosuch"),
)
"""Words that no verb takes, or that it lacks something else beside."""

STUDIES = sorted({*names()} - {*modules()})
OTHERS = sorted({*modules()} - {"verify", "warm-up"})
"""The verbs that take arguments."""


@pytest.mark.parametrize("verb", ["", *OTHERS, *STUDIES])
def test_a_bad_word_is_refused_in_sentences(command: Command, verb: str) -> None:
    # What ends every line: without, some would be good and compute for long.
    fault = "contact.tip_length=-1" if verb not in OTHERS else "--faulty"
    # Others are composed as a run's: some words are enough.
    for word in WORDS if verb in ("", "steady") else WORDS[::6]:
        status, out, err = command(*[verb][: bool(verb)], word, fault)
        assert (status, out) == (2, ""), (word, status, out)
        assert err.strip(), word
        assert not re.search(r"Traceback|Error:|object at 0x", err), (word, err)
        assert left_behind() == [], word
    status, out, err = command("laws", "newton")
    assert (status, err) == (0, "")
    assert out.startswith("newton\n")
