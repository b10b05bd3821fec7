"""Impulses of a rigid contact in its limit of no step: impacts, and corrections of what a step has left.

An impact is the law's, with the Delassus matrix D of the contact as it stands. After an impact with a
rebound w the tip flies, as long as that matters: under a pressing acceleration a the flight takes 2 w/|a|,
and with the restitution e = w/|w_before| the infinitely many that follow it T = 2 w/(|a| (1 - e)) in all.
Where T is shorter than sqrt(tolerance) times the longest step in contact, they are taken as one impulse
that leaves no rebound: what they change beyond that is of second order in T. Nearly elastic rebounds, e >
0.99, never end; they count as none where a single flight is as short as that, which takes the velocity w
from the motion. In plants so slow that all flights are shorter than a step, T is compared with the longest
of them so far, whatever e is. A flight that is no digit of the gap high is none.
"""

from math import inf, sqrt
from typing import Any

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.flight import CLEAR, coarseness
from contactlab.engine.kinematics import Contact, contact_at, free_accelerations, modal_force, tip_motion
from contactlab.engine.memory import jump, recall_start
from contactlab.engine.plant import Matrix, delassus
from contactlab.engine.rigid import ROUND_OFF, sliding_ratio
from contactlab.engine.state import INCONSISTENT, NOT_FINITE, START, Law, Run
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.lagrange import stick_impulse
from contactlab.laws.memory import AT_SLIP, AT_STICK

NEARLY_ELASTIC = 0.01
"""Share of the speed, 1 - e, that impacts lose whose rebounds never end."""

LEAST_HEIGHT = 10.0 * CLEAR
"""Height [m] of a rebound whose flight the digits of the gap still resolve."""


@part_kernel
def matrix_of(run: Run, frame: Contact) -> Matrix:
    """Return the Delassus matrix of a contact."""
    _, _, _, n_u, n_th, t_u, t_th = frame
    return delassus(run.plant, n_u, n_th, t_u, t_th)


@inner_kernel
def _move(run: Run, frame: Contact, p_n: float, p_t: float) -> None:
    """Change the rates at the step's start by impulses [N s]."""
    _, _, _, n_u, n_th, t_u, t_th = frame
    # Coordinates have unit masses, so that a generalised impulse is the change of a rate (eqs. 1.11, 1.12).
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        change = modal_force(mode, n_u * p_n + t_u * p_t, n_th * p_n + t_th * p_t, p_t)
        mode.v[START] += change
        mode.free_v += change


@inner_kernel
def _work_of_led(run: Run, frame: Contact, p_n: float, p_t: float) -> float:
    """Return the work [J] against impulses [N s] of the drive that keeps led coordinates on their path."""
    _, _, _, n_u, n_th, t_u, t_th = frame
    u, th, work = n_u * p_n + t_u * p_t, n_th * p_n + t_th * p_t, 0.0
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        if mode.led != 0:
            work -= (mode.row_u * u + mode.row_th * th + mode.row_r * p_t) * mode.v[START]
    return float(work)


@inner_kernel
def _account(run: Run, before: Contact, after: Contact, p_n: float, p_t: float) -> float:
    """Add impulses [N s] to the sums of contact and run, with their loss [J], which is returned."""
    state, contact = run.state, run.state.contact
    if run.plant.wave.led != 0:
        state.total.drive_work += _work_of_led(run, before, p_n, p_t)
    # Velocities change linearly with the impulses, so that their work is that of the mean velocity: exact,
    # and lost where an impulse opposes it.
    lost = -0.5 * p_n * (before[1] + after[1])
    rubbed = -0.5 * p_t * (before[2] + after[2])
    state.total.contact_loss += lost
    state.total.friction_loss += rubbed
    state.total.normal_impulse += p_n
    state.total.friction_impulse += p_t
    contact.energy_loss += lost + rubbed
    contact.normal_impulse += p_n
    contact.friction_impulse += p_t
    return float(lost + rubbed)


@inner_kernel
def _push(run: Run, frame: Contact, p_n: float, p_t: float) -> None:
    """Let the impulses of an impact act [N s], and account for what they do."""
    state, contact = run.state, run.state.contact
    _move(run, frame, p_n, p_t)
    lost = _account(run, frame, contact_at(run.plant, START), p_n, p_t)
    contact.impact_energy_gain += max(-lost, 0.0)
    _note_impact(contact, p_n)
    if contact.start_time < state.run_start <= state.time:
        _note_impact(state.contact_of_run, p_n)


@inner_kernel
def _note_impact(contact: Any, p_n: float) -> None:
    """Note an impulse [N s] in a row of contacts; its force is the limit of impulse over step."""
    contact.largest_impact = max(contact.largest_impact, p_n)
    contact.peak_normal_force = inf


@inner_kernel
def become(run: Run, law: Law, mode: int, slip: float) -> None:
    """Set the friction mode and the sign of the slip, with the reset map of a change."""
    state, before = run.state, run.state.mode
    state.mode, state.sign = mode, 1 if slip > 0.0 else -1
    if mode != before:
        state.friction_switches += 1
        jump(run, law, law.memory, AT_STICK if mode == STICK else AT_SLIP)


