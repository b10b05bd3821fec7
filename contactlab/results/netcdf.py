"""The groups of a run's dataset, as an xarray tree and as a netCDF-4 file that is there only when whole.

The root holds the time series and the resonator's quantities, the group `contacts` one row a
contact; names, dimensions and units are those of `contactlab.variables`, and with what the law remembers
those of `contactlab.results.netcdf`. The group `state` holds what
the engine needs to go on where the run ended, to the last bit. The attributes say what
ran and with which code. Nothing in the file depends on when, where or on which machine it was
written, so the same run leaves the same bytes. xarray is imported for a tree alone: a run is written,
summed up and drawn without.
"""

import json
from ast import literal_eval
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol, final

import numpy as np
import yaml

from contactlab import variables
from contactlab.immutable import PLAIN
from contactlab.laws import ContactLaw, InternalVariable
from contactlab.laws.memory import ODD
from contactlab.laws.registry import classes_of, provenance
from contactlab.motor import Motor
from contactlab.motor.motor import free_reach
from contactlab.motor.outputs import output_variables
from contactlab.motor.table import keep, kept
from contactlab.results.files import digest_of_file, whole_netcdf
from contactlab.results.provenance import code_attributes
from contactlab.results.yaml_text import read_yaml, write_yaml
from contactlab.settling.verdict import Settling, configured_period, drive_period, settling_of
from contactlab.trajectory import Ending, Trajectory, contact_variables
from contactlab.variables import INTERNAL, Variable
from contactlab.window import cut_to_window

if TYPE_CHECKING:
    import xarray

REFERENCES: Final = (
    "Andersen, B., Blanke, M., Helbo, J. (2001). Two Mode Resonator and Contact Model for Standing "
    "Wave Piezomotor. Proc. 18th ASME Biennial Conference on Mechanical Vibration and Noise."
)

_CHUNK: Final = 2**17
"""Values in a chunk, 1 MiB: one chunk for an ordinary run, and slices of a long one stay cheap."""

TITLE: Final = "Standing-wave piezoelectric motor with the contact law "
"""What the title of a run begins with; that of its law follows."""


class Column(Protocol):
    """Dimensions, values and attributes of a variable; one of xarray's is such a column too."""

    @property
    def dims(self) -> tuple[Any, ...]:
        """Names of the dimensions."""

    @property
    def values(self) -> Any:
        """The array."""

    @property
    def attrs(self) -> Mapping[Any, Any]:
        """Attributes by name."""


@final
class Recorded(NamedTuple):
    """A `Column` of a run in memory."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: dict[str, object]


@final
class Group(NamedTuple):
    """Variables of a group by name, and its attributes."""

    variables: Mapping[Any, Column]
    attrs: Mapping[Any, Any]

    @property
    def values(self) -> dict[str, np.ndarray]:
        """The arrays by name."""
        return {str(name): np.asarray(column.values) for name, column in self.variables.items()}


Groups = dict[str, Group]
"""Groups of a run by path: "/", "/contacts", and "/state" where it is known."""

RECORD, LAYOUT = "record", "layout"
"""Variable of the group `state` with all that has no name of its own, and its attribute with the fields."""

PART: Final = "/first_contact"
"""Group of a run that starts in a contact which began before."""

EMPTY: Final = Group({}, {})

GROUP: Final = "files"
"""Group of the contents of the files that a configuration names, in a section with a `digest`."""


def contents_of(configuration: Mapping[str, Any]) -> dict[str, bytes]:
    """Return the contents of the files that a configuration names, by section."""
    contents: dict[str, bytes] = {}
    for name, keys in configuration.items():
        if type(keys) not in PLAIN and isinstance(keys, Mapping):
            if (content := kept(keys.get("digest"))) is not None:
                contents[name] = content
            contents |= {f"{name}.{below}": content for below, content in contents_of(keys).items()}
    return contents


def keep_contents(tree: "xarray.DataTree") -> None:
    """Keep the contents that a dataset contains."""
    if GROUP in tree.children:
        for values in tree.children[GROUP].to_dataset(inherit=False).values():
            keep(np.asarray(values.values, dtype=np.uint8).tobytes(), recorded=True)


def to_datatree(
    trajectory: Trajectory, configuration: Mapping[str, object] | None = None
) -> "xarray.DataTree":
    """Return the groups of a run, see `to_groups`, as an xarray tree."""
    import xarray

    groups = to_groups(trajectory, configuration)
    return xarray.DataTree.from_dict(
        {path: xarray.Dataset(g.variables, attrs=g.attrs) for path, g in groups.items()}
    )


def groups_of(run: "xarray.DataTree | Groups") -> Groups:
    """Return the groups of a run, which may be a tree."""
    if isinstance(run, dict):
        return run
    datasets = {node.path: node.to_dataset(inherit=False) for node in run.subtree}
    return {path: Group(data.variables, data.attrs) for path, data in datasets.items()}


def to_groups(trajectory: Trajectory, configuration: Mapping[str, object] | None = None) -> Groups:
    """Return the groups of a run's dataset, whose arrays are those of the trajectory.

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
    kept += tuple(each for each in variables.RESONATOR if each.name in values)
    attributes = _attributes(trajectory, configuration or settings_of(trajectory.motor, trajectory.law))
    if not trajectory.contacts["start_time"].size:
        # What no contact disturbs is known beforehand.
        attributes["free_reach"] = free_reach(trajectory.motor)
    of_contacts = (*contact_variables(trajectory.law), *internal_contacts(trajectory.law))
    groups = {
        "/": Group(_columns((*kept, variables.TIME), values), attributes),
        "/contacts": Group(_columns(of_contacts, trajectory.contacts), {}),
    }
    if trajectory.part:
        groups[PART] = Group(
            {
                e.name: Recorded((), np.array(trajectory.part[e.name]), cf_attributes(e))
                for e in of_contacts
                if e.name in trajectory.part
            },
            {"title": "What of the first contact, which began before the run, lies in the run"},
        )
    if trajectory.state:
        groups["/state"] = Group(_of_state(trajectory.state), {})
    if contents := contents_of(configuration or {}):
        groups[f"/{GROUP}"] = Group(
            {
                name: Recorded(
                    (f"{name}_byte",),
                    np.frombuffer(content, np.uint8),
                    {"long_name": f"content of {name}.file"},
                )
                for name, content in contents.items()
            },
            {},
        )
    return groups


