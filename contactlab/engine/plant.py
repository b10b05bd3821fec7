"""The motor as the engine sees it: unit-mass oscillators, tones and three contact rows.

Every coordinate is a scalar oscillator

    qdd_j + c_j qd_j + k_j q_j = a_j + Re sum_k force_jk exp(i omega_k t)
                                 + row_u[j] f_u + row_th[j] f_th + row_r[j] F.

row_u reads u - w where the rotor moves by w on its bearing. The rotor's rotation is the last one,
q = sqrt(J) alpha with k = 0, c = C_r / J, a = -tau / sqrt(J) and row_r = -R / sqrt(J): one more row in the
tangential direction, which puts R^2 / J into the Delassus matrix, and a huge inertia turns it into a belt.
Reading the rows gives u - w, th and -R Omega (from
the rates); the contact force acts through the same rows.
"""

from functools import cache
from math import ceil, pi, sqrt
from typing import Any

import numpy as np

from contactlab.compiler.kernels import kernel
from contactlab.compiler.lanes import WIDTH
from contactlab.engine.state import EVENT_LIMIT, PLACES, copy_of, new_record, record
from contactlab.motor.motor import Motor, persisting_rates
from contactlab.motor.waveform import MOST_DEGREE

RESONANCE_MARGIN = 1e-9
"""Smallest |k - omega^2 + i c omega| / (k + omega^2) of a drivable mode: below, the steady state is lost."""

NEARLY_RESONANT = 1e-2
"""Relative detuning below which the particular solution is not subtracted: its amplitude would swamp the gap
in round-off."""

STEP_LIMIT = 20_000
"""Steps in contact, rejected ones included, within the time that the pace of a run is watched over, on top
of twice those of the contact step, see `pace_of`; healthy runs take some 300, or 900 at tight tolerances."""

MODES, TONES = 64, 16
"""Coordinates and tones that every plant has room for; more compile the engine anew, with twice the room."""

ORDERS = MOST_DEGREE + 1
"""Powers of time in a piece of a waveform."""

ELECTRODES = 8
"""Electrodes with a waveform that every plant has room for; more compile the engine anew."""

GEOMETRY = record(real="tip_length radius clearance cosine sine")
MODE = record(
    ("q", float, PLACES),
    ("v", float, PLACES),
    real="stiffness damping constant "  # k_j [1/s^2], c_j [1/s], a_j
    "row_u row_th row_r row_w "
    "free_q free_v saved_q saved_v",  # at the step's start less the steady state; before the last step
    whole="near led",
)
TONE = record(
    ("cosine", float, PLACES),
    ("sine", float, PLACES),
    ("flight", float, (2, WIDTH)),
    real="omega steady_u steady_th",
)
PHASOR = record(real="force_re force_im steady_re steady_im", whole="near")

Plant = Any
"""A motor and where it is, a record; j runs over coordinates, k over tones.

geometry [m], cosine and sine of its angle; mode_count, tone_count. modes[j]: coefficients and contact rows,
displacement q and rate v at every place of a step; near, whether a tone is nearly resonant; led, whether
tones and waveform are its displacement and no force. tones[k]: omega [rad/s], amplitudes of the steady state
at the tip [m], [rad], cosine and sine of omega t at every place, and as flight at the nodes of one.
phasors[j, k]: of force, of a led coordinate that of its acceleration, and of steady-state displacement, the
latter zero where mode and tone are `near`ly resonant. Real and imaginary parts stand apart because complex
products are slow in compiled loops this short.
wave: electrodes, their number, zero without a waveform; offset and period of its clock [s], the latter zero
where it does not repeat itself; led, whether any coordinate is; led_gap, whether they alone move the gap, and
then depth, a bound of the penetration [m], and approach, one of its rate [m/s]; led_slip, whether no force
changes the slip, which reverses where pieces end; derivatives of its voltages at the step's start [V s^-m].
couplings[j, e] [N/V kg^-1/2]; forces[j, m], derivatives of the modal force.
"""


Matrix = tuple[float, float, float]
"""Delassus matrix: D_nn, D_nt, D_tt [1/kg]."""


@cache
def plant_record(modes: int, tones: int, electrodes: int = ELECTRODES) -> np.dtype[Any]:
    """Declare the record of a plant with room for so many coordinates, tones and electrodes."""
    numbers = {"real": "offset period depth approach", "whole": "electrodes led led_gap led_slip"}
    wave = record(("derivatives", float, (electrodes, ORDERS)), **numbers)
    return record(
        ("geometry", GEOMETRY),
        ("modes", MODE, modes),
        ("tones", TONE, tones),
        ("phasors", PHASOR, (modes, tones)),
        ("wave", wave),
        ("couplings", float, (modes, electrodes)),
        ("forces", float, (modes, ORDERS)),
        whole="mode_count tone_count",
    )


