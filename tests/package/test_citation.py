"""What several files say of the project is the same in all, and the workflow runs what `.ci/run` says."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]


def read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads(read("pyproject.toml"))["project"]
    return found


def test_the_files_for_citation_agree_with_the_package(project: dict[str, Any]) -> None:
    cited, meta = yaml.safe_load(read("CITATION.cff")), json.loads(read("codemeta.json"))
    authors = [author["name"] for author in project["authors"]]
    assert [author["name"] for author in cited["authors"]] == authors
    assert [author["name"] for author in meta["author"]] == authors
    for name, key in (("title", "name"), ("version", "version"), ("keywords", "keywords")):
        assert cited[name] == project[key] == meta[key]
    assert cited["license"] == project["license"] == meta["license"].rpartition("/")[2]
    assert meta["description"] == project["description"]
    assert meta["runtimePlatform"] == f"Python {project['requires-python']}"
    locked = {each["name"]: each.get("version") for each in tomllib.loads(read("uv.lock"))["package"]}
    assert locked["contactlab"] == project["version"]
    paper = cited["references"][0]
    assert meta["referencePublication"]["name"] == paper["title"]
    assert [a["familyName"] for a in meta["referencePublication"]["author"]] == [
        a["family-names"] for a in paper["authors"]
    ]


def test_where_the_project_is_hosted_is_said_by_every_file_or_by_none(project: dict[str, Any]) -> None:
    cited, meta = yaml.safe_load(read("CITATION.cff")), json.loads(read("codemeta.json"))
    addresses = project.get("urls", {})
    assert addresses.keys() <= {"Repository", "Issues", "Documentation"}
    assert cited.get("repository-code") == meta.get("codeRepository") == addresses.get("Repository")
    assert meta.get("issueTracker") == addresses.get("Issues")
    assert cited.get("url") == meta.get("softwareHelp") == addresses.get("Documentation")
    dates = dict(re.findall(r"^## \[(.+?)\] - (\S+)$", read("CHANGELOG.md"), re.M))
    assert str(cited["date-released"]) == meta["dateModified"] == dates[project["version"]]


def test_the_changelog_has_this_version_and_those_before_it_in_order(project: dict[str, Any]) -> None:
    first, *versions = re.findall(r"^## \[(.+?)\](?: - (\d{4}-\d\d-\d\d))?$", read("CHANGELOG.md"), re.M)
    assert first == ("Unreleased", "")
    numbers = [tuple(map(int, version.split("."))) for version, _ in versions]
    assert versions[0][0] == project["version"]
    assert numbers == sorted(numbers, reverse=True)
    assert all(date for _, date in versions)


def test_every_python_that_is_promised_is_tried(project: dict[str, Any]) -> None:
    promised = [word.rpartition(" ")[2] for word in project["classifiers"] if "Python :: 3." in word]
    workflow = yaml.safe_load(read(".github/workflows/ci.yml"))["jobs"]["run"]
    assert workflow["strategy"]["matrix"]["python"] == promised
    assert [step["run"] for step in workflow["steps"] if "run" in step][-1] == ".ci/run"
    quoted = ", ".join(f'"{version}"' for version in promised)
    assert f"PYTHONS = ({quoted})" in read("noxfile.py")
    assert f"for version in {' '.join(promised)}; do" in read(".ci/run")


def test_the_paper_cites_what_it_lists_and_lists_what_it_cites(project: dict[str, Any]) -> None:
    head, text = read("paper/paper.md").removeprefix("---\n").split("\n---\n", 1)
    listed = re.findall(r"^@\w+\{(\w+),$", read("paper/paper.bib"), re.M)
    assert len(listed) == len(set(listed))
    assert set(re.findall(r"@(\w+)", text)) == set(listed)
    assert [author["name"] for author in yaml.safe_load(head)["authors"]] == [
        author["name"] for author in project["authors"]
    ]
    # The Journal of Open Source Software asks for 250 to 1000 words.
    assert 250 <= len(text.split()) <= 1000
    for figure in re.findall(r"\]\((\S+?)\)", text):
        assert (ROOT / "paper" / figure).is_file()


def test_the_forms_for_issues_are_whole() -> None:
    forms = [path for path in (ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml") if path.stem != "config"]
    assert len(forms) >= 3
    for path in forms:
        form = yaml.safe_load(path.read_text(encoding="utf-8"))
        assert {"name", "description", "body"} <= form.keys()
        identities = [part["id"] for part in form["body"]]
        assert len(identities) == len(set(identities))
