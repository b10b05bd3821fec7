"""Configurations from overrides, by Hydra: files of `conf/`, and behind them what the classes declare."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, Final, final

import hydra
from hydra import errors
from hydra.conf import HydraConf
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.core.plugins import Plugins
from hydra.plugins.config_source import ConfigResult, ConfigSource
from hydra.plugins.search_path_plugin import SearchPathPlugin
from omegaconf import Container, DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from omegaconf.resolvers import oc

from contactlab.config.faults import ConfigurationError, one_line, unknown_key
from contactlab.config.nesting import flat
from contactlab.config.options import conf_directory, content, groups, help_on_keys, known_keys
from contactlab.suggestion import suggestion

CONFIG_NAME: Final = "config"
VERSION_BASE: Final = "1.3"
SCHEME: Final = "contactlab"
EXPERIMENT: Final = "experiment"
"""The group whose options are files alone: named sets of changes to the default run."""

_ENVIRONMENT: Final = ContextVar("_ENVIRONMENT", default="all")
"""Section of a configuration that may refer to variables of the environment; 'all', 'hydra' or 'nothing'."""

SEVERAL: Final = (
    "{} gives several values; a single run takes one. Add -m to run every combination; "
    "in Python, contactlab.sweep does."
)
"""What is wrong with an override that is swept."""


_BEYOND: Final = re.compile(r"(?<=[=,])\s*([-+]?[\d.][^,='\"]*[°µμ²³·^][^,='\"]*)(?=,|$)")
"""A number with a unit that has characters beyond those of Hydra's grammar."""

_FUNCTION: Final = re.compile(r"[^=]*=\s*'?(linspace|geomspace|range)\(")
"""An override that lists values by a function, which the command quotes as a whole."""


def compose(overrides: Sequence[str] = ()) -> dict[str, Any]:
    """Compose a configuration from overrides, not yet checked; errors are those of `contactlab.build`."""
    try:
        with started(), without_environment(hydra=False):
            composed = hydra.compose(CONFIG_NAME, overrides=[*map(readable, overrides)])
    # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
    except Exception as error:
        raise ConfigurationError(sentences(error, overrides)) from None
    return resolved(composed)


def readable(override: str) -> str:
    """Give an override as Hydra reads it: a choice without plus, units with letters of their own in quotes.

    Every group has a choice already, so that `+experiment=case_a` can only mean `experiment=case_a`.
    """
    plain = override.lstrip("+")
    group, sign, _ = plain.partition("=")
    chosen = plain if plain != override and sign and group in {*groups(), EXPERIMENT} else override
    return chosen if _FUNCTION.match(chosen) else _BEYOND.sub(r"'\1'", chosen)


def resolved(config: DictConfig) -> dict[str, Any]:
    """Return a composed configuration without Hydra's part, references replaced by the values they refer to.

    Raises:
        ConfigurationError: a reference has no value, or is one to the environment, whose variables may be
            secrets and are no part of what a run records.
    """
    mine = OmegaConf.masked_copy(config, [str(key) for key in config if key != "hydra"])
    try:
        with without_environment(hydra=False):
            return OmegaConf.to_container(mine, resolve=True)  # type: ignore[return-value]
    except OmegaConfBaseException as error:
        words = _reads_environment(error) or f"{one_line(error)} Correct the reference in ${{...}}."
        raise ConfigurationError([words]) from None


class EnvironmentReadError(ValueError):
    """A configuration that refers to a variable of the environment where it must not."""


@contextmanager
def without_environment(*, hydra: bool) -> Iterator[None]:
    """Refuse references to variables of the environment until the end of the context.

    The variables may be secrets: a run's configuration is recorded, and messages show its values.

    Args:
        hydra: whether Hydra's own keys, which name folders and launchers, may refer to them.
    """
    before = _ENVIRONMENT.set("hydra" if hydra else "nothing")
    try:
        yield
    finally:
        _ENVIRONMENT.reset(before)


def _environment(name: str, *default: Any, _parent_: Container) -> Any:
    """Return a variable of the environment, the resolver `oc.env`, to what may refer to it."""
    readers = _ENVIRONMENT.get()
    section = str(_parent_._get_full_key("")).partition(".")[0]
    if readers not in ("all", section):
        raise EnvironmentReadError(name)
    return oc.env(name, *default)


