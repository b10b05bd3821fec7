"""Hydra's source of the options that laws and parts are without a file: see `config.law_defaults`.

A source on the search path and not nodes in Hydra's ConfigStore: those would have to be made before
anything is asked for, and every law be imported for that, with the compiler.
"""

from typing import final

from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.object_type import ObjectType
from hydra.core.plugins import Plugins
from hydra.plugins.config_source import ConfigResult, ConfigSource
from hydra.plugins.search_path_plugin import SearchPathPlugin
from omegaconf import OmegaConf

from contactlab.config.law_defaults import content, groups, options

SCHEME = "contactlab"


@final
class LawSource(ConfigSource):
    """Laws and parts as they are by default, each made when it is chosen."""

    @staticmethod
    def scheme() -> str:
        """See `ConfigSource.scheme`."""
        return SCHEME

    def load_config(self, config_path: str) -> ConfigResult:
        """See `ConfigSource.load_config`."""
        group, option = _split(config_path)
        return ConfigResult(
            config=OmegaConf.create(content(group, option)),
            path=f"{SCHEME}://",
            provider=self.provider,
            header={"package": None},
        )

    def available(self) -> bool:
        """See `ConfigSource.available`."""
        return True

    def is_group(self, config_path: str) -> bool:
        """See `ConfigSource.is_group`."""
        return config_path.strip("/") in ("", *groups())

    def is_config(self, config_path: str) -> bool:
        """See `ConfigSource.is_config`."""
        group, option = _split(config_path)
        return group in groups() and option in options(group)

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        """See `ConfigSource.list`."""
        group = config_path.strip("/")
        prefix = f"{group}/" if group else ""
        found = []
        if results_filter in (None, ObjectType.CONFIG) and group in groups():
            found += options(group)
        if results_filter in (None, ObjectType.GROUP):
            below = [name.removeprefix(prefix) for name in groups() if name.startswith(prefix)]
            found += [name for name in below if "/" not in name]
        return sorted(set(found))


@final
class LawSearchPath(SearchPathPlugin):
    """Puts the source behind every file, so that a file of the same name has precedence."""

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        """See `SearchPathPlugin.manipulate_search_path`."""
        search_path.append("contactlab", f"{SCHEME}://")


def register() -> None:
    """Make Hydra know both."""
    for plugin in (LawSource, LawSearchPath):
        Plugins.instance().register(plugin)


def _split(config_path: str) -> tuple[str, str]:
    """Group and option of a path."""
    group, _, option = config_path.strip("/").removesuffix(".yaml").rpartition("/")
    return group, option
