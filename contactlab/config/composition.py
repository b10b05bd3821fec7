"""Configurations from overrides, by Hydra: files of `conf/`, and behind them what the classes declare."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, final

import hydra
from hydra import errors, utils
from hydra.conf import HydraConf
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.plugins import Plugins
from hydra.plugins.config_source import ConfigResult, ConfigSource
from hydra.plugins.search_path_plugin import SearchPathPlugin
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from contactlab.config.faults import ConfigurationError, one_line, raise_faults
from contactlab.config.groups import FAMILIES, GROUPS, LAW, Section
from contactlab.config.nesting import flat, nested, quoted
from contactlab.config.options import (
    conf_directory,
    content,
    fault_of_option,
    group_selected_by,
    groups,
    help_on_keys,
    known_keys,
    unknown_key,
)
from contactlab.laws.registry import ways_to_choose
from contactlab.quantity import describe
from contactlab.results.yaml_text import check_expansion
from contactlab.suggestion import suggestion

COMMAND: Final = "config"
RUN: Final = "run"
"""Configurations of the command, and of a run, which the first includes."""

SCHEME: Final = "contactlab"
EXPERIMENT: Final = "experiment"
"""The group whose options are files alone: named sets of changes to the default run."""

_ALLOW: Final = getattr(utils, "execution_whitelist", None)
"""Restriction of what a configuration may import; Hydra has it since 1.4, and with it other names."""

VERSION_BASE: Final[dict[str, Any]] = {} if _ALLOW else {"version_base": "1.3"}
"""Option of Hydra before 1.4, which behaves like its first versions without."""

ENVIRONMENT: Final = "${oc.env"
"""A reference to a variable of the environment."""

_BEYOND: Final = re.compile(r"(?<=[=,])\s*([-+]?[\d.][^,='\"]*[°µμ²³·^][^,='\"]*)(?=,|$)")
"""A number with a unit that has characters beyond those of Hydra's grammar."""

_FUNCTION: Final = re.compile(r"[^=]*=\s*'?(linspace|geomspace|range)\(")
"""An override that lists values by a function, which the command quotes as a whole."""


def compose(overrides: Sequence[str] = (), config_dir: str | Path | None = None) -> dict[str, Any]:
    """Compose a configuration, not yet checked; arguments and errors are those of `contactlab.build`."""
    # Files of other folders may change.
    return _merged(_composed(*overrides), {}) if config_dir is None else _compose(overrides, config_dir)


def _compose(overrides: Sequence[str], config_dir: str | Path | None) -> dict[str, Any]:
    refuse_lines(overrides)
    idle = (line for line in overrides if line.lstrip("+~").startswith("hydra."))
    raise_faults(f"{line} is the command's; a run has none." for line in idle)
    searched = []
    if config_dir is not None:
        folder = Path(config_dir).resolve()
        if not folder.is_dir():
            raise ConfigurationError(f"config_dir is '{config_dir}'; it must be a folder that exists.")
        refuse_expansions([str(folder)])
        searched = [f"hydra.searchpath=[{quoted(f'file://{folder}')}]"]
    try:
        with started():
            composed = hydra.compose(RUN, overrides=[*searched, *map(readable, overrides)])
    # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
    except Exception as error:
        raise ConfigurationError(faults_of(error, overrides)) from None
    return resolved(composed)


