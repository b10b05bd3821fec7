"""A small dataset in the layout of a run.nc whose every metric can be found with pencil and paper.

One second in 128 intervals, a drive of 4 Hz, two contacts of an eighth of a second with mean forces of
10 and 20 N, friction of a fifth of that against a slip that stays positive, no load. All numbers are
binary fractions, so that sums are exact.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray
import yaml
from numpy.typing import NDArray

from contactlab import variables

Array = NDArray[np.float64]

INTERVALS = 128
TIME: Array = np.arange(INTERVALS + 1) / INTERVALS
FIRST, SECOND, LONG = 40, 80, 16
"""Records of the touch-downs, and how many intervals a contact lasts."""

MEAN_FORCE = 15.0
NORMAL_AMPLITUDE = 0.5
TANGENTIAL_AMPLITUDE = 0.25

CONFIGURATION: dict[str, Any] = {
    "law": {"name": "hertz_penalty", "stiffness": None, "tip_radius": 8.0},
    "contact": {"friction_coefficient": 0.25},
    "rotor": {"radius": 0.5, "inertia": 2.0, "damping": 0.0, "load_torque": 0.0},
    "drive": {"frequency": 4.0},
}


def touching() -> NDArray[np.bool_]:
    """Records whose interval lies within a contact."""
    record = np.arange(INTERVALS + 1)
    return ((record > FIRST) & (record <= FIRST + LONG)) | ((record > SECOND) & (record <= SECOND + LONG))


def series() -> dict[str, Array]:
    """The time series."""
    inside = touching()
    normal = np.where(inside, np.where(TIME < 0.5, 10.0, 20.0), 0.0)
    friction = -0.2 * normal
    spin = np.cumsum(-0.5 * friction / INTERVALS) / 2.0
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (spin[1:] + spin[:-1]) / INTERVALS)])
    zero, lost = np.zeros_like(TIME), np.cumsum(inside) / LONG
    return {
        "tip_normal_displacement": NORMAL_AMPLITUDE * np.cos(2.0 * np.pi * 4.0 * TIME),
        "gap": np.where(inside, -1.0 / 64.0, 1.0 / 16.0),
        # The tip's own velocity vibrates, the slip is less by what the rotor turns.
        "slip_velocity": 1.0 + TANGENTIAL_AMPLITUDE * np.sin(8.0 * np.pi * TIME) - 0.5 * spin,
        "rotor_velocity": spin,
        "rotor_angle": turned,
        "normal_force": normal,
        "friction_force": friction,
        "kinetic_energy": 6.0 * TIME - 1.5 * lost,
        "strain_energy": zero,
        "contact_energy": zero,
        "drive_work": 10.0 * TIME,
        "damping_loss": 4.0 * TIME,
        "friction_loss": lost,
        "contact_loss": 0.5 * lost,
        "load_work": zero,
        "contact_mode": np.where(inside, 1.0, 0.0),
    }


def contacts() -> dict[str, Array]:
    """The table of the contacts."""
    return {
        "start_time": TIME[[FIRST, SECOND]],
        "duration": np.array([0.125, 0.125]),
        "stick_duration": np.array([0.0, 0.0625]),
        "normal_impulse": np.array([1.25, 2.5]),
        "friction_impulse": np.array([-0.25, -0.5]),
        "peak_normal_force": np.array([16.0, 32.0]),
        "max_penetration": np.array([1.0, 2.0]) / 64.0,
        "approach_velocity": np.array([-1.0, -2.0]),
        "separation_velocity": np.array([0.5, np.nan]),
        "energy_loss": np.array([1.5, 1.5]),
    }


def tree(
    changes: Mapping[str, Array] | None = None,
    table: Mapping[str, Array] | None = None,
    configuration: dict[str, Any] | str | None = None,
    without: tuple[str, ...] = (),
    **attributes: object,
) -> xarray.DataTree:
    """The dataset with series, columns of contacts, configuration or attributes changed or left out."""
    units = {v.name: v.units for v in (*variables.SERIES, *variables.CONTACTS)}
    value = series() | dict(changes or {})
    time = ("time", TIME, {"units": "s"})
    text = yaml.safe_dump(CONFIGURATION if configuration is None else configuration)
    root = xarray.Dataset(
        {
            name: ("time", values, {"units": units.get(name, "1")})
            for name, values in value.items()
            if name not in without
        },
        coords={"time": time},
        attrs={
            "configuration": configuration if isinstance(configuration, str) else text,
            "law": "hertz_penalty",
            "law_parameters": json.dumps({"stiffness": 1e10, "friction_coefficient": 0.25}),
            "contact_step": 1.0 / 256.0,
        }
        | attributes,
    )
    columns = contacts() | dict(table or {})
    group = xarray.Dataset(
        {
            name: ("contact", values, {"units": units[name]})
            for name, values in columns.items()
            if name not in without
        }
    )
    groups = {"/": root} if "contacts" in without else {"/": root, "/contacts": group}
    return xarray.DataTree.from_dict(groups)
