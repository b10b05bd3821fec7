"""Figure 7: the tip's trajectory, free and in contact, for three clearances."""

from functools import partial

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from variations import laws_of, swept, with_clearance

import contactlab as cl

CLEARANCES = (0.0, 1e-6, 2e-6)
FREE = 1e-3
"""Clearance at which nothing touches [m]."""


def cut(data: xarray.Dataset) -> np.ndarray:
    """Height that contact takes off the free eight [m], shape (law, clearance)."""
    top = data.tip_normal_displacement.max("record").values
    return np.asarray(top[:, :1] - top[:, 1:])


class Fig7ConstrainedTrajectories(Experiment):
    """How does contact change the trajectory of the tip?"""

    says = (
        "Figure 7 shows the free figure of eight and the trajectories that contact leaves of it, for "
        "clearances of 0, 1 and 2 um: the rotor cuts off the top of the eight."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """The last periods of a run from rest, under the paper's law and under Hertz."""
        kept = int(2.0 / setup.configuration["drive"]["frequency"] / setup.record_interval)
        columns = ("tip_tangential_displacement", "tip_normal_displacement", "gap")
        result = swept(
            setup,
            {"clearance": [FREE, *CLEARANCES]},
            motor=partial(with_clearance, setup.motor),
            laws={name: laws_of(setup)[name] for name in ("lagrange_slip", "hertz_penalty")},
            metrics=(),
            series=columns,
            duration=2e-3 if self.short else setup.duration,
            record_interval=setup.record_interval,
        )
        late = result.isel(time=slice(-kept, None)).drop_vars("time")
        late = late.rename({"time": "record", **{f"{name}_series": name for name in columns}})
        return late.assign_coords(clearance=("clearance", [np.inf, *CLEARANCES], {"units": "m"}))

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a law and clearance."""
        return [
            {
                "law": str(law),
                "clearance [um]": 1e6 * clearance,
                "cut off the top [um]": 1e6 * float(cut(data)[i, j]),
                "deepest penetration [um]": 1e6 * max(-float(data.gap[i, j + 1].min()), 0.0),
            }
            for i, law in enumerate(data.law.values)
            for j, clearance in enumerate(CLEARANCES)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Free and constrained trajectories, a panel a clearance, with the rotor above."""
        figure, axes = plt.subplots(1, 4, figsize=(7.2, 2.5), sharex=True, sharey=True, layout="constrained")
        titles = ["(a) free", *(f"({x}) {1e6 * c:.0f} µm" for x, c in zip("bcd", CLEARANCES, strict=True))]
        for j, (ax, title) in enumerate(zip(axes, titles, strict=True)):
            for i, law in enumerate(data.law.values):
                path = data.isel(law=i, clearance=j)
                x, y = 1e6 * path.tip_tangential_displacement, 1e6 * path.tip_normal_displacement
                ax.plot(x, y, ["-", "--"][i], label=str(law))
            if j:
                ax.axhline(1e6 * CLEARANCES[j - 1], color="0.5", lw=0.8)
            ax.set_title(title)
            ax.set_xlabel("along the rotor (µm)")
        axes[0].set_ylabel("height (µm)")
        axes[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.12), ncols=2)
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether the rotor cuts off the more the closer it is, and the rigid law keeps out of it."""
        heights = cut(data)
        deep = [max(-float(data.gap[i, 1:].min()), 0.0) for i in range(2)]
        ordered = bool(np.all(np.diff(heights, axis=1) < 0.0))
        return (
            f"The rotor takes {', '.join(f'{1e6 * h:.2f}' for h in heights[0])} um off the top of the "
            f"eight for the three clearances. The rigid law enters it by {1e9 * deep[0]:.2g} nm at "
            f"most, the Hertz contact by {1e6 * deep[1]:.2f} um.",
            ordered and deep[0] < 1e-8,
        )


if __name__ == "__main__":
    main(__file__)
