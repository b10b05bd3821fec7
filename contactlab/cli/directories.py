"""Where the jobs of a command line write to, told before any of them runs."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

from hydra._internal.config_loader_impl import get_overrides_dirname
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.types import Override
from omegaconf import DictConfig, OmegaConf, open_dict

MOST_CHARACTERS = 120
"""Length of a folder's name; file systems take 255, and netCDF wants some for its own."""

_DIGITS = 8
"""Of the digest that keeps a name apart where its text cannot."""


def folder_name(overrides: str) -> str:
    """Name of the folder of a job, or of a sweep: its overrides.

    Kept to characters that every file system and the netCDF library take, and to a length. A digest at
    the end keeps apart what differs elsewhere only.

    Args:
        overrides: separated by commas; empty for the default run.
    """
    spelled = re.sub(r"\s+", "_", re.sub(r"[\\'\"]", "", overrides).strip())
    # A micro sign or a mu, and the slashes of a group.
    plain = re.sub(r"/(?=[\w/]*=)", "-", re.sub(r"[\u00b5\u03bc]", "u", spelled))
    text = re.sub(r"[^-+\w.,=@~%]", "-", plain, flags=re.ASCII)
    if text == plain and len(text) <= MOST_CHARACTERS:
        return text or "default"
    digest = sha256(overrides.encode()).hexdigest()[:_DIGITS]
    return f"{text[: MOST_CHARACTERS - _DIGITS - 1].rstrip('_-,')}-{digest}"


def sweep_directory(composed: DictConfig, tasks: list[Override]) -> str:
    """The folder of a sweep where its name depends on the overrides, else empty.

    A job has fewer overrides than its sweep, so that it cannot tell the name itself.

    Raises:
        OmegaConfBaseException: the name refers to what there is not.
    """
    written = OmegaConf.to_container(composed.hydra.sweep, resolve=False)
    if not isinstance(written, dict) or "override_dirname" not in str(written["dir"]):
        return ""
    _name_job(composed.hydra, tasks)
    with _hydra_config(composed):
        return str(OmegaConf.select(composed, "hydra.sweep.dir"))


def depends_on_number(composed: DictConfig) -> bool:
    """Whether the folder of a job is named by its place in the sweep."""
    written = str(OmegaConf.to_container(composed.hydra.sweep, resolve=False))
    return "job.num" in written or "job.id" in written


def resolved_directory(
    task: DictConfig,
    hydra: DictConfig,
    tasks: list[Override],
    number: int,
    multirun: bool,
    sweep: str = "",
) -> Path:
    """Output directory of a job.

    Args:
        task: what the job is given; Hydra's part is put into it.
        hydra: Hydra's part.
        tasks: the job's overrides.
        number: its place in a sweep.
        multirun: whether it is a job of a sweep.
        sweep: the sweep's folder where it is known already.

    Raises:
        OmegaConfBaseException: its name refers to what there is not.
    """
    with open_dict(hydra.job):
        hydra.job.num = number
        hydra.job.id = str(number)
    _name_job(hydra, tasks)
    # As a node, since setting it as a value makes a copy, which takes longer than all else here.
    task.__dict__["_content"]["hydra"] = hydra
    hydra._set_parent(task)
    keys = ("hydra.sweep.dir", "hydra.sweep.subdir") if multirun else ("hydra.run.dir",)
    with _hydra_config(task):
        known = {"hydra.sweep.dir": sweep} if sweep else {}
        return Path(*(known.get(key) or str(OmegaConf.select(task, key)) for key in keys))


def shared(directories: list[Path]) -> Iterator[str]:
    """Directories that more than one job would write to."""
    for directory, count in Counter(directories).items():
        if count > 1:
            yield (
                f"hydra.sweep.subdir gives '{directory}' to {count} jobs, which would overwrite "
                "each other; it must differ from job to job. Leave it out, and give every value once."
            )


def quoted(text: str) -> str:
    """A text as the value of an override."""
    return "'" + re.sub(r"(\\*)'", r"\1\1\\'", text) + "'"


def to_be_tried(directories: Iterable[Path]) -> list[Path]:
    """The directories that tell whether all can be written to: of new ones, the longest name will do."""
    there, longest = [], dict[Path, Path]()
    for directory in directories:
        if directory.exists():
            there.append(directory)
        elif len(directory.name) > len(longest.get(directory.parent, Path()).name):
            longest[directory.parent] = directory
    return [*there, *longest.values()]


def _name_job(hydra: DictConfig, tasks: list[Override]) -> None:
    said = hydra.job.config.override_dirname
    with open_dict(hydra.job):
        hydra.job.override_dirname = get_overrides_dirname(
            tasks,
            exclude_keys=said.exclude_keys,
            item_sep=said.item_sep,
            kv_sep=said.kv_sep,
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
