"""Configurations from overrides, by Hydra: files of `conf/`, and behind them what the classes declare."""

import re
import shlex
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
from contactlab.config.slips import argument_for, joined, spelled
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


QUOTE: Final = (
    "Quote it if the value has a space, 'KEY=1 um', and the value too if it has special characters, "
    "\"KEY='a (b)'\". A verb stands first."
)
"""How an argument is written that cannot be read."""

LISTS: Final = (
    "Values are listed by linspace(FIRST,LAST,COUNT), geomspace(FIRST,LAST,COUNT) or range(START,STOP,STEP)."
)
"""How many values are written in one argument."""

_BEYOND: Final = re.compile(r"(?<=[=,])\s*([-+]?[\d.][^,='\"]*[°µμ²³·^][^,='\"]*)(?=,|$)")
"""A number with a unit that has characters beyond those of Hydra's grammar."""

_FUNCTION: Final = re.compile(r"[^=]*=\s*'?(linspace|geomspace|range)\(")
"""An override that lists values by a function, which the command quotes as a whole."""

_IN_OUR_WORDS: Final = {
    r"An item is already at '([^']+)'": (
        "+{0} would add a key that there is; it must be set, {0}=VALUE. Leave out the +."
    ),
    r"(?:argument|parameters) '(.+?)'(?: requires --multirun)?$": SEVERAL,
    **{
        rf"Value '(.*)' (?:of type '\w+' could not be converted to|is not a valid) {kind}\b"
        r"[\s\S]*?full_key: (\S+)": f"{{1}} is '{{0}}'; it must be {words}. Set it so, or leave it out."
        for kind, words in {"Integer": "a whole number", "Float": "a number", "bool": "true or false"}.items()
    },
    r"Cannot find primary config '([^']+)'": (
        "--config-name is '{0}', and there is no such configuration; it must be the name of a file {0}.yaml "
        "in a folder that --config-dir names. Leave it out for the usual one."
    ),
    r"Could not delete '([^']+)'": (
        "~{0} would take away what is not there; every group must have a choice. Leave it out, or choose "
        "another option by GROUP=OPTION."
    ),
}
"""What Hydra says of an override, and what is said instead."""


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
    """Say in our words what ended a composition of these overrides, or what is around it."""
    match error:
        case ConfigurationError():
            return error.faults
        case errors.OverrideParseException():
            return [_unreadable(str(error.override), lines)]
        case errors.MissingConfigException() if error.options and error.missing_cfg_file:
            group, _, option = error.missing_cfg_file.rpartition("/")
            hint = suggestion(option, error.options, _elsewhere(group, option) or "Choose one of them.")
            return [f"{group} is '{option}'; it must be one of {', '.join(error.options)}. {hint}"]
        case errors.SearchPathException():
            return [f"{one_line(error)} It must be a folder; create it."]
        case RecursionError():
            return ["An argument is nested too deeply to be read; it must be a value. Simplify it."]
    said = str(error)
    # What Hydra says of a key that is not there; the schema does not get to see it.
    if unknown := re.search(r"Could not override '([^']+)'", said):
        return [unknown_override(unknown[1], lines)]
    if ours := _reads_environment(error) or _in_our_words(f"{said}\n{error.__cause__ or ''}"):
        return [ours]
    if said.startswith("Config group override must be"):
        choices = [line for line in lines if re.fullmatch(r"[^.=-][^.=]*=(null|[-+.\d]*)", line)]
        return [
            f"{' '.join(choices)} names no option; it must have the form GROUP=OPTION. "
            "contactlab --help lists the options of every group."
        ]
    if isinstance(error, errors.HydraException | OmegaConfBaseException | UserWarning):
        return [one_line(error)]
    return [f"The run could not be started: {one_line(error)}"]


def _in_our_words(said: str) -> str:
    for pattern, words in _IN_OUR_WORDS.items():
        if found := re.search(pattern, said, re.M):
            return words.format(*found.groups())
    return ""


def _elsewhere(group: str, option: str) -> str:
    """Ask for the part of a law that was taken for a law; empty for none."""
    families = [family for family, options in groups().items() if "/" in family and option.lower() in options]
    if group != "law" or not families:
        return ""
    return f"Did you mean law=composed {families[0]}={option.lower()}?"


def _unreadable(override: str, lines: Sequence[str]) -> str:
    """Say that an argument is none, and what it may stand for, together with the words around it."""
    if not override.strip():
        return "An argument is empty, as of a shell variable that is not set. Leave it out."
    together = next((group for group in joined(lines) if override in group), [override])
    argument = spelled(together)
    meant = ""
    if len(together) > 1 or argument != override:
        meant = argument_for(argument) or shlex.quote(argument)
    elif "=" not in override:
        meant = argument_for(override, near=True)
    way_out = LISTS if re.search(r"=\s*'?(lin|log|geom|[a-z]+space)\w*\(", override) else QUOTE
    way_out = f"Did you mean {meant}?" if meant else way_out
    return f"{override} cannot be read; an argument must have the form KEY=VALUE or GROUP=OPTION. {way_out}"


def unknown_override(key: str, lines: Iterable[str] = ()) -> str:
    """Say that there is no such key, or none with what the overrides choose."""
    path = key.replace("/", ".")
    given = next((line for line in lines if line.lstrip("+").startswith(f"{key}=")), "")
    if "." not in path and (meant := argument_for(given)):
        return f"{key} is not a known key. Did you mean {meant}?"
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
