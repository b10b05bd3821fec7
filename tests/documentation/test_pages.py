"""Pages lead where they say, in a repository browser as on the site, and name what there is."""

import re
import tomllib
from math import log2, log10
from pathlib import Path

import pytest

from contactlab.engine.collocation import AGREEMENT
from contactlab.engine.compliant import GROWTH
from contactlab.engine.oscillator import REACH
from contactlab.engine.plant import NEARLY_RESONANT
from contactlab.engine.rootfinding import TIME_DIGIT
from contactlab.engine.state import NODES
from contactlab.metrics import METRICS
from contactlab.metrics.convergence import SLOWEST
from contactlab.orbits.arrival import FORETOLD
from contactlab.orbits.bifurcations import LOCATED
from contactlab.orbits.shooting import CLOSED, STEP
from contactlab.settling.verdict import SHARE

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "examples" not in path.relative_to(DOCS).parts)
THEORY = sorted((DOCS / "theory").glob("*.md"))

FENCED = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")
TAG = re.compile(r"\\tag\{([\d.]+)\}")
REFERENCE = re.compile(r"\((\d\.\d+)\)")
ROOM = re.compile(r"`((?:contactlab/)?[a-z_]+(?:/[a-z_]+)*(?:/|\.py))`")


def text_of(page: Path) -> str:
    """A page without its blocks of code."""
    return FENCED.sub("", page.read_text(encoding="utf-8"))


def anchors_of(page: Path) -> set[str]:
    """What headings of a page are called in links."""
    heads = re.findall(r"^#+ (.+)$", text_of(page), re.MULTILINE)
    plain = (re.sub(r"[^\w\- ]", "", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", head.lower())) for head in heads)
    return {head.strip().replace(" ", "-") for head in plain}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_every_link_of_a_page_resolves_in_a_repository_browser(page: Path) -> None:
    for link in LINK.findall(text_of(page)):
        if "://" not in link:
            name, _, anchor = link.partition("#")
            target = page.parent / name if name else page
            assert target.exists(), f"{link} leads nowhere."
            # What is made at build has its headings on the site alone.
            if anchor and "<!-- made:" not in target.read_text(encoding="utf-8"):
                assert anchor in anchors_of(target), f"{link} is no heading."


def test_every_page_is_in_a_table_of_contents() -> None:
    listed = {DOCS / "index.md"}
    for page in PAGES:
        for table in re.findall(r"^```\{toctree\}\n(.*?)^```", page.read_text("utf-8"), re.DOTALL | re.M):
            names = re.findall(r"^(?:.*<)?([\w/]+\.md)>?$", table, re.MULTILINE)
            listed |= {(page.parent / name).resolve() for name in names}
    assert set(PAGES) == listed


def test_equations_are_numbered_in_their_order_and_references_have_one() -> None:
    numbers: list[str] = []
    for page in THEORY:
        of_page = TAG.findall(text_of(page))
        chapter = of_page[0].partition(".")[0] if of_page else ""
        assert of_page == [f"{chapter}.{i}" for i in range(1, len(of_page) + 1)], page.name
        numbers += of_page
    assert len(numbers) == len(set(numbers)) >= 60
    for page in THEORY:
        if page.name != "index.md":
            referred = set(REFERENCE.findall(TAG.sub("", text_of(page))))
            assert referred <= set(numbers), f"{page.name}: {sorted(referred - set(numbers))}"


def test_the_rooms_that_the_theory_names_are_there() -> None:
    named = {(page.name, room) for page in THEORY for room in ROOM.findall(text_of(page))}
    assert len(named) >= 15
    files = {path.relative_to(ROOT).as_posix() for path in (ROOT / "contactlab").rglob("*.py")}
    folders = {f"{path.relative_to(ROOT).as_posix()}/" for path in (ROOT / "contactlab").rglob("*/")}
    for page, room in sorted(named):
        assert any(f"/{each}".endswith(f"/{room}") for each in files | folders), f"{page}: {room}"


def test_the_table_of_rooms_has_every_folder_and_module_once_and_in_the_order_of_imports() -> None:
    page = (DOCS / "architecture.md").read_text(encoding="utf-8")
    rooms = [room for row in re.findall(r"^\| (`.+?`) \|", page, re.MULTILINE) for room in ROOM.findall(row)]
    package = ROOT / "contactlab"
    found = {f"contactlab/{path.name}" for path in package.glob("*.py")}
    found |= {f"contactlab/{path.parent.name}/" for path in package.glob("*/__init__.py")}
    named = [room for room in rooms if room.startswith("contactlab/")]
    assert sorted(named) == sorted(found)
    assert all((ROOT / room).exists() for room in rooms)
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = contract["tool"]["importlinter"]["contracts"][0]["layers"]
    level = {name.strip(): i for i, layer in enumerate(layers) for name in layer.split("|")}
    names = [Path(room).stem for room in named]
    levels = [level[name] for name in names if name != "__init__"]
    assert levels == sorted(levels)


def power(value: float) -> str:
    """A power of ten as the pages write it."""
    return f"10^{{{round(log10(value))}}}"


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("flight.md", f"\\le 1/{round(1.0 / REACH)}$"),
        ("flight.md", f"< {power(NEARLY_RESONANT)} (k + \\omega^2)"),
        ("flight.md", f"to ${power(TIME_DIGIT)}$ of the step"),
        ("compliant.md", f"$0 < c_1 < \\dots < c_{NODES} = 1$"),
        ("compliant.md", f"of order $2 \\cdot {NODES} - 1 = {2 * NODES - 1}$"),
        ("compliant.md", f"a relative change of ${power(AGREEMENT)}$"),
        ("compliant.md", f"$h^{round(log2(GROWTH))}$"),
        ("energy.md", f"\\le {METRICS['energy_residual'].bound:g}\\,"),
        ("steady.md", f"\\le {power(CLOSED)} |z|$"),
        ("steady.md", f"central differences of ${power(STEP)} |z|$"),
        ("steady.md", f"\\le {FORETOLD:g}\\, \\left| A^m"),
        ("steady.md", f"\\ {SLOWEST:g} \\right)"),
        ("steady.md", f"located to ${power(LOCATED)}$"),
        ("steady.md", f"\\le {SHARE:g} , \\tag"),
    ],
)
def test_the_numbers_of_the_theory_are_those_of_the_code(page: str, words: str) -> None:
    text = " ".join((DOCS / "theory" / page).read_text(encoding="utf-8").split())
    assert words in text
