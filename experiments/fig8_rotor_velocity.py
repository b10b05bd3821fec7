"""Figure 8: rotor velocity, a: from rest at three clearances, b: from -0.9 rad/s, c: settled, under load.

The loads of 8c are put on settled motors, on the paper's basis and, beside it, on the converged beam; the
curves are those of the data sheet, from motors on belts.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from variations import laws_of, quantity, swept, with_clearance

import contactlab as cl

CLEARANCES = (0.0, 1e-6, 2e-6)
LOADS = (0.0, 1e-3, 2e-3, 5e-3)
START = -0.9
TRANSIENT = 5e-3
BASES = {"ritz": "paper's basis", "finite_element": "converged beam"}
SAME = 0.01
"""Relative difference of velocities under load that counts as none."""

LONGEST = 1000
"""Periods after which a loaded motor without an orbit has its mean."""


def loaded(setup: cl.Setup, basis: str, laws: Sequence[str]) -> xarray.Dataset:
    """The speed-torque curve of every law on one basis, and settled motors under the paper's loads."""
    motors = [settled(setup, basis, name) for name in laws]
    sheet = cl.characterise(motors).data.to_dataset()
    velocities = np.full((2, len(motors), len(LOADS)), np.nan)
    for i, motor in enumerate(motors):
        sense, stall, before = float(sheet.sense[i]), float(sheet.stall_torque[i]), None
        for j, load in enumerate(LOADS):
            # A load beyond stall turns the motor back, faster and faster.
            if load < stall:
                before = cl.steady(motor, load=sense * load, start=before, longest=LONGEST)
                velocities[:, i, j] = before.velocity
        velocities[0, i] *= sense
    speeds, errors = ((("law", "load_torque"), each, {"units": "rad s-1"}) for each in velocities)
    names = ["velocity", "torque", "stall_torque"]
    return (
        sheet[names]
        .drop_vars("configuration", errors="ignore")
        .assign(under_load=speeds, under_load_error=errors)
        .assign_coords(load_torque=quantity(LOADS, "N m").rename(dim_0="load_torque"))
    )


def settled(setup: cl.Setup, basis: str, law: str) -> cl.Setup:
    """The motor on a basis, driven at its first natural frequency, under a law with its own steps."""
    options = setup.configuration
    chosen = cl.build([f"resonator={basis}", f"law={law}"]).configuration
    own = {"drive": {**options["drive"], "frequency": None}}
    own["solver"] = {**options["solver"], "contact_step": None, "tolerance": None}
    return cl.build({**options, **own, "resonator": chosen["resonator"], "law": chosen["law"]})


def with_rotor(motor: cl.Motor, **changes: float) -> cl.Motor:
    """The motor with another rotor."""
    return replace(motor, rotor=replace(motor.rotor, **changes))