def completed(configuration: Mapping[str, Any], config_dir: str | Path | None = None) -> dict[str, Any]:
    """Return a configuration with the defaults of what is absent, its groups chosen by name.

    Raises:
        ConfigurationError: an option does not exist, or a key occurs twice.
    """
    configuration = _by_group(configuration)
    options: dict[str, str] = {}
    for group, value in configuration.items():
        if group == "law" or group in GROUPS:
            options |= _options_in(group, LAW if group == "law" else GROUPS[group], value)
        elif group == EXPERIMENT and value is not None:
            options[group] = str(value)
    law = options.get("law", "")
    parts = {
        next(iter(entry)) for entry in content("law", law).get("defaults", ()) if isinstance(entry, dict)
    }
    keys: Any = configuration.get("law")
    for part in parts & {*FAMILIES} & {*(keys if isinstance(keys, Mapping) else ())}:
        options |= _options_in(f"law/{part}", FAMILIES[part], keys[part])
    values = {group: value for group, value in configuration.items() if group != EXPERIMENT}
    lines = tuple(f"{group}={option}" for group, option in options.items())
    return _merged(compose(lines, config_dir), values)


def _by_group(configuration: Mapping[str, Any]) -> dict[str, Any]:
    """Return a configuration by groups, whose keys may also be written whole: {"contact.clearance": 1e-6}.

    A text in place of a group with keys is the value of the key that selects its option.
    """
    values: dict[str, Any] = {}
    for key, value in configuration.items():
        whole = {str(key).replace("/", "."): value}
        # A group without keys is one all the same.
        for name, below in (flat(whole) or whole).items():
            if name in values:
                raise ConfigurationError(f"{name} occurs twice; it must occur once. Leave one out.")
            values[name] = below
    above = {key[:end] for key in values for end, sign in enumerate(key) if sign == "."}
    for group in [name for name in values if name in above]:
        section = LAW if group.partition(".")[0] == "law" else GROUPS.get(group)
        option = values.pop(group)
        if option == {}:
            continue
        if section is None or not section.selector:
            raise ConfigurationError(
                f"{group} is {describe(option)} and has keys; it must be a group of keys."
            )
        labels = {name: label for label, name in section.labelled.items()}
        values[f"{group}.{section.selector}"] = labels.get(option, option)
    return nested(values)


def _options_in(group: str, section: Section, value: object) -> dict[str, str]:
    """Return the option that the value of a group names; none where it names none."""
    if isinstance(value, str):
        return {group: value}
    label = value.get(section.selector) if isinstance(value, Mapping) else None
    return {group: section.labelled[label]} if isinstance(label, str) and label in section.labelled else {}


