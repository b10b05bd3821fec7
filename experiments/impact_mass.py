"""The mass that a rigid impact meets: its impulse and the settled motor over the number of kept modes.

The tip alone approaches a wall at 0.1 m/s, without friction and with a restitution of 0.5: over 0.15 m/s its
impulse is the mass that it meets. Every motor is driven at the converged first natural frequency and its
double.
"""

from itertools import product

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import main
from matplotlib.figure import Figure
from variations import SettledMap, changed, quantity

import contactlab as cl

KEPT = (4.0, 6.0, 8.0, 12.0, 24.0, 40.0)
DAMPING = (0.0, 0.05)
"""Damping ratio of all modes; 0 stands for the paper's damping per mass and stiffness."""

STEPS = (5e-8, 1e-8, 1e-11)
"""Contact steps of the single impact [s]; the first is the default of `newton`."""

FREQUENCY = 2137.53
SPEED, RESTITUTION = 0.1, 0.5
BOUND = 0.01


def mass_met(modes: cl.NormalModes, step: float) -> float:
    """Return the impulse of an impact of the tip alone over (1 + e) v [kg]."""
    shape = modes.tip_displacement
    motor = cl.Motor(
        modes,
        geometry=cl.ContactGeometry(clearance=1e-13),
        rotor=cl.Rotor(inertia=1e9),
        start=cl.ModalState(np.zeros_like(shape), shape * SPEED / (shape @ shape)),
    )
    law = cl.Newton(friction_coefficient=0.0, restitution=RESTITUTION)
    run = cl.simulate(motor, law, duration=20.0 * step, contact_step=step, record_interval=step)
    return float(run.contacts.normal_impulse[0]) / ((1.0 + RESTITUTION) * SPEED)


