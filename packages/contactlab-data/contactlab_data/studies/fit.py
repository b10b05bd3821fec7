"""The study `fit`: numbers of laws and motors, and laws, from measurements."""

import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from glob import has_magic
from hashlib import sha256
from importlib.metadata import version
from math import inf
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal

import numpy as np
import pandas
import xarray
import yaml

from contactlab.config import ConfigurationError, build
from contactlab.driving import DEGREE, FRAME
from contactlab.estimate import Estimate
from contactlab.force_curves import CURVE
from contactlab.results.files import digest_of_file
from contactlab.studies.function import function_of, of_laws
from contactlab.studies.law_study import OF_MOTOR, read_file
from contactlab.studies.run_state import code_in
from contactlab.studies.study import LENGTH, Part, Setups, Study, Task, option
from contactlab.studies.tables import UNIT, table, with_unit
from contactlab_data.inference.candidates import Candidate, Data, Discrepancy, candidates_of, of_law
from contactlab_data.inference.evidence import compared, evidences_of, misfits
from contactlab_data.inference.fit import sampled, searched
from contactlab_data.inference.held_out import HeldOut, folds_of
from contactlab_data.inference.law_numbers import FreeNumbers, by_key
from contactlab_data.inference.maximum_likelihood import STARTS
from contactlab_data.inference.nested_sampling import POINTS
from contactlab_data.inference.synthetic import with_noise, without_errors
from contactlab_data.measured.files import read_measurements
from contactlab_data.measured.impacts import MeasuredImpacts
from contactlab_data.measured.series import MeasuredSeries

Method = Literal["least_squares", "nested"]
"""How numbers are found: nested sampling comes after least squares."""

FIRST: Final[Literal["least_squares"]] = "least_squares"
"""End of the keys of the tasks that are done first."""

MISFITS: Final = {"misfit": "misfit", "held out": "held_out_misfit"}
"""Attributes of a fit by the columns that show them."""

OrFree = float | Literal["free"] | None
"""A number of the noise, or that it is free."""


