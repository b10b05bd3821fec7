"""A run as an xarray tree and as a netCDF-4 file that stands under its name only when whole.

The root holds the time series and the resonator's quantities, the group `contacts` one row a
contact; names, dimensions and units are those of `contactlab.variables`, and with what the law remembers
those of `contactlab.results.netcdf`. The group `state` holds what
the engine needs to go on where the run ended, to the last bit. The attributes say what
ran and with which code. Nothing in the file depends on when, where or on which machine it was
written, so the same run leaves the same bytes.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray
import yaml

from contactlab import variables
from contactlab.laws import ContactLaw, InternalVariable
from contactlab.laws.memory import ODD
from contactlab.laws.registry import classes_of, provenance
from contactlab.motor import Motor
from contactlab.motor.motor import free_reach
from contactlab.motor.outputs import output_variables
from contactlab.results.files import digest_of_file, whole_netcdf
from contactlab.results.provenance import code_attributes
from contactlab.settling.verdict import Settling, configured_period, drive_period, settling_of
from contactlab.trajectory import Ending, Trajectory
from contactlab.variables import INTERNAL, Variable

REFERENCES: Final = (
    "Andersen, B., Blanke, M., Helbo, J. (2001). Two Mode Resonator and Contact Model for Standing "
    "Wave Piezomotor. Proc. 18th ASME Biennial Conference on Mechanical Vibration and Noise."
)

_CHUNK: Final = 2**17
"""Values in a chunk, 1 MiB: one chunk for an ordinary run, and slices of a long one stay cheap."""

TITLE: Final = "Standing-wave piezoelectric motor with the contact law "
"""What the title of a run begins with; that of its law follows."""


def to_datatree(trajectory: Trajectory, configuration: Mapping[str, object] | None = None) -> xarray.DataTree:
    """Return a run as an xarray tree, whose arrays are those of the trajectory.

    Args:
        trajectory: what the simulation gave back.
        configuration: the resolved configuration as plain, nested dictionaries, numbers in SI; without
            one, `settings_of` says what ran.

    Returns:
        The time series and the resonator's quantities at the root and the groups `contacts` and `state`,
        see the module. The attribute `complete` is 1 for a run that reached its end with a closed ledger
        and 0 otherwise.
    """
    modes = trajectory.motor.modes
    # A rigid body's mode has no damping ratio.
    with np.errstate(invalid="ignore", divide="ignore"):
        damping_ratio = modes.damping_ratio
    values: dict[str, np.ndarray] = {
        variables.TIME.name: trajectory.time,
        **trajectory.series,
        variables.CONTACT_MODE.name: np.asarray(trajectory.contact_mode, dtype=np.int8),
        "natural_frequency": modes.natural_frequency,
        "damping_ratio": damping_ratio,
    }
    if modes.shape_coupling is not None:
        values["electromechanical_coupling"] = modes.shape_coupling
    kept = (*variables.SERIES, variables.CONTACT_MODE, *internal_series(trajectory.law))
    if modes.rotor_displacement is not None:
        kept += (variables.BEARING,)
    kept += output_variables(modes)
    root = xarray.Dataset(
        _columns((*kept, *(each for each in variables.RESONATOR if each.name in values)), values),
        coords=_columns((variables.TIME,), values),
        attrs=_attributes(trajectory, configuration or settings_of(trajectory.motor, trajectory.law)),
    )
    of_contacts = (*variables.CONTACTS, *internal_contacts(trajectory.law))
    contacts = xarray.Dataset(_columns(of_contacts, trajectory.contacts))
    if not contacts.sizes["contact"]:
        # What no contact disturbs is known beforehand.
        root.attrs["free_reach"] = free_reach(trajectory.motor)
    groups = {"/": root, "/contacts": contacts}
    if trajectory.state:
        groups["/state"] = _as_dataset(trajectory.state)
    return xarray.DataTree.from_dict(groups)


_KINDS: Final = {"real": np.float64, "whole": np.int64}
"""Variables of the group `state`: a variable for each of its hundred numbers would take most of the time in
which a file is written and opened."""


def _as_dataset(state: Mapping[str, Any]) -> xarray.Dataset:
    """Return the numbers of a state, real and whole, one after the other; arrays with lengths."""
    group = xarray.Dataset()
    for kind, number in _KINDS.items():
        parts = {name: x for name, each in state.items() if (x := np.asarray(each)).dtype == number}
        names = " ".join(f"{name}:{part.size}" if part.ndim else name for name, part in parts.items())
        about = {"long_name": f"{kind} numbers where the run ended", "names": names}
        group[kind] = f"{kind}_number", np.concatenate([*map(np.ravel, parts.values())]), about
    return group


def state_of(tree: xarray.DataTree) -> dict[str, Any]:
    """Return the state that a run ended in, as the engine takes it; empty where none was recorded."""
    group = tree.children["state"].to_dataset() if "state" in tree.children else xarray.Dataset()
    if not _KINDS.keys() <= group.keys():
        return {}
    state: dict[str, Any] = {}
    for kind in _KINDS:
        numbers, at = group[kind].values, 0
        for entry in group[kind].attrs["names"].split():
            name, _, length = entry.partition(":")
            end = at + int(length or 1)
            state[name] = numbers[at:end] if length else numbers[at]
            at = end
    return state


def settings_of(motor: Motor, law: ContactLaw) -> dict[str, Any]:
    """Return the numbers of a motor and a law by the keys of a configuration, where there is none."""
    parameters, geometry = law.describe(), motor.geometry
    settings: dict[str, dict[str, Any]] = {
        "law": {"name": law.name, **parameters},
        "contact": {"tip_length": geometry.tip_length, "clearance": geometry.clearance},
        "rotor": {"radius": geometry.rotor_radius, **asdict(motor.rotor)},
    }
    if motor.drive.frequency.size:
        settings["drive"] = {"frequency": motor.drive.frequency[0]}
    if (friction := parameters.get("friction_coefficient")) is not None:
        settings["contact"]["friction_coefficient"] = friction
    # Plain numbers, whatever a motor was made from.
    plain: dict[str, Any] = json.loads(json.dumps(settings, default=float))
    return plain


def configuration_of(tree: xarray.DataTree) -> dict[str, Any]:
    """Return the configuration that a dataset tells; empty where it tells none."""
    try:
        # libyaml, where PyYAML has it, reads the same eight times as fast.
        loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        configuration = yaml.load(str(tree.attrs.get("configuration", "")), loader)
    # Besides its own errors YAML raises those of impossible dates.
    except (yaml.YAMLError, ValueError):
        return {}
    return configuration if isinstance(configuration, dict) else {}


def settling_in(tree: xarray.DataTree) -> Settling:
    """Judge whether the motor of a dataset has settled, from its numbers; they may be those of anybody."""
    root = tree.to_dataset(inherit=False).variables
    contacts = tree.children.get("contacts", xarray.DataTree()).to_dataset(inherit=False).variables
    columns, rows = ({str(k): v.values for k, v in group.items()} for group in (root, contacts))
    return settling_of(columns, rows, period_in(tree.attrs, configuration_of(tree)), lasting_in(root))


def period_in(attributes: Mapping[Any, Any], configuration: Mapping[str, Any]) -> float:
    """Return the drive's period that attributes tell, or else a configuration [s]; zero for none."""
    period = attributes.get("drive_period")
    return float(period) if isinstance(period, int | float | np.number) else configured_period(configuration)