def contacts_in(groups: Groups) -> dict[str, np.ndarray]:
    """Return the contacts of a run, cut to its records, see `contactlab.window.cut_to_window`."""
    part = {name: float(x) for name, x in groups.get(PART, EMPTY).values.items()}
    return cut_to_window(groups["/"].values, groups.get("/contacts", EMPTY).values, part)


def _of_state(state: Mapping[str, Any]) -> dict[str, Recorded]:
    """Return the state where a run ended, and before the step that its end cut, as a record of bytes each."""
    # Imported here: it brings the engine, which who only reads a run does not need.
    from contactlab.engine.state import BEFORE, LEAVES, PACKED, state_from_value

    columns: dict[str, Recorded] = {}
    for prefix, place in (
        ("", "where the run ended"),
        (BEFORE, "before the step that the end of the run cut"),
    ):
        record, q, v = state_from_value(state, prefix)
        # Without the gaps between the fields, which nobody writes to.
        packed = np.zeros(1, PACKED)
        for name in PACKED.names or ():
            packed[name] = record.view(LEAVES)[name]
        columns |= {
            f"{prefix}q": Recorded((f"{prefix}q_0",), q, {"long_name": f"normal coordinates {place}"}),
            f"{prefix}v": Recorded(
                (f"{prefix}v_0",), v, {"long_name": f"rates of the normal coordinates {place}"}
            ),
            f"{prefix}{RECORD}": Recorded(
                ("byte",),
                packed.view(np.uint8),
                {"long_name": f"all else that the engine keeps, {place}", LAYOUT: str(PACKED.descr)},
            ),
        }
    return columns


def state_of(tree: "xarray.DataTree") -> dict[str, Any]:
    """Return the state that a run ended in, as the engine takes it; empty where none was recorded."""
    if "state" not in tree.children:
        return {}
    # A time of its own stands in it beside that of the records.
    group = tree.children["state"].to_dataset(inherit=False)
    state: dict[str, Any] = {}
    for name, column in group.variables.items():
        if LAYOUT in column.attrs:
            layout = np.dtype(literal_eval(column.attrs[LAYOUT]))
            prefix = str(name).removesuffix(RECORD)
            state |= {prefix + field: column.values.view(layout)[field][0] for field in layout.names or ()}
        else:
            # Files of before there was a record have a variable for each of its fields.
            state[str(name)] = column.values[()]
    return state


def settings_of(motor: Motor, law: ContactLaw) -> dict[str, Any]:
    """Return the numbers of a motor and a law by the keys of a configuration, where there is none."""
    parameters = law.describe()
    settings: dict[str, dict[str, Any]] = {"law": {"name": law.name, **parameters}, **motor_settings(motor)}
    # Of a composed law it is that of its friction.
    own = parameters.get("friction_coefficient")
    if (friction := parameters.get("friction.friction_coefficient", own)) is not None:
        settings["contact"]["friction_coefficient"] = friction
    # Plain numbers, whatever a motor was made from.
    plain: dict[str, Any] = json.loads(json.dumps(settings, default=float))
    return plain


def motor_settings(motor: Motor) -> dict[str, dict[str, Any]]:
    """Return the numbers of a motor by the keys of a configuration."""
    geometry = motor.geometry
    settings: dict[str, dict[str, Any]] = {
        "contact": {name: getattr(geometry, name) for name in ("tip_length", "clearance", "angle")},
        "rotor": {"radius": geometry.rotor_radius, **asdict(motor.rotor)},
    }
    if motor.drive.frequency.size:
        settings["drive"] = {"frequency": motor.drive.frequency[0]}
    if motor.plant is not None:
        settings["plant"] = motor.plant.settings
    return settings


