"""The command: a thin Hydra application.

Hydra creates the output directory before it calls the application. Therefore the configuration is
composed and checked first, every job of a sweep included, and a faulty one leaves nothing behind.

Exit status: 0; 1 for a run that is not complete; 2 for a fault of the user's; 130 for Ctrl-C.
"""

import gc
import re
import sys
from argparse import Namespace
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import hydra
from hydra._internal.hydra import Hydra
from hydra._internal.utils import get_args_parser
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli import interrupts, streams
from contactlab.cli.announcement import announce
from contactlab.cli.application import CONFIG_NAME, VERSION_BASE, conf_directory, started
from contactlab.cli.composition import check, check_composition, choices_of
from contactlab.cli.jobs import perform
from contactlab.cli.sweeping import sweep
from contactlab.config import build
from contactlab.config.faults import ConfigurationError, one_line
from contactlab.suggestion import suggestion
from contactlab.sweeps.job import REFUSED as REFUSED_STATE
from contactlab.sweeps.job import Job, State, is_done, key_of, write_state

COMPLETE, INCOMPLETE, REFUSED = 0, 1, 2
"""Exit statuses; that of an interrupted command is in `contactlab.cli.interrupts`."""


def main() -> int:
    """Run or sweep what the command line says; gives the exit status."""
    # Nearly every object of a start stays, and looking for garbage among them takes a tenth of
    # the time of a default run.
    gc.disable()
    try:
        with interrupts.ending_at_once():
            return _dispatch()
    except ConfigurationError as error:
        return _refuse(error.faults)
    except (HydraException, OmegaConfBaseException) as error:
        return _refuse([one_line(error)])
    except RecursionError:
        return _refuse(
            ["An argument is nested too deeply to be read; it must be a value. Simplify it."]
        )
    except KeyboardInterrupt as interrupt:
        print(str(interrupt) or interrupts.MESSAGE, file=sys.stderr)
        return interrupts.STATUS
    except BrokenPipeError:
        # Whoever read the output has had enough of it.
        streams.silence(sys.stdout)
        return INCOMPLETE
    finally:
        gc.enable()


def run(settings: DictConfig) -> int:
    """The task of one job; launchers import it from here.

    A job of a sweep that is complete already is left as it is: whoever starts it may not know.

    Returns:
        The job's exit status.
    """
    hydra = HydraConfig.get()
    directory = Path(hydra.runtime.output_dir)
    asked = Job(overrides=tuple(hydra.overrides.task), choices=choices_of(hydra.runtime.choices))
    try:
        setup = build(OmegaConf.to_container(settings, resolve=True))  # type: ignore[arg-type]
    except ConfigurationError as error:
        # Only a sweeper that chooses its values while it runs gets here.
        write_state(directory, State(REFUSED_STATE, asked, " ".join(error.faults)))
        return _refuse(error.faults)
    job = replace(asked, key=key_of(setup), configuration=setup.configuration)
    if hydra.mode == RunMode.MULTIRUN and is_done(directory, job.key):
        return COMPLETE
    with interrupts.ending_at_once():
        return COMPLETE if perform(setup, directory, job) else INCOMPLETE


def _dispatch() -> int:
    parser = get_args_parser()
    if "--version" in sys.argv[1:]:
        return _print_version()
    # Intermixed: -m may stand between the overrides.
    arguments, unknown = parser.parse_known_intermixed_args()
    if unknown:
        flags = re.findall(r"--[a-z-]+", parser.format_usage())
        hint = suggestion(unknown[0], flags, "contactlab --help lists what there is.")
        return _refuse([f"unrecognized arguments: {' '.join(unknown)}. {hint}"])
    name = arguments.config_name or CONFIG_NAME
    if arguments.help or arguments.cfg or arguments.info:
        with started(arguments.config_path, arguments.config_dir) as application:
            check_composition(application.config_loader, name, arguments.overrides)
        return _show()
    if (
        arguments.shell_completion
        or arguments.hydra_help
        or arguments.resolve
        or arguments.experimental_rerun
        or (arguments.run and arguments.multirun)
    ):
        return _show()
    return _run(arguments, name)


def _show() -> int:
    """Leave the command line to Hydra, which shows something and runs nothing."""
    show = hydra.main(
        config_path=str(conf_directory()), config_name=CONFIG_NAME, version_base=VERSION_BASE
    )
    try:
        show(run)()
    # So Hydra reports flags that exclude each other.
    except ValueError as error:
        return _refuse([str(error)])
    return COMPLETE


def _run(arguments: Namespace, name: str) -> int:
    """Check, then run or sweep: `hydra.main` with the check in between."""
    with started(arguments.config_path, arguments.config_dir) as application:
        if arguments.multirun:
            # The jobs of a sweep leave cycles behind, 50 kB each.
            gc.enable()
        plan = check(application.config_loader, name, arguments.overrides, arguments.multirun)
        if plan.mode is RunMode.RUN:
            announce(job.job.configuration for job in plan.jobs)
            return _performed(application, name, arguments.overrides)
        gc.enable()
        # Between the jobs an exception, at which a launcher ends the processes that it has begun.
        with interrupts.raising():
            return sweep(application, name, arguments.overrides, run, plan)


def _performed(application: Hydra, name: str, lines: list[str]) -> int:
    """The exit status of a single run; what Hydra does around it may fail in any way."""
    try:
        return int(application.run(name, run, lines).return_value)
    except HydraException:
        raise
    except Exception as error:
        return _refuse([f"The run could not be started: {one_line(error)}"])


def _refuse(faults: Iterable[str]) -> int:
    """Tell the faults, a line each."""
    for fault in faults:
        print(fault, file=sys.stderr)
    return REFUSED


def _print_version() -> int:
    from contactlab.results.provenance import versions

    print(f"contactlab {versions()['contactlab_version']} (hydra-core {hydra.__version__})")
    return COMPLETE
