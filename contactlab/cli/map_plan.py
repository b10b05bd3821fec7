"""What a command line of `contactlab map` asks for: composed, checked, and every fault of it told."""

import sys
from collections.abc import Iterator, Sequence
from itertools import product
from math import ceil, prod
from typing import Any, Final, final

from hydra.core.config_loader import ConfigLoader
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import OmegaConf

from contactlab.cli.choices import misplaced
from contactlab.cli.composer import Composer
from contactlab.cli.progress import progress
from contactlab.cli.sweep_values import FORMS, MOST_CELLS, PREFIX, SweepError, Typed, typed
from contactlab.config import ConfigurationError, build, validate
from contactlab.config.nesting import Value
from contactlab.config.quantity import UnitError, describe, to_si
from contactlab.config.rules import FRICTION, idle_friction
from contactlab.config.schema import units_of
from contactlab.parameter import from_cf
from contactlab.suggestion import suggestion
from contactlab.sweeps.cells import Axis
from contactlab.sweeps.many import Wanted
from contactlab.sweeps.plan import Configuration, Plan, code_digest_of, with_key

CHUNK: Final = 1000
"""Runs in a chunk where nothing is said: seconds of work."""

MOST_CHUNKS: Final = 1000
"""Clusters take arrays of about so many tasks."""

LAUNCHER: Final = ("hydra/launcher", "hydra.launcher.")
"""Where the arguments begin that concern the launcher."""

TIMES: Final = ("solver.duration", "record.interval")
"""Keys that the times of the records depend on."""


def plan_of(
    loader: ConfigLoader, config_name: str, lines: Sequence[str], wanted: Wanted, chunk: int | None
) -> Plan:
    """The map that overrides and swept parameters describe.

    Args:
        loader: Hydra's.
        config_name: of the primary configuration.
        lines: the arguments: KEY=VALUE, GROUP=OPTION and sweep.KEY=VALUES.
        wanted: what is kept of every run.
        chunk: runs in a chunk; None takes the default.

    Raises:
        ConfigurationError: with every fault that was found. Nothing has been written.
    """
    planner = _Planner(loader, config_name)
    fixed = [line for line in lines if not line.startswith(PREFIX)]
    swept = planner.read([line.removeprefix(PREFIX) for line in lines if line.startswith(PREFIX)])
    planner.refuse_clashes(fixed, swept, wanted)
    planner.stop()
    groups = [one for one in swept if planner.options(one.key)]
    bases = planner.bases(fixed, groups)
    planner.stop()
    keys = [one for one in swept if one not in groups]
    found = {axis.name: axis for axis in planner.axes(bases, keys)}
    planner.stop()
    given = {line.partition("=")[0].lstrip("+") for line in fixed}
    rubbing = bases if FRICTION in given or FRICTION in found else []
    if words := idle_friction(base["law"] for base in rubbing):
        print(f"contactlab: {words}", file=sys.stderr)
    for group in groups:
        # A slash is no part of a name in a file.
        found[group.key] = Axis(group.key.replace("/", "."), group.listed)
    return Plan(
        axes=tuple(found[one.key] for one in swept),
        groups=tuple(found[one.key].name for one in groups),
        bases=tuple(bases),
        wanted=wanted,
        chunk=chunk or chunk_for(prod(len(axis.values) for axis in found.values())),
        code=code_digest_of(bases),
    )


def chunk_for(cells: int) -> int:
    """Runs in a chunk where nothing is said."""
    return max(CHUNK, ceil(cells / MOST_CHUNKS))


