"""Links, files, scripts, modules and verbs that pages name exist."""

import re
from pathlib import Path

import pytest

from contactlab.cli.verbs import names

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    page
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "paper").glob("*.md")]
    if page.name != "CHANGELOG.md" and "examples" not in page.parts
)
FENCED = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
SCRIPT = re.compile(r"\bpython ((?:experiments|benchmarks|docs/tools|validation)/\w+\.py)")
MODULE = re.compile(r"`((?:contactlab|experiments|benchmarks|docs|tests|conf)/[\w/]*(?:/|\.\w+))`")
COMMAND = re.compile(r"`contactlab (?:-m )?([a-z][\w-]*)[ `]")
SHELL = re.compile(r"^```bash\n(.*?)^```", re.DOTALL | re.MULTILINE)
TAG = re.compile(r"\\tag\{(\d\.\d+[a-z]?)\}")
EQUATION = re.compile(r"\beqs?\. \(?(\d\.\d+[a-z]?)\)?(?:,? (?:and|or|to) \(?(\d\.\d+[a-z]?))?", re.I)
LINE = re.compile(r"^contactlab (?:-m )?([a-z][\w-]*)(?= |$)", re.MULTILINE)


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_what_a_page_refers_to_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    links = [link for link in LINK.findall(FENCED.sub("", text)) if "://" not in link and ":" not in link]
    missing = [link for link in links if not (page.parent / link).exists()]
    missing += [path for path in SCRIPT.findall(text) + MODULE.findall(text) if not (ROOT / path).exists()]
    verbs = COMMAND.findall(text) + LINE.findall("".join(SHELL.findall(text)))
    missing += [verb for verb in verbs if verb not in {*names(), "simulate", "help"}]
    assert not missing


def test_equations_that_comments_of_the_engine_name_stand_in_the_theory() -> None:
    tags = {tag for page in (ROOT / "docs/theory").glob("*.md") for tag in TAG.findall(page.read_text())}
    sources = (re.sub(r"\s+#?\s*", " ", file.read_text()) for file in ROOT.glob("contactlab/engine/*.py"))
    named = {number for source in sources for pair in EQUATION.findall(source) for number in pair} - {""}
    assert len(named) >= 40
    assert not named - tags
