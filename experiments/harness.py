"""What every experiment shares: its configuration, its output folder, and the four files it leaves.

An experiment is a module with

    SAYS                        what the paper says, in our own words
    study(setup, short)         the numbers, an xarray dataset; `short` is the form that the tests run
    table(data)                 rows of numbers for the CSV file and the terminal
    draw(data)                  the figure
    finding(data)               a sentence made from the numbers by rule, and whether the claim holds

and `conf/experiment/NAME.yaml`, its difference from the default configuration.
"""

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas
import xarray
import yaml
from matplotlib.figure import Figure
from tqdm import tqdm

import contactlab as cl
from contactlab.config.nesting import flat, nested
from contactlab.metrics import Run, assess
from contactlab.orbits import BrokenOffError, NotSettledError
from contactlab.plot.style import STYLE
from contactlab.results.provenance import versions
from contactlab.sweeps import Status

STIFFNESS = 1e10
"""Of a Hertz contact where a rigid law is configured [N/m^1.5]: a 5 mm steel tip."""

RIGID = ("lagrange_slip", "lagrange_stick")
"""Laws that take a contact step, not a tolerance."""

FEW = 12
"""Motors for which no processes are started."""

NINE_DIGITS = "{:.9g}".format
"""How tables show numbers."""

DONE, CONTRADICTED, REFUSED = 0, 1, 2
"""Exit statuses; a finding that does not hold is no failure of the script, but nobody shall overlook it."""


@dataclass(frozen=True)
class Result:
    """What an experiment has left.

    Args:
        name: of the experiment.
        title: its first line.
        says: what the paper says.
        sentence: what we find.
        holds: whether the claim holds.
        rows: the table.
        folder: where figure.png, figure.pdf, data.nc and table.csv are.
    """

    name: str
    title: str
    says: str
    sentence: str
    holds: bool
    rows: pandas.DataFrame
    folder: Path


def setup_of(name: str, overrides: Sequence[str] = ()) -> cl.Setup:
    """The checked configuration of an experiment.

    Raises:
        ConfigurationError: with every fault, a sentence each.
    """
    return cl.build([f"experiment={name}", *overrides])


def changed(setup: cl.Setup, changes: Mapping[str, object]) -> cl.Setup:
    """The setup built again with some full keys set otherwise."""
    return cl.build(nested({**flat(setup.configuration), **changes}))


def placed(setup: cl.Setup, start: float, end: float) -> cl.NormalModes:
    """Modes of the configured resonator with the first patch set elsewhere [m]."""
    return changed(setup, {"placement.start": start, "placement.end": end}).motor.modes


def tip_phasors(modes: cl.NormalModes, drive: cl.Drive) -> tuple[np.ndarray, np.ndarray]:
    """Steady phasors of tip displacement [m] and slope [rad], shape (tone,)."""
    w = drive.angular_frequency
    dynamic = modes.stiffness[:, None] + 1j * modes.damping[:, None] * w - w**2
    steady = (modes.coupling @ drive.phasors) / dynamic
    return modes.tip_displacement @ steady, modes.tip_slope @ steady


def with_clearance(motor: cl.Motor, clearance: float) -> cl.Motor:
    """The motor with another clearance [m]."""
    return replace(motor, geometry=replace(motor.geometry, clearance=clearance))


def laws_of(setup: cl.Setup) -> dict[str, cl.ContactLaw]:
    """All three laws with the configured friction, and the configured stiffness if the law has one."""
    mu = setup.configuration["contact"]["friction_coefficient"]
    stiffness = setup.configuration["law"].get("stiffness") or STIFFNESS
    return {
        "lagrange_slip": cl.LagrangeSlip(mu),
        "lagrange_stick": cl.LagrangeStick(mu),
        "hertz_penalty": cl.HertzPenalty(stiffness, mu),
    }