def _merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return nested values with others in their place; a text in place of a group has chosen its option."""
    merged = {key: _merged(x, {}) if isinstance(x, Mapping) else x for key, x in below.items()}
    for key, value in above.items():
        under = below.get(key)
        if isinstance(value, Mapping) and isinstance(under, Mapping):
            merged[key] = _merged(under, value)
        elif not (isinstance(value, str) and isinstance(under, Mapping)):
            merged[key] = value
    return merged


@lru_cache(maxsize=256)
def _composed(*overrides: str) -> dict[str, Any]:
    """Compose overrides, once each; the mapping is shared."""
    return _compose(overrides, None)


def differences(configuration: Mapping[str, Any]) -> list[str]:
    """Return overrides of the default run that compose to a whole configuration: options, then keys."""
    every = {**GROUPS, "law": LAW}
    named = {
        group: {each.selector: configuration[group][each.selector]}
        for group, each in every.items()
        if each.selector and group in configuration
    }
    law: Mapping[str, Any] = configuration["law"]
    named["law"] |= {
        family: {"name": law[family]["name"]} for family in FAMILIES if isinstance(law.get(family), Mapping)
    }
    chosen, usual = completed(named), _composed()
    options = [
        f"{group}={every[group].labelled[values[every[group].selector]]}"
        for group, values in named.items()
        if values[every[group].selector] != usual[group][every[group].selector]
    ]
    options += [
        f"law/{family}={part['name']}"
        for family, part in named["law"].items()
        if family in FAMILIES and part["name"] != _composed("law=composed")["law"][family]["name"]
    ]
    default = flat(chosen)
    keys = [f"{key}={written(x)}" for key, x in flat(configuration).items() if x != default.get(key)]
    return [*options, *keys]


def written(value: Any) -> str:
    """Return a value as an override has it."""
    match value:
        case None | bool():
            return "null" if value is None else str(value).lower()
        case list() | tuple():
            return f"[{','.join(map(written, value))}]"
        case str():
            return quoted(value)
    return str(value)


def parsed(overrides: Sequence[str]) -> tuple[dict[str, str], dict[str, Any]]:
    """Return the options of groups and the values by full key that overrides set.

    Raises:
        ConfigurationError: one is none, or sets what no run has.
    """
    refuse_lines(overrides)
    lines = [*map(readable, overrides)]
    try:
        read = OverridesParser.create().parse_overrides(lines)
    # The parser lets the errors of what it calls through.
    except Exception as error:
        raise ConfigurationError(faults_of(error, overrides)) from None
    options: dict[str, str] = {}
    values: dict[str, Any] = {}
    for override in read:
        key, value = override.key_or_group, override.value()
        if override.is_delete() or override.is_sweep_override() or key.split(".")[0] in ("hydra", EXPERIMENT):
            raise ConfigurationError(f"{override.input_line} is no KEY=VALUE of a run; it must be one.")
        if key in groups() and not isinstance(value, dict):
            options[key] = str(value)
        else:
            values |= flat({key: value})
    return options, values


def overridden(
    source: Mapping[str, Any], options: Mapping[str, Any], values: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a whole configuration with other options of groups and other values of keys, not yet checked.

    A law or a part takes the defaults that it declares; other groups, which may have options in files, are
    composed.

    Raises:
        ConfigurationError: an option does not exist, a key has another below it, or would rename an option.
    """
    lines = {group: option for group, option in options.items() if group.partition("/")[0] != "law"}
    whole = completed(_merged(source, {}) | lines) if lines else _merged(source, {})
    for group, option in options.items():
        if group == "law" or "/" in group:
            if not isinstance(option, str) or option not in groups()[group]:
                # The composition says what there is.
                compose([f"{group}={option}"])
            family = group.partition("/")[2]
            section = declared_section(group, option)
            whole["law"] = {**whole["law"], family: section} if family else section
    for key, value in values.items():
        if group := group_selected_by(key):
            fault = f"{key} would rename a {group} and keep its parameters; choose by {group}=NAME."
            raise ConfigurationError(fault)
        *path, last = key.split(".")
        below = whole
        for name in path:
            below = below.setdefault(name, {})
            if not isinstance(below, dict):
                raise ConfigurationError(unknown_override(key))
        below[last] = value
    return whole


def declared_section(group: str, option: str) -> dict[str, Any]:
    """Return the section of a law or a part, those of its parts included, as its classes declare it."""
    section = {**content(group, option)}
    for entry in section.pop("defaults", ()):
        if isinstance(entry, dict):
            # "friction": name, or "friction@other": name where the field has another name.
            ((place, name),) = entry.items()
            family, _, field = place.partition("@")
            section = {field or family: declared_section(f"law/{family}", name), **section}
    return section


def readable(override: str) -> str:
    """Return an override as Hydra reads it: a choice without plus, units with letters of their own in quotes.

    Every group has a choice already, so that `+experiment=case_a` can only mean `experiment=case_a`.
    """
    plain = override.lstrip("+")
    group, sign, _ = plain.partition("=")
    chosen = plain if plain != override and sign and group in {*groups(), EXPERIMENT} else override
    return chosen if _FUNCTION.match(chosen) else _BEYOND.sub(r"'\1'", chosen)


def resolved(config: DictConfig) -> dict[str, Any]:
    """Return a composed configuration without Hydra's part, references replaced by the values they refer to.

    Raises:
        ConfigurationError: a reference has no value, or is one to the environment.
    """
    return with_references(as_written(config))


