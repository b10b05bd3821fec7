"""The study `fit`: what measurements tell about the numbers of laws and motors, and about laws."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from math import inf
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal
from warnings import warn

import pandas
import xarray

from contactlab.inference.evidence import Evidence, ranked, sentences
from contactlab.inference.fit import STARTS, Candidate, Data, Discrepancy, candidates_of, fitted
from contactlab.inference.law_choice import LawChoice
from contactlab.inference.nested_sampling import POINTS, available
from contactlab.inference.synthetic import with_noise, without_errors
from contactlab.measured.files import read_measurements
from contactlab.measured.series import MeasuredSeries
from contactlab.results.files import digest_of_file
from contactlab.results.provenance import UNKNOWN, code_digest
from contactlab.settling.statistics import Estimate
from contactlab.studies.runner import run
from contactlab.studies.study import Part, Result, Setups, Study, Task, option
from contactlab.studies.tables import UNIT, table

Noise = float | Literal["free"] | None
Tails = float | Literal["free"] | None

COLUMNS: Final = {"best": "best", "low": "5 %", "high": "95 %", "truth": "truth"}


@dataclass(frozen=True, kw_only=True)
class Fit(Study):
    """What do measurements tell about the numbers of a law or a motor, and about laws?

    Numbers with a range, KEY=LOW..HIGH, are free; without any range all numbers of the law without a value
    are. Least squares from many starts are followed by nested sampling, which yields posterior and evidence.
    Several laws, law=A,B, are compared by their evidence.
    """

    name: ClassVar[str] = "fit"

    data: Annotated[str | Data, option("file of measured series or impacts")]
    choice: Annotated[Sequence[str], option("laws, free numbers and values")] = ()
    noise: Annotated[Noise, option("standard deviation of the noise, over the size of the data")] = None
    discrepancy: Annotated[Discrepancy, option("whether the laws may be wrong")] = "off"
    student: Annotated[Tails, option("degrees of freedom of Student-t noise")] = None
    series: Annotated[Sequence[str], option("series of the data; default: all")] = ()
    points: Annotated[int, option("live points", at_least=25)] = POINTS
    starts: Annotated[int, option("starts of least squares", at_least=1)] = STARTS
    seed: Annotated[int, option("seed of all random numbers", at_least=0)] = 0
    checkpoints: Annotated[Path | None, option("folder of checkpoints")] = None

    @property
    def options(self) -> dict[str, Any]:
        """See `Study.options`; the measurements are identified by the keys of the tasks."""
        every = {name: value for name, value in super().options.items() if name not in ("data", "checkpoints")}
        return every | {"data": self._name[0]}

    @cached_property
    def _name(self) -> tuple[str, str]:
        """Name and digest of the measurements."""
        if isinstance(self.data, str):
            return Path(self.data).name, digest_of_file(Path(self.data))
        digest = self.data.digest if isinstance(self.data, MeasuredSeries) else ""
        return type(self.data).__name__, digest

    @cached_property
    def measurements(self) -> Data:
        """The measurements with the chosen series and noise.

        Raises:
            OSError: the file cannot be read.
            ValueError: it contains no measurements, or a series that is chosen is missing.
        """
        found = read_measurements(Path(self.data)) if isinstance(self.data, str) else self.data
        if self.series:
            if not isinstance(found, MeasuredSeries):
                raise ValueError("series are chosen and the data are impacts; leave the option out.")
            found = found.only(self.series)
        if self.noise is None:
            return found
        return without_errors(found) if self.noise == "free" else with_noise(found, self.noise)

    @cached_property
    def candidates(self) -> list[Candidate]:
        """The laws to be fitted.

        Raises:
            ConfigurationError: laws or free numbers cannot be used with the measurements.
        """
        tails = inf if self.student is None else None if self.student == "free" else self.student
        name, digest = self._name
        return candidates_of(
            self.measurements,
            LawChoice.of(self.choice),
            discrepancy=self.discrepancy,
            degrees_of_freedom=tails,
            name=name,
            digest=digest,
        )

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one task a law.

        Raises:
            NoSamplerError: dynesty is not installed.
        """
        del setups
        available()
        # Likelihoods are evaluated by several processes where the laws are not.
        workers = None if self.workers == 1 and self.scheduler is None else 1
        tasks = []
        for one in self.candidates:
            key = f"{one.label} {self._digest(one)}"
            checkpoint = self.checkpoints and self.checkpoints / f"{key.replace(' ', '_')}.checkpoint"
            settings = {"points": self.points, "seed": self.seed, "starts": self.starts}
            tasks.append(Task(key, _fitted, (one, settings, checkpoint, workers)))
        return tasks

    def _digest(self, candidate: Candidate) -> str:
        """Return the digest of all that a fit depends on."""
        try:
            sampler = version("dynesty")
        except PackageNotFoundError:
            sampler = UNKNOWN
        free = [str(one) for one in candidate.problem.free]
        parts = [candidate.label, *candidate.origin.items(), *free, sampler, code_digest()]
        parts += [one.values.tobytes() for one in candidate.problem.data]
        settings = (self.points, self.seed, self.starts, self.noise, *self.series)
        return sha256(repr([*parts, *settings]).encode()).hexdigest()[:16]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the fits, a group for each law."""
        del setups
        fits = {key.rpartition(" ")[0]: tree for key, tree in parts.items()}
        tree = xarray.DataTree.from_dict({f"/{label}": None for label in fits})
        for label, fit in fits.items():
            tree[label] = fit
        tree.attrs["title"] = f"Fit of {', '.join(fits)}"
        return tree

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return mean and standard deviation of each free number, after the label of one of several laws."""
        found = {}
        for label, fit in data.children.items():
            before = f"{label}." if len(data.children) > 1 else ""
            for row in _rows(fit):
                found[f"{before}{row['parameter']}"] = Estimate(row["mean"], row["deviation"])
        return found

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the comparison of the laws, then what limits each fit."""
        found = sentences(evidences(data))
        for label, fit in data.children.items():
            before = f"{label}: " if len(data.children) > 1 else ""
            found += [f"{before}{line}" for line in fit.attrs["findings"].splitlines()]
        return found

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return evidence and, for each law, posterior and correlation."""
        tables = {}
        if len(data.children) > 1:
            first, *_ = every = ranked(evidences(data))
            rows = [
                {
                    "law": one.label,
                    "ln Z": Estimate(one.log_evidence, one.error),
                    "less the largest": one.log_evidence - first.log_evidence,
                }
                for one in every
            ]
            tables["evidence"] = table(rows, caption="Evidence")
        for label, fit in data.children.items():
            rows = []
            for row in _rows(fit):
                columns = {head: row[name] for name, head in COLUMNS.items() if name == "best"}
                columns["mean"] = Estimate(row["mean"], row["deviation"])
                columns |= {head: row[name] for name, head in COLUMNS.items() if name != "best"}
                rows.append({"number": row["parameter"], UNIT: row["units"], **columns})
            frame = table(rows, caption=f"Posterior of {label}: optimum, mean +- deviation, 90 % interval")
            tables[f"posterior{_ending(data, label)}"] = (
                frame.drop(columns="truth") if frame["truth"].isna().all() else frame
            )
            matrix = fit["summary"].to_dataset()["correlation"].to_pandas()
            if len(matrix) > 1:
                related = [{"number": name, **values} for name, values in matrix.round(2).iterrows()]
                tables[f"correlation{_ending(data, label)}"] = table(
                    related, caption=f"Correlation of the posterior of {label}"
                )
        return tables

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return, for each law, the posterior of all pairs of numbers, and data beside predictions."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.fit_figures import draw_corner, draw_predictions

        return {
            f"{name}{_ending(data, label)}": draw(fit)
            for label, fit in data.children.items()
            for name, draw in {"corner": draw_corner, "predictions": draw_predictions}.items()
        }