@dataclass(frozen=True, kw_only=True)
class Fit(Study):
    """Which numbers of a law or a motor do measurements support, and which law?

    Numbers with a range, KEY=LOW..HIGH, are free; without any range all numbers of the law are that are not
    stated. Numbers of the geometry of measured impacts are data.NAME. Behind a frame the slip of a path is
    that of its load point, as in `drive`; frame_stiffness and its others are values or ranges. So are
    contact_point, baseline, tilt and cantilever_stiffness of a force curve, of which the first three may be
    free without a range. Least squares from many starts are followed by nested sampling, which yields
    posterior and evidence. Several laws, law=A,B, are compared by their evidence, each with its own numbers
    free besides. Keys are those of the motor that the data state, and go before them. Least squares, with
    intervals by the profile likelihood, are on the page within seconds, posterior and evidence when they are
    there; method=least_squares ends with the first.

        >>> import contactlab as cl
        >>> newton = cl.build(["law=newton"])
        >>> cl.fit(newton, data="impacts.csv", free={"law.restitution": (0.0, 1.0)})  # doctest: +SKIP

    Raises:
        ConfigurationError, ValueError: data, laws or options cannot be used.
    """

    name: ClassVar[str] = "fit"
    several: ClassVar[bool] = True
    ignored: ClassVar[tuple[str, ...]] = ("record", *LENGTH)
    files: ClassVar[str] = "data"
    early: ClassVar[bool] = True

    data: Annotated[
        list[str | Path | Data] | str | Path | Data,
        option(
            "files of measured impacts, tracks, forces on a path, force curves, series or points of a motor"
        ),
    ] = ""
    method: Annotated[Method, option("least_squares, or nested sampling after them")] = "nested"
    free: Annotated[FreeNumbers, option("ranges of free numbers, KEY=LOW..HIGH")] = None
    known: Annotated[list[str] | None, option("keys of a law's numbers that are not free")] = None
    own: Annotated[list[str] | None, option("keys of numbers that several data do not share")] = None
    noise: Annotated[
        OrFree, option("standard deviation over the size of the data, or free", above=0.0, at_most=1.0)
    ] = None
    discrepancy: Annotated[Discrepancy, option("whether the laws may be wrong: off, on or both")] = "off"
    student: Annotated[OrFree, option("degrees of freedom of Student-t noise, or free", above=0.0)] = None
    series: Annotated[list[str] | None, option("series of the data; all")] = None
    held_out: Annotated[
        HeldOut, option("what fits to the rest predict: auto, off, files, cycles of loops, or folds")
    ] = "auto"
    degree: Annotated[int, option("of the spline through the samples of a path: 1, 3, 5 or 7")] = DEGREE
    frame_stiffness: Annotated[float | None, FRAME["frame_stiffness"]] = None
    frame_damping: Annotated[float, FRAME["frame_damping"]] = 0.0
    frame_force: Annotated[float, FRAME["frame_force"]] = 0.0
    contact_point: Annotated[float | Literal["free"], CURVE["contact_point"]] = 0.0
    baseline: Annotated[float | Literal["free"], CURVE["baseline"]] = 0.0
    tilt: Annotated[float | Literal["free"], CURVE["tilt"]] = 0.0
    cantilever_stiffness: Annotated[float | None, CURVE["cantilever_stiffness"]] = None
    points: Annotated[int, option("live points", at_least=25, at_most=100_000)] = POINTS
    starts: Annotated[int, option("starts of least squares", at_least=1, at_most=10_000)] = STARTS
    seed: Annotated[int, option("seed of all random numbers", at_least=0)] = 0

    @cached_property
    def measurements(self) -> Mapping[str, Data]:
        """The measurements with the chosen series and noise, by the name of their file if there are several.

        Raises:
            ConfigurationError: a file cannot be read, or an option does not apply to them.
        """
        files = [Path(each) if isinstance(each, str | Path) else None for each in self._sources]
        labels = [re.sub(r"\W", "_", x.stem) if x else f"data_{i}" for i, x in enumerate(files, 1)]
        if len({*labels}) < len(labels):
            raise ConfigurationError(f"data are {', '.join(labels)}; each must have a name of its own.")
        if len(labels) == 1:
            labels = [""]
        return {label: self._measured(each) for label, each in zip(labels, self._sources, strict=True)}

    @property
    def _sources(self) -> list[Any]:
        """The data as they are given; a name with wildcards stands for the files that it matches."""
        every = list[Any]()
        for each in self.data if isinstance(self.data, list) else [self.data]:
            place = Path(each) if isinstance(each, str | Path) else Path()
            if has_magic(str(place)) and not place.exists():
                every += sorted(Path(place.anchor).glob(str(place.relative_to(place.anchor))))
            else:
                every.append(each)
        if not every:
            raise ConfigurationError(f"data is '{self.data}', which matches no file; it must match one.")
        return every

    def _measured(self, data: Any) -> Data:
        """Return one of the measurements with the chosen series and noise."""
        result: Data = read_file(data, read_measurements) if isinstance(data, str | Path) else data
        if self.series:
            if not isinstance(result, MeasuredSeries):
                raise ConfigurationError("study.series is set and the data are no series; leave it out.")
            try:
                result = result.only(self.series)
            except ValueError as error:
                raise ConfigurationError(str(error)) from error
        noise = self.noise
        if noise is None and not isinstance(result, MeasuredImpacts):
            stated = str(result.attributes.get("noise", ""))
            with suppress(ValueError):
                noise = "free" if stated == "free" else float(stated)
            if stated and noise != "free" and not (noise and 0.0 < noise <= 1.0):
                raise ConfigurationError(
                    f"noise is '{stated}' in the data; it must be free, or above 0 and at most 1."
                )
        if noise is None:
            return result
        return without_errors(result) if noise == "free" else with_noise(result, noise)

    @property
    def base(self) -> Mapping[str, Any]:
        """The configuration of the motor as far as the data state it.

        Raises:
            ConfigurationError: they state several.
        """
        every = [x.configuration for x in self.measurements.values() if not isinstance(x, MeasuredImpacts)]
        stated = [each for each in every if each]
        if any(each != stated[0] for each in stated[1:]):
            raise ConfigurationError("data are of motors with several configurations; they must be of one.")
        return stated[0] if stated else {}

    @property
    def idle(self) -> tuple[str, ...]:
        """Groups and keys of a configuration on which no prediction depends."""
        return OF_MOTOR if self._of_law else self.ignored

    @property
    def _of_law(self) -> bool:
        """Whether all measurements are of a law alone."""
        return all(map(of_law, self.measurements.values()))

    def put_to(self, setups: Setups) -> Setups:
        """Return the setups; without any that of a motor's data."""
        if setups or self._of_law:
            return setups
        return {"": build(self.base)}

    def candidates(self, setups: Setups) -> list[Candidate]:
        """Return the laws to be fitted.

        Raises:
            ConfigurationError: laws or free numbers cannot be used with the measurements.
        """
        tails, free = self.student, by_key(self.free, self.known)
        if unused := [key for key in free for idle in self.idle if f"{key}.".startswith(f"{idle}.")]:
            raise ConfigurationError(
                [f"{key} must be left out: no prediction of these data depends on it." for key in unused]
            )
        sets = self.measurements
        return candidates_of(
            sets[""] if [*sets] == [""] else sets,
            setups,
            free,
            self.known or (),
            own=self.own or (),
            discrepancy=self.discrepancy,
            degrees_of_freedom=inf if tails is None else None if tails == "free" else tails,
            degree=self.degree,
            frame={name: getattr(self, name) for name in FRAME},
            recording={name: getattr(self, name) for name in CURVE},
            name=", ".join(Path(x).name for x in self._sources if isinstance(x, str | Path)),
            digest=" ".join(
                digest_of_file(Path(x)) if isinstance(x, str | Path) else getattr(x, "digest", "")
                for x in self._sources
            ),
        )

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return least squares of each law."""
        settings = {"seed": self.seed, "starts": self.starts, "held_out": self.held_out}
        self._made.update({f"{item.label} {self._digest(item)}": item for item in self.candidates(setups)})
        folds_of(next(iter(self._made.values())).problem, self.held_out)
        return [
            Task(f"{key} {FIRST}", part_of, (searched, settings, item)) for key, item in self._made.items()
        ]

    @cached_property
    def _made(self) -> dict[str, Candidate]:
        """The laws to be fitted by the keys of their tasks, once these are made."""
        return {}

    def further_tasks(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> Iterable[Task]:
        """Return nested sampling of each law after all least squares."""
        del setups
        if self.method != "nested" or any(key in parts for key in self._made):
            return []
        # Likelihoods are evaluated by several processes where the laws are not.
        workers = None if self.workers == 1 and self.scheduler is None else 1
        settings: dict[str, Any] = {"points": self.points, "seed": self.seed, "workers": workers}
        return [
            Task(key, part_of, (sampled, settings, item, parts[f"{key} {FIRST}"]), resumes=True)
            for key, item in self._made.items()
        ]

    def notice(self, setups: Setups) -> str:
        """Return what is on the page first."""
        del setups
        text = "The page has least squares first, posterior and evidence when they are there."
        return text if self.method == "nested" else ""

    def _digest(self, candidate: Candidate) -> str:
        """Return the digest of all that a fit depends on."""
        free = [str(item) for item in candidate.problem.free]
        data = [item.values.tobytes() for item in candidate.problem.data.values()]
        code = (version("dynesty"), *code_in(yaml.safe_load(candidate.origin["configuration"])))
        parts = (candidate.label, *candidate.origin.items(), *free, *code, *data, self.held_out, self.degree)
        return sha256(repr(parts).encode()).hexdigest()[:16]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the fits, a group for each law, by the last method that is done."""
        del setups
        fits = {
            key.rpartition(" ")[0]: parts[key if key in parts else f"{key} {FIRST}"] for key in self._made
        }
        tree = xarray.DataTree(children=fits)
        tree.attrs["title"] = f"Fit of {', '.join(fits)}"
        tree.attrs["comparison"] = "\n".join(compared(fits))
        return tree

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return mean and standard deviation of each free number, after the label of one of several laws."""
        result = {}
        for label, fit in data.children.items():
            before = f"{label}." if len(data.children) > 1 else ""
            for row in _rows(fit):
                result[f"{before}{row['parameter']}"] = Estimate(row["mean"], row["deviation"])
        return result

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the numbers of one law, or the comparison of several and then theirs; what limits them."""
        return findings_of(data)

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return evidence and, for each law, posterior and correlation."""
        return tables_of(data)

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return, for each law, the posterior of all pairs of numbers, and data beside predictions."""
        # Imported here: it brings matplotlib.
        from contactlab_data.studies.fit_figures import draw_corner, draw_predictions, draw_residuals, sets_in

        figures = {}
        for label, fit in data.children.items():
            end, sets = _ending(data, label), sets_in(fit)
            drawn = {f"Posterior of {label}, by pairs of its numbers": (f"corner{end}", draw_corner(fit))}
            for each in sets:
                of = f" of {each}" if each else ""
                picture = draw_predictions(fit, each)
                drawn[f"Data{of} and predictions of {label}"] = (
                    f"predictions{end}{each and f'_{each}'}",
                    picture,
                )
            if "residuals" in fit.children and len(sets) > 1:
                residuals = f"residuals{end}", draw_residuals(fit)
                drawn[f"Residuals of {label} over their errors"] = residuals
            for caption, (name, figure) in drawn.items():
                figure.set_label(caption)
                figures[name] = figure
        return figures