def as_written(config: DictConfig) -> dict[str, Any]:
    """Return a composed configuration without Hydra's part, its references as they are written.

    Raises:
        ConfigurationError: one is to the environment.
    """
    mine = OmegaConf.masked_copy(config, [str(key) for key in config if key != "hydra"])
    written: Any = OmegaConf.to_container(mine, resolve=False)
    refuse_lines(f"{key}={value}" for key, value in flat(written).items() if ENVIRONMENT in str(value))
    return written  # type: ignore[no-any-return]


def with_references(written: Mapping[str, Any]) -> dict[str, Any]:
    """Return a configuration with the values that its references, `${drive.voltage_1}`, refer to.

    Raises:
        ConfigurationError: a reference has no value.
    """
    if not any("${" in str(value) for value in flat(written).values()):
        return dict(written)
    try:
        return OmegaConf.to_container(OmegaConf.create(dict(written)), resolve=True)  # type: ignore[return-value]
    except OmegaConfBaseException as error:
        raise ConfigurationError(f"{one_line(error)} Correct the reference in ${{...}}.") from None


def refuse_lines(lines: Iterable[str]) -> None:
    """Refuse overrides that Hydra composes to what nobody wants.

    Variables of the environment may be secrets: a run's configuration is recorded, and messages show its
    values; Hydra's own keys may refer to them. A law, a part or a basis that is renamed by a key would
    receive the parameters of another.
    """
    faults = []
    for line in lines:
        key, _, value = line.lstrip("+~").partition("=")
        if not key.strip() or (key.startswith("hydra.") and not value):
            faults.append(f"{line!r} is empty, as of a shell variable that is not set; it must be KEY=VALUE.")
        if value.startswith("[") and key in groups():
            faults.append(f"{line} chooses several options of a group; it must be one, or a sweep (-m).")
        if ENVIRONMENT in line and not key.startswith("hydra."):
            faults.append(f"{key} refers to a variable of the environment; it must be a value.")
        below = re.findall(r"(\w+)\s*:", value) if value.startswith("{") else []
        for group in filter(None, map(group_selected_by, [key, *(f"{key}.{leaf}" for leaf in below)])):
            faults.append(f"{line} would rename a {group} and keep its parameters; choose by {group}=NAME.")
    raise_faults(faults)


def refuse_expansions(folders: Iterable[str]) -> None:
    """Refuse folders of configurations with a file whose aliases multiply: Hydra would expand them all."""
    faults = []
    for path in (path for folder in folders for path in sorted(Path(folder).rglob("*.yaml"))):
        try:
            check_expansion(path.read_text(encoding="utf-8"))
        # What is no text, no YAML, or cannot be read, Hydra refuses if it is chosen.
        except (OSError, UnicodeDecodeError, YAMLError):
            continue
        except ValueError as error:
            faults.append(f"'{path}' is no configuration: {one_line(error)}")
    raise_faults(faults)


def faults_of(error: Exception, lines: Sequence[str]) -> list[str]:
    """Return what ended a composition of these overrides, a sentence for each fault."""
    text = one_line(error)
    match error:
        case ConfigurationError():
            return error.faults
        case errors.MissingConfigException() if error.options and error.missing_cfg_file:
            group, _, option = error.missing_cfg_file.rpartition("/")
            hint = ways_to_choose(option) if group == "law" else ""
            hint = hint or suggestion(option, error.options)
            return [f"{group} is '{option}'; it must be one of {', '.join(error.options)}. {hint}".rstrip()]
        case errors.OverrideParseException():
            return [f"{error.override} cannot be read; it must be KEY=VALUE, brackets and quotes closed."]
        case RecursionError():
            return ["An argument is nested too deeply to be read; it must be a value."]
    if unknown := re.search(r"Could not override '([^']+)'", text):
        return [unknown_override(unknown[1], lines)]
    if several := re.search(r"Ambiguous value for argument '([^=]+)=(.*?)' 1\.", text):
        return [f"{several[1]} is {several[2]}; it must be one value. Add -m for every one in turn."]
    if "requires --multirun" in text or "sweep parameters" in text.lower():
        text = f"{text} Add -m to run every combination; in Python, contactlab.sweep does."
    return [text if any(line.partition("=")[0] in text for line in lines) else f"{' '.join(lines)}: {text}"]


