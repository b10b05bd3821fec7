"""The sweeper of contactlab where Hydra looks for sweepers: it takes those of this package alone."""

from dataclasses import dataclass
from typing import Any

from hydra.core.config_store import ConfigStore
from hydra.plugins.sweeper import Sweeper
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig


@dataclass
class ContactlabSweeperConf:
    """Option of the sweeper: the jobs that a launcher is given at once."""

    _target_: str = "hydra_plugins.contactlab_sweeper.ContactlabSweeper"
    max_batch_size: int | None = None


class ContactlabSweeper(Sweeper):
    """Hands sweeps to `contactlab.cli.sweeper`, imported for a sweep alone: Hydra imports this for all."""

    def __init__(self, **options: Any) -> None:
        self.options = options

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        """See `Sweeper.setup`."""
        self.given = (hydra_context, task_function, config)

    def sweep(self, arguments: list[str]) -> Any:
        """See `Sweeper.sweep`."""
        from contactlab.cli.sweeper import Sweeping

        return Sweeping(*self.given, **self.options).sweep(arguments)


ConfigStore.instance().store(
    group="hydra/sweeper", name="contactlab", node=ContactlabSweeperConf, provider="contactlab"
)
