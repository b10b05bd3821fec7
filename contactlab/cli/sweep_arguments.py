"""What the arguments of a sweep say: swept values by Hydra's grammar and ours, and the rest composed."""

import random
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, final

import pandas
import xarray
from hydra.core.override_parser.types import Override, QuotedString, RangeSweep, Transformer
from hydra.types import HydraContext
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli.app import choices_of
from contactlab.cli.arguments import quoted
from contactlab.cli.checking import sentences
from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.faults import one_line
from contactlab.config.nesting import Value
from contactlab.settings import Sweep
from contactlab.sweeps.plan import Configuration, Outputs, Plan
from contactlab.sweeps.values import FORMS, SweepError, call_in, spread


@final
class Arguments:
    """Reads the arguments of a sweep.

    Args:
        overrides: as Hydra parses them.
        section: the section `sweep` as Hydra composes it.
    """

    def __init__(self, overrides: Iterable[Override], section: Mapping[str, Any]) -> None:
        self.columns: dict[str, list[Value]] = {}
        self.faults: list[str] = []
        self.settings = dict(section)
        self._typed: dict[str, list[str]] = {}
        self._lines: dict[str, tuple[str, bool]] = {}
        for override in overrides:
            key = override.key_or_group
            values, typed = self._values(override)
            if key.startswith("sweep."):
                # A list of names is written as that of values is.
                if override.is_sweep_override():
                    self.settings[key.removeprefix("sweep.")] = values
                continue
            if key in self._lines:
                self.faults.append(
                    f"{key} is given more than once; it must be either swept or set, and once. Leave the "
                    "others out."
                )
            swept = override.is_sweep_override() or any(map(call_in, values))
            self._lines[key] = (str(override.input_line), swept)
            if swept:
                self.columns[key], self._typed[key] = values, typed
        if self.columns and self.settings["samples"] is not None:
            self.faults.append(
                f"{', '.join(self.columns)} and the table of sweep.samples are swept at once; it must be one "
                "of them. Put all into the table, or leave it out."
            )

    @property
    def fixed(self) -> list[str]:
        """The overrides that all runs have."""
        return [line for line, swept in self._lines.values() if not swept]

    def lines(self, plan: Plan) -> Callable[[int], list[str]]:
        """Give what gives the overrides of each run, with its values as typed where they were one by one."""
        texts = {}
        for axis in plan.axes:
            typed = self._typed.get(axis.key, ())
            as_typed = len(typed) == len(axis.values)
            texts[axis.key] = typed if as_typed else [_text(value) for value in axis.values]

        def lines_of(cell: int) -> list[str]:
            places = zip(texts.items(), plan.places(cell), strict=True)
            chosen = {key: column[place] for (key, column), place in places}
            lines = [
                f"{line.partition('=')[0]}={chosen.pop(key)}" if swept else line
                for key, (line, swept) in self._lines.items()
            ]
            return [*lines, *(f"{key}={text}" for key, text in chosen.items())]

        return lines_of

    def _values(self, override: Override) -> tuple[list[Any], list[str]]:
        """Give the values of an override, and how they are typed."""
        line = str(override.input_line)
        if override.is_delete():
            return [], []
        if not override.is_sweep_override():
            return [_plain(override.value())], [line.partition("=")[2]]
        if isinstance(said := override.value(), RangeSweep):
            text = f"range({said.start},{said.stop},{said.step})"
            if not said.shuffle:
                return [text], []
            try:
                values = spread(override.key_or_group, text)
            except SweepError as error:
                self.faults.append(str(error))
                return [], []
            random.shuffle(values)
            return values, [_text(value) for value in values]
        if not override.is_discrete_sweep():
            self.faults.append(f"{line} cannot be swept; a swept parameter must have {FORMS}.")
            return [], []
        values = [_plain(value) for value in override.sweep_iterator(Transformer.identity)]
        return values, [str(text) for text in override.sweep_string_iterator()]


