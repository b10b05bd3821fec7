"""The configuration composed without Hydra, and runs of it, as datasets and as the command leaves them."""

from functools import cache
from pathlib import Path
from typing import Any

import xarray
import yaml

from contactlab.config import build
from contactlab.config.options import content, groups
from contactlab.engine import simulate
from contactlab.laws import ContactLaw
from contactlab.results.netcdf import to_datatree, write_tree

CONF = Path(__file__).resolve().parents[2] / "conf"

DURATION = 5e-3
"""Of case A [s]."""

LAWS = ("lagrange_slip", "lagrange_stick", "hertz_penalty")

SHORT: dict[str, object] = {"solver.duration": 2e-3, "record.interval": 1e-6}
"""What the runs that are compared change of the default configuration."""


def options(group: str) -> list[str]:
    """Names of a group's options."""
    files = [path.stem for path in (CONF / group).glob("*.yaml")]
    others = groups().get(group, [])
    return sorted({*files, *others})


def chosen(group: str, option: str, choices: dict[str, str]) -> dict[str, Any]:
    """An option's keys, those of its own defaults included."""
    path = CONF / group / f"{option}.yaml"
    keys: dict[str, Any] = (
        yaml.safe_load(path.read_text(encoding="utf-8")) if path.exists() else content(group, option)
    )
    for entry in keys.pop("defaults", []):
        if isinstance(entry, dict):
            ((below, part),) = entry.items()
            name = f"{group}/{below}"
            keys[below] = chosen(name, choices.get(name, part), choices)
    return keys


def composed(**choices: str) -> dict[str, Any]:
    """The default configuration of a run with some groups chosen otherwise."""
    defaults = yaml.safe_load((CONF / "run.yaml").read_text(encoding="utf-8"))["defaults"]
    usual = {
        group: option
        for entry in defaults
        if isinstance(entry, dict)
        for group, option in entry.items()
        if option is not None and not group.startswith("override ")
    }
    values = usual | choices
    return {group: chosen(group, option, values) for group, option in values.items() if "/" not in group}


def altered(changes: dict[str, object], **choices: str) -> dict[str, Any]:
    """The default configuration with some full keys set otherwise."""
    configuration = composed(**choices)
    for key, value in changes.items():
        *path, name = key.split(".")
        section = configuration
        for group in path:
            section = section[group]
        section[name] = value
    return configuration


def configured(option: str = "hertz_penalty", /, **changes: dict[str, Any]) -> dict[str, Any]:
    """The default configuration with a law, on case A's tones for 5 ms; sections are changed by keys."""
    sections = composed(law=option)
    sections["drive"] |= {"frequency": 3210.0}
    sections["solver"] |= {"duration": DURATION}
    for section, keys in changes.items():
        sections[section] |= keys
    return sections


def datatree(configuration: dict[str, Any]) -> xarray.DataTree:
    """A run of a configuration as the command makes it."""
    setup = build(configuration)
    trajectory = setup.run()
    assert trajectory.complete, trajectory.message
    return to_datatree(trajectory, setup.configuration)


def of_law(
    law: ContactLaw,
    record_interval: float = 1e-7,
    contact_step: float | None = None,
    **changes: dict[str, Any],
) -> xarray.DataTree:
    """A law that no configuration can name, on case A with some sections changed."""
    setup = build(configured(**changes))
    steps = {"record_interval": record_interval, "contact_step": contact_step}
    trajectory = simulate(setup.motor, law, duration=DURATION, **steps)  # type: ignore[arg-type]
    assert trajectory.complete, trajectory.message
    return to_datatree(trajectory, setup.configuration)


@cache
def case_a_tree(law: str, contact_step: float | None, record_interval: float) -> xarray.DataTree:
    """Case A under one of the paper's laws."""
    return datatree(
        configured(law, solver={"contact_step": contact_step}, record={"interval": record_interval})
    )


def leave(folder: Path, law: str, **changes: object) -> Path:
    """A run folder; two underscores in a key stand for its dot."""
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    folder.mkdir(parents=True, exist_ok=True)
    write_tree(datatree(altered(SHORT | keys, law=law)), folder / "run.nc")
    return folder


def leave_all(folder: Path) -> Path:
    """A folder of the paper's three laws, as a sweep leaves it."""
    for number, law in enumerate(LAWS):
        leave(folder / f"{number}_law={law}", law)
    return folder
