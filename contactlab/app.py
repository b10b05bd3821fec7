"""The command: a thin Hydra application.

Hydra creates the output directory before it calls the application. Therefore the configuration is
composed and checked first, every job of a sweep included, and a faulty one leaves nothing behind.

Exit status: 0; 1 for a run that did not reach its end; 2 for a fault of the user's; 130 for Ctrl-C.
"""

import sys
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path

import hydra
from hydra._internal.hydra import Hydra
from hydra._internal.utils import create_config_search_path, get_args_parser
from hydra.core.config_search_path import ConfigSearchPath, SearchPathQuery
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.utils import JobReturn
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from contactlab.composition import check
from contactlab.config import build
from contactlab.faults import ConfigurationError
from contactlab.runner import execute

COMPLETE, INCOMPLETE, REFUSED, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses."""

CONFIG_NAME = "config"


def main() -> int:
    """Entry point of the command; gives the exit status."""
    try:
        return _dispatch()
    except ConfigurationError as error:
        return _refuse(error.faults)
    except HydraException as error:
        return _refuse([str(error)])
    except KeyboardInterrupt as interrupt:
        print(interrupt or "Interrupted before the run was written.", file=sys.stderr)
        return INTERRUPTED


def run(settings: DictConfig) -> int:
    """The task of one job; launchers import it from here.

    Returns:
        The job's exit status.
    """
    try:
        setup = build(OmegaConf.to_container(settings, resolve=True))  # type: ignore[arg-type]
        directory = Path(HydraConfig.get().runtime.output_dir)
        return COMPLETE if execute(setup, directory) else INCOMPLETE
    except ConfigurationError as error:
        # Only a sweeper that chooses its values while it runs gets here.
        return _refuse(error.faults)
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
    arguments = parser.parse_args()
    if _only_shows(arguments):
        show = hydra.main(
            config_path=str(conf_directory()), config_name=CONFIG_NAME, version_base="1.3"
        )
        show(run)()
        return COMPLETE
    return _run(arguments)


def _only_shows(arguments: Namespace) -> bool:
    """Whether the command line asks Hydra for something else than a run."""
    return bool(
        arguments.help
        or arguments.hydra_help
        or arguments.cfg
        or arguments.info
        or arguments.shell_completion
        or arguments.resolve
        or arguments.experimental_rerun
    )


def _run(arguments: Namespace) -> int:
    """Check, then run or sweep: `hydra.main` with the check in between."""
    hydra.version.setbase("1.3")
    name = arguments.config_name or CONFIG_NAME
    application = Hydra.create_main_hydra2("contactlab", _search_path(arguments))
    try:
        mode = check(application.config_loader, name, arguments.overrides, arguments.multirun)
        start = application.run if mode is RunMode.RUN else application.multirun
        return _status(start(name, run, [*arguments.overrides, f"hydra.mode={mode.name}"]))
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


def _refuse(faults: Iterable[str]) -> int:
    """Tell the faults, a line each."""
    for fault in faults:
        print(fault, file=sys.stderr)
    return REFUSED


def _print_version() -> int:
    from importlib.metadata import version

    print(f"contactlab {version('contactlab')} (hydra-core {hydra.__version__})")
    return COMPLETE
