"""The command as a Hydra application: its own configuration, runs, sweeps, help, and the names of folders.

The configuration of the command, `conf/config.yaml`, includes that of a run, `conf/run.yaml`; besides it has
the study, and how the runs of -m are made. The modules of a run are imported when one is performed: help and
completion need none of them.
"""

import os
import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from shutil import rmtree
from string import Template
from typing import Final

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.object_type import ObjectType
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from contactlab.cli import verbs
from contactlab.cli.arguments import for_hydra, refuse_dashed
from contactlab.cli.completion import print_candidates, queried_shell
from contactlab.cli.sections import SECTIONS
from contactlab.cli.terminal import COMPLETE, RefusalError, refuse, unwritable
from contactlab.config.composition import (
    COMMAND,
    EXPERIMENT,
    VERSION_BASE,
    allowing,
    faults_of,
    refuse_expansions,
    refuse_lines,
    register_resolver,
    started,
)
from contactlab.config.options import conf_directory, declare, groups
from contactlab.config.schema import KEYS
from contactlab.results.provenance import versions

# Workers of a launcher compose the command's configuration too: the task's module brings this with it.
declare(SECTIONS)

_begun: Final[list[bool]] = []
"""Jobs of this process that have begun: Hydra has written the copies of their configuration."""

MOST_CHARACTERS: Final = 120
"""Length of a folder's name; file systems take 255, and netCDF wants some for its own."""

DIGITS: Final = 8
"""Length of the digest that distinguishes names that were shortened or simplified."""


def main(arguments: list[str]) -> int:
    """Run or sweep what the arguments say, and return the exit status."""
    if "--version" in arguments:
        print(f"contactlab {versions()['contactlab_version']} (hydra-core {hydra.__version__})")
        return COMPLETE
    if shell := queried_shell(arguments):
        print_candidates(shell)
        return COMPLETE
    # So Hydra raises what it would print and end on.
    os.environ["HYDRA_FULL_ERROR"] = "1"
    sys.argv[1:] = lines = for_hydra(arguments)
    # Of an earlier command of this process.
    _begun.clear()
    HydraConfig.instance().cfg = None
    try:
        refuse_dashed(arguments, (*KEYS, "experiment", *SECTIONS))
        refuse_lines(line for line in arguments if not line.startswith("-"))
        refuse_expansions(_folders(lines))
        with (
            warnings.catch_warnings(),
            allowing("contactlab.cli.app.Check", "hydra.experimental.callbacks.*", "logging.NullHandler"),
        ):
            # Hydra warns of a folder of options that does not exist, and goes on without.
            warnings.filterwarnings("error", ".* is not available", UserWarning)
            _perform(lines)
    except (BrokenPipeError, RefusalError):
        raise
    # Jobs catch their own: this is from Hydra, whose exceptions have many kinds.
    except Exception as error:
        if isinstance(error, OSError) and HydraConfig.initialized():
            raise unwritable(_left_clean(), error) from error
        return refuse(faults_of(error, sys.argv[1:]))
    return COMPLETE


def _left_clean() -> Path:
    """Return the folder of the run, without the copies of its configuration if Hydra was writing them."""
    about = HydraConfig.get()
    if about.mode == RunMode.MULTIRUN:
        return Path(about.sweep.dir)
    folder = Path(about.run.dir)
    if not _begun and about.output_subdir:
        rmtree(folder / about.output_subdir, ignore_errors=True)
        with suppress(OSError):
            folder.rmdir()
    return folder


def _folders(lines: list[str]) -> Iterator[str]:
    """Yield the folders of configurations that the arguments name."""
    for flag, follower in pairwise([*lines, ""]):
        name, sign, value = flag.partition("=")
        if name in ("--config-dir", "-cd", "--config-path", "-cp"):
            yield value if sign else follower
        elif name == "hydra.searchpath":
            yield from re.findall(r"file://([^,'\"\]]+)", value)


def _perform(lines: list[str]) -> None:
    """Run, sweep or inform, as the arguments say."""
    flags = [line for line in lines if line.startswith("-")]
    if flags in (["--help"], ["-h"]) and not any(line.startswith("hydra.") for line in lines):
        print(_help(lines[:-1]))
        return
    sweeps = flags in (["-m"], ["--multirun"])
    if (flags and not sweeps) or any(line.startswith(("hydra.mode", f"{EXPERIMENT}=")) for line in lines):
        hydra.main(str(conf_directory()), COMMAND, **VERSION_BASE)(task)()
        return
    # Hydra composes once more to see whether the configuration asks for a sweep, which none of these can.
    overrides = [line for line in lines if line not in flags]
    with started() as application:
        if sweeps:
            application.multirun(COMMAND, task, [*overrides, "hydra.mode=MULTIRUN"])
        else:
            application.run(COMMAND, task, [*overrides, "hydra.mode=RUN"])


def _help(lines: list[str]) -> str:
    """Return what Hydra prints for --help; it lists its own groups besides, which takes longer than all."""
    with started() as application:
        config = hydra.compose(COMMAND, lines, return_hydra_config=True)
        HydraConfig.instance().set_config(config)
        sources, listed = application.config_loader.get_sources(), ""
        every = {group for source in sources for group in source.list("", ObjectType.GROUP)}
        for group in sorted({*groups(), *every} - {"hydra"}):
            having = [source for source in sources if source.is_group(group)]
            if names := {name for source in having for name in source.list(group, ObjectType.CONFIG)}:
                listed += f"{group}: {', '.join(sorted(names))}\n"
        own = OmegaConf.masked_copy(config, [str(key) for key in config if key != "hydra"])
        template = Template(config.hydra.help.template)
        return template.substitute(APP_CONFIG_GROUPS=listed, CONFIG=OmegaConf.to_yaml(own))


def task(settings: DictConfig) -> int:
    """Perform one job and return its exit status; launchers import it from here."""
    from contactlab.cli.app import run

    _begun.append(True)
    return run(settings)


def folder_name(overrides: str) -> str:
    """Return the name of the folder of a job, or of a sweep, by its overrides, separated by commas.

    The characters are those that every file system and the netCDF library take, and the length is limited;
    a digest at the end distinguishes what differs elsewhere only.
    """
    spelled = re.sub(r"\s+", "_", re.sub(r"[\\'\"]", "", overrides).strip())
    # A micro sign or a mu, and the slashes of a group.
    plain = re.sub(r"/(?=[\w/]*=)", "-", re.sub(r"[\u00b5\u03bc]", "u", spelled))
    text = re.sub(r"[^-+\w.,=@~%]", "-", plain, flags=re.ASCII)
    if text == plain and len(text) <= MOST_CHARACTERS:
        return text or "default"
    digest = sha256(overrides.encode()).hexdigest()[:DIGITS]
    return f"{text[: MOST_CHARACTERS - DIGITS - 1].rstrip('_-,')}-{digest}"


# Workers of a launcher compose configurations too: whatever they import brings this with it.
register_resolver("folder_name", folder_name)
register_resolver("help_on_verbs", partial(verbs.lines, "    "))
