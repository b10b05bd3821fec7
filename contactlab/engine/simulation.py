"""Run a motor with a contact law: memory, compilation, progress, and the trajectory at the end."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.arguments import check_kinds, check_numbers, check_rates
from contactlab.engine.compilation import compile_loop, kernels_of
from contactlab.engine.contact_step import default_contact_step
from contactlab.engine.diagnosis import Witness
from contactlab.engine.explanation import balanced, explain
from contactlab.engine.loop import advance
from contactlab.engine.pace import set_pace
from contactlab.engine.plant import Plant, plant_of
from contactlab.engine.readout import record_times, take_series
from contactlab.engine.run import (
    COUNTS,
    END,
    ENDING,
    FRICTION_LIMIT,
    HELD_ENERGY,
    INTERVAL,
    LEAST_OPEN,
    LEVEL,
    LOSS,
    MOST_OPEN,
    OPEN,
    PHASE,
    PRESSED,
    PROJECTS,
    RECORDED,
    RELEASED,
    RUNNING,
    SEPARATION,
    STORED,
    TIME,
    TOLERANCE,
    TOUCHING,
    Run,
    run_for,
)
from contactlab.engine.step import PARITY, RUBBING, Step, step_for
from contactlab.engine.workspace import Workspace
from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.declaration import LawError
from contactlab.laws.intake import check_words, fault_of_answers, guarded, kernel_parameters
from contactlab.motor.geometry import contact_frame
from contactlab.motor.motor import Motor
from contactlab.trajectory import Ending, Trajectory
from contactlab.variables import CONTACTS

DEFAULT_TOLERANCE = 1e-7
"""Error of the force at a compliant step's start, as an impulse over that of the contact. The step
itself is far better: its end converges with nearly twice the order of this estimate."""

STEPS_PER_CALL = 50_000
"""Steps between two looks at progress and Ctrl-C."""


def simulate(
    motor: Motor,
    law: ContactLaw,
    *,
    duration: float,
    record_interval: float,
    contact_step: float | None = None,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
    workspace: Workspace | None = None,
) -> Trajectory:
    """Simulate a motor from its start, at rest if it says nothing else; the drive is switched on at t = 0.

    Free flight is exact (the modal flow under the harmonic drive) and every touch-down is located.
    In contact a penalty law is collocated at order 9 with steps that follow its error, a
    multiplier law is stepped at order 1. The trajectory does not depend on the record interval.

    Args:
        motor: what moves.
        law: what acts between tip and rotor.
        duration: [s], positive.
        record_interval: [s], positive and at most the duration. The last record lies at the end.
        contact_step: step of a multiplier law, or longest step of a penalty law [s]; None takes the
            law's default, or less, see `contactlab.engine.contact_step.default_contact_step`.
        tolerance: error of a compliant step [1]; None takes the default. Multiplier laws have none.
        workspace: what runs that follow each other can share; it changes no bit of any.
        progress: called with 0 once the engine is compiled, then now and then with the simulated time [s].

    Returns:
        The trajectory; one that is not complete says why and holds what it had.

    Raises:
        ValueError: an argument out of range, an undamped mode that a tone meets, or tip and rotor
            that overlap at the start where the law is rigid.
        TypeError: an argument of another kind, or a law of neither family.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    check_kinds(motor, law)
    if contact_step is None:
        contact_step = default_contact_step(motor.modes, law)
    check_numbers(law, duration, record_interval, contact_step, tolerance)
    parameters, kernels, law_errors = take_in(law)
    force, rub, solve = kernels
    plant = plant_of(motor)
    check_rates(plant, duration)
    compliant = isinstance(law, PenaltyLaw)
    tables = (workspace or Workspace()).tables(plant, contact_step, duration, not compliant)
    step = step_for(plant)
    run = run_for(_count_records(duration, record_interval))
    run.real[END] = duration
    run.real[INTERVAL] = record_interval
    run.real[TOLERANCE] = DEFAULT_TOLERANCE if tolerance is None else tolerance
    run.real[LEAST_OPEN], run.real[MOST_OPEN] = np.inf, -np.inf
    run.whole[LEVEL] = tables.fresh_level
    set_pace(plant, run, contact_step, compliant)
    _note_kind(law, step, run)
    _start(motor, plant, step, run, compliant)
    compile_loop(plant, tables, step, run)

    if progress is not None:
        progress(0.0)
    finished: list[Array] = []
    ending, message = Ending.COMPLETE, ""
    try:
        while run.real[TIME] < duration and run.whole[ENDING] == RUNNING:
            with law_errors():
                advance(
                    plant,
                    tables,
                    step,
                    run,
                    force,
                    rub,
                    solve,
                    compliant,
                    parameters,
                    STEPS_PER_CALL,
                )
            finished.append(_collect(run))
            if progress is not None:
                progress(float(run.real[TIME]))
    except KeyboardInterrupt:
        ending, message = Ending.INTERRUPTED, f"Interrupted at {run.real[TIME]:.6g} s."
    if run.whole[ENDING] != RUNNING:
        reach = tables.longest * 0.5**tables.contact_level
        witness = Witness(plant, step, run, reach, compliant, kernels, parameters)
        with law_errors():
            ending, message = explain(plant, step, run, witness, contact_step)
    finished.append(_collect(run))
    if run.whole[PHASE] == TOUCHING:
        # The end of the run cut this contact: it has no separation.
        run.contact[SEPARATION] = np.nan
        run.contact[LOSS] -= run.real[HELD_ENERGY]
        finished.append(run.contact[np.newaxis])
    time = record_times(run, int(run.whole[RECORDED]))
    series, modes = take_series(run, time)
    if ending is Ending.COMPLETE:
        ending, message = balanced(run, series, compliant, contact_step)
    rows = np.vstack(finished)
    return Trajectory(
        motor=motor,
        law=law,
        duration=duration,
        contact_step=contact_step,
        record_interval=record_interval,
        time=time,
        series=series,
        contact_mode=modes,
        contacts={v.name: rows[:, column].copy() for column, v in enumerate(CONTACTS)},
        statistics={
            name: int(count) for name, count in zip(COUNTS, run.whole[-len(COUNTS) :], strict=True)
        },
        ending=ending,
        message=message,
    )