def room_for(count: int, least: int) -> int:
    """Return the room for a number of things: `least`, doubled until they fit."""
    return least if count <= least else room_for(count, 2 * least)


def modes_of(plant: Plant) -> Any:
    """Return the coordinates that a plant has, a structured array."""
    return plant["modes"][: plant["mode_count"]]


def root_inertia(plant: Plant) -> float:
    """Return the root of the rotor's moment of inertia [kg^1/2 m]."""
    return float(-plant["geometry"]["radius"] / modes_of(plant)["row_r"][-1])


def plant_of(motor: Motor, like: tuple[Motor, Plant] | None = None) -> Plant:
    """Assemble the plant of a motor, at rest.

    Args:
        motor: all that moves.
        like: another motor and its plant at rest, of which that is copied which both have in common.

    Raises:
        ValueError: a tone meets an undamped mode, whose response would grow without bound.
    """
    modes, drive, rotor = motor.modes, motor.drive, motor.rotor
    root = sqrt(rotor.inertia)
    before, shared = like or (None, None)
    same = before is not None and modes is before.modes and drive.waveform is before.drive.waveform
    if before is None or not same or drive.frequency.size != before.drive.frequency.size:
        before, plant = None, _without_drive(motor)
    else:
        plant = copy_of(shared)
    plant["geometry"] = motor.geometry.numbers
    made, prescribed = modes_of(plant), modes.is_prescribed
    turns = made["damping"][-1]
    made["damping"][-1] = rotor.damping / rotor.inertia
    made["constant"][:-1] = 0.0 if motor.preload is None else np.where(prescribed, 0.0, motor.preload)
    made["constant"][-1] = -rotor.load_torque / root
    made["row_r"][-1] = -motor.geometry.rotor_radius / root
    if before is None or drive is not before.drive or made["damping"][-1] != turns:
        _add_tones(plant, motor)
    if prescribed.any():
        wave = plant["wave"]
        # Where no free mode moves the gap, no force does: there is no mass behind the contact, and no impact.
        wave["led_gap"] = not motor.rows_at_rest[0][~prescribed].any()
        wave["led_slip"] = (
            motor.slip_is_prescribed and drive.waveform is not None and not drive.frequency.size
        )
        # Without a mass behind the contact no impulse scales its errors: forces at these bounds do.
        wave["depth"], wave["approach"] = _reach(motor)
    return plant


def _without_drive(motor: Motor) -> Plant:
    """Return a plant of modes and waveform, without tones, rotor and geometry."""
    modes, waveform, tones = motor.modes, motor.drive.waveform, motor.drive.frequency.size
    count = modes.stiffness.size + 1
    electrodes = 0 if waveform is None else modes.coupling.shape[1]
    rooms = room_for(count, MODES), room_for(tones, TONES), room_for(electrodes, ELECTRODES)
    plant = new_record(plant_record(*rooms))
    plant["mode_count"], plant["tone_count"] = count, tones
    made, wave = modes_of(plant)[:-1], plant["wave"]
    made["stiffness"], made["damping"] = modes.stiffness, modes.damping
    made["row_u"], made["row_th"] = modes.approach, modes.tip_slope
    made["row_w"] = 0.0 if modes.rotor_displacement is None else modes.rotor_displacement
    if modes.is_prescribed.any():
        made["led"], wave["led"] = modes.is_prescribed, 1
    if waveform is not None:
        wave["electrodes"], wave["offset"] = electrodes, waveform.start
        wave["period"] = waveform.period if waveform.periodic else 0.0
        plant["couplings"][: count - 1, :electrodes] = modes.coupling
    return plant


