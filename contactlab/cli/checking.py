"""What a command line gets wrong, told before anything is written: in its composition and in its values."""

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any, final

from hydra.conf import HydraConf
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.experimental.callback import Callback
from omegaconf import DictConfig, OmegaConf, read_write
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli.arguments import gives_several, quoted
from contactlab.cli.collect import collect_swept
from contactlab.cli.jobs import refusals
from contactlab.cli.study import refusals_of, setups_of
from contactlab.cli.terminal import INCOMPLETE, REFUSED, refuse, tell
from contactlab.config import ConfigurationError, build
from contactlab.config.composition import SEVERAL, resolved, unknown_override
from contactlab.config.faults import one_line
from contactlab.config.nesting import flat
from contactlab.config.options import group_told_by
from contactlab.config.schema import BYTES_A_RECORD, FRICTION, idle_friction
from contactlab.results.files import STATE
from contactlab.sweeps import state

IN_FILE = 60
"""Bytes of a record in run.nc, compressed; runs of all laws and intervals took 52 to 80."""

WORTH_SAYING = 100e6
"""Bytes on disk that one wants to know of beforehand."""

_OF_HYDRA = {field.name for field in fields(HydraConf)}
"""Keys of Hydra's own part of the configuration."""


@final
class Check(Callback):
    """Checks a single run before Hydra makes its folder."""

    def on_run_start(self, config: DictConfig, **_: Any) -> None:
        """Refuse a run by what is wrong with it, and announce a large one.

        Raises:
            SystemExit: a fault of the user's. Hydra makes warnings of other exceptions here.
        """
        lines = typed(config.hydra.overrides.hydra) + typed(config.hydra.overrides.task)
        verb = str(config.study.name)
        faults = [*misplaced(lines), *refusals_of(verb, lines)]
        try:
            setup = build(resolved(config))
            configuration = setup.configuration
            faults = faults or list(_folder_faults(config))
            if over := config.sweep.over:
                setups_of(lines, list(over))
            is_set = not faults and sets_friction(lines)
            if is_set and (words := idle_friction([configuration["law"]])):
                tell(f"contactlab: {words}", sys.stderr)
        except ConfigurationError as error:
            faults += error.faults
        if faults:
            sys.exit(refuse(faults))
        announce([configuration])

    def on_multirun_start(self, config: DictConfig, **_: Any) -> None:
        """Hold the folder of a sweep for all its jobs, which else name it by their own overrides."""
        if _is_ours(config):
            return
        # What it refers to may not be there yet; each job then says so.
        with suppress(OmegaConfBaseException), read_write(config.hydra):
            folder = str(config.hydra.sweep.dir)
            config.hydra.sweep.dir = folder
            config.hydra.overrides.hydra.append(f"hydra.sweep.dir={quoted(folder)}")

    def on_multirun_end(self, config: DictConfig, **_: Any) -> None:
        """Collect what a sweep left, and give its exit status by that, where the sweeper is another.

        Raises:
            SystemExit: with it, where a run is not complete.
        """
        if _is_ours(config):
            return
        folder = Path(str(config.hydra.sweep.dir))
        collect_swept(folder)
        found = [state.read_state(path.parent) for path in folder.rglob(STATE)]
        states = {each.state for each in found if each}
        if states != {state.COMPLETE}:
            sys.exit(REFUSED if state.REFUSED in states else INCOMPLETE)


def _is_ours(config: DictConfig) -> bool:
    """Tell whether the sweeper is ours, which does all this itself."""
    return "contactlab" in str(config.hydra.sweeper.get("_target_"))


def typed(overrides: Any) -> list[str]:
    """Give arguments as they were typed: what they refer to is none of their own."""
    return [str(line) for line in OmegaConf.to_container(overrides, resolve=False) or ()]


def misplaced(lines: Sequence[str], *, swept: bool = False) -> list[str]:
    """Say which arguments, as typed, can be none of a run's or of a sweep's, though Hydra composes them."""
    overrides = OverridesParser.create().parse_overrides(list(lines))
    faults = [fault for override in overrides for fault in _faults_of(override)]
    if swept:
        return faults
    faults += [SEVERAL.format(line) for line in lines if gives_several(line)]
    return faults + [
        f"{line} says how the runs of a sweep are made; a single run must be without. Add -m, or leave "
        "it out."
        for line in lines
        if line.lstrip("+").startswith("sweep.") and not line.startswith("sweep.over=")
    ]


