"""Hydra's composition of a command line, with faults collected instead of raised.

Hydra stops at the first fault and has no opinion on values. Here composition goes on after a fault
and a key that does not exist is left to the schema, so that unknown options, unknown keys and bad
values come out together. Where the command line is sound, the result is Hydra's own.
"""

import warnings
from collections.abc import Sequence
from dataclasses import fields
from math import prod
from typing import final

from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.conf import HydraConf
from hydra.core.config_loader import ConfigLoader
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli.choices import misplaced
from contactlab.cli.sweep_values import SweepError, range_values
from contactlab.cli.verbs import VERBS
from contactlab.config.faults import one_line
from contactlab.config.quantity import describe
from contactlab.suggestion import suggestion

MOST_JOBS = 100_000
"""Jobs of a sweep; each leaves a folder, and takes a fifth of a second beside its run."""

_OF_HYDRA = [field.name for field in fields(HydraConf)]
"""Keys of Hydra's own part of the configuration."""

BASIC_SWEEPER = f"{BasicSweeper.__module__}.{BasicSweeper.__qualname__}"
"""Hydra's own sweeper, all of whose jobs are known beforehand."""


def sweeper_of(composed: DictConfig) -> str:
    """The class of the sweeper."""
    return str(composed.hydra.sweeper.get("_target_", BASIC_SWEEPER))


def parted(composed: DictConfig) -> tuple[DictConfig, DictConfig]:
    """A copy of what a job is given, and Hydra's own part itself."""
    mine = [str(key) for key in composed if key != "hydra"]
    return OmegaConf.masked_copy(composed, mine), composed.hydra


