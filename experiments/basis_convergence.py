"""How many shapes a contact needs: the paper's basis against a converged one with static correction.

Every resonator moves the same motor with a Hertz contact. The effective mass is what a force of infinite
frequency moves at the tip, 1 / sum u_j^2; the compliance is what a constant force bends, sum u_j^2 / k_j.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from variations import laws_of

import contactlab as cl

SHAPES = (2, 3, 4, 6, 8, 12, 16, 24, 40)
CONVERGED = 24
"""Kept modes of the reference, with static correction."""

QUANTITIES = {
    "first_frequency": "Hz",
    "second_frequency": "Hz",
    "compliance": "m N-1",
    "effective_mass": "kg",
    "peak_normal_force": "N",
    "rotor_velocity": "rad s-1",
}


class BasisConvergence(Experiment):
    """How do frequencies and contact depend on the number of shapes?"""

    says = (
        "All simulations take the first four eigenmodes of the beam without patches and tip. Whether "
        "four are enough is not asked."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Return every basis at the converged first natural frequency and its double."""
        shapes = SHAPES[1:4] if self.short else SHAPES
        kept = 6 if self.short else CONVERGED
        options = {k: v for k, v in setup.configuration["resonator"].items() if k not in ("basis", "shapes")}
        converged = cl.build(["resonator=finite_element"]).configuration["resonator"]
        elements = {k: v for k, v in converged.items() if k not in options} | {"kept_modes": kept}
        bases = {f"ritz {n}": {"basis": "ritz", "shapes": n} for n in shapes}
        bases[f"finite_element {kept}"] = elements
        modes = {
            name: cl.build({**setup.configuration, "resonator": options | basis}).motor.modes
            for name, basis in bases.items()
        }
        *_, reference = modes.values()
        tones = reference.natural_frequency[0] * np.array([1.0, 2.0])
        motor = replace(setup.motor, drive=replace(setup.motor.drive, frequency=tones))
        law = laws_of(setup)["hertz_penalty"]
        result = cl.sweep(
            {"basis": [*bases]},
            lambda basis: cl.Setup.of(replace(motor, modes=modes[basis]), law, setup.duration),
            metrics=("peak_force", "final_rotor_velocity"),
        )
        numbers = [
            [
                *item.natural_frequency[:2],
                np.sum(item.tip_displacement**2 / item.stiffness),
                1.0 / np.sum(item.tip_displacement**2),
            ]
            for item in modes.values()
        ]
        columns = (*np.transpose(numbers), result.peak_force, result.final_rotor_velocity)
        return xarray.Dataset(
            {
                name: ("basis", np.array(column), {"units": units})
                for (name, units), column in zip(QUANTITIES.items(), columns, strict=True)
            },
            coords={"basis": [*bases], "shapes": ("basis", [*shapes, kept])},
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a basis."""
        return [
            {"basis": str(basis)}
            | {f"{name} [{units}]": float(data[name][i]) for name, units in QUANTITIES.items()}
            for i, basis in enumerate(data.basis.values)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Every quantity over the number of shapes, relative to the converged one."""
        figure, axes = plt.subplots(1, 2, figsize=(7.0, 2.8), layout="constrained", sharex=True)
        ritz = data.isel(basis=slice(None, -1))
        names = list(QUANTITIES)
        for ax, group in zip(axes, (names[:4], names[4:]), strict=True):
            ax.axhline(1.0, color="0.6", lw=0.8)
            for k, name in enumerate(group):
                relative = ritz[name] / float(data[name][-1])
                ax.semilogx(ritz.shapes, relative, "os^D"[k] + "-", label=name.replace("_", " "))
            ax.set_xlabel("Ritz shapes")
            ax.set_xticks([2, 4, 8, 16, 40], ["2", "4", "8", "16", "40"])
            ax.minorticks_off()
            ax.legend()
        axes[0].set_ylabel("over the converged value")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """What truncation does to frequencies and contact, and whether the basis falls towards the limit."""
        four = data.isel(basis=list(data.shapes.values[:-1]).index(4))
        end, most = data.isel(basis=-1), data.isel(basis=-2)
        falls = bool(np.all(np.diff(data.first_frequency.values) < 1e-6))
        return (
            f"Converged, the patched beam has f1 = {float(end.first_frequency):.1f} Hz and f2 = "
            f"{float(end.second_frequency):.1f} Hz; four shapes give {float(four.first_frequency):.0f} and "
            f"{float(four.second_frequency):.0f}, {int(most.shapes)} still {float(most.first_frequency):.0f} "
            f"and {float(most.second_frequency):.0f}. At the converged frequency the motor with four shapes "
            f"peaks at {float(four.peak_normal_force):.2f} in place of {float(end.peak_normal_force):.2f} N "
            f"and turns at {float(four.rotor_velocity):.3f} in place of {float(end.rotor_velocity):.3f} "
            "rad/s.",
            falls,
        )


if __name__ == "__main__":
    main(__file__)
