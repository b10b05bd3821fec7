"""Periodic orbits of the motor over its clearance: where they fold, and where the last contact grazes.

A motor whose clearance grows does not lose its contact gently. Under a rigid law the branch of orbits that
touch folds at a clearance beyond the one that the tip just bridges without contact; between the two, a
motion with contact and one without are both stable.
"""

from dataclasses import replace

import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from matplotlib.style import context
from variations import laws_of

import contactlab as cl
from contactlab.plot.style import STYLE
from contactlab.steady_state.branches import family
from contactlab.steady_state.continuation import Mark, follow
from contactlab.studies.orbit_figures import MARKERS, draw_curve

LAWS = ("hertz_penalty", "lagrange_stick", "newton")
START, LATE, END = 1e-6, 3.85e-6, 3.93e-6
"""Of the clearance [m]; from the second on it goes in smaller steps, and the short form begins there."""

STEP = 0.03
"""Of the branches."""

KEPT = ("value", "rotor_velocity", "stable", "mark", "softest_approach")
"""Of a branch."""

AGREE = 1e-3
"""Relative difference of the clearance at which a branch ends from the one that the tip bridges."""


def bridged(motor: cl.Motor) -> float:
    """The largest clearance that the tip bridges without contact [m], by the closed form of its motion."""
    drive, modes, geometry = motor.drive, motor.modes, motor.geometry
    rate = drive.angular_frequency
    stiffness, damping = modes.stiffness[:, None], modes.damping[:, None]
    response = modes.coupling @ drive.phasors / (stiffness - rate**2 + 1j * damping * rate)
    # The second tone has a whole number of periods in one of the first.
    turns = np.exp(1j * np.outer(rate, np.linspace(0.0, 1.0 / drive.frequency[0], 200_001)))
    u, slope = (part @ (response @ turns).real for part in (modes.tip_displacement, modes.tip_slope))
    radius, length = geometry.rotor_radius, geometry.tip_length
    fall = 2.0 * length * np.sin(0.5 * slope) ** 2
    aside = radius - np.sqrt(radius**2 - (length * np.sin(slope)) ** 2)
    return float(np.max(u - fall - aside))


class OrbitsOverClearance(Experiment):
    """Where do the periodic orbits fold and end over the clearance?"""

    says = "The clearance is given, what happens to the motor where it grows is not looked at."

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """The branch of every law; the short form is the end of one."""
        laws = laws_of(setup)
        names = ("newton",) if self.short else LAWS
        parts = []
        for name in names:
            law = laws.get(name) or cl.Newton(laws["lagrange_stick"].friction_coefficient)
            own = cl.build([f"law={name}", f"contact.friction_coefficient={law.friction_coefficient}"])
            branch = cl.branch(
                own, "contact.clearance", LATE - 1e-8 if self.short else START, LATE, step=STEP
            ).details
            # In smaller steps, from where it has come to.
            orbit = branch.points[-1].orbit
            late = follow(family(own, "contact.clearance"), orbit, LATE, END, step=STEP)
            result = replace(branch, points=branch.points + late.points[1:], end=late.end)
            folds = [p.value for p in result.events if p.mark is Mark.FOLD]
            data = result.to_xarray()[list(KEPT)]
            data = data.assign_coords(point=np.arange(data.sizes["point"]))
            data["fold"] = folds[0] if folds else np.nan
            data["last"] = result.points[-1].value
            data["end"] = result.end
            parts.append(data.expand_dims(law=[name]))
        every = xarray.concat(
            parts,
            "law",
            join="outer",
            combine_attrs="drop_conflicts",
            fill_value={"stable": np.int8(0), "mark": np.int8(0)},
        )
        every["bridged"] = bridged(setup.motor)
        return every

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Fold and end of every law."""
        return [
            {
                "law": name,
                "fold [m]": float(data.fold.sel(law=name)),
                "last contact [m]": float(data["last"].sel(law=name)),
                "bridged without contact [m]": float(data.bridged),
                "end": str(data.end.sel(law=name).values),
            }
            for name in data.law.values
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Velocity over clearance, whole and near the end."""
        with context(STYLE):
            figure = Figure(figsize=(7.2, 3.2), layout="constrained")
            whole, near = figure.subplots(1, 2)
            edge = float(data.bridged)
            colours = ("#0072B2", "#D55E00", "#009E73")
            for ax in (whole, near):
                for name, colour in zip(data.law.values, colours, strict=False):
                    item = data.sel(law=name)
                    draw_curve(
                        ax, item.dropna("point", subset=["value"]), "rotor_velocity", str(name), colour
                    )
                ax.axvline(1e6 * edge, color="0.5", linewidth=0.6, zorder=0)
                ax.set_xlabel("clearance (µm)")
            whole.set_ylabel("mean rotor velocity (rad/s)")
            near.set_xlim(1e6 * edge - 0.004, 1e6 * edge + 0.008)
            near.set_ylim(1.5, 2.6)
            near.text(1e6 * edge, 1.52, " bridged without contact", fontsize=7, va="bottom")
            whole.legend(loc="upper left")
            for event in ("fold", "grazing"):
                near.plot([], [], MARKERS[event], color="black", markerfacecolor="white", label=event)
            near.legend(loc="upper right")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Where the branches fold and end, against the clearance that the tip bridges."""
        edge = float(data.bridged)
        apart = np.abs(data["last"] / edge - 1.0)
        folds = {str(name): float(f) for name, f in zip(data.law.values, data.fold.values, strict=True)}
        folded = {name: value for name, value in folds.items() if np.isfinite(value)}
        texts = ", ".join(f"{1e6 * value:.4f} µm ({name})" for name, value in folded.items())
        sentence = (
            f"Without contact the tip bridges {1e6 * edge:.4f} µm, and there the last contact grazes under "
            f"every law, within {float(apart.max()):.1e} of it. Under a rigid law the orbits fold beyond, at "
            f"{texts}: between grazing and fold a motion with contact and one without are both stable."
        )
        rigid = [folds[str(name)] > edge for name in data.law.values if name != "hertz_penalty"]
        return sentence, bool((apart <= AGREE).all() and all(rigid))


if __name__ == "__main__":
    main(__file__)
