"""The motor of a checked configuration: its modes, its drive, and the files that these come from.

Files are recorded by path and digest.
"""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import check_kind
from contactlab.config.faults import ConfigurationError, as_fault, one_line, raise_faults
from contactlab.config.groups import BASES, GROUPS, MODAL, MOTIONS, OF_BEAMS, PLANTS, SIGNALS, resonator_class
from contactlab.motor import (
    Bearing,
    ContactGeometry,
    Drive,
    Motor,
    NormalModes,
    Piezoceramic,
    PiezoceramicDatasheet,
    Rotor,
    Steel,
    Waveform,
    on_bearing,
)
from contactlab.motor.modal import modes_of
from contactlab.motor.table import MeasurementError, Table, keep, read_table, recorded_content
from contactlab.parameter import DeclaredField
from contactlab.results.files import check_file

RESONANCE: Final = 1e-9
"""Relative distance at which an undamped tone counts as at a natural frequency."""

_DEGREES: Final = {"linear": 1, "cubic": 3, "quintic": 5, "septic": 7}
_UNITS: Final = {"time": "s", "frequency": "Hz", "voltage": "V", "phase": "rad"}

Numbers = tuple[tuple[str, Any], ...]


def motor_of(values: dict[str, Any], modes: NormalModes | None = None) -> Motor:
    """Return the motor of a checked configuration, to which what follows from modes and files is added.

    The modes are made where they are not known.

    Raises:
        ConfigurationError: the sections do not fit each other, or a file cannot be used.
    """
    if "plant" in values:
        return plant_of(values["plant"])
    contact, rotor = values["contact"], dict(values["rotor"])
    radius, mass = rotor.pop("radius"), rotor.pop("mass")
    bearing = {name: rotor.pop(f"bearing_{name}") for name in ("stiffness", "damping")}
    modes = modes or _modes(values)
    geometry = ContactGeometry(contact["tip_length"], radius, contact["clearance"], contact["angle"])
    motor = Motor(modes, _drive(values["drive"], modes), geometry, Rotor(**rotor))
    if contact["preload"] is None:
        return motor
    if mass is None:
        mass = values["rotor"]["mass"] = 2.0 * motor.rotor.inertia / radius**2
    with as_fault():
        return on_bearing(motor, Bearing(mass, contact["preload"], **bearing))


def plant_of(section: Mapping[str, Any]) -> Motor:
    """Return the small plant of a checked section; a ConfigurationError if its numbers do not fit."""
    numbers = {**section}
    name = numbers.pop("name")
    for key, kind in MOTIONS.items():
        if key in numbers:
            own = numbers[key]
            first, *rest = own
            if own[first] is None:
                usual = kind()
                raise_faults(
                    f"plant.{key}.{leaf} is {own[leaf]}; it must come with plant.{key}.{first}."
                    for leaf in rest
                    if own[leaf] != getattr(usual, leaf)
                )
            with as_fault(f"plant.{key}: "):
                numbers[key] = None if own[first] is None else kind(**own)
    with as_fault(f"plant={name}: "):
        return PLANTS[name](**numbers)


def _modes(values: Mapping[str, Any]) -> NormalModes:
    """Return the modes of the beam, of a file, or of another package's resonator.

    Path and digest of a file are completed in its section.
    """
    section = dict(values["resonator"])
    basis = section.pop("basis")
    if basis in BASES:
        sections = section, section.pop("steel"), *(values[group] for group in OF_BEAMS)
        return _modes_of_beam(basis, *(tuple(each.items()) for each in sections))
    raise_faults(
        f"{group}.{key} is {values[group].get(key)}; it must be left out with resonator={basis}, "
        "which has nothing of it."
        for group in OF_BEAMS
        for key, field in next(iter(GROUPS[group].options.values())).items()
        if isinstance(field, DeclaredField) and values[group].get(key) != field.default
    )
    if basis == MODAL:
        path, content = named_file("resonator", values["resonator"])
        with as_fault(f"resonator.file is '{path}': ", OSError):
            return _modes_of_file(content, values["contact"]["tip_length"], section["modes"])
    try:
        modes: NormalModes = resonator_class(basis)(**section).modes
        check_kind("modes", modes, NormalModes)
    # A resonator of another package may refuse, or fail, in ways of its own.
    except Exception as error:
        fault = f"resonator={basis} cannot be made from its numbers: {one_line(error)}"
        raise ConfigurationError(fault) from error
    return modes


# A sweep over anything else asks for the same resonator, file and drive again and again.
@lru_cache(maxsize=256)
def _modes_of_beam(
    basis: str, numbers: Numbers, steel: Numbers, piezoceramic: Numbers, placement: Numbers
) -> NormalModes:
    constants = dict(piezoceramic)
    if constants.pop("constants") == "bending":
        layer = Piezoceramic(**constants)
    else:
        layer = PiezoceramicDatasheet(**constants).in_bending()
    patch = {f"patch_{edge}": place for edge, place in placement}
    with as_fault("resonator, piezoceramic or placement: "):
        modes: NormalModes = BASES[basis](
            **dict(numbers), steel=Steel(**dict(steel)), piezoceramic=layer, **patch
        ).modes
    return modes


