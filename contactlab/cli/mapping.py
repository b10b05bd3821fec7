"""The work of `contactlab map`: plan, chunks by this machine or by a launcher, and the dataset at the end."""

from argparse import Namespace
from hashlib import sha256
from pathlib import Path

from contactlab.cli import interrupts
from contactlab.cli.announcement import announce_series
from contactlab.cli.application import CONFIG_NAME, started
from contactlab.cli.directories import folder_name
from contactlab.cli.map_launcher import launch, launcher_config
from contactlab.cli.map_plan import plan_of
from contactlab.cli.map_summary import summary
from contactlab.cli.progress import progress
from contactlab.cli.runner import refusals
from contactlab.config import ConfigurationError, build
from contactlab.metrics import METRICS
from contactlab.sweeps.chunks import MapFolder
from contactlab.sweeps.many import USUAL, Wanted, wanted_of
from contactlab.sweeps.plan import Plan
from contactlab.sweeps.workers import processors

MAPS = "maps"
"""Folder of the folders of maps."""


def make_map(given: Namespace) -> bool:
    """Make a map, or go on with it.

    Args:
        given: the parsed command line, see `contactlab.cli.map`.

    Returns:
        Whether all of it is there.

    Raises:
        ConfigurationError: with every fault of the command line. Nothing has been written.
        MapError: the folder holds another map, or a damaged one.
        WorkerError: a worker process died.
        OSError: the folder cannot be written to.
    """
    wanted = _wanted(given)
    with started(config_dir=given.config_dir) as hydra:
        plan = plan_of(hydra.config_loader, CONFIG_NAME, given.arguments, wanted, given.chunk)
        folder = MapFolder(given.output or Path(MAPS) / _name(plan), plan)
        if faults := list(refusals(folder.path, "Choose another one by --output DIR.")):
            raise ConfigurationError(faults)
        config = launcher_config(hydra, given.arguments, folder.path)
        folder.begin()
        if folder.complete:
            folder.merge()
            print(f"The map is complete already: {folder.file}")
            return True
        missing = folder.missing()
        print(_outlook(plan, len(missing)), flush=True)
        if wanted.series:
            one = build(plan.configuration(plan.point(0))).configuration
            announce_series(plan.cells, len(wanted.series), one)
        with interrupts.raising():
            if config is None:
                _run_here(folder, missing, given.workers)
            else:
                launch(hydra, config, folder, missing, given.workers)
            dataset = folder.merge()
    print(summary(dataset, folder.file))
    return bool(dataset.attrs["runs_absent"] == 0)


def _wanted(given: Namespace) -> Wanted:
    """What is kept of every run."""
    for option in ("workers", "chunk"):
        number = getattr(given, option)
        if number is not None and number < 1:
            raise ConfigurationError(
                [f"--{option} is {number}; it must be at least 1. Leave it out for the default."]
            )
    named = {None: USUAL, "all": tuple(METRICS)}.get(given.metrics)
    try:
        return wanted_of(named or _names(given.metrics), _names(given.series))
    except ValueError as error:
        raise ConfigurationError([str(error)]) from error


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]


def _name(plan: Plan) -> str:
    """Name of a map's folder: what is swept, and a digest of all the rest."""
    digest = sha256(plan.text().encode()).hexdigest()[:8]
    return f"{folder_name(','.join(axis.name for axis in plan.axes))[:80]}-{digest}"


def _outlook(plan: Plan, missing: int) -> str:
    sizes = " x ".join(str(size) for size in plan.shape)
    there = plan.chunks - missing
    kept = f"; {there} are finished already" if there else ""
    return f"{sizes} = {plan.cells} runs in {plan.chunks} chunk{'s' * (plan.chunks > 1)}{kept}."


def _run_here(folder: MapFolder, missing: list[int], workers: int | None) -> None:
    """Run chunk after chunk on this machine."""
    runs = sum(len(folder.plan.cells_of(chunk)) for chunk in missing)
    done = 0
    with (
        progress(runs, "runs", "The map") as show,
        folder.pool(workers or processors()) as pool,
    ):

        def report(count: int) -> None:
            nonlocal done
            done += count
            show(done)

        for chunk in missing:
            folder.run(chunk, pool, report)