def _faults_of(override: Override) -> Iterator[str]:
    if override.is_delete():
        return
    line, key = override.input_line, override.key_or_group
    group = key.replace(".", "/")
    value = None if override.is_sweep_override() else override.value()
    if override.is_hydra_override() and value == "":
        yield (
            f"{line} is empty, as of a shell variable that is not set; it must have a value. "
            "Leave it out for the default."
        )
    elif override.is_hydra_override() and "." in key and key.split(".")[1] not in _OF_HYDRA:
        yield unknown_override(key)
    below = flat({key: value}) if isinstance(value, dict) else [key]
    # Asked of what may name an option alone: Hydra looks through all files for its answer.
    is_choice = key.count(".") == 1 and isinstance(value, str | None)
    loader = GlobalHydra.instance().config_loader()
    if is_choice and (options := loader.get_group_options(group)):
        yield (
            f"{line} gives a value to a group of keys; it must be a choice, {group}=NAME. "
            f"Choose one of {', '.join(options)}."
        )
    if isinstance(value, list) and "." not in key and loader.get_group_options(group):
        several = ",".join(map(str, value))
        yield (
            f"{line} chooses {len(value)} options of a group, of which a run has one. Choose one, or run all "
            f"by contactlab -m {key}={several}."
        )
    # A law, a part, a basis comes with its parameters, and is not renamed by a key.
    for told in filter(None, map(group_told_by, below)):
        yield (
            f"{line} would hand the parameters of one {told} to another; they must be chosen together. "
            f"Choose one by {told}=NAME."
        )


def _folder_faults(config: DictConfig) -> Iterator[str]:
    """Say why the run cannot be written where it is to go."""
    below = Path(config.hydra.output_subdir or "")
    if below.is_absolute() or ".." in below.parts:
        yield f"hydra.output_subdir is '{below}'; it must be a folder below that of the run. Leave it out."
        return
    try:
        # For ${hydra:...} in its name.
        HydraConfig.instance().set_config(config)
        folder = Path(str(OmegaConf.select(config, "hydra.run.dir")))
    except OmegaConfBaseException as error:
        yield f"hydra.run.dir cannot be resolved: {one_line(error)} Name a directory."
        return
    yield from refusals(folder)


def sets_friction(lines: Iterable[str]) -> bool:
    """Tell whether an argument sets the friction coefficient that laws share."""
    return any(line.lstrip("+").startswith(f"{FRICTION}=") for line in lines)


def announce(configurations: Iterable[Mapping[str, Any]]) -> None:
    """Say how much the runs of resolved configurations will leave, if it is much."""
    records = [*map(_records, configurations)]
    if (size := IN_FILE * sum(records)) < WORTH_SAYING:
        return
    runs = "The run leaves" if len(records) == 1 else f"The {len(records)} runs leave"
    tell(
        f"{runs} about {_spelled(size)}: {sum(records):.3g} records of {IN_FILE} bytes. The "
        f"longest takes {_spelled(BYTES_A_RECORD * max(records))} of memory meanwhile. A larger "
        "record.interval makes both smaller and does not change the motion.",
        sys.stderr,
    )


def announce_series(runs: int, names: int, configuration: Mapping[str, Any]) -> None:
    """Say how much the series of so many names will take in a sweep that keeps metrics, if it is much."""
    records = _records(configuration)
    if (size := 8.0 * runs * names * records) >= WORTH_SAYING:
        tell(
            f"The series take up to {_spelled(size)}: {runs} runs of {records:.3g} records. A larger "
            "record.interval or fewer names of sweep.series make it less.",
            sys.stderr,
        )


def _records(configuration: Mapping[str, Any]) -> float:
    number: float = configuration["solver"]["duration"] / configuration["record"]["interval"]
    return number


def _spelled(size: float) -> str:
    return f"{size / 1e9:.2g} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"