@final
class _Planner:
    """Collects the parts of a plan, and the faults."""

    def __init__(self, loader: ConfigLoader, config_name: str) -> None:
        self._composer = Composer(loader, config_name)
        self._parser = OverridesParser.create(config_loader=loader)
        self._faults = self._composer.faults

    def stop(self) -> None:
        """Raise what is wrong so far.

        Raises:
            ConfigurationError: something is.
        """
        if self._faults:
            raise ConfigurationError(list(dict.fromkeys(self._faults)))

    def options(self, key: str) -> list[str]:
        """The options of a group, none for what is no group."""
        return self._composer.options(key)

    def read(self, lines: Sequence[str]) -> list[Typed]:
        """The swept parameters as typed."""
        found = []
        for line in lines:
            try:
                found.append(typed(line, self._parser))
            except SweepError as error:
                self._faults.append(str(error))
                continue
            if fault := misplaced(f"{PREFIX}{line}", found[-1].key, None, self.options):
                self._faults.append(fault)
        return found

    def refuse_clashes(self, fixed: Sequence[str], swept: Sequence[Typed], wanted: Wanted) -> None:
        """Note what does not go together."""
        if not swept and not self._faults:
            self._faults.append(
                f"Nothing is swept; there must be one parameter at least: {PREFIX}KEY={FORMS}. One run "
                "alone needs no map."
            )
        keys = [one.key for one in swept]
        given = {line.partition("=")[0].lstrip("+") for line in fixed}
        for key in dict.fromkeys(keys):
            if keys.count(key) > 1 or key in given:
                self._faults.append(
                    f"{key} is given more than once; it must be either swept or set, and once. Leave "
                    "the others out."
                )
        if (cells := prod(map(len, swept))) > MOST_CELLS:
            self._faults.append(
                f"{' x '.join(str(len(one)) for one in swept)} = {cells:.4g} runs are asked for; a map "
                f"must have at most {MOST_CELLS}, whose numbers fit into memory. Take fewer values."
            )
        for one in swept:
            if len(set(one.listed)) < len(one.listed) and not one.spacing:
                self._faults.append(f"{PREFIX}{one.key} has a value twice; give every value once.")
        for line in fixed:
            if line.lstrip("+~").startswith("hydra") and not line.startswith(LAUNCHER):
                self._faults.append(
                    f"{line} has no meaning for a map; of Hydra it takes {LAUNCHER[0]}=NAME and "
                    f"{LAUNCHER[1]}KEY=VALUE. The folder is chosen by --output DIR."
                )
        for key in set(keys).intersection(TIMES) if wanted.series else ():
            self._faults.append(
                f"{key} is swept and series are kept; they must be at the same times in every run. "
                "Leave out --series or set it."
            )

    def bases(self, fixed: Sequence[str], groups: Sequence[Typed]) -> list[Configuration]:
        """A configuration for every combination of options."""
        for group in groups:
            options = self.options(group.key)
            for value in group.listed:
                if group.spacing or value not in options:
                    self._faults.append(
                        f"{PREFIX}{group.key} has {describe(value)}; it must be of {', '.join(options)}. "
                        + suggestion(str(value), options, "Choose from them.")
                    )
        self._no_lists(fixed)
        self.stop()
        return [
            base
            for chosen in product(*(group.listed for group in groups))
            for base in self._base(
                [*fixed, *(f"{g.key}={value}" for g, value in zip(groups, chosen, strict=True))]
            )
        ]

    def _no_lists(self, fixed: Sequence[str]) -> None:
        for override in self._composer.parse(fixed):
            if override.is_sweep_override():
                self._faults.append(
                    f"{override.input_line} gives several values; a map takes them as "
                    f"{PREFIX}{override.input_line}."
                )

    def _base(self, lines: Sequence[str]) -> Iterator[Configuration]:
        """The configuration of a combination; none where it is faulty."""
        composed = self._composer.compose_job(self._composer.parse(lines))
        if composed is None:
            return
        base: Any = OmegaConf.to_container(composed[0], resolve=False)
        if "${" in str(base):
            self._faults.append(
                "The configuration has references in ${...}; a map must have their values, which may "
                "depend on what is swept. Write the values."
            )
        yield base

    def axes(self, bases: Sequence[Configuration], keys: Sequence[Typed]) -> list[Axis]:
        """The axes of swept keys, every value of which at least some combination admits."""
        combinations = _trials(bases, keys)
        units = self._units(combinations)
        self.stop()
        trials = [_checked(trial) for trial in combinations]
        found = []
        for one in keys:
            unit = units.get(one.key, "")
            try:
                values = one.values(lambda value, unit=unit: _number(value, unit))  # type: ignore[misc]
            except (SweepError, UnitError) as error:
                said = (
                    str(error) if isinstance(error, SweepError) else f"{PREFIX}{one.key}: {error}."
                )
                self._faults.append(said)
                continue
            resolved = []
            with progress(len(values), "values", f"Checking {one.key}") as show:
                for count, value in enumerate(values, 1):
                    resolved.append(self._resolved(trials, one.key.split("."), value))
                    show(count)
            if len(set(resolved)) < len(resolved) and None not in resolved:
                self._faults.append(f"{PREFIX}{one.key} has a value twice; give every value once.")
            found.append(Axis(one.key, tuple(v for v in resolved if v is not None), unit))
        return found

    def _units(self, trials: Sequence[Configuration]) -> dict[str, str]:
        """Units of all keys of some sound combination of values."""
        first: ConfigurationError | None = None
        for trial in trials:
            try:
                return units_of(validate(trial))
            except ConfigurationError as error:
                first = first or error
        assert first is not None
        self._faults += first.faults
        return {}

    def _resolved(
        self,
        trials: Sequence[tuple[Configuration, Configuration]],
        path: Sequence[str],
        value: Value,
    ) -> Value | None:
        """A value as it runs; a fault where none of the combinations tried admits it."""
        first: ConfigurationError | None = None
        for trial, checked in trials:
            section = with_key(trial, path, value)[path[0]]
            try:
                found: Any = build({**checked, path[0]: section}).configuration
            except ConfigurationError as error:
                first = first or error
                continue
            for step in path:
                found = found[step]
            # A radius that a stiffness was computed from is gone from what runs.
            return value if found is None else found
        assert first is not None
        self._faults += first.faults
        return None


def _trials(bases: Sequence[Configuration], keys: Sequence[Typed]) -> list[Configuration]:
    """Combinations that values are tried in: every base with the first and with the last values."""
    found = []
    for base, end in product(bases, (0, -1)):
        trial = base
        for one in keys:
            trial = with_key(trial, one.key.split("."), one.listed[end])
        found.append(trial)
    return found


def _checked(trial: Configuration) -> tuple[Configuration, Configuration]:
    """A combination as it is, and with its sections checked once and for all if they are sound."""
    try:
        checked = validate(trial)
    except ConfigurationError:
        return trial, trial
    return trial, {section: getattr(checked, section) for section in trial}


def _number(value: Value, unit: str) -> float:
    """The SI number of an end of what is spaced.

    Raises:
        UnitError: it is none.
    """
    try:
        return to_si(str(value), from_cf(unit) if unit else "1")
    except UnitError as error:
        raise UnitError(f"{describe(value)}, {error}") from None