@inner_kernel
def _ends(run: Run, rebound: float, lost: float) -> bool:
    """Return whether the flights after a rebound [m/s], which lost a share of the speed, count as none."""
    state, longest = run.state, run.propagator.rule.resolved
    pressing = -free_accelerations(run, START, 0.0)[0]
    # T = 2 w/(|a| (1 - e)) of all flights; where impacts lose nearly nothing, 2 w/|a| of a single one.
    if lost < NEARLY_ELASTIC and longest <= state.watchdog.longest_quiet:
        lost = 1.0
    # The height w^2/(2 |a|) that the digits of the gap resolve, and the time that is none, both times |a|:
    # without a pressing acceleration the tip does not come back by itself.
    high = coarseness(run, tip_motion(run.plant, START)[1]) * LEAST_HEIGHT * pressing
    long = sqrt(state.tolerance) * min(longest, state.watchdog.longest_quiet) * pressing * lost
    return bool(pressing > 0.0 and (2.0 * rebound <= long or 0.5 * rebound * rebound <= high))


@inner_kernel
def apply_impact(run: Run, law: Law, rate: float, slip: float) -> bool:
    """Let the law answer an approach [m/s], and return whether the tip flies off; sets mode and sign.

    An approach that it does not stop ends the run as INCONSISTENT.
    """
    state = run.state
    frame = contact_at(run.plant, START)
    d_nn, d_nt, d_tt = matrix_of(run, frame)
    recall_start(run, law)
    p_n, p_t = law.impact(rate, slip, d_nn, d_nt, d_tt, law.parameters)
    state.critical_friction = d_nn / abs(d_nt) if d_nt != 0.0 else inf
    # Also NaN is no positive impulse.
    if not p_n > 0.0 or not np.isfinite(p_n + p_t):
        state.ending = INCONSISTENT if np.isfinite(p_n + p_t) else NOT_FINITE
        return False
    _push(run, frame, p_n, p_t)
    after = contact_at(run.plant, START)
    rebound, left = after[1], after[2]
    # A slip that the law ends is the difference of two velocities: of their round-off the mode must not hang.
    if abs(left) <= ROUND_OFF * max(abs(rate), abs(slip), abs(d_tt * p_t)):
        left = 0.0
    become(run, law, STICK if left == 0.0 else SLIP, left)
    if rebound <= ROUND_OFF * abs(rate):
        return False
    # The flights that follow the rebound are taken one by one, unless they are short enough to count as none
    # (docs/theory/rigid.md, "Rebounds").
    if not _ends(run, rebound, 1.0 - rebound / abs(rate)):
        return True
    # One impulse takes the rebound back, in stick (eq. 4.5) or with the friction of the slip (eq. 4.6 with
    # the rebound for the gap rate). It is negative; the impact's and this one together are positive.
    if left == 0.0:
        p_n, p_t = stick_impulse(rebound, 0.0, d_nn, d_nt, d_tt)
    else:
        pressing = free_accelerations(run, START, 0.0)[0]
        ratio = sliding_ratio(law, pressing, left, (d_nn, d_nt, d_tt))
        ratio = ratio if np.isfinite(ratio) else 0.0
        p_n = -rebound / (d_nn + ratio * d_nt)
        p_t = ratio * p_n
    _push(run, after, p_n, p_t)
    return False


@inner_kernel
def settle(run: Run, holds: bool) -> Contact:
    """Take from the step's start what is left of gap, gap rate and, if the contact `holds` it, slip.

    It is along the gradient, by the masses, as the paper's corrector (eq. 57). What changes the rates are
    impulses of the contact: a slip that is located up to SLIP_ROUND_OFF turns the rotor as it ends. A contact
    without impulse so far may be a touch by round-off, which has none. Returns the contact.
    """
    contact = run.state.contact
    frame = contact_at(run.plant, START)
    _, _, _, n_u, n_th, _, _ = frame
    # Eq. 4.3: one Newton step onto g = 0 along its gradient. What is left is of second order in a gap of
    # 1e-22.
    shift = frame[0] / matrix_of(run, frame)[0]
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        change = modal_force(mode, shift * n_u, shift * n_th, 0.0)
        mode.q[START] -= change
        mode.free_q -= change
    # The displacement has turned the directions.
    frame = contact_at(run.plant, START)
    d_nn, d_nt, d_tt = matrix_of(run, frame)
    # Then the rates: gdot = 0, and in stick v = 0, by impulses as in eq. 4.5. Slip keeps its rate, as
    # friction there is no constraint; a prescribed one yields to no impulse.
    p_n, p_t = -frame[1] / d_nn, 0.0
    if holds and run.plant.wave.led_slip == 0:
        p_n, p_t = stick_impulse(frame[1], frame[2], d_nn, d_nt, d_tt)
    _move(run, frame, p_n, p_t)
    after = contact_at(run.plant, START)
    if contact.duration > 0.0 or contact.normal_impulse != 0.0:
        _account(run, frame, after, p_n, p_t)
    return after
