"""README is short, shows what it names, and its two commands are those that every change runs.

Its other blocks run in `test_blocks`.
"""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_readme_is_read_in_minutes() -> None:
    assert len(README.splitlines()) <= 150


def test_the_commands_that_install_are_run_for_every_change() -> None:
    steps = (ROOT / ".ci/run").read_text(encoding="utf-8")
    installing = re.findall(
        r"^<!-- not run: `.ci/run` runs it -->\n```bash\n(.*)\n```$", README, re.MULTILINE
    )
    assert len(installing) == 2
    assert all(command in steps for command in installing)


def test_the_pictures_and_pages_of_readme_are_there_and_small() -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", README)
    own = [ROOT / link for link in links if "://" not in link]
    assert len(own) >= 10
    assert not [path for path in own if not path.is_file()]
    pictures = [path for path in own if path.suffix in {".png", ".gif"}]
    assert {path.suffix for path in pictures} == {".png", ".gif"}
    assert sum(path.stat().st_size for path in pictures) < 1_500_000