def configuration_of(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the configuration that the attributes of a dataset contain; empty without one."""
    try:
        configuration = read_yaml(str(attributes.get("configuration", "")))
    # Besides its own errors YAML raises those of impossible dates.
    except (yaml.YAMLError, ValueError):
        return {}
    return configuration if isinstance(configuration, dict) else {}


def settling_in(run: "xarray.DataTree | Groups") -> Settling:
    """Judge whether the motor of a dataset has settled, from its numbers; they may be those of anybody."""
    groups = groups_of(run)
    root = groups["/"]
    period = period_in(root.attrs, configuration_of(root.attrs))
    return settling_of(root.values, contacts_in(groups), period, lasting_in(root.variables))


def period_in(attributes: Mapping[Any, Any], configuration: Mapping[str, Any]) -> float:
    """Return the drive's period that attributes tell, or else a configuration [s]; zero for none."""
    period = attributes.get("drive_period")
    return float(period) if isinstance(period, int | float | np.number) else configured_period(configuration)


def write_tree(tree: "xarray.DataTree", path: Path) -> str:
    """Write a tree to a netCDF-4 file, whole or not at all, and return its digest.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    encoding = {
        path: {name: {"_FillValue": None, **_stored(v.values.shape)} for name, v in group.variables.items()}
        for path, group in groups_of(tree).items()
    }
    with whole_netcdf(path) as partial:
        tree.to_netcdf(partial, engine="netcdf4", encoding=encoding)
        return digest_of_file(partial)


def write_groups(groups: Groups, path: Path) -> str:
    """Write the groups of a run as `write_tree` does its tree, but without xarray."""
    # Imported here: it brings the netCDF library, which a summary does not need.
    import netCDF4

    with whole_netcdf(path) as partial:
        with netCDF4.Dataset(partial, "w", format="NETCDF4") as file:
            for name, group in groups.items():
                node = file if name == "/" else file.createGroup(name)
                node.setncatts(group.attrs)
                for variable, column in group.variables.items():
                    values = column.values
                    for dimension, size in zip(column.dims, values.shape, strict=True):
                        if dimension not in node.dimensions:
                            node.createDimension(dimension, size)
                    made = node.createVariable(variable, values.dtype, column.dims, **_stored(values.shape))
                    made.setncatts(column.attrs)
                    made[...] = values
        return digest_of_file(partial)


def _stored(shape: tuple[int, ...]) -> dict[str, Any]:
    """Return how a variable of a shape is stored: compressed without loss."""
    chunks = tuple(min(max(size, 1), _CHUNK) for size in shape)
    return {"zlib": True, "complevel": 1, "shuffle": True, "chunksizes": chunks}


def reached_end(attributes: Mapping[Any, Any]) -> bool:
    """Return whether the run of a dataset reached its end; True where its attributes do not state it."""
    unbalanced = attributes.get("ending") == Ending.UNBALANCED.name.lower()
    return bool(attributes.get("complete", 1)) or unbalanced


def _columns(table: Iterable[Variable], values: Mapping[str, np.ndarray]) -> dict[str, Recorded]:
    """Return dimensions, values and CF attributes of every variable of a table."""
    return {e.name: Recorded(e.dims, values[e.name], cf_attributes(e)) for e in table}


def cf_attributes(variable: Variable) -> dict[str, object]:
    """Return the CF attributes of a variable, and its symbol."""
    attributes: dict[str, object] = {
        "units": variable.units,
        "long_name": variable.long_name,
        "symbol": variable.symbol,
    }
    for name in ("cell_methods", "standard_name", "comment"):
        if text := getattr(variable, name):
            attributes[name] = text
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
        "configuration": write_yaml(dict(configuration)),
        "drive_period": period,
        **({} if trajectory.motor.preload is None else {"preloaded": 1}),
        **prescribed_by(trajectory.motor),
        **{f"frame_{name}": value for name, value in trajectory.frame.items()},
        **settling_of(columns, trajectory.contacts_within, period, trajectory.lasting).attributes,
        "solver_statistics": json.dumps({k: int(v) for k, v in trajectory.statistics.items()}),
        "impulse_error": float(trajectory.impulse_error),
        "rotor_velocity_error": float(trajectory.rotor_velocity_error),
        "keeps_tolerance": int(law.keeps_tolerance),
        "ending": Ending(trajectory.ending).name.lower(),
        "message": trajectory.message,
        "complete": int(trajectory.complete),
    }


def prescribed_by(motor: Motor) -> dict[str, object]:
    """Return the attribute of a run whose slip is prescribed, with gap or normal force; empty for others."""
    if not motor.slip_is_prescribed:
        return {}
    led = motor.modes.is_prescribed[motor.modes.approach != 0.0].any()
    return {"prescribed": "gap" if led else "normal force"}


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
