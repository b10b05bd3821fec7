"""Whatever a page calls a command is one: verbs, options, keys and scripts of every line are there.

Blocks that run are run elsewhere; this takes apart what stands in a sentence, and what is marked as not run.
"""

import re
import shlex
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import made_verbs
import pytest
from page_blocks import blocks
from page_desk import Desk, follow, surroundings

from contactlab.cli.arguments import FLAGS, INSTEAD, VERBS
from contactlab.config.composition import options_of
from contactlab.config.options import groups, known_keys
from contactlab.orbits.basins import COORDINATES

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("docs", "paper", "tests", ".github")
PAGES = sorted(
    page
    for page in [*ROOT.glob("*.md"), *(page for name in FOLDERS for page in (ROOT / name).rglob("*.md"))]
    # What was, is told in the words of that time; what is made at build has its commands in its scripts.
    if page.name != "CHANGELOG.md" and not page.is_relative_to(ROOT / "docs/examples")
)

MARK = r"(?: *<!-- not run: [^>\n]+ -->\n)"
FENCED = re.compile(rf"({MARK})?^( *)```(\S*).*?\n(.*?)^\2```", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"(?<!`)`(contactlab|python)\s+([^`]+)`(?!`)")
COMMAND = re.compile(r"^(?:.*(?:&&|\|) *)?(contactlab|python) +(.+)$", re.MULTILINE)
INDENTED = re.compile(
    r"^(?: {4}|\t)\s*(?:\$ *)?(?:contactlab|python3?|pip|pytest|nox|git|ruff)\b.*", re.MULTILINE
)
PLACEHOLDER = re.compile(r"[\[(]?(?:[A-Z][A-Z0-9_]*|\.\.\.)(?:[=./,:].*|\.{2,3})?[\])]?|\[.*\]|.*\.\.\.")


def commands(text: str) -> Iterator[list[str]]:
    """The commands of a page, in sentences and in blocks of a shell, split into words."""
    lines = [(each[1], each[2]) for each in INLINE.finditer(FENCED.sub("", text))]
    for block in FENCED.finditer(text):
        if block[3] == "bash":
            lines += COMMAND.findall(re.sub(r"\\\n", " ", block[4]))
    for program, rest in lines:
        try:
            words = shlex.split(f"{program} {rest}", comments=True)
        except ValueError as error:
            pytest.fail(f"{program} {rest} cannot be read: {error}")
        # What follows on a failure shows what is refused, and runs.
        if "||" in words:
            continue
        ends = (i for i, word in enumerate(words) if word in {"&&", "|", ">", ";"})
        yield words[: next(ends, None)]


def faults_of(words: list[str], text: str) -> list[str]:
    """What is wrong with a command of a page."""
    program, *rest = words
    if program == "python":
        return _faults_of_script(rest)
    verb = rest[0] if rest else ""
    if verb in VERBS:
        known = set(re.findall(r"--?[a-z][\w-]*", made_verbs.help_of(verb)))
        rest = rest[1:]
    elif verb == "help":
        return [
            f"no verb {word}" for word in rest[1:] if word not in VERBS and not PLACEHOLDER.fullmatch(word)
        ]
    else:
        known = {*FLAGS}
        if verb and not verb.startswith("-") and "=" not in verb and not PLACEHOLDER.fullmatch(verb):
            return [f"no verb {verb}"]
    found = []
    for word in rest:
        if word.startswith("-") and not re.match(r"-[\d.]", word):
            name = word.partition("=")[0].rstrip("]")
            found += [] if name in known else [f"no option {name}"]
        elif "=" in word and not PLACEHOLDER.fullmatch(word):
            found += _faults_of_argument(word, text)
    return found


def _faults_of_argument(word: str, text: str) -> list[str]:
    key, _, value = word.lstrip("+~").partition("=")
    if key.split(".")[0].split("/")[0] == "hydra":
        return []
    if "." not in key and (options := _options(key)):
        asked = value.strip("'\"").split(",") if re.fullmatch(r"[\w,]+", value) else []
        # A law of the page's own is an entry point that the page shows.
        return [
            f"no option {key}={one}"
            for one in asked
            if one not in options and not one.isupper() and f'{one} = "' not in text
        ]
    # So is a number of it one that the page shows among its parameters.
    if key.startswith("law.") and f"parameter {key.removeprefix('law.')}: " in text:
        return []
    return [] if key in known_keys() or key in COORDINATES else [f"no key {key}"]


