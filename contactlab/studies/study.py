"""A study: one question put to one or more setups, declared once.

From the declaration follow the verb with its help, the options of the Hydra group `study`, sweeps over any
configuration key, resumption, progress, files, the page and the Python function. A package of one's own
adds a study by an entry point:

    [project.entry-points."contactlab.studies"]
    stroke = "their_module:Stroke"
"""

from __future__ import annotations

import re
import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cache, cached_property, partial
from html import escape
from inspect import get_annotations
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self, final, get_origin

import numpy as np

from contactlab.checks import check_fields
from contactlab.estimate import Estimate
from contactlab.interrupts import Stop, stopped_by
from contactlab.parameter import Parameter, declared_fields
from contactlab.quantity import UnitError, to_si
from contactlab.results.netcdf import configuration_of
from contactlab.results.provenance import code_attributes
from contactlab.results.yaml_text import read_yaml, write_yaml
from contactlab.studies.docstrings import question_in
from contactlab.studies.tables import as_html, as_text, with_unit
from contactlab.studies.task import TASKS, Part as Part, Progress as Progress, Setups as Setups, Task as Task
from contactlab.variables import Variable

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from contactlab.config import Setup

STUDY, SEVERAL = "study", "configurations"
"""Attributes of a result's data: its study with all options, and the configurations by label if several."""


LENGTH: Final = ("solver.duration", "solver.until", "solver.precision")
"""Keys of the end of a run, on which a steady state does not depend."""


def option(meaning: str, **limits: Any) -> Parameter:
    """Return the declaration of an option without unit and symbol."""
    return Parameter("", "1", meaning, **limits)


