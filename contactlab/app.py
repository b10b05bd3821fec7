"""The command: a thin Hydra application.

Hydra creates the output directory before it calls the application. Therefore the configuration is
composed and checked first, every job of a sweep included, and a faulty one leaves nothing behind.

Exit status: 0; 1 for a run that did not reach its end; 2 for a fault of the user's; 130 for Ctrl-C.
"""

import copy
import gc
import os
import re
import sys
import traceback
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path
from typing import Any, final

import hydra
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.hydra import Hydra
from hydra._internal.utils import create_config_search_path, get_args_parser
from hydra.core.config_search_path import ConfigSearchPath, SearchPathQuery
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.utils import JobReturn
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.command import interrupts
from contactlab.command.composition import check, check_composition
from contactlab.command.law_source import register
from contactlab.command.runner import execute
from contactlab.config import build
from contactlab.config.faults import ConfigurationError, one_line
from contactlab.laws import LawError

COMPLETE, INCOMPLETE, REFUSED = 0, 1, 2
"""Exit statuses; that of an interrupted command is in `contactlab.command.interrupts`."""

CONFIG_NAME = "config"
LAUNCHERS = ("joblib", "submitit")
"""What Hydra's launchers for processors and clusters stand on."""

VERSION_BASE = "1.3"
"""Of Hydra's behaviour."""


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


def job_directory(number: object, overrides: str) -> str:
    """Name of a job's directory in a sweep: its number and what sets it apart.

    Kept to characters that every file system and the netCDF library take, and to a length.
    """
    text = re.sub(r"\s+", "_", overrides.replace("\\", ""))
    text = re.sub(r"[^-+\w.,=_@~%]", "-", text, flags=re.ASCII)
    return f"{number}_{text}"[:120].rstrip("_")


OmegaConf.register_new_resolver("job_directory", job_directory, replace=True)
register()


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
    except KeyboardInterrupt as interrupt:
        print(str(interrupt) or interrupts.MESSAGE, file=sys.stderr)
        return interrupts.STATUS
    except BrokenPipeError:
        # Whoever read the output has had enough of it; Python's own last flush must not complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return INCOMPLETE
    except Exception as error:
        if not _of_a_launcher(error):
            raise
        print(f"The sweep was not finished: {error}", file=sys.stderr)
        return INCOMPLETE
    finally:
        gc.enable()


def run(settings: DictConfig) -> int:
    """The task of one job; launchers import it from here.

    Returns:
        The job's exit status.
    """
    try:
        setup = build(OmegaConf.to_container(settings, resolve=True))  # type: ignore[arg-type]
        directory = Path(HydraConfig.get().runtime.output_dir)
        with interrupts.ending_at_once():
            return COMPLETE if execute(setup, directory) else INCOMPLETE
    except ConfigurationError as error:
        # Only a sweeper that chooses its values while it runs gets here.
        return _refuse(error.faults)
    except LawError as error:
        print(error, file=sys.stderr)
        return INCOMPLETE
    except OSError as error:
        print(f"The run could not be written: {error}", file=sys.stderr)
        return INCOMPLETE


def conf_directory() -> Path:
    """The configuration files: inside the package in a wheel, beside it in a checkout."""
    package = Path(__file__).resolve().parent
    inside = package / "conf"
    return inside if inside.is_dir() else package.parent / "conf"


def _dispatch() -> int:
    parser = get_args_parser()
    if "--version" in sys.argv[1:]:
        return _print_version()
    # Intermixed: -m may stand between the overrides.
    arguments = parser.parse_intermixed_args()
    hydra.version.setbase(VERSION_BASE)
    name = arguments.config_name or CONFIG_NAME
    if arguments.help or arguments.cfg or arguments.info:
        application = Hydra("contactlab", _RememberingLoader(_search_path(arguments)))
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
    application = Hydra("contactlab", _RememberingLoader(_search_path(arguments)))
    GlobalHydra.instance().initialize(application)
    try:
        mode = check(application.config_loader, name, arguments.overrides, arguments.multirun)
        if mode is RunMode.RUN:
            return _status(application.run(name, run, arguments.overrides))
        gc.enable()
        overrides = [*arguments.overrides, "hydra.mode=MULTIRUN"]
        # Between the jobs an exception, at which a launcher ends the processes that it has begun.
        with interrupts.raising():
            return _status(application.multirun(name, run, overrides))
    finally:
        GlobalHydra.instance().clear()


def _search_path(arguments: Namespace) -> ConfigSearchPath:
    path = create_config_search_path(arguments.config_path or str(conf_directory()))
    if arguments.config_dir is not None:
        extra = Path(arguments.config_dir).absolute()
        if not extra.is_dir():
            raise ConfigurationError(
                [f"--config-dir is '{extra}', which is not a directory; it must be one. Create it."]
            )
        path.prepend("command-line", f"file://{extra}", anchor=SearchPathQuery(provider="schema"))
    return path


def _status(returned: object) -> int:
    """The largest exit status of the jobs; a sweeper that gives back something else has none."""
    if isinstance(returned, JobReturn):
        return int(returned.return_value)
    if isinstance(returned, list | tuple):
        return max(map(_status, returned), default=COMPLETE)
    return COMPLETE


def _of_a_launcher(error: Exception) -> bool:
    """Whether it is what runs the jobs that failed: a worker is gone, there is no cluster."""
    frames = (frame for frame, _ in traceback.walk_tb(error.__traceback__))
    return any(frame.f_globals["__name__"].split(".")[0] in LAUNCHERS for frame in frames)


def _refuse(faults: Iterable[str]) -> int:
    """Tell the faults, a line each."""
    for fault in faults:
        print(fault, file=sys.stderr)
    return REFUSED


def _print_version() -> int:
    from contactlab.output.provenance import versions

    print(f"contactlab {versions()['contactlab_version']} (hydra-core {hydra.__version__})")
    return COMPLETE
