"""The page that brings a law of one's own to the command is right, in an environment that has its package."""

import os
import re
import sys
from pathlib import Path

import pytest
from page_blocks import blocks
from page_desk import Desk, follow, surroundings
from support.command_line import EXAMPLE, Elsewhere

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/howto/own_law_package.md"


@pytest.mark.long
def test_every_block_runs_in_order_where_the_package_is_installed(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    made = Elsewhere(tmp_path_factory.mktemp("packages"), tmp_path_factory.mktemp("wheels"))
    made.install(made.example())
    known = surroundings(Path(sys.executable))
    paths = [str(made.packages), str(ROOT), known.get("PYTHONPATH", "")]
    known["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
    with Desk(tmp_path, known) as at:
        assert len(list(follow(PAGE, tmp_path, at))) == len(blocks(PAGE.read_text(encoding="utf-8")))


def test_its_entry_points_are_those_of_the_package() -> None:
    (shown,) = re.findall(r"^```toml\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert shown in (EXAMPLE / "pyproject.toml").read_text(encoding="utf-8")