@final
@dataclass(frozen=True)
class Range:
    """A number of a motor from one value to another.

        >>> Range.of_text("contact.clearance=1 um..4 um").within("m")
        (1e-06, 4e-06)

    Args:
        name: of the number, as a full key.
        start, end: in SI, or texts with units.
    """

    PATTERN: ClassVar[re.Pattern[str]] = re.compile(
        r"(?P<name>[\w.]+)=(?P<start>\s*[-+]?\.?\d.*?)\.\.(?P<end>\s*[-+]?\.?\d.*)"
    )
    """Words of a command that are one: KEY=START..END. Both are numbers, which no path is: a/../b."""

    name: str
    start: float | str
    end: float | str

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Read KEY=START..END; a ValueError if it is something else."""
        if span := cls.PATTERN.fullmatch(text):
            return cls(span["name"], span["start"].strip(), span["end"].strip())
        raise ValueError("it must be KEY=START..END, as in contact.clearance=1 um..4 um")

    def __str__(self) -> str:
        return f"{self.name}={self.start}..{self.end}"

    def within(self, unit: str) -> tuple[float, float]:
        """Return start and end in SI.

        Raises:
            UnitError: one of them has another unit; a sentence that names both.
        """
        sides = (self.start, self.end)
        try:
            start, end = (to_si(side, unit) if isinstance(side, str) else float(side) for side in sides)
        except UnitError as error:
            raise UnitError(f"{self}, {error}") from error
        return start, end


@dataclass(frozen=True, kw_only=True)
class Study(ABC):
    """Base class of studies; fields of subclasses are options, annotated with `Parameter`.

    The docstring of a subclass is the help of its verb: the first paragraph states the question.
    """

    name: ClassVar[str]
    """Name of the verb, of the option of the group `study` and of the files."""

    quantities: ClassVar[tuple[Variable, ...]] = ()
    """Numbers of a result, each with its error: what a sweep of the study collects."""

    together: ClassVar[int] = 1
    """Cells of a sweep that are one task: more than one where a cell takes far less than a second."""

    several: ClassVar[bool] = False
    """Whether one study takes several setups: `law=newton,poisson`."""

    ignored: ClassVar[tuple[str, ...]] = ("record", "solver.changes")
    """Groups and keys of a configuration on which the study does not depend; they are refused."""

    files: ClassVar[str] = ""
    """Option that takes words of the command line which name files or folders."""

    presets: ClassVar[tuple[str, ...]] = ()
    """Options of groups, 'GROUP=OPTION', by default instead of those of a run; an experiment has its own."""

    early: ClassVar[bool] = False
    """Whether files are written once the first tasks are done, before further ones replace them."""

    delay: ClassVar[float] = 0.0
    """Processor time after which other processes are started, which takes seconds itself [s]."""

    def __post_init__(self) -> None:
        _check_attributes(type(self))
        check_fields(self, self.name)

    workers: Annotated[int, option("processes at work", at_least=1, at_most=1000)] = 1
    scheduler: Annotated[str | None, option("address of a Dask scheduler whose workers do the tasks")] = None

    @property
    def base(self) -> Mapping[str, Any] | None:
        """Configuration below the overrides of the command, without any of which there is no setup.

        None is that of the default run, which is a setup of its own.
        """
        return None

    @property
    def idle(self) -> tuple[str, ...]:
        """`ignored`, and what this one does not depend on besides."""
        return self.ignored

    def put_to(self, setups: Setups) -> Setups:
        """Return the setups to which the study is put, by the labels of its data; by default those chosen."""
        return setups

    def notice(self, setups: Setups) -> str:
        """Return what is to be known before the tasks are done, as that they are too few; empty without."""
        del setups
        return ""

    @abstractmethod
    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return the independent pieces of the study."""

    def further_tasks(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> Iterable[Task]:
        """Return tasks that follow from finished ones, as further samples; none ends the study."""
        del setups, parts
        return ()

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the data of the study from those of its tasks by key; a single task's are its own."""
        del setups
        (data,) = parts.values()
        return data

    @abstractmethod
    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the values of `quantities` with their errors."""

    def numbers_of(self, details: Any) -> dict[str, Estimate] | None:
        """Return the numbers from the details of the one task, None where the data alone have them."""
        del details
        return None

    def evaluate(self, setup: Setup) -> dict[str, Estimate]:
        """Return the numbers for one setup alone: a sweep keeps nothing else of the study."""
        return self(setup).numbers

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the sentences that the result supports, the answer to the question first."""
        del data
        return []

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return tables by name; units of columns are `attrs["units"]`, see `contactlab.studies.tables`."""
        del data
        return {}

    def figures(self, data: xarray.DataTree) -> dict[str, Figure]:
        """Return figures by name."""
        del data
        return {}

    def facts(self, data: xarray.DataTree) -> Mapping[str, Any]:
        """Return what is known by name beside the numbers, such as the kind of a motion."""
        del data
        return {}

    def __call__(
        self,
        setups: Setup | Setups,
        *,
        output: str | Path | None = None,
        stop: Stop | None = None,
        progress: Progress | None = None,
    ) -> Result:
        """Put the study to a setup, or to several by label.

        Args:
            setups: what it is put to.
            output: folder of the files, in which an interrupted study goes on; None writes none.
            stop: function or event that is looked at between periods of steady states and branches and after
                each task; once it is true or set, the study ends by a StoppedError, and keeps what is in the
                folder.
            progress: receives the number of finished tasks and that of all.

        Raises:
            OSError: the folder cannot be written to.
            StoppedError: it was stopped.
        """
        folder = None if output is None else Path(output)
        every: Setups = setups if isinstance(setups, Mapping) else {"": setups}
        with stopped_by(stop):
            result = run(self, every, folder, progress)
        if folder is not None:
            finish(result, folder)
        return result

    @property
    def options(self) -> dict[str, Any]:
        """The options on which the result depends, by name, as plain numbers, texts and lists of them."""
        every = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: plain(value) for name, value in every.items() if name not in WITHOUT_EFFECT}


@cache
def _check_attributes(study: type[Study]) -> None:
    """Refuse a class attribute that no study has, which would be ignored, by a TypeError."""
    # A base class of studies may declare attributes of its own.
    declared = (name for base in study.__mro__[1:] for name in get_annotations(base))
    known = {*dir(Study), *declared, *(field.name for field in fields(study))}
    for name, value in vars(study).items():
        described = callable(value) or hasattr(value, "__get__")
        if not (name in known or name.startswith("_") or described):
            attributes = [n for n in get_annotations(Study) if n not in WITHOUT_EFFECT]
            raise TypeError(
                f"{study.__name__}.{name} is no attribute of a study; it must be one of "
                f"{', '.join(attributes)}, an annotated option, or begin with an underscore."
            )


def check_options(study: type[Study]) -> None:
    """Refuse a class of which an option cannot be one of a command, by a TypeError."""
    for name, field in declared_fields(study).items():
        if field.parameter is None:
            raise TypeError(
                f"The option {name} of the study {study.name} is declared without a Parameter; it must be "
                f"Annotated[..., option('what it is')]."
            )
        if any(get_origin(kind) is tuple for kind in field.kinds):
            raise TypeError(
                f"The option {name} of the study {study.name} is annotated {field.kind}; several values "
                "must be a list[...]."
            )


def listing(quantities: Iterable[Variable], numbers: Mapping[str, Estimate]) -> str:
    """Return the quantities that are known as a sentence lists them: name, number and unit of each."""
    known = [q for q in quantities if np.isfinite(numbers[q.name].value)]
    return ", ".join(f"{q.name.replace('_', ' ')} {with_unit(numbers[q.name], q.units)}" for q in known)


def estimates(data: xarray.Dataset, quantities: Iterable[Variable]) -> dict[str, Estimate]:
    """Return the quantities of a dataset that has NAME and NAME_error of each."""
    return {q.name: Estimate(float(data[q.name]), float(data[f"{q.name}_error"])) for q in quantities}


WITHOUT_EFFECT: Final = frozenset(field.name for field in fields(Study))
"""Options of every study, on which no number depends."""


@final
@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """Result of a study.

        result.data                         an xarray tree with CF attributes
        result.velocity                     a number and its error, by the name of the quantity
        result.tables, result.findings      pandas tables, sentences
        result.save("folder")               dataset, page, figures and tables; back by `contactlab.load`
        result.plot()                       the first figure

    Args:
        study: the question.
        setups: what it was put to; of a file, those that can be built again.
        source: the data of the study, or a function that makes them when they are read first.
        details: the object of the analysis where the study has one task and it ran in this process: its
            attributes are attributes of the result too; None where the data were read from a file.
    """

    study: Study
    setups: Setups
    source: xarray.DataTree | Callable[[], xarray.DataTree]
    details: Any = None

    @classmethod
    def of(
        cls,
        study: Study,
        setups: Setups,
        source: xarray.DataTree | Callable[[], xarray.DataTree],
        details: Any = None,
    ) -> Result:
        """Return a result whose data say what they were made from, and by which code."""
        configurations = {label: setup.configuration for label, setup in setups.items()}

        def make() -> xarray.DataTree:
            data = source() if callable(source) else source
            about = {STUDY: write_yaml({"name": study.name, **study.options})}
            if [*configurations] == [""]:
                # A single task may have written it already.
                about["configuration"] = data.attrs.get("configuration") or write_yaml(configurations[""])
            elif configurations:
                about[SEVERAL] = write_yaml(configurations)
            data.attrs = {**code_attributes(), **about, **data.attrs}
            return data

        return cls(study, setups, make if callable(source) else make(), details)

    @cached_property
    def data(self) -> xarray.DataTree:
        """The data of the study, an xarray tree."""
        return self.source() if callable(self.source) else self.source

    @property
    def configurations(self) -> dict[str, Any]:
        """The configuration of each setup by its label, as the data have it."""
        if SEVERAL in self.data.attrs:
            return dict(read_yaml(self.data.attrs[SEVERAL]))
        single = configuration_of(self.data.attrs)
        return {"": single} if single else {}

    @cached_property
    def numbers(self) -> dict[str, Estimate]:
        """The named numbers with their errors."""
        known = None if self.details is None else self.study.numbers_of(self.details)
        return self.study.numbers(self.data) if known is None else known

    @cached_property
    def tables(self) -> dict[str, pandas.DataFrame]:
        """The tables by name."""
        return self.study.tables(self.data)

    @cached_property
    def findings(self) -> list[str]:
        """The sentences that the result supports, the answer first."""
        return self.study.findings(self.data)

    @cached_property
    def facts(self) -> Mapping[str, Any]:
        """What is known by name beside the numbers."""
        return self.study.facts(self.data)

    def __getattribute__(self, name: str) -> Any:
        try:
            return super().__getattribute__(name)
        except AttributeError:
            # A method of the study may have raised it, which `__getattr__` would not see.
            if name.startswith("_") or hasattr(type(self), name):
                raise
        for named in (self.numbers, self.facts):
            if name in named:
                return named[name]
        if self.details is None:
            raise AttributeError(f"{type(self).__name__} of {self.study.name} has no number {name!r}")
        return getattr(self.details, name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *filter(str.isidentifier, (*self.numbers, *self.facts))]

    def __getitem__(self, name: str) -> Any:
        """Return a variable of the data, or a group."""
        return self.data[name]

    @property
    def figures(self) -> dict[str, Figure]:
        """The figures by name, drawn anew in the style of the package."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.report import styled

        with styled():
            return self.study.figures(self.data)

    def plot(self) -> Figure:
        """Return the first figure.

        Raises:
            ValueError: the study has none.
        """
        for figure in self.figures.values():
            return figure
        raise ValueError(f"The study {self.study.name} has no figure.")

    def save(self, folder: str | Path) -> list[str]:
        """Write dataset, figures, tables and the page into a folder, each file whole or not at all.

        Returns:
            The names of the files.

        Raises:
            OSError: the folder cannot be written to.
        """
        # Imported here: it brings matplotlib.
        from contactlab.studies.report import Report

        study = self.study
        report = Report(
            name=study.name,
            question=question_in(study.__doc__),
            data=self.data,
            findings=self.findings,
            tables=self.tables,
            draw=lambda: self.figures,
            options=study.options,
            configurations=self.configurations,
        )
        return report.save(Path(folder))

    def __repr__(self) -> str:
        return self.text()

    def text(self, width: int = 0) -> str:
        """Return findings, the answer first, and tables of so many characters at most; 0 is any number."""
        tables = ((t.attrs["caption"], as_text(t, width)) for t in self._tables_to_read)
        blocks = ["\n".join(filter(None, table)) for table in tables]
        return "\n\n".join(filter(None, ["\n".join(self.findings), *blocks]))

    def _repr_html_(self) -> str:
        """Show findings and tables in a notebook."""
        tables = (f"<p>{escape(t.attrs['caption'])}</p>{as_html(t)}" for t in self._tables_to_read)
        findings = (f"<li>{escape(sentence)}</li>" for sentence in self.findings)
        return f"<ul>{''.join(findings)}</ul>{''.join(tables)}"

    @property
    def _tables_to_read(self) -> list[pandas.DataFrame]:
        """The tables that have rows, but those of reference, which are for the page."""
        return [t for t in self.tables.values() if len(t) and not t.attrs.get("reference")]


def run(study: Study, setups: Setups, folder: Path | None = None, progress: Progress | None = None) -> Result:
    """Do what is left of a study's tasks and combine them.

    Args:
        study: the question.
        setups: what it is put to, by label.
        folder: where finished tasks are kept until `finish`; None keeps none.
        progress: receives the number of finished tasks and that of all.

    Raises:
        ValueError: two tasks have one key, or of a single setup one of `quantities` has no number.
        TypeError: a task returns no `Part`.
        WorkerError: a worker process died, or has other code.
        OSError: the folder cannot be written to.
        KeyboardInterrupt: as it comes; finished tasks are kept.
    """
    # Imported here: it brings xarray.
    from contactlab.studies.runner import RemovedError, done_parts

    single, setups, result = len(setups) == 1, study.put_to(setups), None

    def write_first(parts: Mapping[str, xarray.DataTree]) -> None:
        if study.early and folder is not None:
            Result.of(study, setups, study.combine(setups, parts)).save(folder)

    while result is None:
        with suppress(RemovedError):
            parts, details = done_parts(study, setups, folder, progress, write_first)
            combined = partial(study.combine, setups, parts)
            result = Result.of(study, setups, combined if parts.unmade else combined(), details)
    if missing := [q.name for q in study.quantities if single and q.name not in result.numbers]:
        raise ValueError(
            f"The numbers of the study {study.name} are {', '.join(result.numbers) or 'none'} without "
            f"{', '.join(missing)}; there must be one for each of its quantities."
        )
    return result


def finish(result: Result, folder: Path) -> list[str]:
    """Write the files of a result into its folder, remove the finished tasks and return the files' names.

    Raises:
        OSError: the folder cannot be written to.
    """
    files = result.save(folder)
    shutil.rmtree(folder / TASKS, ignore_errors=True)
    return files


def plain(value: Any) -> Any:
    """Return an option as YAML has it: numbers as Python's own, a Range as its text, data by their digest."""
    match value:
        case list() | tuple():
            return [*map(plain, value)]
        case Mapping():
            return {name: plain(x) for name, x in value.items()}
        case np.generic():
            return value.item()
        case np.ndarray():
            return value.tolist()
        case _ if isinstance(value, Path) or hasattr(value, "of_text"):
            return str(value)
    return getattr(value, "content_digest", value)
