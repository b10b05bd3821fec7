"""Where the jobs of a command line write to, told before any of them runs."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hydra._internal.config_loader_impl import get_overrides_dirname
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.types import Override
from omegaconf import DictConfig, OmegaConf, open_dict


def resolved_directory(
    composed: DictConfig, tasks: list[Override], number: int, multirun: bool
) -> Path:
    """Output directory of a job.

    Raises:
        OmegaConfBaseException: its name refers to what there is not.
    """
    with open_dict(composed.hydra.job):
        composed.hydra.job.num = number
        composed.hydra.job.id = str(number)
        composed.hydra.job.override_dirname = get_overrides_dirname(
            tasks,
            exclude_keys=composed.hydra.job.config.override_dirname.exclude_keys,
            item_sep=composed.hydra.job.config.override_dirname.item_sep,
            kv_sep=composed.hydra.job.config.override_dirname.kv_sep,
        )
    keys = ("hydra.sweep.dir", "hydra.sweep.subdir") if multirun else ("hydra.run.dir",)
    with _hydra_config(composed):
        return Path(*(str(OmegaConf.select(composed, key)) for key in keys))


def shared(directories: list[Path]) -> Iterator[str]:
    """Directories that more than one job would write to."""
    for directory, count in Counter(directories).items():
        if count > 1:
            yield (
                f"hydra.sweep.subdir gives '{directory}' to {count} jobs, which would overwrite "
                "each other; it must differ from job to job. Leave it out."
            )


@contextmanager
def _hydra_config(composed: DictConfig) -> Iterator[None]:
    """Make ${hydra:...} refer to a configuration for a while."""
    instance = HydraConfig.instance()
    before = instance.cfg
    # Its setter makes a copy of everything, which takes longer than all else here.
    instance.cfg = composed  # type: ignore[assignment]
    try:
        yield
    finally:
        instance.cfg = before
