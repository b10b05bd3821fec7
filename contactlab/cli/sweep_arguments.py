"""What the arguments of a sweep say: swept values by Hydra's grammar and ours, and the rest composed."""

import csv
import random
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, final

import pandas
import xarray
from hydra.core.override_parser.types import Override, QuotedString, RangeSweep, Transformer
from hydra.types import HydraContext
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli.app import choices_of
from contactlab.cli.arguments import quoted
from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.composition import resolved, sentences
from contactlab.config.faults import one_line
from contactlab.config.nesting import Value
from contactlab.sweeps.plan import Configuration, Plan, raise_faults
from contactlab.sweeps.state import Job, key_of
from contactlab.sweeps.values import FORMS, call_in, spread


@final
class Arguments:
    """Reads the arguments of a sweep, and composes configurations by Hydra; see `plan.Composer`.

    It takes what Hydra gives a sweeper, the overrides as parsed, and the section `sweep` as composed.
    """

    def __init__(
        self,
        context: HydraContext,
        config: DictConfig,
        overrides: Iterable[Override],
        settings: Mapping[str, Any],
    ) -> None:
        self.options = context.config_loader.get_group_options
        self.columns: dict[str, list[Value]] = {}
        self.faults: list[str] = []
        self.settings = dict(settings)
        self._loader, self._config = context.config_loader, config
        self._lines: dict[str, str] = {}
        self._composed: dict[tuple[Value, ...], DictConfig] = {}
        for override in overrides:
            key = override.key_or_group
            values = self._values(override)
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
            self._lines[key] = str(override.input_line)
            if override.is_sweep_override() or any(map(call_in, values)):
                self.columns[key] = values
        if self.columns and self.settings["samples"] is not None:
            self.faults.append(
                f"{', '.join(self.columns)} and the table of sweep.samples are swept at once; it must be one "
                "of them. Put all into the table, or leave it out."
            )

    @property
    def fixed(self) -> list[str]:
        """The overrides that all runs have."""
        return [line for key, line in self._lines.items() if key not in self.columns]

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these options, all else as it is set."""
        options = tuple(chosen.values())
        if options not in self._composed:
            self._composed[options] = self._placed(chosen)
        everything = _contents(self._composed[options])
        return {key: value for key, value in everything.items() if key not in ("hydra", "sweep")}

    def _placed(self, chosen: Mapping[str, Value]) -> DictConfig:
        """Compose with these options, and with the folder told as it is before Hydra knows the job."""
        lines = [*self.fixed, *(f"{group}={option}" for group, option in chosen.items())]
        try:
            composed = self._loader.load_sweep_config(self._config, lines)
        # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
        except Exception as error:
            raise ConfigurationError(sentences(error, lines)) from error
        everything = _contents(composed)
        sweep = everything["hydra"]["sweep"]
        sweep["subdir"] = str(sweep["subdir"]).replace("${hydra:", "${hydra.")
        place = OmegaConf.create(everything)
        OmegaConf.copy_cache(self._config, place)
        return place

    def build(self, configuration: Configuration) -> Setup:
        """Build what a configuration says, with values in the place of references to them."""
        if "${" not in str(configuration):
            return build(configuration)
        return build(resolved(OmegaConf.create(dict(configuration))))

    def job(self, plan: Plan, cell: int, setup: Setup) -> tuple[str, Job]:
        """Give the name of a run's folder and what it is asked for, values as typed where they are listed.

        Raises:
            ConfigurationError: the name, made as Hydra makes it, refers to what there is not.
        """
        point, lines = plan.point(cell), dict(self._lines)
        for axis, place in zip(plan.axes, plan.places(cell), strict=True):
            column = self.columns.get(axis.key, axis.values)
            typed = axis.values if any(map(call_in, column)) else column
            before = lines.get(axis.key, axis.key).partition("=")[0]
            lines[axis.key] = f"{before}={_text(typed[place])}"
        composed = self._composed[tuple(point.pop(group) for group in plan.groups)]
        hydra = composed.hydra
        said = hydra.job.config.override_dirname
        told = sorted(x for x in lines.values() if x.partition("=")[0] not in said.exclude_keys)
        hydra.job.override_dirname = said.item_sep.join(told).replace("=", said.kv_sep)
        hydra.job.num, hydra.job.id = cell, str(cell)
        try:
            for key, value in point.items():
                OmegaConf.update(composed, key, value, force_add=True)
            name = str(OmegaConf.select(composed, "hydra.sweep.subdir"))
        except OmegaConfBaseException as error:
            raise ConfigurationError(
                [f"hydra.sweep.subdir cannot be resolved: {one_line(error)} Name a directory."]
            ) from error
        job = Job(key_of(setup), tuple(lines.values()), choices_of(hydra), setup.configuration)
        return name, job

    def _values(self, override: Override) -> list[Any]:
        """Give the values of an override."""
        if override.is_delete():
            return []
        said = override.value()
        if not override.is_sweep_override():
            return [_plain(said)]
        if isinstance(said, RangeSweep):
            values: list[Any] = [f"range({said.start},{said.stop},{said.step})"]
            if said.shuffle:
                values = spread(override.key_or_group, values[0])
                random.shuffle(values)
            return values
        if not override.is_discrete_sweep():
            self.faults.append(f"{override.input_line} cannot be swept; a swept parameter must have {FORMS}.")
            return []
        return [_plain(value) for value in override.sweep_iterator(Transformer.identity)]


def table(path: str) -> dict[str, list[Value]]:
    """Read a table of samples, CSV or netCDF: its values by the names of its columns.

    Raises:
        ConfigurationError: it cannot be read, or lacks a value.
    """
    try:
        if path.endswith(".csv"):
            raise_faults(_faults_of_cells(path))
            # Without False a column too many would become the index, and all others would shift.
            rows = pandas.read_csv(path, skipinitialspace=True, index_col=False)
        else:
            with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as dataset:
                said = {name: values.attrs for name, values in dataset.variables.items()}
                # The dataset of a sweep says which of its variables are keys.
                keys = {name: text["key"] for name, text in said.items() if "key" in text}
                rows = dataset.to_dataframe()
                rows = rows.reset_index()[[*keys]].rename(columns=keys) if keys else rows
    except ConfigurationError:
        raise
    # A file can be anything.
    except Exception as error:
        # Numbers of the netCDF library, and what others say, tell of the reader.
        why = "is no table that can be read"
        if isinstance(error, OSError) and (error.errno or 0) > 0:
            why = f"cannot be read ({error.strerror})"
        words = f"sweep.samples is '{path}' and {why}; it must be a table, CSV (NAME.csv) or netCDF, whose "
        words += "columns are keys and whose rows are runs."
        raise ConfigurationError([words]) from error
    raise_faults(
        f"sweep.samples has no {name} in row {int(row) + 1} of '{path}'; every run must have one. Add it, or "
        "leave the row out."
        for name in rows
        for row in rows[name].isna().to_numpy().nonzero()[0]
    )
    columns = {str(name).strip(): rows[name].tolist() for name in rows}
    raise_faults(
        f"sweep.samples has a reference in row {row} of '{path}', column {name}; a cell must be a number or "
        "the name of an option. Write the value."
        for name, column in columns.items()
        for row, value in enumerate(column, 1)
        if "${" in str(value)
    )
    return columns


def _faults_of_cells(path: str) -> Iterator[str]:
    """Check that the rows of a CSV file have the cells of its header, and its columns different names."""
    with Path(path).open(newline="", encoding="utf-8-sig") as file:
        rows = [row for row in csv.reader(file, skipinitialspace=True) if row]
    header = [name.strip() for name in rows[0]] if rows else []
    for name, count in Counter(filter(None, header)).items():
        if count > 1:
            yield f"sweep.samples has {count} columns {name} in '{path}'; it must have one. Leave one out."
    for number, row in enumerate(rows[1:], 1):
        if any(cell.strip() for cell in row[len(header) :]):
            yield (
                f"sweep.samples has {len(row)} cells in row {number} of '{path}' and {len(header)} columns; "
                "every row must have a cell for each column. Separate the cells by single commas."
            )
            # The others have the same fault.
            break


def _plain(value: Any) -> Any:
    return value.text if isinstance(value, QuotedString) else value


def _text(value: Value) -> str:
    """Give a value as an override has it."""
    if isinstance(value, str):
        return value if re.fullmatch(r"[\w.+-]+", value, re.ASCII) else quoted(value)
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _contents(composed: DictConfig) -> dict[str, Any]:
    """Give what a configuration holds, references as they stand."""
    everything: Any = OmegaConf.to_container(composed)
    return dict(everything)
