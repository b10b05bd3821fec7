"""The command as a Hydra application: its task, and what of ours Hydra is told of.

Hydra makes the folder of a run before it calls the task. Therefore single runs are checked by a callback of
ours, `contactlab.cli.checking`, and sweeps by our sweeper: a faulty one leaves nothing behind.
"""

import os
import re
import sys
import warnings
from hashlib import sha256
from pathlib import Path

import hydra
from hydra.conf import HydraConf
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from contactlab.cli import terminal
from contactlab.cli.arguments import for_hydra
from contactlab.cli.checking import typed
from contactlab.cli.jobs import perform
from contactlab.cli.next_step import after_a_run
from contactlab.cli.study import perform_study, setups_of
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, RefusalError, refuse
from contactlab.config import ConfigurationError, build, validate
from contactlab.config.composition import CONFIG_NAME, VERSION_BASE, resolved, sentences, without_environment
from contactlab.config.options import conf_directory
from contactlab.config.studies import RUN, study_of
from contactlab.results.provenance import versions
from contactlab.sweeps.state import REFUSED, Job, State, is_done, key_of, write_state

MOST_CHARACTERS = 120
"""Length of a folder's name; file systems take 255, and netCDF wants some for its own."""

_DIGITS = 8
"""Of the digest that keeps a name apart where its text cannot."""


def main() -> int:
    """Run or sweep what the command line says, and give the exit status."""
    if "--version" in sys.argv[1:]:
        print(f"contactlab {versions()['contactlab_version']} (hydra-core {hydra.__version__})")
        return COMPLETE
    # So Hydra raises what it would print and end on.
    os.environ["HYDRA_FULL_ERROR"] = "1"
    command = hydra.main(
        config_path=str(conf_directory()), config_name=CONFIG_NAME, version_base=VERSION_BASE
    )
    try:
        sys.argv[1:] = for_hydra(sys.argv[1:])
        with warnings.catch_warnings(), without_environment(hydra=True):
            # Hydra warns of a folder of options that there is not, and goes on without.
            warnings.filterwarnings("error", ".* is not available", UserWarning)
            command(run)()
    except (BrokenPipeError, UnicodeEncodeError, RefusalError):
        raise
    # Whatever a job raises is told by the job: this is of Hydra, whose exceptions have many kinds.
    except Exception as error:
        return refuse(sentences(error, sys.argv[1:]))
    return COMPLETE


def run(settings: DictConfig) -> int:
    """Perform one job and give its exit status; launchers import it from here.

    A job of a sweep that is complete already is left as it is: whoever starts it may not know.

    Raises:
        SystemExit: with the status, where the job is a run of its own, since Hydra gives back none.
    """
    hydra_config = HydraConfig.get()
    directory = Path(hydra_config.runtime.output_dir)
    swept = hydra_config.mode == RunMode.MULTIRUN
    job = Job(overrides=tuple(typed(hydra_config.overrides.task)), choices=choices_of(hydra_config))
    try:
        configuration = resolved(settings)
        setup = build(configuration)
    except ConfigurationError as error:
        # Only a sweeper that chooses its values while it runs gets here.
        write_state(directory, State(REFUSED, job, " ".join(error.faults)))
        status = refuse(error.faults)
    else:
        if configuration.get("study", {}).get("name", RUN) != RUN:
            checked = validate(configuration)
            over = checked["sweep"]["over"] or []
            setups = setups_of(job.overrides, over) if over else {"": setup}
            sys.exit(perform_study(study_of(checked["study"]), setups, directory))
        job = Job(key_of(setup), job.overrides, job.choices, setup.configuration)
        if swept and is_done(directory, job.key):
            return COMPLETE
        with terminal.ending_at_once():
            status = COMPLETE if perform(setup, directory, job) else INCOMPLETE
        if status == COMPLETE and not swept:
            here = Path(hydra_config.runtime.cwd)
            terminal.tell(after_a_run(directory, job.overrides, here), sys.stdout)
    if status and not swept:
        sys.exit(status)
    return status


def choices_of(hydra_config: HydraConf | DictConfig) -> dict[str, str | None]:
    """Give the options chosen from groups that are not Hydra's."""
    return {
        str(group): None if option is None else str(option)
        for group, option in sorted(hydra_config.runtime.choices.items())
        if not str(group).startswith("hydra/")
    }


def folder_name(overrides: str) -> str:
    """Name the folder of a job, or of a sweep, by its overrides, separated by commas; empty for none.

    Kept to characters that every file system and the netCDF library take, and to a length. A digest at
    the end keeps apart what differs elsewhere only.
    """
    spelled = re.sub(r"\s+", "_", re.sub(r"[\\'\"]", "", overrides).strip())
    # A micro sign or a mu, and the slashes of a group.
    plain = re.sub(r"/(?=[\w/]*=)", "-", re.sub(r"[\u00b5\u03bc]", "u", spelled))
    text = re.sub(r"[^-+\w.,=@~%]", "-", plain, flags=re.ASCII)
    if text == plain and len(text) <= MOST_CHARACTERS:
        return text or "default"
    digest = sha256(overrides.encode()).hexdigest()[:_DIGITS]
    return f"{text[: MOST_CHARACTERS - _DIGITS - 1].rstrip('_-,')}-{digest}"


# Workers of a launcher compose configurations too: whatever they import brings this with it.
OmegaConf.register_new_resolver("folder_name", folder_name, replace=True)
