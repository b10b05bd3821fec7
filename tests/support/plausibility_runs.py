"""Runs of case A as datasets, each made once."""

from functools import cache
from typing import Any

import xarray
from support.conf_files import composed

from contactlab.config import build
from contactlab.engine import simulate
from contactlab.laws import ContactLaw
from contactlab.results.netcdf import to_datatree

DURATION = 5e-3


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
    trajectory = simulate(
        setup.motor,
        setup.law,
        duration=setup.duration,
        record_interval=setup.record_interval,
        contact_step=setup.contact_step,
        tolerance=setup.tolerance,
    )
    assert trajectory.complete, trajectory.message
    return to_datatree(trajectory, setup.configuration)


def of_law(
    law: ContactLaw, record_interval: float = 1e-7, **changes: dict[str, Any]
) -> xarray.DataTree:
    """A law that no configuration can name, on case A with some sections changed."""
    setup = build(configured(**changes))
    trajectory = simulate(setup.motor, law, duration=DURATION, record_interval=record_interval)
    assert trajectory.complete, trajectory.message
    return to_datatree(trajectory, setup.configuration)


@cache
def case_a_tree(law: str, contact_step: float | None, record_interval: float) -> xarray.DataTree:
    """Case A under one of the paper's laws."""
    return datatree(
        configured(law, solver={"contact_step": contact_step}, record={"interval": record_interval})
    )
