"""The configuration, composed without Hydra: the files and the options that need none."""

from pathlib import Path
from typing import Any

import yaml

from contactlab.config import groups

CONF = Path(__file__).resolve().parents[2] / "conf"


def options(group: str) -> list[str]:
    """Names of a group's options."""
    files = [path.stem for path in (CONF / group).glob("*.yaml")]
    others = groups.groups().get(group, [])
    return sorted({*files, *others})


def chosen(group: str, option: str, choices: dict[str, str]) -> dict[str, Any]:
    """An option's keys, those of its own defaults included."""
    path = CONF / group / f"{option}.yaml"
    keys: dict[str, Any] = (
        yaml.safe_load(path.read_text(encoding="utf-8"))
        if path.exists()
        else groups.content(group, option)
    )
    for entry in keys.pop("defaults", []):
        if isinstance(entry, dict):
            ((below, part),) = entry.items()
            name = f"{group}/{below}"
            keys[below] = chosen(name, choices.get(name, part), choices)
    return keys


def composed(**choices: str) -> dict[str, Any]:
    """The default configuration with some groups chosen otherwise."""
    defaults = yaml.safe_load((CONF / "config.yaml").read_text(encoding="utf-8"))["defaults"]
    usual = {
        group: option
        for entry in defaults
        if isinstance(entry, dict)
        for group, option in entry.items()
        if option is not None and not group.startswith("override ")
    }
    given = usual | choices
    return {
        group: chosen(group, option, given) for group, option in given.items() if "/" not in group
    }


def altered(changes: dict[str, object], **choices: str) -> dict[str, Any]:
    """The default configuration with some full keys set otherwise."""
    configuration = composed(**choices)
    for key, value in changes.items():
        *groups, name = key.split(".")
        section = configuration
        for group in groups:
            section = section[group]
        section[name] = value
    return configuration