def findings_of(data: xarray.DataTree) -> list[str]:
    """Return the numbers of one law, or the comparison of several and then theirs; what limits each fit.

    What does not fit stands before all of several laws, and after the numbers of one.
    """
    several = len(data.children) > 1
    result = compared(data.children) if several else []
    for label, fit in data.children.items():
        before = f"{label}: " if several else ""
        estimates = [
            f"{row['parameter']} = {with_unit(Estimate(row['mean'], row['deviation']), row['units'])}"
            for row in _rows(fit)
        ]
        result.append(f"{before}{'; '.join(estimates)}.")
        result += [] if several else compared(data.children)
        result += [f"{before}{line}" for line in fit.attrs["findings"].splitlines()]
    return result


def tables_of(data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
    """Return evidence and, for each law of some fits, posterior and correlation."""
    tables = {}
    if len(data.children) > 1:
        every = evidences_of(data.children)
        largest = next(iter(every.values())).value
        failing = misfits(data.children)
        rows = [
            {"law": x, "fits": "no" if x in failing else "yes"}
            | {name: data[x].attrs[key] for name, key in MISFITS.items()}
            | {"ln Z": z, "less the largest": z.value - largest}
            for x, z in every.items()
        ]
        none = " (no law fits: it ranks misfits)" if len(failing) == len(rows) else ""
        quick = " by Laplace's approximation" if np.isnan(next(iter(every.values())).error) else ""
        caption = f"Misfit (residuals over errors), and evidence{quick}{none}"
        tables["evidence"] = table(rows, caption=caption)
    if unseen := [row for label, fit in data.children.items() for row in _unseen(label, fit)]:
        tables["held_out"] = table(unseen, caption="Held out: root mean square of residuals over errors")
    for label, fit in data.children.items():
        end, rows = _ending(data, label), []
        for row in _rows(fit):
            mean = Estimate(row["mean"], row["deviation"])
            number = {"number": row["parameter"], UNIT: row["units"], "best": row["best"], "mean": mean}
            rows.append(number | {"5 %": row["low"], "95 %": row["high"], "truth": row["truth"]})
        frame = table(rows, caption=f"Posterior of {label}: optimum, mean +- deviation, 90 % interval")
        known = frame["truth"].notna().any()
        tables[f"posterior{end}"] = frame if known else frame.drop(columns="truth")
        matrix = fit["summary"].to_dataset()["correlation"].to_pandas().round(2)
        if len(matrix) > 1:
            related = matrix.rename_axis("number").rename_axis(columns=None).reset_index()
            tables[f"correlation{end}"] = table(related, caption=f"Correlation of the posterior of {label}")
    return tables


def part_of(
    function: Callable[..., xarray.DataTree | xarray.Dataset], settings: Mapping[str, Any], *arguments: Any
) -> Part:
    """Return what a function makes of settings and arguments, as the part of a task."""
    data = function(*arguments, **settings)
    return Part(data if isinstance(data, xarray.DataTree) else xarray.DataTree(data))


def _rows(fit: xarray.DataTree) -> list[dict[str, Any]]:
    """Return the rows of a summary."""
    data = fit["summary"].to_dataset().drop_dims("other")
    rows: list[dict[str, Any]] = data.to_dataframe().reset_index().to_dict("records")
    return rows


def _unseen(label: str, fit: xarray.DataTree) -> Iterable[dict[str, Any]]:
    """Yield a row for each part of the data that was held out."""
    if "held_out" in fit.children:
        data = fit["held_out"].to_dataset().drop_dims("parameter")
        for row in data.to_dataframe().reset_index().to_dict("records"):
            yield {
                "law": label,
                "held out": row["fold"],
                "residuals": row["count"],
                "misfit": row["misfit"],
                "misfit when fitted": row["fitted_misfit"],
            }


def _ending(data: xarray.DataTree, label: str) -> str:
    """Return the end of the names of one law's files."""
    return f"_{label.replace(' + ', '_').replace(' ', '_')}" if len(data.children) > 1 else ""


fit = function_of(Fit, of_laws)
