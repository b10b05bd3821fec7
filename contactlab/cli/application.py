"""Hydra as the command uses it: where its configuration lies, and the parts of it that are ours."""

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, final

import hydra
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.hydra import Hydra
from hydra._internal.utils import create_config_search_path
from hydra.core.config_search_path import ConfigSearchPath, SearchPathQuery
from hydra.core.global_hydra import GlobalHydra
from omegaconf import DictConfig, OmegaConf

from contactlab.cli.directories import folder_name
from contactlab.config.composition import CONFIG_NAME, VERSION_BASE, conf_directory
from contactlab.config.faults import ConfigurationError

__all__ = ["CONFIG_NAME", "VERSION_BASE", "conf_directory", "folder_name", "started"]

# Workers of a launcher compose configurations too: whatever they import brings this with it.
OmegaConf.register_new_resolver("folder_name", folder_name, replace=True)


@contextmanager
def started(config_path: str | None = None, config_dir: str | None = None) -> Iterator[Hydra]:
    """Hydra, until the end of the context.

    Args:
        config_path: folder of another primary configuration.
        config_dir: folder of more options.

    Raises:
        ConfigurationError: the folder is not there.
    """
    hydra.version.setbase(VERSION_BASE)
    application = Hydra("contactlab", _RememberingLoader(_search_path(config_path, config_dir)))
    GlobalHydra.instance().initialize(application)
    try:
        yield application
    finally:
        GlobalHydra.instance().clear()


@final
class _RememberingLoader(ConfigLoaderImpl):
    """Hydra's loader, which composes only once what is asked for twice in a row.

    A single run is composed for the check and then by Hydra again; this halves the time.
    """

    _last: tuple[object, DictConfig] | None = None

    def load_configuration(self, *arguments: Any, **options: Any) -> DictConfig:
        """See `ConfigLoader.load_configuration`."""
        asked = (repr(arguments), repr(options))
        if self._last is None or self._last[0] != asked:
            self._last = (asked, super().load_configuration(*arguments, **options))
        return copy.deepcopy(self._last[1])


def _search_path(config_path: str | None, config_dir: str | None) -> ConfigSearchPath:
    path = create_config_search_path(config_path or str(conf_directory()))
    if config_dir is not None:
        extra = Path(config_dir).absolute()
        if not extra.is_dir():
            raise ConfigurationError(
                [f"--config-dir is '{extra}', which is not a directory; it must be one. Create it."]
            )
        path.prepend("command-line", f"file://{extra}", anchor=SearchPathQuery(provider="schema"))
    return path