def _fitted(candidate: Candidate, settings: dict[str, int], checkpoint: Path | None, workers: int | None) -> Part:
    """Fit one law."""
    if checkpoint is not None:
        checkpoint.parent.mkdir(parents=True, exist_ok=True)

    def announce(sentence: str) -> None:
        warn(sentence, stacklevel=1)

    return Part(fitted(candidate, **settings, checkpoint=checkpoint, workers=workers, announce=announce))


def evidences(data: xarray.DataTree) -> list[Evidence]:
    """Return the evidence of each law."""
    names = ("log_evidence", "log_evidence_error", "covers", "coverage")
    return [
        Evidence(label, *(float(fit.attrs[name]) for name in names[:2]), bool(fit.attrs["covers"]), float(fit.attrs["coverage"]))
        for label, fit in data.children.items()
    ]


def _rows(fit: xarray.DataTree) -> list[dict[str, Any]]:
    """Return the rows of a summary."""
    data = fit["summary"].to_dataset().drop_dims("other")
    return data.to_dataframe().reset_index().to_dict("records")


def _ending(data: xarray.DataTree, label: str) -> str:
    """Return the end of the names of one law's files."""
    return f"_{label.replace(' + ', '_').replace(' ', '_')}" if len(data.children) > 1 else ""


def fit(
    data: str | Path | Data,
    laws: str | Sequence[str] = (),
    *,
    free: Mapping[str, tuple[float | str, float | str]] | None = None,
    fixed: Mapping[str, Any] | None = None,
    folder: str | Path | None = None,
    progress: Callable[[int, int], object] | None = None,
    **options: Any,
) -> Result:
    """Fit laws to measurements: the study `Fit`.

        >>> import contactlab as cl
        >>> cl.fit("impacts.csv", "newton", free={"law.restitution": (0.0, 1.0)})  # doctest: +SKIP

    Args:
        data: impacts or series of a motor, or their file.
        laws: names; none is the law of the series' configuration.
        free: ranges by key; without any, all numbers of the laws that are not fixed are free.
        fixed: values by key, parts of a composed law as "law/normal".
        folder: where finished laws and checkpoints are kept, so that an interrupted fit resumes.
        progress: receives the number of finished laws and that of all.
        options: fields of `Fit`.

    Raises:
        OSError: the file cannot be read.
        ConfigurationError, ValueError: data, laws or options cannot be used.
        NoSamplerError: dynesty is not installed.
    """
    names = [laws] if isinstance(laws, str) else [*laws]
    choice = [f"law={','.join(names)}"] if names else []
    choice += [f"{key}={low}..{high}" for key, (low, high) in (free or {}).items()]
    choice += [f"{key}={value}" for key, value in (fixed or {}).items()]
    study = Fit(data=str(data) if isinstance(data, Path) else data, choice=tuple(choice), **options)
    if folder is not None:
        study = replace(study, checkpoints=Path(folder) / "tasks")
    return run(study, {}, None if folder is None else Path(folder), progress)