def write_tree(tree: xarray.DataTree, path: Path) -> str:
    """Write what `to_datatree` gives to a netCDF-4 file, whole or not at all, and give its digest.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    encoding = {
        node.path: {name: _encoding(v) for name, v in node.to_dataset(inherit=False).variables.items()}
        for node in tree.subtree
    }
    with whole_netcdf(path) as partial:
        tree.to_netcdf(partial, engine="netcdf4", encoding=encoding)
        return digest_of_file(partial)


def _encoding(variable: xarray.Variable) -> dict[str, Any]:
    """Return the encoding of a variable: compressed without loss, and without a fill value beside NaN."""
    chunks = tuple(min(max(size, 1), _CHUNK) for size in variable.shape)
    return {"zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None, "chunksizes": chunks}


def reached_end(attributes: Mapping[Any, Any]) -> bool:
    """Return whether the run of a dataset reached its end; True where its attributes do not state it."""
    unbalanced = attributes.get("ending") == Ending.UNBALANCED.name.lower()
    return bool(attributes.get("complete", 1)) or unbalanced


def _columns(
    table: Iterable[Variable], values: Mapping[str, np.ndarray]
) -> dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, object]]]:
    """Return dimensions, values and CF attributes of every variable of a table."""
    return {entry.name: (entry.dims, values[entry.name], cf_attributes(entry)) for entry in table}


def cf_attributes(variable: Variable) -> dict[str, object]:
    """Return the CF attributes of a variable, and its symbol."""
    attributes: dict[str, object] = {
        "units": variable.units,
        "long_name": variable.long_name,
        "symbol": variable.symbol,
    }
    if variable.cell_methods:
        attributes["cell_methods"] = variable.cell_methods
    if variable.comment:
        attributes["comment"] = variable.comment
    if variable.flags:
        # CF wants the values in the type of the variable itself.
        attributes["flag_values"] = np.arange(len(variable.flags), dtype=np.int8)
        attributes["flag_meanings"] = " ".join(variable.flags)
    return attributes


def _attributes(trajectory: Trajectory, configuration: Mapping[str, object]) -> dict[str, object]:
    """Return the attributes of the root, `complete` last."""
    law = trajectory.law
    period = drive_period(trajectory.motor.drive)
    columns = {**trajectory.series, variables.TIME.name: trajectory.time}
    return {
        **code_attributes(),
        "title": TITLE + law.title,
        "references": f"{REFERENCES} Contact law: {law.source}.",
        "law": law.name,
        "law_origin": provenance(*classes_of(law)),
        "law_parameters": json.dumps(law.describe()),
        "duration": float(trajectory.duration),
        "contact_step": float(trajectory.contact_step),
        "record_interval": float(trajectory.record_interval),
        "configuration": yaml.safe_dump(dict(configuration), sort_keys=False, allow_unicode=True),
        "drive_period": period,
        **({} if trajectory.motor.preload is None else {"preloaded": 1}),
        **settling_of(columns, trajectory.contacts, period, trajectory.lasting).attributes,
        "solver_statistics": json.dumps({k: int(v) for k, v in trajectory.statistics.items()}),
        "ending": Ending(trajectory.ending).name.lower(),
        "message": trajectory.message,
        "complete": int(trajectory.complete),
    }


LIVES: Final = {"contact": "Begins anew in every contact.", "run": "Goes on from contact to contact."}


def internal_series(law: ContactLaw) -> tuple[Variable, ...]:
    """Return the internal variables of a law as root variables over time."""
    return tuple(_recorded(each, "time", each.meaning) for each in law.internal_variables)


def internal_contacts(law: ContactLaw) -> tuple[Variable, ...]:
    """Return them as variables of the contacts: the value that each ended with."""
    return tuple(
        _recorded(each, "contact", f"{each.meaning}, where the contact ended")
        for each in law.internal_variables
    )


def lasting_in(variables: Mapping[Any, Any]) -> tuple[str, ...]:
    """Return the names of the internal variables whose life is the run among a dataset's variables."""
    return tuple(
        str(name)
        for name, each in variables.items()
        if str(name).startswith(INTERNAL) and str(each.attrs.get("comment")).startswith(LIVES["run"])
    )


def _recorded(variable: InternalVariable, dimension: str, meaning: str) -> Variable:
    mirrored = " Changes its sign in a mirror." if variable.parity == ODD else ""
    comment = LIVES[variable.life] + mirrored
    return Variable(
        INTERNAL + variable.name, (dimension,), variable.units, variable.symbol, meaning, comment=comment
    )
