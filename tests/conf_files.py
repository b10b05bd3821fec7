"""The configuration files, composed without Hydra: only what the tests need."""

from pathlib import Path
from typing import Any

import yaml

CONF = Path(__file__).resolve().parent.parent / "conf"


def options(group: str) -> list[str]:
    """Names of a group's files."""
    return sorted(path.stem for path in (CONF / group).glob("*.yaml"))


def composed(**choices: str) -> dict[str, Any]:
    """The default configuration with some groups chosen otherwise."""
    defaults = yaml.safe_load((CONF / "config.yaml").read_text(encoding="utf-8"))["defaults"]
    groups = {
        group: option
        for entry in defaults
        if isinstance(entry, dict)
        for group, option in entry.items()
        if option is not None and not group.startswith("override ")
    }
    return {
        group: yaml.safe_load((CONF / group / f"{option}.yaml").read_text(encoding="utf-8"))
        for group, option in (groups | choices).items()
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
