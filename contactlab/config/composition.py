"""Configurations from overrides, by Hydra: files of `conf/`, and behind them what the classes declare."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
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
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.config.faults import ConfigurationError, one_line, unknown_key
from contactlab.config.nesting import flat
from contactlab.config.options import content, groups, help_on_keys, known_keys
from contactlab.suggestion import suggestion

CONFIG_NAME: Final = "config"
VERSION_BASE: Final = "1.3"
SCHEME: Final = "contactlab"

SEVERAL: Final = (
    "{} gives several values; a single run takes one. Add -m to run every combination; "
    "in Python, contactlab.sweep does."
)
"""What is wrong with an override that is swept."""


def conf_directory() -> Path:
    """Give the folder of the configuration files: inside the package in a wheel, beside it in a checkout."""
    inside = Path(__file__).resolve().parents[1] / "conf"
    return inside if inside.is_dir() else inside.parents[1] / "conf"


def compose(overrides: Sequence[str] = ()) -> dict[str, Any]:
    """Compose a configuration from overrides, not yet checked; errors are those of `contactlab.build`."""
    try:
        with started():
            composed = hydra.compose(CONFIG_NAME, overrides=list(overrides))
    # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
    except Exception as error:
        raise ConfigurationError(sentences(error, overrides)) from error
    return resolved(composed)


def resolved(config: DictConfig) -> dict[str, Any]:
    """Give a composed configuration without Hydra's part, values in the place of references to them."""
    mine = OmegaConf.masked_copy(config, [str(key) for key in config if key != "hydra"])
    try:
        return OmegaConf.to_container(mine, resolve=True)  # type: ignore[return-value]
    except OmegaConfBaseException as error:
        words = f"{one_line(error)} Correct the reference in ${{...}}."
        raise ConfigurationError([words]) from error


def sentences(error: Exception, lines: Sequence[str]) -> list[str]:
    """Say in our words what ended a composition of these overrides, or what is around it."""
    match error:
        case ConfigurationError():
            return error.faults
        case errors.OverrideParseException():
            return [
                f"{error.override} cannot be read; an argument must have the form KEY=VALUE or "
                "GROUP=OPTION. Quote it if the value has a space, 'KEY=1 um', and the value "
                "too if it has special characters, \"KEY='1 µm'\". A verb stands first."
            ]
        case errors.MissingConfigException() if error.options and error.missing_cfg_file:
            group, _, option = error.missing_cfg_file.rpartition("/")
            hint = suggestion(option, error.options, "Choose one of them.")
            return [f"{group} is '{option}'; it must be one of {', '.join(error.options)}. {hint}"]
        case errors.SearchPathException():
            return [f"{one_line(error)} It must be a folder; create it."]
        case RecursionError():
            return ["An argument is nested too deeply to be read; it must be a value. Simplify it."]
    said = str(error)
    # What Hydra says of a key that is not there; the schema does not get to see it.
    if unknown := re.search(r"Could not override '([^']+)'", said):
        return [unknown_override(unknown[1], lines)]
    if several := re.search(r"(?:argument|parameters) '(.+?)'( requires --multirun)?$", said, re.M):
        return [SEVERAL.format(several[1])]
    if said.startswith("Config group override must be"):
        choices = [line for line in lines if re.fullmatch(r"[^.=-][^.=]*=(null|[-+.\d]*)", line)]
        return [
            f"{' '.join(choices)} names no option; it must have the form GROUP=OPTION. "
            "contactlab --help lists the options of every group."
        ]
    if isinstance(error, errors.HydraException | OmegaConfBaseException | UserWarning):
        return [one_line(error)]
    return [f"The run could not be started: {one_line(error)}"]


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