class Fig8RotorVelocity(Experiment):
    """How does the rotor velocity depend on clearance, initial velocity and load?"""

    says = (
        "Figure 8a shows the rotor from rest at clearances of 0, 1 and 2 um; the smallest is called "
        "the best, since its contact lasts longest. 8b starts at -0.9 rad/s and reaches a steady "
        "state. 8c gives the velocity for loads of 0, 1, 2 and 5 mN m."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Return all panels under the three laws, the last of the short form under one."""
        duration = 0.02 if self.short else setup.duration

        def velocity(
            over: Mapping[str, object],
            motor: Callable[..., cl.Motor],
            duration: float,
            records: int,
            **wanted: Any,
        ) -> xarray.DataArray:
            """Rotor velocity at so many equal intervals."""
            wanted |= {"metrics": (), "series": ("rotor_velocity",)}
            wanted |= {"duration": duration, "record_interval": duration / records}
            return swept(setup, over, motor=motor, **wanted).rotor_velocity_series

        rotor = partial(with_rotor, setup.motor)
        clearance = partial(with_clearance, setup.motor)
        transient = velocity({"clearance": quantity(CLEARANCES, "m")}, clearance, TRANSIENT, 250)
        steady = velocity({"initial_velocity": [START]}, rotor, duration, 200).squeeze(drop=True)
        laws = ["hertz_penalty"] if self.short else [*laws_of(setup)]
        bases = [*BASES][: 1 if self.short else None]
        sheets = [loaded(setup, basis, laws) for basis in bases]
        return xarray.Dataset({"transient": transient.rename(time="instant"), "from_start": steady}).merge(
            xarray.concat(sheets, pandas.Index(bases, name="basis"), join="outer").rename(law="loaded_law")
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a law and basis; a motor that its load turns back has no number."""
        rows = []
        for law in data.law.values:
            i = data.law.values.tolist().index(law)
            row: dict[str, object] = {"law": str(law)}
            row |= {
                f"{1e6 * c:.0f} um, 5 ms": float(data.transient[i, j, -1]) for j, c in enumerate(CLEARANCES)
            }
            rows.append(row | {"from -0.9, end": float(data.from_start[i, -20:].mean())})
            for basis in data.basis.values[: len(data.basis) * (law in data.loaded_law.values)]:
                settled = data.sel(basis=basis, loaded_law=law)
                row = {
                    "law": f"{law}, {BASES[str(basis)]}",
                    "stall [mN m]": 1e3 * float(settled.stall_torque),
                }
                rows.append(
                    row | {f"{1e3 * m:.0f} mN m": float(settled.under_load.sel(load_torque=m)) for m in LOADS}
                )
        return rows

    def draw(self, data: xarray.Dataset) -> Figure:
        """Four panels; the transients for the paper's law, the others for all."""
        figure, ((a, b), lower) = plt.subplots(2, 2, figsize=(7.2, 5.0), layout="constrained")
        lines = ["-", "--", "-."]
        for j, clearance in enumerate(CLEARANCES):
            a.plot(1e3 * data.instant, data.transient[0, j], lines[j], label=f"{1e6 * clearance:.0f} µm")
        a.set_title("(a) lagrange_slip, from rest")
        a.legend(title="clearance")
        for i, law in enumerate(data.law.values):
            b.plot(1e3 * data.time, data.from_start[i], lines[i], label=str(law))
        b.set_title(f"(b) from {START} rad/s")
        b.legend()
        for ax, basis, letter in zip(lower, data.basis.values, "cd", strict=False):
            for i, law in enumerate(data.law.values):
                if law in data.loaded_law.values:
                    motor = data.sel(basis=basis, loaded_law=law)
                    curve = motor[["velocity", "torque"]].dropna("point").sortby("velocity")
                    ax.plot(1e3 * curve.torque, curve.velocity, f"C{i}{lines[i]}")
                    ax.plot(1e3 * data.load_torque, motor.under_load, f"C{i}" + "os^"[i], label=str(law))
            ax.axhline(0.0, color="0.5", linewidth=0.6, zorder=0)
            ax.set_title(f"({letter}) settled, {BASES[str(basis)]}")
            ax.set_xlabel("braking torque (mN m)")
            ax.set_ylabel("velocity, forward (rad/s)")
            fastest = float(data.under_load.max())
            ax.set(xlim=(-0.2, 5.5), ylim=(-0.2 * fastest, 1.15 * fastest))
        lower[data.basis.size - 1].legend(title="loads of 8c, and curve")
        for ax in (a, b):
            ax.set_xlabel("time (ms)")
            ax.set_ylabel("rotor velocity (rad/s)")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Order of the clearances, steady state, and fall with the load, under every law."""
        speeds = np.abs(data.transient[:, :, -1].values)
        names = data.law.values
        ordered = [str(n) for n, row in zip(names, speeds, strict=True) if np.all(np.diff(row) < 0.0)]
        tail = data.from_start.values[:, -40:]
        drift = float((np.ptp(tail, axis=1) / np.abs(tail).mean(axis=1)).max())
        loaded = data.under_load.values
        # NaN where a load is not carried.
        risen = np.any(np.diff(loaded, axis=-1) > -SAME * loaded[..., :1], axis=-1)
        rising = {
            str(law) for law, column in zip(data.loaded_law.values, risen.T, strict=True) if column.any()
        }
        falls = f"under all laws but {', '.join(sorted(rising))}" if rising else "under every law"
        best = [
            f"{1e6 * CLEARANCES[int(np.argmax(row))]:.0f} um under {n}"
            for n, row in zip(names, speeds, strict=True)
        ]
        texts = (
            "as the paper has it, under " + ", ".join(ordered) if ordered else "under no law as in the paper"
        )
        stalls = []
        for basis, torques in zip(data.basis.values, 1e3 * data.stall_torque.values, strict=True):
            carried = int(np.isfinite(data.under_load.sel(basis=basis)).all("loaded_law").sum())
            text = f"{torques.min():.2f} to {torques.max():.2f} mN m on the {BASES[str(basis)]}"
            stalls.append(
                f"{text}, which carries {carried} of the paper's {len(LOADS)} loads under every law"
            )
        return (
            f"After 5 ms the clearances are ordered {texts}; the fastest is {', '.join(best)}. From "
            f"-0.9 rad/s the velocity settles within {100 * drift:.1f} % over the last fifth of the "
            f"run. The settled speed falls with every braking torque {falls}. "
            f"Stall torques: {'; '.join(stalls)}.",
            "lagrange_slip" in ordered and drift < 0.05,
        )


if __name__ == "__main__":
    main(__file__)
