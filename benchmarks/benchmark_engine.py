"""The engine against SciPy's ODE solvers on the same motor, at the same error, in the same run.

    python benchmarks/benchmark_engine.py [repeats]

Work: the frictionless case A (placement 2, clearance 1 um, K = 1e10 N/m^1.5, 3210 and 6420 Hz, 5 ms).
Error: the larger of the relative errors of u and th at the end, against DOP853 at rtol 1e-13 with
steps of at most 1 us. SciPy gets the motor in normal modes, as the engine does, once with a lean NumPy
right-hand side and once with a compiled one; it integrates no energy ledger and records nothing, while
the engine always carries its ledger and both impulses. For every setting of the engine the table names
the quickest SciPy run that is at least as accurate.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from timeit import repeat

import numba
import numpy as np
from scipy.integrate import solve_ivp

from contactlab.arrays import Array
from contactlab.laws import HertzPenalty
from contactlab.motor.geometry import contact_frame
from contactlab.motor.motor import Motor
from contactlab.testing.plants import last, paper_motor, run

RightHandSide = Callable[[float, Array], Array]

STIFFNESS = 1e10
DURATION = 5e-3
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
ENGINE_SETTINGS = ((1e-5, 1e-3), (1e-5, 1e-5), (4e-6, 1e-6), (4e-6, 1e-7))
"""Contact step [s] and tolerance; the last are the defaults."""


@dataclass(frozen=True)
class Timing:
    """One solver at one setting: its shortest time [s] and its error [1]."""

    name: str
    seconds: float
    error: float


def numpy_side(motor: Motor) -> RightHandSide:
    """Right-hand side of y = (q, v) with NumPy."""
    modes, shape, omega = motor.modes, motor.geometry, motor.drive.angular_frequency
    force = modes.coupling @ motor.drive.phasors
    in_phase, quadrature = force.real.copy(), force.imag.copy()
    count = modes.stiffness.size

    def side(time: float, y: Array) -> Array:
        q, v = y[:count], y[count:]
        u, th = modes.tip_displacement @ q, modes.tip_slope @ q
        a = in_phase @ np.cos(omega * time) - quadrature @ np.sin(omega * time)
        a -= modes.damping * v + modes.stiffness * q
        across = shape.tip_length * np.sin(th)
        excess = shape.clearance - u + shape.tip_length * (1.0 - np.cos(th))
        distance = np.hypot(across, shape.rotor_radius + excess)
        gap = distance - shape.rotor_radius
        if gap < 0.0:
            n_x, n_u = -across / distance, -(shape.rotor_radius + excess) / distance
            n_th = -shape.tip_length * (np.cos(th) * n_x + np.sin(th) * n_u)
            normal = STIFFNESS * (-gap) ** 1.5
            a += normal * (n_u * modes.tip_displacement + n_th * modes.tip_slope)
        return np.concatenate([v, a])

    return side


def compiled_side(motor: Motor) -> RightHandSide:
    """Return the compiled right-hand side."""
    modes, numbers, omega = motor.modes, motor.geometry.numbers, motor.drive.angular_frequency
    force = modes.coupling @ motor.drive.phasors
    in_phase, quadrature = force.real.copy(), force.imag.copy()
    k, c, row_u, row_th = modes.stiffness, modes.damping, modes.tip_displacement, modes.tip_slope
    count = k.size

    @numba.njit(error_model="numpy")
    def side(time: float, y: Array) -> Array:
        out = np.empty(2 * count)
        u, th = 0.0, 0.0
        for j in range(count):
            u += row_u[j] * y[j]
            th += row_th[j] * y[j]
        gap, n_u, n_th, _, _ = contact_frame(u, th, *numbers)
        normal = STIFFNESS * (-gap) ** 1.5 if gap < 0.0 else 0.0
        for j in range(count):
            a = -c[j] * y[count + j] - k[j] * y[j] + normal * (n_u * row_u[j] + n_th * row_th[j])
            for tone in range(omega.size):
                a += in_phase[j, tone] * np.cos(omega[tone] * time)
                a -= quadrature[j, tone] * np.sin(omega[tone] * time)
            out[j] = y[count + j]
            out[count + j] = a
        return out

    side(0.0, np.zeros(2 * count))
    return side


def integrate(
    motor: Motor, side: RightHandSide, duration: float, method: str, rtol: float, step: float = np.inf
) -> tuple[float, float]:
    """End state (u, th) by one of SciPy's solvers; tolerances scaled to displacements and rates."""
    count = motor.modes.stiffness.size
    scale = np.repeat([1e-7, 1e-3], count)
    start = np.zeros(2 * count)
    result = solve_ivp(
        side, (0.0, duration), start, method=method, rtol=rtol, atol=rtol * scale, max_step=step
    )
    q = result.y[:count, -1]
    return float(motor.modes.tip_displacement @ q), float(motor.modes.tip_slope @ q)


def measure(duration: float = DURATION, repeats: int = 5) -> tuple[list[Timing], list[Timing]]:
    """Time SciPy and the engine; returns both lists."""
    motor, law = paper_motor(), HertzPenalty(STIFFNESS, 0.0)
    sides = {"NumPy": numpy_side(motor), "compiled": compiled_side(motor)}
    reference = np.array(integrate(motor, sides["compiled"], duration, "DOP853", 1e-13, step=1e-6))

    def timing(name: str, work: Callable[[], tuple[float, float]], runs: int) -> Timing:
        error = np.abs(np.array(work()) / reference - 1.0).max()
        return Timing(name, min(repeat(work, number=1, repeat=runs)), float(error))

    scipy_timings = [
        timing(
            f"{method} {rtol:g}, {kind} side",
            lambda m=method, s=side, r=rtol: integrate(motor, s, duration, m, r),
            max(1, repeats // 2),
        )
        for kind, side in sides.items()
        for method in ("LSODA", "DOP853")
        for rtol in TOLERANCES
    ]

    def engine(contact_step: float, tolerance: float) -> tuple[float, float]:
        made = run(motor, law, duration, contact_step, tolerance=tolerance)
        return last(made, "tip_normal_displacement"), last(made, "tip_slope")

    engine_timings = [
        timing(
            f"engine, step {step:g} s, tolerance {tolerance:g}",
            lambda s=step, t=tolerance: engine(s, t),
            10 * repeats,
        )
        for step, tolerance in ENGINE_SETTINGS
    ]
    return scipy_timings, engine_timings


def main() -> None:
    """Print the table."""
    scipy_timings, engine_timings = measure(repeats=int(sys.argv[1]) if len(sys.argv) > 1 else 5)
    print(f"{'solver':48s} {'time':>10s} {'error':>9s}")
    for row in (*scipy_timings, *engine_timings):
        print(f"{row.name:48s} {1e3 * row.seconds:7.2f} ms {row.error:9.1e}")
    for kind in ("NumPy", "compiled"):
        print(f"\nengine against SciPy's quickest run that is as accurate, {kind} right-hand side")
        for row in engine_timings:
            able = [t for t in scipy_timings if kind in t.name and t.error <= row.error]
            if not able:
                print(f"{row.name:48s} error {row.error:.1e}: SciPy does not get there")
                continue
            rival = min(able, key=lambda t: t.seconds)
            print(
                f"{row.name:48s} error {row.error:.1e}: {rival.seconds / row.seconds:5.0f} times "
                f"faster than {rival.name} ({rival.error:.1e})"
            )


if __name__ == "__main__":
    main()
