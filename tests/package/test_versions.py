"""Version and supported Pythons are the same in all files that state them."""

import json
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
    assert {*stated, locked["contactlab"]} == {PROJECT["version"]}
    assert f"\n## [{PROJECT['version']}]" in read("CHANGELOG.md")


def test_every_supported_python_is_tested() -> None:
    promised = [text.rpartition(" ")[2] for text in PROJECT["classifiers"] if "Python :: 3." in text]
    workflow = yaml.safe_load(read(".github/workflows/ci.yml"))["jobs"]["run"]
    assert workflow["strategy"]["matrix"]["python"] == promised
    assert all(version in read(".ci/run") and version in read("noxfile.py") for version in promised)
