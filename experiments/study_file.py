"""A study of optuna in a file that outlives the process, whatever ends it.

The file is an SQLite database: what was told to the study is in it as a whole or not at all, and a lock
ends with the process that holds it. Optuna's journal needs nothing less to be installed; there, a line
that was cut makes all that follows unreadable, and a lock of a killed process holds for half a minute.
"""

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import optuna
from sqlalchemy.pool import StaticPool

from contactlab.config import ConfigurationError
from contactlab.config.nesting import flat

NAME = "contactlab"
"""Of the one study in the file."""

SETTINGS = "settings"
"""Attribute of the study: what its trials depend on."""

DIFFERENCES = 3
"""That are told of a file that belongs to other settings."""


@contextmanager
def study_in(
    file: Path | None,
    settings: Mapping[str, Any],
    directions: Sequence[str],
    pruner: optuna.pruners.BasePruner,
) -> Iterator[optuna.Study]:
    """The study in a file, new or as it was left.

    Args:
        file: where it is kept; None keeps it in memory.
        settings: all that the trials depend on, of JSON's types; a file made with others is refused.
        directions: of the objectives, `maximize` or `minimize`.
        pruner: for a single objective.

    Raises:
        ConfigurationError: the file cannot be made, is in use, is no study or that of other settings.
            It is left as it is.
    """
    if file is None:
        yield optuna.create_study(directions=directions, pruner=pruner)
        return
    with closing(_locked(file)) as connection:
        storage = optuna.storages.RDBStorage(
            "sqlite://",
            # One connection for all, the one with the lock.
            engine_kwargs={"creator": lambda: connection, "poolclass": StaticPool},
        )
        study = optuna.create_study(
            study_name=NAME, storage=storage, directions=directions, pruner=pruner, load_if_exists=True
        )
        # Without trials nothing depends on settings: the process was killed before they were written.
        if not study.get_trials(deepcopy=False):
            study.set_user_attr(SETTINGS, settings)
        _refuse_others(file, study.user_attrs.get(SETTINGS, {}), settings)
        try:
            yield study
        finally:
            storage.remove_session()


def _locked(file: Path) -> sqlite3.Connection:
    """A connection that keeps the file to itself until it is closed."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        connection = sqlite3.connect(file, timeout=0.0)
    except (sqlite3.Error, OSError) as error:
        raise ConfigurationError([_why(file, error)]) from error
    try:
        connection.execute("PRAGMA locking_mode = EXCLUSIVE")
        connection.execute("BEGIN EXCLUSIVE")
        connection.commit()
        tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_master")}
        if tables and "studies" not in tables:
            raise sqlite3.DatabaseError("it is a database of something else")
        # Whole after a loss of power too, without waiting for the disk after every number.
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
    except sqlite3.Error as error:
        connection.close()
        raise ConfigurationError([_why(file, error)]) from error
    return connection


def _why(file: Path, error: object) -> str:
    if "locked" in str(error):
        return f"The study {file} is in use; let the search that writes it finish, or choose another file."
    return f"{file} cannot hold a study: {error}. Choose another file by study=FILE."


def _refuse_others(file: Path, made: Mapping[str, Any], asked: Mapping[str, Any]) -> None:
    before, now = flat(made), flat(asked)
    differ = [key for key in {**now, **before} if before.get(key) != now.get(key)]
    if differ:
        told = [f"{key} = {before.get(key)}, not {now.get(key)}" for key in differ[:DIFFERENCES]]
        more = f" and {len(differ) - DIFFERENCES} more" if len(differ) > DIFFERENCES else ""
        raise ConfigurationError(
            [
                f"The study {file} was made with {', '.join(told)}{more}; trials of both would not be one "
                "search. Choose another file by study=FILE or output=DIR."
            ]
        )