def quantity(numbers: Sequence[float] | np.ndarray, units: str) -> xarray.DataArray:
    """Values of a swept parameter with their unit."""
    return xarray.DataArray(np.asarray(numbers), attrs={"units": units})


def swept(
    setup: cl.Setup,
    over: Mapping[str, object],
    *,
    motor: Callable[..., cl.Motor] | None = None,
    laws: Mapping[str, cl.ContactLaw | Callable[..., cl.ContactLaw]] | None = None,
    rigid_step: float | None = None,
    **asked: Any,
) -> xarray.Dataset:
    """A sweep under every law, which is the first dimension.

    A run that is not complete has NaN, and its reason is printed.

    Args:
        over: values by name.
        motor: makes the motor of them; None is the configured one.
        laws: by name, or functions that make them of the values; None is all three.
        rigid_step: contact step of the rigid laws [s]; None is the default.
        asked: further arguments of `contactlab.sweep`; the duration is the setup's where none is given.
    """
    laws, found = laws or laws_of(setup), []
    for name, law in laws.items():
        with tqdm(desc=name, unit=" runs", disable=None) as bar:
            runs = cl.sweep(
                over,
                motor=motor or (lambda **_: setup.motor),
                law=law,
                contact_step=rigid_step if name in RIGID else None,
                report=lambda count, bar=bar: bar.update(count - bar.n),
                **{"duration": setup.duration, **asked},
            )
        for reason in sorted({*runs.reason.values.ravel()} - {""}):
            print(f"{name}: {reason}", file=sys.stderr)
        found.append(runs.drop_vars(["status", "reason"]).where(runs.status == Status.COMPLETE))
    every = xarray.concat(found, pandas.Index([*laws], name="law")).drop_attrs(deep=False)
    if "time" in every:
        every.time.attrs["units"] = "s"
    return every


def settled(
    setup: cl.Setup,
    over: Mapping[str, xarray.DataArray],
    *,
    motor: Callable[..., cl.Motor] | None = None,
    laws: Mapping[str, cl.ContactLaw | Callable[..., cl.ContactLaw]] | None = None,
    rigid_step: float | None = None,
    metrics: Sequence[str] = (),
) -> xarray.Dataset:
    """The steady states of motors over values, under every law, which is the first dimension.

    Gives the mean `rotor_velocity`, its `error` where a motor has no periodic motion, the `periods` of the
    drive after which the motion repeats itself (0 for never), the `settling_time` in which small deviations
    fall by e, and metrics of the settled motion. What breaks off has NaN, and its reason is printed.

    Args:
        over, motor, laws, rigid_step: as of `swept`; functions get all values by name.
        metrics: keys of `contactlab.metrics.METRICS`.
    """
    laws = laws or laws_of(setup)
    shape = (len(laws), *(each.size for each in over.values()))
    cells = []
    for name, law in laws.items():
        for values in product(*(each.values.tolist() for each in over.values())):
            named = dict(zip(over, values, strict=True))
            moved = motor(**named) if motor else setup.motor
            step = rigid_step if name in RIGID else None
            cells.append((moved, law if isinstance(law, cl.ContactLaw) else law(**named), step, metrics))
    if len(cells) <= FEW:
        found = [*map(_settled, cells)]
    else:
        with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
            states = pool.map(_settled, cells, chunksize=8)
            found = list(tqdm(states, total=len(cells), unit=" motors", disable=None))
    for reason in sorted({reason for _, reason in found} - {""}):
        print(reason, file=sys.stderr)
    columns = pandas.DataFrame([numbers for numbers, _ in found])
    dims = ("law", *over)
    return xarray.Dataset(
        {name: (dims, column.to_numpy().reshape(shape)) for name, column in columns.items()},
        coords={"law": [*laws], **{name: (name, each.values, each.attrs) for name, each in over.items()}},
    )


