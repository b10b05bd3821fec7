"""Configurations from overrides, by Hydra: files of `conf/`, and behind them what the classes declare."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, Final, final

import hydra
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.core.plugins import Plugins
from hydra.errors import HydraException
from hydra.plugins.config_source import ConfigResult, ConfigSource
from hydra.plugins.search_path_plugin import SearchPathPlugin
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.config.faults import ConfigurationError, one_line
from contactlab.config.groups import content, groups, help_on_keys

CONFIG_NAME: Final = "config"
VERSION_BASE: Final = "1.3"
"""Of Hydra's behaviour."""

SCHEME: Final = "contactlab"

_folder: ContextVar[Path | None] = ContextVar("folder", default=None)
"""A folder of more options, while Hydra starts."""


def conf_directory() -> Path:
    """Give the folder of the configuration files: inside the package in a wheel, beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "conf"
    return inside if inside.is_dir() else package.parent / "conf"


def compose(overrides: Sequence[str] = (), config_dir: str | Path | None = None) -> dict[str, Any]:
    """Compose a configuration, not yet checked.

    Args:
        overrides: as on the command line: ["law=newton", "drive.phase=0"].
        config_dir: folder of more options.

    Raises:
        ConfigurationError: with Hydra's fault.
    """
    try:
        with started(config_dir):
            found = hydra.compose(CONFIG_NAME, overrides=list(overrides))
        return OmegaConf.to_container(found, resolve=True)  # type: ignore[return-value]
    except (HydraException, OmegaConfBaseException) as error:
        raise ConfigurationError([one_line(error)]) from error


def options_of(group: str) -> list[str]:
    """Give the options of a group, those of files included; none for what is no group."""
    with started():
        return list(GlobalHydra.instance().config_loader().get_group_options(group))


@contextmanager
def started(config_dir: str | Path | None = None) -> Iterator[None]:
    """Start Hydra for compositions until the end of the context; one that runs already goes on after it.

    Raises:
        ConfigurationError: the folder of more options is not there.
    """
    extra = None if config_dir is None else Path(config_dir).absolute()
    if extra and not extra.is_dir():
        words = f"--config-dir is '{extra}', which is not a directory; it must be one. Create it."
        raise ConfigurationError([words])
    running = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    folder = _folder.set(extra)
    conf = str(conf_directory())
    try:
        with hydra.initialize_config_dir(conf, job_name=SCHEME, version_base=VERSION_BASE):
            yield
    finally:
        _folder.reset(folder)
        if running is not None:
            GlobalHydra.instance().initialize(running)


@final
class DeclaredSource(ConfigSource):
    """Options as the classes declare them, each made when it is chosen."""

    @staticmethod
    def scheme() -> str:
        """See `ConfigSource.scheme`."""
        return SCHEME

    def load_config(self, config_path: str) -> ConfigResult:
        """See `ConfigSource.load_config`."""
        config = OmegaConf.create(content(*_split(config_path)))
        return ConfigResult(self.provider, f"{SCHEME}://", config, header={"package": None})

    def available(self) -> bool:
        """See `ConfigSource.available`."""
        return True

    def is_group(self, config_path: str) -> bool:
        """See `ConfigSource.is_group`."""
        return config_path.strip("/") in {"", *groups()}

    def is_config(self, config_path: str) -> bool:
        """See `ConfigSource.is_config`."""
        group, option = _split(config_path)
        return option in groups().get(group, ())

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """See `ConfigSource.list`."""
        group = config_path.strip("/")
        options = groups().get(group, []) if results_filter is not ObjectType.GROUP else []
        below = groups() if results_filter is not ObjectType.CONFIG else ()
        return sorted({*options, *(leaf for parent, leaf in map(_split, below) if parent == group)})


@final
class DeclaredSearchPath(SearchPathPlugin):
    """Puts the source behind every folder, so that a file of the same name has precedence."""

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        """See `SearchPathPlugin.manipulate_search_path`."""
        if folder := _folder.get():
            search_path.append("command-line", f"file://{folder}")
        # Hydra puts the folder of --config-dir before the first provider of this name.
        search_path.append("schema", f"{SCHEME}://")


def _split(path: str) -> tuple[str, str]:
    """Give group and option of a path."""
    group, _, option = path.strip("/").removesuffix(".yaml").rpartition("/")
    return group, option


# Workers of a launcher compose configurations too: whatever they import brings this with it.
for plugin in (DeclaredSource, DeclaredSearchPath):
    Plugins.instance().register(plugin)
OmegaConf.register_new_resolver("help_on_keys", help_on_keys, replace=True)