@final
class HydraComposer:
    """Composes configurations by Hydra, once for every combination of options; see `planning.Composer`."""

    def __init__(self, context: HydraContext, config: DictConfig, fixed: Sequence[str]) -> None:
        self._loader = context.config_loader
        self._config = config
        self._fixed = list(fixed)
        self._composed: dict[tuple[Value, ...], DictConfig] = {}

    def options(self, key: str) -> list[str]:
        """Give the options of a group; none for what is no group."""
        return self._loader.get_group_options(key)

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these options, all else as it is set."""
        lines = [*self._fixed, *(f"{group}={option}" for group, option in chosen.items())]
        try:
            composed = self._loader.load_sweep_config(self._config, lines)
        # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
        except Exception as error:
            raise ConfigurationError(sentences(error, lines)) from error
        everything: dict[str, Any] = OmegaConf.to_container(composed, resolve=False)  # type: ignore[assignment]
        sweep = everything["hydra"]["sweep"]
        # The folder is told before Hydra knows the job.
        sweep["subdir"] = str(sweep["subdir"]).replace("${hydra:", "${hydra.")
        place = self._composed[tuple(chosen.values())] = OmegaConf.create(everything)
        OmegaConf.copy_cache(self._config, place)
        return {key: value for key, value in everything.items() if key not in ("hydra", "sweep")}

    def build(self, configuration: Configuration) -> Setup:
        """Build what a configuration says, with values in the place of references to them."""
        if "${" not in str(configuration):
            return build(configuration)
        try:
            resolved = OmegaConf.to_container(OmegaConf.create(dict(configuration)), resolve=True)
        except OmegaConfBaseException as error:
            words = f"{one_line(error)} Correct the reference in ${{...}}."
            raise ConfigurationError([words]) from error
        return build(resolved)  # type: ignore[arg-type]

    def job(self, plan: Plan, cell: int, lines: Sequence[str]) -> tuple[str, dict[str, str | None]]:
        """Name the folder of a run with these overrides, as Hydra does, and give the options chosen.

        Raises:
            ConfigurationError: the name refers to what there is not.
        """
        point = plan.point(cell)
        place = self._composed[tuple(point.pop(group) for group in plan.groups)]
        said = place.hydra.job.config.override_dirname
        told = sorted(line for line in lines if line.partition("=")[0] not in said.exclude_keys)
        place.hydra.job.override_dirname = said.item_sep.join(told).replace("=", said.kv_sep)
        place.hydra.job.num, place.hydra.job.id = cell, str(cell)
        try:
            for key, value in point.items():
                OmegaConf.update(place, key, value, force_add=True)
            return str(OmegaConf.select(place, "hydra.sweep.subdir")), choices_of(place.hydra)
        except OmegaConfBaseException as error:
            raise ConfigurationError(
                [f"hydra.sweep.subdir cannot be resolved: {one_line(error)} Name a directory."]
            ) from error


def outputs_of(settings: Sweep) -> Outputs:
    """Take what is kept of a run.

    Raises:
        ConfigurationError: there is no such metric or series.
    """
    try:
        return Outputs.named(settings.metrics, settings.series or ())
    except ValueError as error:
        raise ConfigurationError([str(error)]) from error


def table(path: str) -> dict[str, list[Value]]:
    """Read a table of samples, CSV or netCDF: its values by the names of its columns.

    Raises:
        ConfigurationError: it cannot be read, or lacks a value.
    """
    try:
        if path.endswith(".csv"):
            rows = pandas.read_csv(path, skipinitialspace=True)
        else:
            with xarray.open_dataset(path, decode_times=False) as dataset:
                said = {name: values.attrs for name, values in dataset.variables.items()}
                # The dataset of a sweep says which of its variables are keys.
                keys = {name: text["key"] for name, text in said.items() if "key" in text}
                rows = dataset.to_dataframe()
                rows = rows.reset_index()[[*keys]].rename(columns=keys) if keys else rows
    # A file can be anything.
    except Exception as error:
        raise ConfigurationError(
            [
                f"sweep.samples is '{path}' and cannot be read ({one_line(error)}); it must be a table, CSV "
                "or netCDF, whose columns are keys and whose rows are runs."
            ]
        ) from error
    empty = [
        f"sweep.samples has no {name} in row {int(row) + 1} of '{path}'; every run must have one. Add it, or "
        "leave the row out."
        for name in rows
        for row in rows[name].isna().to_numpy().nonzero()[0]
    ]
    if empty:
        raise ConfigurationError(empty)
    return {str(name).strip(): rows[name].tolist() for name in rows}


def _plain(value: Any) -> Any:
    return value.text if isinstance(value, QuotedString) else value


def _text(value: Value) -> str:
    """Give a value as an override has it."""
    if isinstance(value, str):
        return value if re.fullmatch(r"[\w.+-]+", value, re.ASCII) else quoted(value)
    return str(value).lower() if isinstance(value, bool) else repr(value)