def prepare(motor: Motor, law: ContactLaw) -> None:
    """Compile the engine and a law, or load their code, before the first run asks for it."""
    plant = plant_of(motor)
    tables = Workspace().tables(
        plant, law.default_contact_step, 1.0, isinstance(law, MultiplierLaw)
    )
    compile_loop(plant, tables, step_for(plant), run_for(2))
    kernels_of(law)


def take_in(
    law: ContactLaw,
) -> tuple[Array, tuple[Any, ...], Callable[[], AbstractContextManager[None]]]:
    """A law's parameters between guards and its kernels, see `kernels_of`.

    Raises:
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    check_words(law)
    parameters = kernel_parameters(law)
    kernels, law_errors = kernels_of(law)
    with law_errors():
        fault = fault_of_answers(law, parameters, *kernels)
    if fault:
        raise LawError(fault)
    return guarded(parameters), kernels, law_errors


def _count_records(duration: float, interval: float) -> int:
    """Records at 0, interval, 2 interval, ... and at the end; 1e-6 of an interval is round-off."""
    return max(int(np.ceil(duration / interval - 1e-6)), 1) + 1


def _note_kind(law: ContactLaw, step: Step, run: Run) -> None:
    """What the kernels know of a law beside its own kernels."""
    run.real[FRICTION_LIMIT] = law.friction_limit
    if isinstance(law, PenaltyLaw):
        step.whole[RUBBING] = law.friction_kind
        step.whole[PARITY] = law.internal_parity
    if isinstance(law, MultiplierLaw):
        run.whole[PROJECTS] = law.projects


def _start(motor: Motor, plant: Plant, step: Step, run: Run, compliant: bool) -> None:
    """Initial state and phase."""
    step.v[-1] = -motor.rotor.initial_velocity * plant.radius / plant.row_r[-1]
    if motor.start is not None:
        step.q[:-1] = motor.start.displacement
        step.v[:-1] = motor.start.velocity
    u, th = float(plant.row_u @ step.q), float(plant.row_th @ step.q)
    gap, n_u, n_th, _, _ = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)
    rate = n_u * float(plant.row_u @ step.v) + n_th * float(plant.row_th @ step.v)
    if gap < 0.0 and not compliant:
        raise ValueError(
            f"The gap is {gap} m at the start; it must not be negative where the law is rigid: tip and "
            "rotor would overlap."
        )
    if gap < 0.0 or (gap == 0.0 and rate < 0.0):
        run.whole[PHASE] = PRESSED
    else:
        run.whole[PHASE] = OPEN if gap > 0.0 else RELEASED


def _collect(run: Run) -> Array:
    """Take the finished contacts out of the run's storage."""
    rows = run.contacts[: run.whole[STORED]].copy()
    run.whole[STORED] = 0
    return rows