@cache
def _options(group: str) -> frozenset[str]:
    return frozenset([*groups().get(group, ()), *options_of(group)])


def _faults_of_script(words: list[str]) -> list[str]:
    if not words[0].startswith(("experiments/", "benchmarks/", "docs/tools/", "tests/tools/")):
        return []
    script = ROOT / words[0]
    if PLACEHOLDER.fullmatch(script.stem):
        return []
    if not script.is_file():
        return [f"no script {words[0]}"]
    own = script.read_text(encoding="utf-8")
    conf = ROOT / "conf/experiment" / f"{script.stem}.yaml"
    own += conf.read_text(encoding="utf-8") if conf.is_file() else ""
    found = []
    for word in words[1:]:
        key = word.strip("[]").partition("=")[0]
        if "=" in word and not PLACEHOLDER.fullmatch(word) and not re.search(rf"\b{re.escape(key)}\b", own):
            found += _faults_of_argument(word.strip("[]"), "")
        elif word.startswith("--") and key not in own:
            found.append(f"no option {key}")
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_command_of_a_page_has_a_verb_options_and_keys_that_there_are(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    wrong = {shlex.join(words): faults for words in commands(text) if (faults := faults_of(words, text))}
    assert wrong == {}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_what_can_be_pasted_is_fenced_at_the_margin_and_called_what_it_is(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert [each[0] for each in INDENTED.finditer(FENCED.sub("", text))] == []
    for mark, margin, language, code in FENCED.findall(text):
        assert language not in {"sh", "shell", "console", "zsh", "py", "pycon"}, code
        # What runs blocks finds them at the margin.
        assert mark or not (margin and language in {"bash", "python"}), code
        # What has no language is no command.
        assert language or not COMMAND.search(code), code


def test_a_block_outside_of_docs_runs_in_a_test_or_is_marked() -> None:
    tests = list((ROOT / "tests").rglob("test_*.py"))
    for page in PAGES:
        if not page.is_relative_to(ROOT / "docs") and blocks(page.read_text(encoding="utf-8")):
            assert any(page.name in path.read_text(encoding="utf-8") for path in tests), page


@pytest.mark.long
def test_what_a_contributor_is_told_to_run_passes_in_the_checkout() -> None:
    with Desk(ROOT, surroundings(Path(sys.executable))) as at:
        page = ROOT / "CONTRIBUTING.md"
        assert len(list(follow(page, ROOT, at))) == len(blocks(page.read_text(encoding="utf-8"))) > 0


@pytest.mark.parametrize(
    ("command", "fault"),
    [
        ("contactlab stedy", "no verb stedy"),
        ("contactlab steady --brakes 1", "no option --brakes"),
        ("contactlab law=hertz", "no option law=hertz"),
        ("contactlab contact.gap=1", "no key contact.gap"),
        ("contactlab -m law=newton,newtn", "no option law=newtn"),
        ("contactlab --multi", "no option --multi"),
        ("contactlab help stedy", "no verb stedy"),
        ("contactlab validate impacts.csv law=newtons", "no option law=newtons"),
        ("python experiments/nothing.py", "no script experiments/nothing.py"),
        ("python experiments/optimise_motor.py objektive=velocity", "no key objektive"),
    ],
)
def test_a_command_that_is_none_is_found(command: str, fault: str) -> None:
    assert [faults_of(words, "") for words in commands(f"So `{command}` does.")] == [[fault]]
    marked = f"<!-- not run: it takes long -->\n```bash\ncd x && {command}   # so\n```\n"
    assert [faults_of(words, "") for words in commands(marked)] == [[fault]]


@pytest.mark.parametrize(
    "command",
    [
        "contactlab [GROUP=OPTION ...] [KEY=VALUE ...]",
        "contactlab laws NAME",
        "contactlab -m ... sweep.keep=metrics",
        "contactlab steady --brake 1e-3 law=newton",
        "contactlab law=composed law/normal=linear law.normal.stiffness=2e7",
        "contactlab --help",
        "python experiments/optimise_motor.py objective=velocity law=lagrange_stick",
    ],
)
def test_a_command_that_there_is_passes(command: str) -> None:
    assert [faults_of(words, "") for words in commands(f"So `{command}` does.")] == [[]]


def test_no_word_of_others_for_a_verb_is_a_verb() -> None:
    assert not INSTEAD.keys() & VERBS.keys()
