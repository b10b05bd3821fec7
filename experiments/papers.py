"""Write numbers, sentences, tables and figures of the papers, paper/, from docs/results.

    python experiments/papers.py

A paper is a page of claims, as those of the documentation are (results_pages.py): what one changed number
changes in text, tables and figures changes together. Where a sentence of a paper has fallen, or a section of
results is missing, nothing is written; the exit status is 1, and it is said what. Blanks that only the
authors can fill are counted.
"""

import re
import sys
from typing import Final

import matplotlib.pyplot as plt
from claims import PAPERS
from contrast_figures import FIGURES
from dependencies import ROOT
from law_practice import missed
from recorded_numbers import results
from results_pages import Page

from contactlab.studies.report import styled

NEEDED: Final = ("law_contrasts", "law_practice")
"""Sections of the experiments from which figures are drawn."""

LAWS: Final = "paper/laws"

BLANK: Final = re.compile(r"\[BLANK \d+")


def main() -> int:
    """Write the papers and return the exit status."""
    faults = [
        f"docs/results/experiments.json has no section {name}, which {LAWS} needs: "
        f"python experiments/remake.py {name} --{name} FOLDER, from a run of experiments/{name}.py."
        for name in NEEDED
        if name not in results("experiments")
    ]
    pages = [] if faults else [Page(name) for name in PAPERS]
    faults += [
        fault for page in pages for each in (page.fallen(), page.fill(), page.bare()) for fault in each
    ]
    if faults:
        print(*faults, sep="\n", file=sys.stderr)
        return 1
    for page in pages:
        (ROOT / page.name).write_text(page.text, encoding="utf-8")
        print(f"{page.name}: {len(BLANK.findall(page.text))} blanks for its authors")
    for section, suffix, draw in (
        *(("law_contrasts", suffix, draw) for suffix, draw in FIGURES.items()),
        ("law_practice", "_practice", missed),
    ):
        with styled():
            figure = draw(results("experiments")[section]["numbers"])
            # The same numbers are the same bytes.
            figure.savefig(ROOT / LAWS / f"contrasts{suffix}.pdf", metadata={"CreationDate": None})
        plt.close(figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
