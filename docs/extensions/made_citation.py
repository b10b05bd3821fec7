"""How to cite: CITATION.cff as BibTeX."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import yaml

CITATION: Final = Path(__file__).resolve().parents[2] / "CITATION.cff"


def citation() -> str:
    """Return the software, and the works that it asks to be cited beside it, as BibTeX in Markdown."""
    stated = yaml.safe_load(CITATION.read_text(encoding="utf-8"))
    year = str(stated["date-released"])[:4]
    entries = [
        _entry("software", stated, year, version=stated["version"], license=stated["license"]),
        *(
            _entry("inproceedings", work, str(work["year"]), booktitle=work["collection-title"])
            for work in stated["references"]
        ),
    ]
    return "\n".join(["```text", *entries, "```"])


def _entry(kind: str, work: Mapping[str, Any], year: str, **further: str) -> str:
    names = [
        f"{{{person['name']}}}" if "name" in person else f"{person['family-names']}, {person['given-names']}"
        for person in work["authors"]
    ]
    # Software goes by its name.
    head = work["title"] if kind == "software" else work["authors"][0]["family-names"]
    key = f"{head.lower()}{year}"
    fields = {"author": " and ".join(names), "title": work["title"], **further, "year": year}
    return "\n".join([f"@{kind}{{{key},", *(f"  {name} = {{{text}}}," for name, text in fields.items()), "}"])
