"""The page on installing has every package of a user's install with a reason, and every extra."""

import re
import tomllib
from importlib.metadata import requires
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def rows_of(heading: str) -> list[list[str]]:
    """The cells of the table below a heading, without its head."""
    section = PAGE.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def needed(direct: list[str]) -> dict[str, set[str]]:
    """All packages that some requirements bring here, by name, with those that ask for them."""
    found: dict[str, set[str]] = {}
    waiting = [("contactlab", Requirement(text)) for text in direct]
    while waiting:
        owner, requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        new = name not in found
        found.setdefault(name, set()).add(owner)
        for text in (requires(name) or []) if new or requirement.extras else []:
            below = Requirement(text)
            extras = ("", *requirement.extras)
            if not below.marker or any(below.marker.evaluate({"extra": extra}) for extra in extras):
                waiting.append((name, below))
    return found


def test_every_package_of_a_users_install_has_a_reason_and_no_other_has(project: dict[str, Any]) -> None:
    rows = rows_of("What is installed, and why")
    reasons = {canonicalize_name(name): reason for name, _, reason in rows}
    assert len(reasons) == len(rows)
    assert reasons.keys() == needed(project["dependencies"]).keys()


def test_a_reason_names_who_needs_the_package(project: dict[str, Any]) -> None:
    direct = {canonicalize_name(Requirement(text).name) for text in project["dependencies"]}
    short = {"hydra": "hydra-core"}
    asking = needed(project["dependencies"])
    for name, size, reason in rows_of("What is installed, and why"):
        assert re.fullmatch(r"\d+|< 1", size), name
        told = {canonicalize_name(word) for word in re.findall(r"[\w-]*\w", reason)}
        told = {short.get(word, word) for word in told}
        assert told & asking[canonicalize_name(name)], f"{name}: {reason}"
        assert ("contactlab" in told) == (canonicalize_name(name) in direct), f"{name}: {reason}"


def test_every_extra_is_on_the_page(project: dict[str, Any]) -> None:
    extras = {name.strip("`") for name, *_ in rows_of("Extras")}
    assert extras == project["optional-dependencies"].keys()