def _reads_environment(error: BaseException | None) -> str:
    """Return the fault of a reference to the environment that an exception comes from; empty for others."""
    key = ""
    while error is not None:
        if isinstance(error, EnvironmentReadError):
            # Hydra resolves the choices of a defaults list in a container of its own.
            subject = key if key and not key.startswith("_") else "The choice of an option"
            return (
                f"{subject} refers to the variable {error} of the environment; it must be a value or refer "
                "to another key. Let the shell put the value in its place."
            )
        key = key or str(getattr(error, "full_key", None) or "")
        error = error.__cause__ or error.__context__
    return ""


def sentences(error: Exception, lines: Sequence[str]) -> list[str]:
    """Return what ended a composition of these overrides, a sentence for each fault."""
    text = str(error)
    match error:
        case ConfigurationError():
            return error.faults
        case errors.OverrideParseException():
            words = (
                f"{error.override} cannot be read; an argument must have the form KEY=VALUE or GROUP=OPTION."
            )
            return [f"{words} Quote a value with spaces or special characters: \"KEY='a (b)'\"."]
        case errors.MissingConfigException() if error.options and error.missing_cfg_file:
            group, _, option = error.missing_cfg_file.rpartition("/")
            hint = suggestion(option, error.options)
            return [f"{group} is '{option}'; it must be one of {', '.join(error.options)}. {hint}".rstrip()]
        case RecursionError():
            return ["An argument is nested too deeply to be read; it must be a value. Simplify it."]
    if unknown := re.search(r"Could not override '([^']+)'", text):
        return [unknown_override(unknown[1], lines)]
    if swept := re.search(r"(?:argument|parameters) '(.+?)'(?: requires --multirun)?$", text, re.M):
        return [SEVERAL.format(swept[1])]
    if environment := _reads_environment(error):
        return [environment]
    if text.startswith("Config group override must be"):
        choices = [line for line in lines if re.fullmatch(r"[^.=-][^.=]*=(null|[-+.\d]*)", line)]
        return [f"{' '.join(choices)} names no option; it must have the form GROUP=OPTION."]
    if isinstance(error, errors.HydraException | OmegaConfBaseException | UserWarning):
        return [one_line(error)]
    return [f"{' '.join(lines)} cannot be composed: {one_line(error)}"]


def unknown_override(key: str, lines: Iterable[str] = ()) -> str:
    """Say that there is no such key, or none with what the overrides choose."""
    path = key.replace("/", ".")
    group = path.rpartition(".")[0].replace(".", "/")
    chosen = (line.partition("=")[2] for line in lines if line.startswith(f"{group}="))
    hydras = flat({"hydra": OmegaConf.to_container(OmegaConf.structured(HydraConf))})
    return unknown_key(path, next(chosen, "the default"), [*known_keys(), *hydras])


def options_of(group: str) -> list[str]:
    """Give the options of a group, those of files included; none for what is no group."""
    with started():
        return list(GlobalHydra.instance().config_loader().get_group_options(group))


@contextmanager
def started() -> Iterator[None]:
    """Start Hydra for compositions until the end of the context; one that runs already goes on after it."""
    running = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    conf = str(conf_directory())
    try:
        with hydra.initialize_config_dir(conf, job_name=SCHEME, version_base=VERSION_BASE):
            yield
    finally:
        if running is not None:
            GlobalHydra.instance().initialize(running)


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
        found: set[str] = set()
        if results_filter is not ObjectType.GROUP:
            found.update(groups().get(group, ()))
        if results_filter is not ObjectType.CONFIG:
            found.update(leaf for parent, leaf in map(_split, groups()) if parent == group)
        return sorted(found)


@final
class _DeclaredSearchPath(SearchPathPlugin):
    """Puts the source behind every folder, so that a file of the same name has precedence."""

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        # Hydra puts the folder of --config-dir before the first provider of this name.
        search_path.append("schema", f"{SCHEME}://")


def _split(path: str) -> tuple[str, str]:
    """Give group and option of a path."""
    group, _, option = path.strip("/").removesuffix(".yaml").rpartition("/")
    return group, option


# Workers of a launcher compose configurations too: whatever they import brings this with it.
for plugin in (_DeclaredSource, _DeclaredSearchPath):
    Plugins.instance().register(plugin)
OmegaConf.register_new_resolver("help_on_keys", help_on_keys, replace=True)
OmegaConf.register_new_resolver("oc.env", _environment, replace=True)