def _settled(
    cell: tuple[cl.Motor, cl.ContactLaw, float | None, Sequence[str]],
) -> tuple[dict[str, float], str]:
    """The numbers of one steady state, and why there are none."""
    motor, law, step, metrics = cell
    names = ("rotor_velocity", "error", "periods", "settling_time")
    try:
        state = cl.steady(motor, law, contact_step=step)
    except (BrokenOffError, NotSettledError) as error:
        return dict.fromkeys((*names, *metrics), np.nan), f"{law.name}: {error}"
    time = state.orbit.settling_time if state.orbit else np.nan
    found = assess(Run.of_trajectory(state.motion, {}), metrics) if metrics else {}
    return dict(zip(names, (*state.velocity, state.periods, time), strict=True)) | found, ""


def in_chunks(
    work: Callable[[range], pandas.DataFrame], numbers: range, size: int, workers: int
) -> pandas.DataFrame:
    """The rows that some work gives for chunks of numbers, in their order, made by several processes."""
    chunks = [numbers[i : i + size] for i in range(0, len(numbers), size)]
    # Started afresh, workers are the same on every system; each loads the compiled engine once.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        parts = tqdm(pool.map(work, chunks), total=len(chunks), unit=f" x {size}", disable=None)
        return pandas.concat(parts, ignore_index=True)


def perform(module: ModuleType, folder: Path, overrides: Sequence[str] = (), short: bool = False) -> Result:
    """Run an experiment and write its figure, dataset and table."""
    setup = setup_of(_name(module), overrides)
    data: xarray.Dataset = module.study(setup, short)
    data.attrs["configuration"] = yaml.safe_dump(setup.configuration, sort_keys=False)
    return leave(module, data, folder)


def leave(module: ModuleType, data: xarray.Dataset, folder: Path) -> Result:
    """Write figure, dataset and table of what an experiment has found."""
    sentence, holds = module.finding(data)
    rows = pandas.DataFrame(module.table(data))
    folder.mkdir(parents=True, exist_ok=True)
    title = (module.__doc__ or "").partition("\n")[0]
    data.attrs |= {"title": title, "finding": sentence, **versions()}
    data.to_netcdf(folder / "data.nc", engine="netcdf4")
    rows.to_csv(folder / "table.csv", index=False, float_format="%.9g", lineterminator="\n")
    with plt.style.context(STYLE):
        figure: Figure = module.draw(data)
        figure.savefig(folder / "figure.png")
        # No date in the file: the same run gives the same bytes.
        figure.savefig(folder / "figure.pdf", metadata={"CreationDate": None})
    plt.close(figure)
    return Result(_name(module), title, module.SAYS, sentence, holds, rows, folder)


def _name(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2]


def show(result: Result) -> None:
    """Print the table and the finding."""
    print(result.rows.to_string(index=False, float_format=NINE_DIGITS))
    print(f"\n{'Holds' if result.holds else 'DOES NOT HOLD'}: {result.sentence}")
    print(f"Written to {result.folder}: figure.png, figure.pdf, data.nc, table.csv")


def main(name: str, arguments: Sequence[str] | None = None) -> int:
    """Run one experiment from the command line; returns the exit status.

    python experiments/NAME.py [output=DIR] [KEY=VALUE ...]
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    module: Any = sys.modules[name]
    stem = Path(module.__file__).stem
    if "--help" in words or "-h" in words:
        print(f"{module.__doc__}\nusage: python experiments/{stem}.py [output=DIR] [KEY=VALUE ...]")
        return DONE
    folder = Path("outputs") / "experiments" / stem
    for word in [w for w in words if w.startswith("output=")]:
        folder = Path(word.removeprefix("output="))
        words.remove(word)
    try:
        module.__name__ = stem
        result = perform(module, folder, words)
    except cl.ConfigurationError as error:
        print(*error.faults, sep="\n", file=sys.stderr)
        return REFUSED
    show(result)
    return DONE if result.holds else CONTRADICTED