def unknown_override(key: str, lines: Iterable[str] = ()) -> str:
    """Return the fault of a key that does not exist, or not with what the overrides choose."""
    path = key.replace("/", ".")
    if path == "output":
        return "output is no key of a run; its folder is hydra.run.dir, that of a sweep (-m) hydra.sweep.dir."
    group = path.rpartition(".")[0].replace(".", "/")
    chosen = (line.partition("=")[2] for line in lines if line.startswith(f"{group}="))
    option = next(chosen, "")
    if option and (fault := fault_of_option(group, option)):
        return fault
    if group == "law" and (
        way := ways_to_choose(*(x.partition("=")[2] for x in lines if x.startswith(f"{key}=")))
    ):
        return f"{key} is a part of a composed law alone. {way}"
    hydras = flat({"hydra": OmegaConf.to_container(OmegaConf.structured(HydraConf))})
    return unknown_key(path, option or "the default", [*known_keys(), *hydras])


def options_of(group: str) -> list[str]:
    """Return the options of a group, those of files included; none for what is no group."""
    with started():
        return list(GlobalHydra.instance().config_loader().get_group_options(group))


@contextmanager
def started() -> Iterator[Any]:
    """Start Hydra until the end of the context, and yield it; one that runs already goes on after it."""
    running = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    conf = str(conf_directory())
    try:
        with hydra.initialize_config_dir(conf, job_name=SCHEME, **VERSION_BASE):
            yield GlobalHydra.instance().hydra
    finally:
        if running is not None:
            GlobalHydra.instance().initialize(running)


def allowing(*targets: str) -> AbstractContextManager[Any]:
    """Return a context in which a configuration may import no other callbacks and handlers than these."""
    return _ALLOW([*targets]) if _ALLOW else nullcontext()


def register_resolver(name: str, function: Callable[..., str]) -> None:
    """Let configurations refer to a function of this package by a name."""
    old = "" if _ALLOW else "_new"
    getattr(OmegaConf, f"register{old}_resolver")(name, function, replace=True)


@final
class _DeclaredSource(ConfigSource):
    """Options as the classes declare them, each made when it is chosen."""

    @staticmethod
    def scheme() -> str:
        return SCHEME

    def load_config(self, config_path: str) -> ConfigResult:
        config = OmegaConf.create(content(*_split(config_path)))
        return ConfigResult(self.provider, f"{SCHEME}://", config, header={"package": None})

    def available(self) -> bool:
        return True

    def is_group(self, config_path: str) -> bool:
        return config_path.strip("/") in {"", *groups()}

    def is_config(self, config_path: str) -> bool:
        group, option = _split(config_path)
        return option in groups().get(group, ())

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        group = config_path.strip("/")
        names: set[str] = set()
        if results_filter is not ObjectType.GROUP:
            names.update(groups().get(group, ()))
        if results_filter is not ObjectType.CONFIG:
            names.update(leaf for parent, leaf in map(_split, groups()) if parent == group)
        return sorted(names)


@final
class _DeclaredSearchPath(SearchPathPlugin):
    """Puts the source behind every folder, so that a file of the same name has precedence."""

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        # Hydra puts the folder of --config-dir before the first provider of this name.
        search_path.append("schema", f"{SCHEME}://")


def _split(path: str) -> tuple[str, str]:
    """Return group and option of a path."""
    group, _, option = path.strip("/").removesuffix(".yaml").rpartition("/")
    return group, option


# Workers of a launcher compose configurations too: whatever they import brings this with it.
for plugin in (_DeclaredSource, _DeclaredSearchPath):
    Plugins.instance().register(plugin)
register_resolver("help_on_keys", help_on_keys)
