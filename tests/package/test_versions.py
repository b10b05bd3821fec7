"""Version and supported Pythons are the same in all files that state them."""

import json
import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_is_the_same_everywhere() -> None:
    locked = {
        package["name"]: package.get("version") for package in tomllib.loads(read("uv.lock"))["package"]
    }
    stated = yaml.safe_load(read("CITATION.cff"))["version"], json.loads(read("codemeta.json"))["version"]
    parts = [path.parent.name for path in ROOT.glob("packages/*/pyproject.toml")]
    of_parts = [
        tomllib.loads(read(f"packages/{name}/pyproject.toml"))["project"]["version"] for name in parts
    ]
    assert {*stated, *of_parts, *(locked[name] for name in ("contactlab", *parts))} == {PROJECT["version"]}
    assert all(f"packages/{name}\n" in read(".github/workflows/wheels.yml") for name in parts)
    assert f"\n## [{PROJECT['version']}]" in read("CHANGELOG.md")


def test_what_is_not_released_stands_in_fragments_alone() -> None:
    towncrier = tomllib.loads(read("pyproject.toml"))["tool"]["towncrier"]
    changelog = read(towncrier["filename"])
    # A release is put where the mark is, so that none may be above and nothing else below it.
    before, _, after = changelog.partition(towncrier["start_string"])
    assert "\n## " not in before
    assert re.match(r"\n## \[\d+\.\d+\.\d+\] - ", after)
    assert "[unreleased]" not in changelog.lower()
    sections = "|".join(each["directory"] for each in towncrier["type"])
    name = re.compile(rf"(\d+|\+[\w-]+)\.({sections})\.md")
    ignored = {*towncrier["ignore"]}
    for path in (ROOT / towncrier["directory"]).iterdir():
        assert path.name in ignored or name.fullmatch(path.name), path.name


def test_every_supported_python_is_tested() -> None:
    promised = [text.rpartition(" ")[2] for text in PROJECT["classifiers"] if "Python :: 3." in text]
    workflow = yaml.safe_load(read(".github/workflows/ci.yml"))["jobs"]["run"]
    assert workflow["strategy"]["matrix"]["python"] == promised
    assert all(version in read(".ci/run") and version in read("noxfile.py") for version in promised)


def test_the_recipe_for_conda_has_the_version_and_the_bounds_of_the_package() -> None:
    recipe = yaml.safe_load(read("recipe/recipe.yaml"))
    assert recipe["context"]["version"] == PROJECT["version"]
    assert recipe["about"]["summary"] == PROJECT["description"]
    # The names that conda-forge has; of one with a condition on Python the first is meant.
    names = {"netcdf4": "netCDF4", "matplotlib-base": "matplotlib"}
    rows = (line.split() for line in recipe["requirements"]["run"])
    bounds = {names.get(name, name): bound for name, bound in rows}
    stated = dict(
        re.fullmatch(r"([\w-]+)(>=[\w.]+).*", line).groups() for line in reversed(PROJECT["dependencies"])
    )
    assert bounds == {"python": PROJECT["requires-python"], **stated}
    assert {*yaml.safe_load(read("CITATION.cff"))["keywords"]} == {*PROJECT["keywords"]}
    assert {*json.loads(read("codemeta.json"))["keywords"]} == {*PROJECT["keywords"]}


def test_wheels_are_built_for_every_supported_python_but_the_first() -> None:
    tool = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["cibuildwheel"]
    promised = [text.rpartition(" ")[2] for text in PROJECT["classifiers"] if "Python :: 3." in text]
    assert tool["build"].split() == [f"cp{version.replace('.', '')}-*" for version in promised[1:]]
    assert tool["environment"] == {"CONTACTLAB_COMPILE": "1"}
    runners = yaml.safe_load(read(".github/workflows/wheels.yml"))["jobs"]["wheels"]["strategy"]["matrix"][
        "runner"
    ]
    assert {name.partition("-")[0] for name in runners} == {"ubuntu", "macos", "windows"}
    assert any(name.endswith("-arm") for name in runners)
