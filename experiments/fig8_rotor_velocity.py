"""Figure 8: rotor velocity, a: from rest at three clearances, b: from -0.9 rad/s, c: under load."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray
from harness import laws_of, main, quantity, swept, with_clearance
from matplotlib.figure import Figure

import contactlab as cl

SAYS = (
    "Figure 8a shows the rotor from rest at clearances of 0, 1 and 2 um; the smallest is called "
    "the best, since its contact lasts longest. 8b starts at -0.9 rad/s and reaches a steady "
    "state. 8c gives the velocity for loads of 0, 1, 2 and 5 mN m."
)
CLEARANCES = (0.0, 1e-6, 2e-6)
LOADS = (0.0, 1e-3, 2e-3, 5e-3)
START = -0.9
TRANSIENT = 5e-3
RIGID_STEP = 1e-7
"""Contact step of the rigid laws [s]."""


def study(setup: cl.Setup, short: bool = False) -> xarray.Dataset:
    """All three panels under all three laws; the loads brake, whichever way the motor turns."""
    duration = 0.02 if short else setup.duration

    def velocity(
        over: Mapping[str, object],
        motor: Callable[..., cl.Motor],
        duration: float,
        records: int,
        **asked: Any,
    ) -> xarray.DataArray:
        """Rotor velocity at so many equal intervals."""
        asked |= {"metrics": (), "series": ("rotor_velocity",), "rigid_step": RIGID_STEP}
        asked |= {"duration": duration, "record_interval": duration / records}
        return swept(setup, over, motor=motor, **asked).rotor_velocity_series

    rotor = partial(with_rotor, setup.motor)
    clearance = partial(with_clearance, setup.motor)
    transient = velocity({"clearance": quantity(CLEARANCES, "m")}, clearance, TRANSIENT, 250)
    steady = velocity({"initial_velocity": [START]}, rotor, duration, 200).squeeze(drop=True)
    loaded = []
    for name, law in laws_of(setup).items():
        sign = np.sign(float(steady.sel(law=name)[-1]))
        load = velocity(
            {"load_torque": quantity(LOADS, "N m")},
            lambda load_torque, sign=sign: rotor(load_torque=sign * load_torque),
            duration,
            20,
            laws={name: law},
        )
        loaded.append(load.isel(time=slice(-4, None)).mean("time", keep_attrs=True))
    return xarray.Dataset(
        {
            "transient": transient.rename(time="instant"),
            "from_start": steady,
            "under_load": xarray.concat(loaded, "law"),
        }
    )


def with_rotor(motor: cl.Motor, **changes: float) -> cl.Motor:
    """The motor with another rotor."""
    return replace(motor, rotor=replace(motor.rotor, **changes))


def forward(data: xarray.Dataset) -> np.ndarray:
    """Velocities under load, positive the way each law turns without [rad/s], shape (law, load)."""
    velocities = data.under_load.values
    return np.asarray(velocities * np.sign(velocities[:, :1]))


def table(data: xarray.Dataset) -> list[dict[str, object]]:
    """One row a law."""
    return [
        {"law": str(law)}
        | {f"{1e6 * c:.0f} um, 5 ms": float(data.transient[i, j, -1]) for j, c in enumerate(CLEARANCES)}
        | {"steady": float(data.from_start[i, -20:].mean())}
        | {f"{1e3 * load:.0f} mN m": float(data.under_load[i, j]) for j, load in enumerate(LOADS)}
        for i, law in enumerate(data.law.values)
    ]


def draw(data: xarray.Dataset) -> Figure:
    """Three panels; the transients for the paper's law, the others for all."""
    figure, (a, b, c) = plt.subplots(1, 3, figsize=(7.2, 2.5), layout="constrained")
    for j, clearance in enumerate(CLEARANCES):
        a.plot(
            1e3 * data.instant, data.transient[0, j], ["-", "--", "-."][j], label=f"{1e6 * clearance:.0f} µm"
        )
    a.set_title("(a) lagrange_slip, from rest")
    a.legend(title="clearance")
    for i, law in enumerate(data.law.values):
        style = ["-", "--", "-."][i]
        b.plot(1e3 * data.time, data.from_start[i], style, label=str(law))
        c.plot(1e3 * data.load_torque, forward(data)[i], "os^"[i] + style, label=str(law))
    b.set_title(f"(b) from {START} rad/s")
    b.legend()
    c.set_title("(c) under load")
    c.set_xlabel("braking torque (mN m)")
    c.set_ylabel("velocity, forward (rad/s)")
    for ax in (a, b):
        ax.set_xlabel("time (ms)")
        ax.set_ylabel("rotor velocity (rad/s)")
    return figure


def finding(data: xarray.Dataset) -> tuple[str, bool]:
    """Order of the clearances, steady state, and fall with the load, under every law."""
    speeds = np.abs(data.transient[:, :, -1].values)
    names = data.law.values
    ordered = [str(n) for n, row in zip(names, speeds, strict=True) if np.all(np.diff(row) < 0.0)]
    tail = data.from_start.values[:, -40:]
    drift = float((np.ptp(tail, axis=1) / np.abs(tail).mean(axis=1)).max())
    falls = bool(np.all(np.diff(forward(data), axis=1) < 0.0))
    best = [
        f"{1e6 * CLEARANCES[int(np.argmax(row))]:.0f} um under {n}"
        for n, row in zip(names, speeds, strict=True)
    ]
    words = "as the paper has it, under " + ", ".join(ordered) if ordered else "under no law as in the paper"
    return (
        f"After 5 ms the clearances are ordered {words}; the fastest is {', '.join(best)}. From "
        f"-0.9 rad/s the velocity settles within {100 * drift:.1f} % over the last fifth of the "
        f"run. The speed falls with every braking torque: {'yes' if falls else 'no'}.",
        "lagrange_slip" in ordered and drift < 0.05 and falls,
    )


if __name__ == "__main__":
    sys.exit(main(__name__))
