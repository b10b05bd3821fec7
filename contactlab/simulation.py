"""One run and its result: `simulate` gives a `Solution`."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final, get_args

from contactlab.checks import check_kind, check_number, checked_arguments
from contactlab.compiler.notice import telling
from contactlab.config import ConfigurationError, Setup, build, rebuild
from contactlab.config.made_in_python import KEYS
from contactlab.engine.arguments import check_kinds
from contactlab.impacts import velocities_after
from contactlab.interrupts import Stop, is_stopped, stopped_by
from contactlab.laws.base import ContactLaw, is_stepped
from contactlab.motor import Motor
from contactlab.progress import shown_by
from contactlab.results.netcdf import configuration_of, state_of, to_datatree, write_tree
from contactlab.results.summary import summarise, summary_of
from contactlab.settling.criterion import LONGEST, PRECISION, STEADY, Until
from contactlab.settling.verdict import SHARE
from contactlab.trajectory import Ending, Trajectory
from contactlab.variables import CONTACT_MODE, CONTACTS, SERIES

SHORTEST: Final = 2e-6
"""Duration of a run that compiles what runs need [s]."""

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, repr=False, eq=False)
class Solution(Mapping[str, "xarray.DataArray"]):
    """What a simulation gives back, and what its file holds: a mapping of names to quantities.

        solution["gap"]                         a quantity over time, with its unit
        solution.sel(time=slice(1e-3, 2e-3))    all quantities in a part of the run, an xarray dataset
        solution.contacts["normal_impulse"]     a row each contact
        solution.save("run.nc")                 and back by `contactlab.load`
        contactlab.simulate(start=solution)     goes on where it ended

        >>> import contactlab as cl
        >>> run = cl.simulate(cl.build(), duration=5e-4)
        >>> run.ending, run.contacts.sizes["contact"]
        (<Ending.COMPLETE: 0>, 2)
        >>> run["normal_force"].attrs["units"], run["normal_force"].max().round(1).item()
        ('N', 9.9)

    Args:
        source: the run in memory, or the tree of a file, see `tree`; its arrays are the solution's.
        setup: what ran, from which it can be run again or go on; None for a file that does not tell,
            as that of a motor that was made in Python.
    """

    source: "Trajectory | xarray.DataTree"
    setup: Setup | None = None

    @cached_property
    def tree(self) -> "xarray.DataTree":
        """See `contactlab.results.netcdf.to_datatree`; made when it is read first, its arrays read-only."""
        tree = self.source
        if isinstance(tree, Trajectory):
            tree = to_datatree(tree, self.setup and self.setup.configuration)
        for node in tree.subtree:
            for variable in node.to_dataset(inherit=False).variables.values():
                variable.values.flags.writeable = False
        return tree

    def __getitem__(self, name: str) -> "xarray.DataArray":
        """Return a quantity at the root of the tree by its name.

        Raises:
            KeyError: there is none; a sentence with those that are.
        """
        if name not in self.tree.variables:
            there = ", ".join(map(str, self.tree.variables))
            raise KeyError(f"There is no quantity {name!r}; it must be one of {there}.")
        return self.tree.to_dataset()[name].copy(deep=False)

    def __iter__(self) -> Iterator[str]:
        return map(str, self.tree.variables)

    def __len__(self) -> int:
        return len(self.tree.variables)

    # Of a mapping, but arrays have no single truth value.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def attrs(self) -> dict[str, Any]:
        """What ran, with which code, and how it ended."""
        return {str(name): value for name, value in self.tree.attrs.items()}

    def sel(self, *labels: Any, **more: Any) -> "xarray.Dataset":
        """Select quantities by labels, such as times [s], as `xarray.Dataset.sel` does."""
        return self.tree.to_dataset().sel(*labels, **more)

    def to_dataframe(self) -> "pandas.DataFrame":
        """Return the series as a table over time."""
        root = self.tree.to_dataset()
        return root[[name for name in root.data_vars if root[name].dims == ("time",)]].to_dataframe()

    @property
    def contacts(self) -> "xarray.Dataset":
        """The contacts, a row each; one that the end of the run cut has no separation velocity."""
        return self.tree.children["contacts"].to_dataset(inherit=False).copy(deep=False)

    @property
    def state(self) -> Mapping[str, Any]:
        """The state in which the run ended, from which another goes on: the group `state` of the tree."""
        return self.source.state if isinstance(self.source, Trajectory) else state_of(self.source)

    @property
    def ending(self) -> Ending:
        """How the run ended."""
        source = self.source
        return source.ending if isinstance(source, Trajectory) else Ending[source.attrs["ending"].upper()]

    @property
    def message(self) -> str:
        """The ending in a sentence, empty for a complete run."""
        source = self.source
        return source.message if isinstance(source, Trajectory) else str(source.attrs["message"])

    @property
    def complete(self) -> bool:
        """Whether the run reached its end with a closed energy ledger."""
        return self.ending is Ending.COMPLETE

    def to_xarray(self) -> "xarray.DataTree":
        """Return the tree that run.nc holds: attributes, series, and the groups `contacts` and `state`.

        Its arrays are read-only; those of a deep copy are not.
        """
        return self.tree.copy(deep=False)

    def save(self, path: str | Path) -> None:
        """Write a netCDF-4 file, whole or not at all.

        Raises:
            OSError: the folder is missing, not writable or full; a sentence.
        """
        write_tree(self.tree, Path(path))

    def plot(self) -> "Figure":
        """Draw rotor velocity, path of the tip, gap and force, or the forces on a prescribed path."""
        # They bring matplotlib.
        if "prescribed" in self.tree.attrs:
            from contactlab.plot.driven import draw_driven

            return draw_driven(self.tree)
        from contactlab.plot.overview import draw_overview

        return draw_overview(self.tree)

    def __repr__(self) -> str:
        return summarise(self.tree)

    def _repr_html_(self) -> str:
        """Show the lines of the summary as a table in a notebook."""
        rows = (
            f"<tr><th>{escape(label)}</th><td>{escape(value)}</td></tr>"
            for label, value in summary_of(self.tree).items()
        )
        return f"<table>{''.join(rows)}</table>"


@checked_arguments(duration="s", record_interval="s", contact_step="s", tolerance="1", precision="1")
def simulate(
    motor: Motor | Setup | None = None,
    law: ContactLaw | None = None,
    *,
    duration: float | None = None,
    record_interval: float | None = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
    until: Until | None = None,
    precision: float | None = None,
    start: Solution | None = None,
    stop: Stop | None = None,
    progress: Callable[[float], None] | None = None,
) -> Solution:
    """Simulate a motor with a contact law.

    What moves is a motor with a law, a whole setup, or what another run left:

        >>> import contactlab as cl
        >>> setup = cl.build(["law=newton", "contact.clearance=0.5 um"])
        >>> whole = cl.simulate(setup.motor, setup.law, duration=2e-3)
        >>> first = cl.simulate(setup, duration=1e-3)
        >>> later = cl.simulate(start=first, duration=1e-3)
        >>> bool(later["rotor_velocity"][-1] == whole["rotor_velocity"][-1])
        True

    Args:
        motor: what moves, or a whole setup as `contactlab.build` gives it; without one, the setup of `start`.
        law: what acts between tip and rotor; a setup has its own.
        duration: [s]; after that of `start`, if one is given. A motor and a law need one, unless they run
            until steady: then it is 1 s at most.
        record_interval: [s]; 1 us, of a slow motor a two-hundredth of its shortest period if 100,000 records
            are not enough for that, see `default_record_interval` in `contactlab.engine.defaults`. The
            last record lies at the end.
        contact_step: longest step in contact of a compliant law [s], by default the law's, and longer for
            slow motors. A rigid law is stepped in time by it, as in the paper; without, it is solved in its
            limit of no step.
        tolerance: error of a step in contact [1]; the engine's default. Time stepping has none.
        until: 'steady' ends the run once the motor has settled, and at the latest after the duration;
            'duration' is the default.
        precision: share by which the motor may be off its steady state where `until='steady'` ends the run
            [1]; 1e-3, at most 0.01.
        start: a run whose end is this one's start: in two parts or in one, a motor does the same to the last
            bit, as long as motor, law and numbers are the same. Others act from that end on.
        stop: function or event that is looked at as often as progress is reported; once it is true or set,
            the run ends as by Ctrl-C, as `Ending.INTERRUPTED`, and the solution has what there is by then.
        progress: called with 0 once the engine is compiled, then now and then with the simulated time [s].

    Returns:
        The solution; one that is not complete says why and holds what it had.

    Raises:
        TypeError: an argument of another kind.
        ValueError: an argument out of range, one too many or one too few.
        LawError: the law contradicts itself, or its code raised an exception.
    """
    numbers = (duration, record_interval, contact_step, tolerance)
    settings: dict[str, Any] = {name: x for name, x in zip(KEYS, numbers, strict=True) if x is not None}
    for name, value in settings.items():
        check_number(f"The {name.replace('_', ' ')}", value)
        settings[name] = float(value)
    settings |= _ending(until, precision)
    if start is not None:
        check_kind("The start", start, Solution)
        if not start.state:
            raise ValueError(
                "The run to start from tells no state to go on from; its file must have the group 'state', "
                "which those of earlier versions lack. Run it again."
            )
    if motor is None and start is not None:
        motor = start.setup
        if motor is None:
            raise ValueError(
                "The run to start from was read from a file that tells no configuration to make its motor "
                "from; give motor and law to simulate too."
            )
    longest = {"duration": LONGEST} if until == STEADY and not isinstance(motor, Setup) else {}
    setup = setup_of(motor, law, longest | settings)

    def report(time: float) -> None:
        if progress is not None:
            progress(time)
        # Before a first step there is nothing to keep.
        if time > 0.0 and is_stopped():
            raise KeyboardInterrupt

    with stopped_by(stop):
        begins = None if start is None else start.state
        trajectory = setup.run(progress=report, start=begins, keep_interrupted=True)
    return Solution(trajectory, setup)


@checked_arguments()
def warm(law: ContactLaw, *, progress: Callable[[str, float], object] | None = None) -> list[str]:
    """Compile what runs and impacts under a law need and what is not there yet, once for an installation.

        >>> import contactlab as cl
        >>> functions = cl.warm(cl.Newton())

    A page or a class calls it first, from a thread if need be: the first run then waits for nothing. The
    command `contactlab warm-up` does it for laws of every kind.

    Args:
        law: whose kind of engine is compiled.
        progress: receives what is compiled, with the seconds that it has taken and will take, and NaN.

    Returns:
        The functions that were compiled; none where all was there.

    Raises:
        TypeError: an argument of another kind.
        LawError: the law contradicts itself.
    """
    check_kind("The law", law, ContactLaw)
    setup = build()
    with telling() as compiled, shown_by(progress or (lambda *_: None)):
        simulate(setup.motor, law, duration=SHORTEST, record_interval=SHORTEST)
        velocities_after(law, [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.5])
    return compiled.functions


def _ending(until: Until | None, precision: float | None) -> dict[str, Any]:
    """Check what says how a run ends, and return it by name."""
    settings: dict[str, Any] = {}
    if until is not None:
        if until not in get_args(Until):
            raise ValueError(f"until is {until!r}; it must be {' or '.join(map(repr, get_args(Until)))}.")
        # A run that lasts its duration has no precision.
        settings = {"until": until} | ({"precision": PRECISION} if until != STEADY else {})
    if precision is not None:
        check_number("The precision", precision)
        if not 0.0 < precision <= SHARE:
            raise ValueError(f"The precision is {precision}; it must be greater than 0 and at most {SHARE}.")
        if until != STEADY:
            raise ValueError("A precision is given; it must come with until='steady', whose runs it ends.")
        settings["precision"] = float(precision)
    return settings


def solution_in(tree: "xarray.DataTree", path: str | Path) -> Solution:
    """Return the solution in the tree of a file.

    Raises:
        ValueError: it is no run of contactlab's; a sentence.
    """
    names = {v.name for v in (*SERIES, CONTACT_MODE)} - set(tree.variables)
    group = tree.children.get("contacts")
    names |= {v.name for v in CONTACTS} - set(group.variables if group is not None else ())
    names |= {"ending", "configuration", "law_parameters"} - set(tree.attrs)
    if names:
        raise ValueError(
            f"'{path}' lacks {', '.join(sorted(names))}; it must be a file that contactlab wrote. Other "
            "datasets are judged by contactlab.metrics.assess."
        )
    try:
        return Solution(tree, rebuild(configuration_of(tree.attrs)))
    # A motor made in Python, or a law that is not installed here.
    except ConfigurationError:
        return Solution(tree)


def setup_of(motor: Any, law: Any, settings: dict[str, Any]) -> Setup:
    """Return the setup of a motor and a law made in Python, or a setup with other numbers of `KEYS`.

    The configuration of the former has the numbers of motor, law and solver.

    Raises:
        TypeError: the motor or the law is of another kind.
        ValueError: a law beside a setup, which has its own, or no duration beside a motor.
    """
    if isinstance(motor, Setup):
        if law is not None:
            raise ValueError(
                "A setup has a law of its own, and another one is given; give a motor and a law, or choose "
                'the law of the setup: contactlab.build(["law=NAME"]).'
            )
        return changed(motor, settings)
    check_kinds(motor, law)
    if "duration" not in settings:
        raise ValueError("The duration is missing; a motor and a law need one in seconds: duration=5e-3.")
    numbers = {name: value for name, value in settings.items() if name in KEYS}
    others = {name: value for name, value in settings.items() if name not in KEYS}
    return replace(Setup.of(motor, law, **numbers), **others)


def changed(setup: Setup, settings: dict[str, Any]) -> Setup:
    """Return a setup with other numbers of `KEYS`."""
    if is_stepped(setup.law, settings.get("contact_step")):
        settings = {"tolerance": None} | settings
    return replace(setup, **settings)