@lru_cache(maxsize=16)
def _modes_of_file(content: bytes, tip_length: float, most: int | None) -> NormalModes:
    return modes_of(read_table(content), tip_length, most)


def _drive(values: dict[str, Any], modes: NormalModes) -> Drive:
    """Return the drive of a section, and write what follows from modes or file into the section.

    Raises:
        ConfigurationError: the file cannot be used, the modes have other electrodes, or a tone meets
            an undamped mode.
    """
    numbers = {key: value for key, value in values.items() if key != "signal"}
    signal, electrodes = values["signal"], modes.coupling.shape[1]
    if "file" in numbers:
        path, content = named_file("drive", values)
        numbers = {**numbers, "digest": values["digest"]}
        del numbers["file"]
        with as_fault(f"drive.file is '{path}': ", OSError):
            drive = _read(signal, content, electrodes, tuple(numbers.items()))
        keys = [f"drive.file, '{path}', has a tone of"] * drive.frequency.size
    else:
        if electrodes != 2:
            fault = f"drive={signal} has 2 electrodes and the resonator {electrodes}; both must have as many."
            raise ConfigurationError(f"{fault} drive=tones and drive=sampled have any number.")
        null = ""
        if numbers.get("frequency", 0.0) is None:
            numbers["frequency"] = values["frequency"] = float(modes.natural_frequency[0])
            null = " null, that is the first natural frequency,"
        with as_fault("drive: "):
            drive = _made(signal, tuple(numbers.items()))
        keys = [f"drive.frequency is{null}", "drive.frequency times drive.frequency_ratio is"]
    # At an undamped natural frequency there is no steady state.
    undamped = modes.natural_frequency[modes.damping == 0.0].tolist()
    raise_faults(
        f"{key} {tone:.12g} Hz, an undamped natural frequency with unbounded response; it must differ from "
        f"{natural:.12g} Hz by more than {RESONANCE:g} of it, or the mode be damped."
        for key, tone in zip(keys, drive.frequency.tolist(), strict=False)
        for natural in undamped
        if abs(tone - natural) <= RESONANCE * natural
    )
    return drive


@lru_cache(maxsize=4096)
def _made(signal: str, numbers: Numbers) -> Drive:
    return cast(Drive, SIGNALS[signal](**dict(numbers)).drive())


@lru_cache(maxsize=16)
def _read(signal: str, content: bytes, electrodes: int, numbers: Numbers) -> Drive:
    table, options = read_table(content), dict(numbers)
    volts, phases = ([f"{name}_{e + 1}" for e in range(electrodes)] for name in ("voltage", "phase"))
    if signal == "sampled":
        time, *voltages = _columns(table, ["time", *volts])
        degree = _DEGREES[options["interpolation"]]
        waveform = Waveform.sampled(time, np.stack(voltages), degree, options["period"])
        return Drive(np.empty(0), np.empty((electrodes, 0), np.complex128), waveform)
    frequency, *rest = _columns(table, ["frequency", *volts, *phases])
    voltages, angles = rest[:electrodes], rest[electrodes:]
    return Drive(frequency, -1j * np.stack(voltages) * np.exp(1j * np.stack(angles)))


def _columns(table: Table, names: list[str]) -> Iterator[Array]:
    """Yield the columns of a table, which must have these and no others."""
    table.check_names(names)
    for name in names:
        if name not in table.names:
            raise MeasurementError(f"'{name}' is missing; there must be the columns {', '.join(names)}.")
        yield table.numbers(name, _UNITS[name.partition("_")[0]])


def named_file(group: str, section: dict[str, Any]) -> tuple[Path, bytes]:
    """Return path and content of the file of a section, and write whole path and digest into the section.

    The content of a dataset stands for that of a file that is gone or has changed since.

    Raises:
        ConfigurationError: it cannot be read, or its digest is another than that of the section.
    """
    path, expected = Path(section["file"]).absolute(), section["digest"]
    try:
        check_file(path)
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        if (recorded := recorded_content(expected)) is not None:
            return path, recorded
        reason = getattr(error, "strerror", None) or error
        fault = f"{group}.file is '{path}', which cannot be read ({reason}); it must be a file."
        raise ConfigurationError(fault) from error
    digest = keep(content)
    if expected not in (None, digest):
        if (recorded := recorded_content(expected)) is not None:
            return path, recorded
        fault = f"{group}.digest is '{expected}'; it must be '{digest}', that of '{path}'."
        raise ConfigurationError(f"{fault} The file has changed; leave the digest out to take it as it is.")
    section |= {"file": str(path), "digest": digest}
    return path, content
