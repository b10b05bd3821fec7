"""The sweeper of contactlab where Hydra looks for sweepers: it takes those of this package alone."""

from dataclasses import dataclass

from hydra.core.config_store import ConfigStore
from hydra.core.plugins import Plugins
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

    def __init__(self, max_batch_size: int | None = None) -> None:
        self.max_batch_size = max_batch_size

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        """See `Sweeper.setup`."""
        self.loader, self.config = hydra_context.config_loader, config
        self.launcher = Plugins.instance().instantiate_launcher(
            hydra_context=hydra_context, task_function=task_function, config=config
        )

    def sweep(self, arguments: list[str]) -> None:
        """See `Sweeper.sweep`."""
        from contactlab.cli.sweeper import sweep

        sweep(self.loader, self.launcher, self.config, arguments, self.max_batch_size)


ConfigStore.instance().store(
    group="hydra/sweeper", name="contactlab", node=ContactlabSweeperConf, provider="contactlab"
)