@final
class Composer:
    """Hydra's composition, with faults collected instead of raised."""

    def __init__(self, loader: ConfigLoader, config_name: str) -> None:
        self.faults: list[str] = []
        self._loader = loader
        self._config_name = config_name
        self._parser = OverridesParser.create(config_loader=loader)
        self._composed: dict[tuple[str, ...], DictConfig | None] = {}
        self._groups: dict[str, list[str]] = {}

    def parse(self, lines: Sequence[str]) -> list[Override]:
        """The overrides that can be read."""
        overrides = []
        for line in lines:
            try:
                (override,) = self._parser.parse_overrides([line])
            # ValueError: a whole number of thousands of digits.
            except (HydraException, ValueError):
                self.faults.append(
                    f"{line} cannot be read; an argument must have the form KEY=VALUE or "
                    "GROUP=OPTION. Quote it if the value has a space, 'KEY=1 um', and the value "
                    "too if it has special characters, \"KEY='1 µm'\". A verb stands first: "
                    f"{', '.join(VERBS)}."
                )
                continue
            if not override.key_or_group:
                self.faults.append(f"{line} has no key; it must have the form KEY=VALUE. Name one.")
            elif fault := self._misplaced(override):
                self.faults.append(fault)
            else:
                overrides.append(override)
        return overrides

    def _misplaced(self, override: Override) -> str:
        if override.is_delete():
            return ""
        value = None if override.is_sweep_override() else override.value()
        if override.is_hydra_override() and value == "":
            return (
                f"{override.input_line} is empty, as of a shell variable that is not set; it must have a "
                "value. Leave it out for the default."
            )
        steps = override.key_or_group.split(".")
        if override.is_hydra_override() and len(steps) > 1 and steps[1] not in _OF_HYDRA:
            return f"{override.input_line} is no key of Hydra's. {suggestion(steps[1], _OF_HYDRA)}".strip()
        return misplaced(str(override.input_line), override.key_or_group, value, self.options)

    def refuse_sweeps(self, overrides: list[Override]) -> list[Override]:
        """The overrides that give one value; the others are faults of a single run."""
        for override in overrides:
            if override.is_sweep_override():
                self.faults.append(
                    f"{override.input_line} gives several values; a single run takes one. "
                    "Add -m to run every combination."
                )
        return [override for override in overrides if not override.is_sweep_override()]

    def jobs(self, overrides: list[Override], base: DictConfig | None) -> list[list[Override]]:
        """Every job of a sweep; of a sweeper that chooses its values itself, what they share."""
        shared = [override for override in overrides if not override.is_sweep_override()]
        if base is not None and sweeper_of(base) != BASIC_SWEEPER:
            return [shared]
        parameters = {} if base is None else base.hydra.sweeper.get("params") or {}
        swept = self.parse([f"{key}={value}" for key, value in parameters.items()])
        hydras = [override for override in shared if override.is_hydra_override()]
        swept += [override for override in overrides if override not in hydras]
        swept = [listed for override in swept for listed in self._listed(override)]
        if self._too_many(swept):
            return [shared]
        try:
            (batch,) = BasicSweeper.split_arguments(swept, None)
        except HydraException as error:
            self.faults.append(f"{one_line(error)} Give a list of values or a range.")
            return [shared]
        return [hydras + self._parser.parse_overrides(list(job)) for job in batch]

    def _listed(self, override: Override) -> list[Override]:
        """An override with its range written out, since Hydra's own goes past its end."""
        if not override.is_range_sweep():
            return [override]
        try:
            values = range_values(override, MOST_JOBS)
        except SweepError as error:
            self.faults.append(str(error))
            return []
        if not values:
            self.faults.append(
                f"{override.input_line} has no values; a range ends before its STOP."
            )
            return []
        key = str(override.input_line).partition("=")[0]
        listed = ",".join(map(repr, values))
        shuffled = override.value().shuffle  # type: ignore[union-attr]
        return self._parser.parse_overrides(
            [f"{key}={f'shuffle({listed})' if shuffled else listed}"]
        )

    def _too_many(self, overrides: Sequence[Override]) -> bool:
        """Whether there are more jobs than a sweep can have; before any is made."""
        swept = [override for override in overrides if override.is_discrete_sweep()]
        counts = [sum(1 for _ in override.sweep_iterator()) for override in swept]
        self.faults += [
            f"{override.input_line} has no values; it must have one at least. Name one."
            for override, count in zip(swept, counts, strict=True)
            if not count
        ]
        if too_many := prod(counts) > MOST_JOBS:
            self.faults.append(
                f"{' x '.join(map(str, counts))} = {prod(counts):.4g} runs are asked for; a sweep of folders "
                f"must have at most {MOST_JOBS}. Take fewer values, or `contactlab map`, which keeps numbers "
                "alone."
            )
        return too_many

    def compose_whole(self, lines: Sequence[str]) -> DictConfig | None:
        """The configuration just as Hydra composes it, None where it refuses."""
        try:
            return self._load(tuple(lines))
        # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
        except Exception:
            return None

    def compose_job(self, job: list[Override]) -> tuple[DictConfig, DictConfig] | None:
        """The configuration of a job as far as it can be composed.

        Returns:
            What the job is given, and Hydra's own part, which jobs with the same options share.
        """
        composed = self.compose(job)
        if composed is None:
            return None
        task, hydra = parted(composed)
        for override in job:
            if self._is_value(override):
                self._set(task, override)
        return task, hydra

    def compose(self, overrides: list[Override]) -> DictConfig | None:
        """The configuration of the groups' options, without the values of single keys.

        Faulty options are left out; None where it fails even so.
        """
        lines = tuple(str(o.input_line) for o in overrides if not self._is_value(o))
        if lines not in self._composed:
            self._composed[lines] = self._compose_sound(lines)
        return self._composed[lines]

    def _compose_sound(self, lines: tuple[str, ...]) -> DictConfig | None:
        if (composed := self.compose_whole(lines)) is not None:
            return composed
        sound: list[str] = []
        faulty: list[str] = []
        # What stands above first: the options of law/normal depend on the law, and the keys of
        # hydra.launcher on the choice of hydra/launcher.
        for line in sorted(lines, key=_depth):
            group = _group(line)
            # With the wrong law nothing can be said of its parts.
            if any(group.startswith(f"{above}/") for above in faulty):
                continue
            try:
                self._load((*sound, line))
                sound.append(line)
            except Exception as error:
                self.faults.append(self._explain(line, error, sound))
                faulty.append(group)
        try:
            return self._load(tuple(sound))
        except Exception as error:
            self.faults.append(one_line(error))
            return None

    def _load(self, lines: tuple[str, ...]) -> DictConfig:
        # Hydra warns of a folder of options that there is not, and goes on without.
        with warnings.catch_warnings():
            warnings.simplefilter("error", UserWarning)
            # Spelled as Hydra spells it, so that a loader can tell that it is the same.
            return self._loader.load_configuration(
                config_name=self._config_name,
                overrides=list(lines),
                run_mode=RunMode.RUN,
                from_shell=True,
                validate_sweep_overrides=True,
            )

    def _is_value(self, override: Override) -> bool:
        """Whether an override sets a key, rather than choose an option or concern Hydra."""
        if override.is_hydra_override() or override.is_delete() or override.package is not None:
            return False
        if not override.is_sweep_override() and isinstance(override.value(), dict):
            return True
        return not self.options(override.key_or_group)

    def options(self, group: str) -> list[str]:
        """A group's options, none for what is no group."""
        if group not in self._groups:
            self._groups[group] = self._loader.get_group_options(group)
        return self._groups[group]

    def _set(self, composed: DictConfig, override: Override) -> None:
        """Set a key, one that does not exist as well: the schema refuses it with all the others."""
        key = override.key_or_group
        if override.is_add() and OmegaConf.select(composed, key) is not None:
            self.faults.append(f"{override.input_line} adds a key that exists; leave out the '+'.")
        try:
            OmegaConf.update(composed, key, override.value(), merge=True, force_add=True)
        except OmegaConfBaseException as error:
            self.faults.append(f"{override.input_line} cannot be set: {one_line(error)}")

    def _explain(self, line: str, error: Exception, sound: list[str]) -> str:
        """Why an override that is no value fails, after those that do not."""
        (override,) = self._parser.parse_overrides([line])
        group, value = override.key_or_group, override.value()
        options = self.options(group)
        if not options or value in options:
            above = group.rpartition("/")[0]
            composed = self.compose_whole(sound)
            chosen = composed.hydra.runtime.choices.get(above) if above and composed else None
            if options and chosen:
                return (
                    f"{line} does not belong to {above}={chosen}; it must be absent with this choice "
                    f"of {above}. Leave it out or choose another {above}: contactlab {above}s lists "
                    "what each is made of."
                )
            return f"{line} cannot be composed: {one_line(error)}"
        hint = suggestion(str(value), options, "Choose one of them.")
        return f"{group} is {describe(value)}; it must be one of {', '.join(options)}. {hint}"


def _group(line: str) -> str:
    """The group that an override chooses from."""
    return line.partition("=")[0].partition("@")[0].lstrip("+~")


def _depth(line: str) -> tuple[bool, int]:
    """How deep the group of an override lies; a key lies below every group."""
    group = _group(line)
    return "." in group, group.count("/")
