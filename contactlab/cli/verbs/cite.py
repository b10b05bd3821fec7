"""Print how contactlab is cited, with the paper whose motor it simulates, as BibTeX.

It is what `CITATION.cff` states, in the version that is installed.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE


def main(arguments: list[str]) -> int:
    """Print the entries, and return the exit status."""
    Parser(__name__, __doc__).read(arguments)
    print(bibtex())
    return COMPLETE


def bibtex() -> str:
    """Return the software, and the works that it asks to be cited beside it, as BibTeX."""
    package = Path(__file__).resolve().parents[2]
    inside = package / "CITATION.cff"
    file = inside if inside.exists() else package.with_name("CITATION.cff")
    stated = yaml.safe_load(file.read_text(encoding="utf-8"))
    year = str(stated["date-released"])[:4]
    works = (
        _entry("inproceedings", work, str(work["year"]), booktitle=work["collection-title"])
        for work in stated["references"]
    )
    software = _entry("software", stated, year, version=stated["version"], license=stated["license"])
    return "\n".join([software, *works])


def _entry(kind: str, work: Mapping[str, Any], year: str, **further: str) -> str:
    names = [
        f"{{{person['name']}}}" if "name" in person else f"{person['family-names']}, {person['given-names']}"
        for person in work["authors"]
    ]
    # Software goes by its name.
    head = work["title"] if kind == "software" else work["authors"][0]["family-names"]
    fields = {"author": " and ".join(names), "title": work["title"], **further, "year": year}
    lines = [f"  {name} = {{{text}}}," for name, text in fields.items()]
    return "\n".join([f"@{kind}{{{head.lower()}{year},", *lines, "}"])