class ImpactMass(SettledMap):
    """Does a rigid impact depend on the number of modes, and what does that change in the motor?"""

    says = (
        "Two residual modes with the flexibility and the inverse mass that the kept modes leave out make the "
        "impulse of a rigid impact the same, within 1 %, from 4 modes on."
    )
    metrics = ()

    def axes(self, setup: cl.Setup) -> dict[str, xarray.DataArray]:
        """Return damping, whether there are residual modes with mass, and numbers of kept modes."""
        del setup
        damping, kept = (DAMPING[:1], KEPT[:3:2]) if self.short else (DAMPING, KEPT)
        return {
            "damping_ratio": quantity(damping, "1"),
            "residual_mass": quantity([0.0, 1.0], "1"),
            "kept_modes": quantity(kept, "1"),
        }

    def laws(self, setup: cl.Setup) -> dict[str, cl.ContactLaw]:
        """Return two rigid laws and a compliant one."""
        mu = setup.configuration["contact"]["friction_coefficient"]
        return {
            "lagrange_stick": cl.LagrangeStick(mu),
            "newton": cl.Newton(mu),
            "hertz_penalty": cl.HertzPenalty(friction_coefficient=mu),
        }

    def varied(self, setup: cl.Setup, law: cl.ContactLaw, **values: float) -> tuple[cl.Motor, cl.ContactLaw]:
        """Return the motor with damping and modes."""
        changes = {
            "resonator.damping_ratio": values["damping_ratio"] or None,
            "resonator.residual_mass": bool(values["residual_mass"]),
            "resonator.kept_modes": int(values["kept_modes"]),
        }
        return changed(setup, changes).motor, law

    def join(self, setup: cl.Setup, parts: list[xarray.Dataset]) -> xarray.Dataset:
        """Return settled motors, and the mass that a single impact meets."""
        data, law = super().join(setup, parts), cl.Newton()
        axes = [data[name].values for name in ("damping_ratio", "residual_mass", "kept_modes")]
        mass = np.empty((*(values.size for values in axes), len(STEPS)))
        for i, j, k in np.ndindex(mass.shape[:-1]):
            values = dict(zip(self.axes(setup), (axes[0][i], axes[1][j], axes[2][k]), strict=True))
            modes = self.varied(setup, law, **values)[0].modes
            mass[i, j, k] = [mass_met(modes, step) for step in STEPS]
        data["mass"] = (*self.axes(setup), "step"), mass, {"units": "kg"}
        return data.assign_coords(step=("step", [*STEPS], {"units": "s"})).assign_attrs(
            tip_mass=setup.configuration["resonator"]["tip_mass"]
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a damping, kind of residual modes and number of kept modes."""
        axes = ("damping_ratio", "residual_mass", "kept_modes")
        rows: list[dict[str, object]] = []
        for values in product(*(data[name].values.tolist() for name in axes)):
            part = data.sel(dict(zip(axes, values, strict=True)))
            damping, residual, kept = values
            row = {"damping ratio [1]": damping or "paper", "residual mass": bool(residual)}
            row |= {"kept modes [1]": int(kept)}
            row |= {f"mass in {1e9 * float(m.step):g} ns [g]": 1e3 * float(m) for m in part.mass}
            row |= {f"{law} [rad/s]": float(part.rotor_velocity.sel(law=law)) for law in data.law.values}
            rows.append(row)
        return rows

    def draw(self, data: xarray.Dataset) -> Figure:
        """Return masses over the number of modes, and the changes of velocity against the most modes."""
        count = data.damping_ratio.size
        figure, axes = plt.subplots(
            count, 2, figsize=(7.0, 2.6 * count), layout="constrained", sharex=True, squeeze=False
        )
        for (left, right), damping in zip(axes, data.damping_ratio.values, strict=True):
            part = data.sel(damping_ratio=damping)
            finest = part.isel(step=-1) if damping == 0.0 else part.isel(step=1)
            for flag, style, label in ((0.0, "o--", "static correction"), (1.0, "s-", "residual mass")):
                shown = finest.mass.sel(residual_mass=flag)
                left.plot(data.kept_modes, 1e3 * shown, style, color="k", mfc="w", label=label)
                for k, law in enumerate(data.law.values):
                    velocity = part.rotor_velocity.sel(law=law)
                    limit = float(velocity.isel(residual_mass=1, kept_modes=-1))
                    change = 100.0 * (velocity.sel(residual_mass=flag) / limit - 1.0)
                    name = law if flag else None
                    right.plot(data.kept_modes, change, style, color=f"C{k}", mfc="w", label=name)
            left.axhline(1e3 * data.attrs["tip_mass"], color="0.6", lw=0.8)
            kind = f"damping ratio {damping:g}" if damping else "the paper's damping"
            left.set_title(f"{kind}, step {1e9 * float(finest.step):g} ns")
            left.set_ylabel("mass of an impact (g)")
            right.set_ylabel("change of velocity (%)")
            right.set_title(kind)
        for ax in axes[-1]:
            ax.set_xlabel("kept modes")
            ax.set_xscale("log")
            ax.set_xticks(data.kept_modes.values, [f"{n:g}" for n in data.kept_modes.values])
            ax.minorticks_off()
        axes[0, 0].legend()
        axes[0, 1].legend()
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Return changes of mass and velocity over the modes, without and with residual mass."""
        tip, sentences, holds = data.attrs["tip_mass"], [], True
        for damping in data.damping_ratio.values:
            part = data.sel(damping_ratio=damping)
            fine = part.mass.isel(step=2 if damping == 0.0 else 1)
            off = float(np.abs(fine.sel(residual_mass=1.0) / tip - 1.0).max())
            least, most = (1e3 * float(f(fine.sel(residual_mass=0.0))) for f in (np.min, np.max))
            coarse = float(np.abs(part.mass.sel(residual_mass=1.0).isel(step=0) / tip - 1.0).max())
            holds = holds and off < BOUND and most > 1.2 * least
            velocities = part.rotor_velocity
            change = np.abs(velocities / velocities.isel(residual_mass=1, kept_modes=-1) - 1.0).max(
                "kept_modes"
            )
            moved = ", ".join(
                f"{law} {100.0 * float(change.sel(law=law, residual_mass=0.0)):.2g} and "
                f"{100.0 * float(change.sel(law=law, residual_mass=1.0)):.2g} %"
                for law in data.law.values
            )
            kind = f"a damping ratio of {damping:g}" if damping else "the paper's damping"
            sentences.append(
                f"With {kind} an impact of {1e9 * float(fine.step):g} ns meets {least:.2f} to {most:.2f} g "
                f"without residual mass, and with it the tip's {1e3 * tip:.3f} g within {100.0 * off:.2g} % "
                f"({100.0 * coarse:.2g} % in 50 ns). Over the number of modes the settled velocity changes, "
                f"without and with it, by {moved} at most."
            )
        return " ".join(sentences), holds


if __name__ == "__main__":
    main(__file__)
