"""The study `steady`: what a motor does once it has settled."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from math import isnan
from operator import attrgetter, methodcaller
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final

import numpy as np
import pandas
import xarray

from contactlab.config import Setup
from contactlab.estimate import Estimate
from contactlab.interrupts import Stop, stopped_by
from contactlab.laws import ContactLaw
from contactlab.motor import ModalState, Motor
from contactlab.parameter import Parameter
from contactlab.results.netcdf import TITLE, to_datatree
from contactlab.settling.statistics import PERIODIC
from contactlab.steady_state.search import LONGEST, Converged, converged as find_refined, steady_setup
from contactlab.steady_state.state import CUMULATIVE, Steady as State
from contactlab.studies.function import Put, function_of
from contactlab.studies.study import Part, Progress, Result, Setups, Study, Task, estimates, option
from contactlab.studies.tables import table_of_quantities, with_unit
from contactlab.variables import Variable

ROUGH: Final = 1e-2
"""Roughness of the period map above which its multipliers are reported as rough."""


LEAST_LEFT: Final = 1e-3
"""Share of the way to an orbit that a page still writes [%]."""


@dataclass(frozen=True, kw_only=True)
class Steady(Study):
    """What does the motor do once it has settled: velocity, torque, power, stability?

    The steady state is computed at three steps or tolerances, whose differences give its numerical error.

        >>> import contactlab as cl
        >>> result = cl.steady(cl.build())
        >>> result.kind, round(result.velocity.value, 6)
        ('periodic', -2.191106)

    Raises:
        NoPeriodError, NotSettledError, BrokenOffError: there is none, or it is not reached.
    """

    name: ClassVar[str] = "steady"
    together: ClassVar[int] = 16
    ignored: ClassVar[tuple[str, ...]] = (*Study.ignored, "solver.until", "solver.precision")
    quantities: ClassVar[tuple[Variable, ...]] = (
        Variable("rotor_velocity", (), "rad s-1", "Omega", "mean rotor velocity"),
        Variable("torque", (), "N m", "M", "mean torque of the contact on the rotor"),
        Variable("normal_impulse", (), "N s", "I_n", "normal impulse of a period"),
        Variable("peak_normal_force", (), "N", "N_max", "largest normal force"),
        Variable("contact_share", (), "1", "c", "share of time in contact"),
        Variable("drive_work_rate", (), "W", "P_d", "mean rate of drive work"),
        Variable("damping_loss_rate", (), "W", "P_c", "mean rate of damping loss"),
        Variable("friction_loss_rate", (), "W", "P_f", "mean rate of friction loss"),
        Variable("contact_loss_rate", (), "W", "P_n", "mean rate of contact loss"),
        Variable("load_work_rate", (), "W", "P_l", "mean rate of load work"),
    )

    belt: Annotated[float | None, Parameter("Omega_b", "rad s-1", "prescribed rotor velocity")] = None
    load: Annotated[
        float | None, Parameter("tau", "N m", "load torque in place of rotor.load_torque, positive brakes")
    ] = None
    brake: Annotated[
        float | None, Parameter("tau_b", "N m", "load torque against the rotation of either sense", above=0.0)
    ] = None
    longest: Annotated[
        int,
        option(
            "periods of the drive after which a motion without an orbit has its means",
            at_least=1,
            at_most=10_000_000,
        ),
    ] = LONGEST
    refine: Annotated[bool, option("whether finer steps give the numerical error")] = True

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one task a setup."""
        return [
            Task(label, _steady_state, (setup, self.refine, self.arguments))
            for label, setup in setups.items()
        ]

    def __call__(
        self,
        setups: Setup | Setups,
        *,
        start: "Result | State | tuple[ModalState, float] | None" = None,
        output: str | Path | None = None,
        stop: Stop | None = None,
        progress: Progress | None = None,
    ) -> Result:
        """Compute the steady state of a setup, or of several by label.

        Args:
            setups: what is computed.
            start: of a single setup, another steady state, or modal state and rotor velocity [rad/s] at the
                drive's phase 0.
        """
        if start is None:
            return super().__call__(setups, output=output, stop=stop, progress=progress)
        (setup,) = setups.values() if isinstance(setups, Mapping) else (setups,)
        begun: Any = start.details if isinstance(start, Result) else start
        if isinstance(begun, Converged):
            begun = begun.best
        with stopped_by(stop):
            part = _steady_state(setup, self.refine, {**self.arguments, "start": begun})
        result = Result.of(self, {"": setup}, part.source, part.details)
        if output is not None:
            result.save(output)
        return result

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of `contactlab.steady_state.search.steady`."""
        return {name: getattr(self, name) for name in ("belt", "load", "brake", "longest")}

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the quantities; `velocity` is another name of `rotor_velocity`."""
        every = estimates(data["steady"].to_dataset(), self.quantities)
        return {"velocity": every["rotor_velocity"], **every}

    def numbers_of(self, details: Any) -> dict[str, Estimate]:
        """Return the quantities as `numbers` does, without the orbit that the data show."""
        every = _means(details)
        return {"velocity": every["rotor_velocity"], **every}

    def evaluate(self, setup: Setup) -> dict[str, Estimate]:
        """Return the quantities of one setup, without the orbit that its data show."""
        state = find_refined(setup, refine=self.refine, **self.arguments)
        return _means(state if self.refine else state.best)

    def facts(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return kind, periods, phase and, of an orbit, its multipliers' attributes."""
        return {str(name): value for name, value in data["steady"].attrs.items()}

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return velocity, or torque at a held rotor, kind and stability, and what limits the result."""
        about, group = data["steady"].attrs, data["steady"].to_dataset()
        several = f" of {about['periods']} periods of the drive" if about["periods"] > 1 else ""
        quantity = self.quantities["belt" in about]
        number = self.numbers(data)[quantity.name]
        value, meaning = with_unit(number, quantity.units), quantity.long_name
        ending = f", with the rotor held at {about['belt']:.6g} rad/s" if "belt" in about else ""
        if isnan(number.value):
            # A flat contact has no lever.
            force = float(data.to_dataset()["friction_force"].values[1:].mean())
            value, meaning, ending = f"{force:.6g} N", "mean friction force on the body", ""
        sentences = [
            f"The {meaning} is {value}{ending}.",
            f"The motion is {about['kind']}{several}, found after {about['warm_up']} periods.",
        ]
        if "brake" in about:
            outcome = "holds the rotor" if about["kind"] == "standing" else "is overcome"
            sentences.append(f"A brake of {about['brake']:.6g} N m {outcome}.")
        if "multiplier_real" in group:
            other = "largest other" if about["neutral"] else "largest"
            if about["neutral"]:
                sentences.append(
                    f"{about['neutral']} of the Floquet multipliers is one: the motion repeats itself at any "
                    "value along its direction, and has that of the initial conditions."
                )
            sentences.append(
                f"Small deviations decay with a time constant of {with_unit(about['settling_time'], 's')}; "
                f"the {other} Floquet multiplier has the modulus {about['largest_multiplier']:.6g}."
            )
            if "belt" not in about:
                left = 100.0 * np.exp(-about["run_duration"] / about["settling_time"])
                lacks = f"{left:.3g} %" if left >= LEAST_LEFT else f"less than {LEAST_LEFT:g} %"
                sentences.append(
                    f"A run of the configured {with_unit(about['run_duration'], 's')} lacks {lacks} of the "
                    "way from its start."
                )
            if about["roughness"] > ROUGH:
                sentences.append(
                    "The period map is not smooth here: its derivatives over steps of 1e-6 and 1e-4 differ "
                    f"by {about['roughness']:.2g}, as where a contact grazes; the multipliers are rough."
                )
        elif about["kind"] == PERIODIC:
            sentences.append("No closed orbit was found next to it: no multipliers.")
        elif "reason" in about:
            sentences.append(about["reason"])
        return sentences

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return the quantities, a row each."""
        caption = f"Steady state under {data.attrs['law']}"
        numbers = self.numbers(data)
        there = [each for each in self.quantities if not isnan(numbers[each.name].value)]
        return {"quantities": table_of_quantities(there, {"value": numbers}, caption)}

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return path of the tip, multipliers, velocity, gap and forces."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.figures import captioned
        from contactlab.studies.orbit_figures import draw_steady

        caption = (
            f"{data.attrs['title']}: path of the tip end, Floquet multipliers or stroboscopic samples; rotor "
            "velocity, gap and forces over one orbit or period."
        )
        return {self.name: captioned(draw_steady(data), caption)}


def _steady_state(setup: Setup, refine: bool, arguments: dict[str, Any]) -> Part:
    state = find_refined(setup, refine=refine, **arguments)
    return Part(partial(tree_of, state), state if refine else state.best)


def _means(state: Converged | State) -> dict[str, Estimate]:
    """Return `Steady.quantities` by name; those of a single step have no discretisation error."""
    names = ("velocity", "torque", "impulse", "peak_force", "contact_share")
    each: list[Any] = [attrgetter(name) for name in names]
    each += [methodcaller("average", name) for name in CUMULATIVE[1:]]
    values = [state.value(of) if isinstance(state, Converged) else of(state) for of in each]
    return dict(zip((quantity.name for quantity in Steady.quantities), values, strict=True))


def tree_of(converged: Converged) -> xarray.DataTree:
    """Return one orbit, or one period of another motion, as a tree like that of a run.

    The group `steady` contains the quantities of `Steady` with their errors, the Floquet multipliers where
    there is an orbit, stroboscopic samples elsewhere, and kind and section as attributes.
    """
    best = converged.best
    tree = to_datatree(best.curves(records=2000), best.setup.configuration)
    del tree["state"]
    law = str(tree.attrs["title"]).removeprefix(TITLE)
    tree.attrs["title"] = f"Steady state of a standing-wave piezoelectric motor with the contact law {law}"
    tree["time"].attrs["long_name"] = f"time since the drive's phase of {best.phase:.9g} periods"
    variables: dict[str, Any] = {}
    for quantity, (value, error) in zip(Steady.quantities, _means(converged).values(), strict=True):
        for name, number, about in (("", value, ""), ("_error", error, "error of the ")):
            meaning = {"units": quantity.units, "long_name": about + quantity.long_name}
            variables[quantity.name + name] = (), number, meaning
    facts: dict[str, Any] = {"kind": best.kind, "periods": best.periods, "phase": best.phase}
    facts |= {"run_duration": best.setup.duration, "warm_up": best.warm_up}
    facts[converged.control] = json.dumps(converged.values)
    facts |= {key: value for key in ("belt", "brake") if (value := getattr(best, key)) is not None}
    facts |= {"reason": best.reason} if best.reason else {}
    if best.orbit is not None:
        every = best.orbit.multipliers
        for part, values in (("real", every.real), ("imag", every.imag)):
            meaning = {"units": "1", "long_name": f"{part} part of the Floquet multipliers"}
            variables[f"multiplier_{part}"] = "multiplier", values, meaning
        facts |= {name: getattr(best.orbit, name) for name in ("roughness", "settling_time")}
        facts["largest_multiplier"] = best.orbit.largest
        facts["neutral"] = int(best.orbit.neutral.sum())
    else:
        for name in ("slip_velocity", "rotor_velocity"):
            attributes = {**tree[name].attrs, "long_name": f"{tree[name].attrs['long_name']}, once a period"}
            variables[f"stroboscopic_{name}"] = "sample", best.motion.series[name][1:], attributes
    tree["steady"] = xarray.DataTree(xarray.Dataset(variables, attrs=facts))
    return tree


def _motor(
    motor: Motor | Setup,
    law: ContactLaw | None = None,
    *,
    contact_step: Annotated[float | None, Parameter("h", "s", "largest step in contact")] = None,
    tolerance: Annotated[float | None, Parameter("", "1", "relative tolerance in contact")] = None,
) -> Put:
    """Put the study to a motor.

    Args:
        motor: what moves, or a whole setup.
        law: what acts between tip and rotor; a setup has its own.
        contact_step, tolerance: as of `contactlab.simulate`.
    """
    return {"": steady_setup(motor, law, contact_step, tolerance)}, {}


steady = function_of(Steady, _motor, refine=False)
converged = function_of(Steady, _motor, name="converged")