def _add_tones(plant: Plant, motor: Motor) -> None:
    """Write forces and steady state of the tones into a plant."""
    made, omega = modes_of(plant), motor.drive.angular_frequency
    tones, phasors = plant["tones"][: omega.size], plant["phasors"][: made.size, : omega.size]
    stiffness, damping = made["stiffness"], made["damping"]
    force = np.zeros((made.size, omega.size), complex)
    force[:-1] = motor.force_phasors
    # Eq. 2.2: the steady state is the force over k - omega^2 + i c omega.
    dynamic = stiffness[:, None] - omega**2 + 1j * damping[:, None] * omega
    margin = np.abs(dynamic[:-1]) / (stiffness[:-1, None] + omega**2)
    if margin.size and margin.min() < RESONANCE_MARGIN:
        mode, tone = np.unravel_index(margin.argmin(), margin.shape)
        raise ValueError(
            f"The tone at {motor.drive.frequency[tone]} Hz meets mode {mode + 1} at "
            f"{motor.modes.natural_frequency[mode]} Hz, which has no damping: its response grows without "
            "bound. Give the resonator damping or move the tone."
        )
    # The rotor has no stiffness and so no resonance: only modes can be near one.
    near = np.zeros(force.shape, bool)
    near[:-1] = margin < NEARLY_RESONANT
    steady = np.where(near, 0.0, force / dynamic)
    made["near"] = near.any(axis=1)
    tones["omega"] = omega
    tones["steady_u"] = np.abs(made["row_u"] @ steady)
    tones["steady_th"] = np.abs(made["row_th"] @ steady)
    phasors["force_re"], phasors["force_im"] = force.real, force.imag
    phasors["steady_re"], phasors["steady_im"] = steady.real, steady.imag
    phasors["near"] = near


def _reach(motor: Motor) -> tuple[float, float]:
    """Return how deep [m] and how fast [m/s] a prescribed motion presses.

    A waveform is looked at where its pieces end, and tones count by their amplitudes.
    """
    modes, drive, reach = motor.modes, motor.drive, np.zeros(2)
    row = motor.rows_at_rest[0][modes.is_prescribed] @ modes.coupling[modes.is_prescribed]
    for order in range(2):
        if drive.voltages:
            reach[order] = (np.abs(row @ drive.phasors) * drive.angular_frequency**order).sum()
        if drive.waveform is not None:
            ends = drive.waveform.pieces.x - drive.waveform.start
            reach[order] -= (row @ drive.waveform.voltage(ends, order)).min()
    return max(float(reach[0]) - motor.geometry.clearance, 0.0), max(float(reach[1]), 0.0)


def resolved_rate(plant: Plant) -> float:
    """Return the fastest rate that persists [rad/s] of tones and modes; zero where nothing vibrates."""
    modes = modes_of(plant)[:-1]
    rates = persisting_rates(modes["stiffness"], modes["damping"])
    return float(max(rates.max(initial=0.0), plant["tones"]["omega"].max()))


def pace_of(plant: Plant, contact_step: float, stepped: bool) -> tuple[float, int]:
    """Return the window of the stall watchdog [s], and the number of steps in contact that it allows.

    Of a compliant law it is a period of the fastest tone, the waveform or the slowest mode, whichever is
    fastest, and at most that of an event every second step. Of a rigid law that is stepped in time it is that
    of an event every fifth step, and at most five periods.
    """
    tones, stiffness = plant["tone_count"], modes_of(plant)["stiffness"]
    phasors = plant["phasors"][: plant["mode_count"], :tones]
    # A tone that no mode feels sets no pace.
    loud = np.any((phasors["force_re"] != 0.0) | (phasors["force_im"] != 0.0), axis=0)
    slowest = np.sqrt(stiffness[stiffness > 0.0].min(initial=np.inf))
    turns = 2.0 * pi / plant["wave"]["period"] if plant["wave"]["period"] > 0.0 else 0.0
    fastest = plant["tones"]["omega"][:tones][loud].max(initial=turns)
    rate = float(max(fastest, slowest if slowest < np.inf else 0.0))
    period = 2.0 * pi / rate if rate > 0.0 else np.inf
    steps, periods = (5.0, 5.0) if stepped else (2.0, 1.0)
    window = min(steps * EVENT_LIMIT * contact_step, periods * period)
    return window, STEP_LIMIT + 2 * ceil(window / contact_step)


def fastest_rate(plant: Plant) -> float:
    """Return the fastest rate of any transient [1/s]."""
    modes = modes_of(plant)
    return float((modes["damping"] + np.sqrt(modes["stiffness"])).max())


@kernel
def delassus(plant: Plant, n_u: float, n_th: float, t_u: float, t_th: float) -> Matrix:
    """Return D_nn, D_nt, D_tt [1/kg] of D = G M^-1 G', rotor included, for directions of `contact_frame`.

    A led coordinate yields to no force, so that what its mass would be has no say.
    """
    nn, nt, tt = 0.0, 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        if mode.led != 0:
            continue
        normal = n_u * mode.row_u + n_th * mode.row_th
        tangential = t_u * mode.row_u + t_th * mode.row_th + mode.row_r
        # Eq. 1.12: with unit masses D is a sum of products of the rows. D_tt is positive by the rotor, D_nt
        # has any sign.
        nn += normal * normal
        nt += normal * tangential
        tt += tangential * tangential
    return nn, nt, tt
