"""Spheres that rebound at a slant: every friction, and rigid laws, against what was measured.

    python experiments/oblique_spheres.py PATH [output=DIR]

No parameter is fitted. Stiffness and Mindlin's ratio are those of the materials, restitution and friction
those measured.
"""

from dataclasses import dataclass
from math import nan
from typing import Annotated, Any

import numpy as np
import sphere_rebounds as spheres
import xarray
from experiment import Experiment, main
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.style import context
from sphere_laws import ALUMINA_ON_GLASS, KINDS, candidates

import contactlab as cl
from contactlab.plot.style import STYLE
from contactlab.studies.study import option

RIGID_STICK = 5.0 / 7.0
"""Tangential restitution of a rigid contact that sticks: D <= 2/7 v_t where friction ends with the slip."""

DIP, WITHIN = 0.60, 0.02
"""What is measured, and what a law may miss it by."""

GRID = np.arange(0.5, 62.25, 0.5)
"""Incidences of the curves [degrees]."""

NAMES = {"restitution": "tangential_restitution", "angle": "rebound_angle_deg", "spin": "spin_rad_per_s"}


def _place_of(curve: xarray.DataArray) -> float:
    """The incidence of the lowest value [degrees]; NaN where it is that of many."""
    lowest = curve.where(curve < curve.min() + 1e-6, drop=True)
    return float(lowest.grid[0]) if lowest.size == 1 else nan


COLOURS = ("#000000", "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "0.5")
LOOKS: dict[str, dict[str, Any]] = {
    "microslip": {"color": COLOURS[0], "linestyle": "-", "label": "microslip"},
    "mindlin": {"color": COLOURS[1], "linestyle": "-", "label": "mindlin"},
    "iwan": {"color": COLOURS[2], "linestyle": "--", "label": "iwan"},
    "bouc_wen": {"color": COLOURS[3], "linestyle": "--", "label": "bouc_wen"},
    "elasto_plastic": {"color": COLOURS[4], "linestyle": "--", "label": "elasto_plastic"},
    "lugre": {"color": COLOURS[5], "linestyle": "--", "label": "lugre, dahl"},
    "rate_and_state": {"color": COLOURS[6], "linestyle": ":", "label": "rate_and_state"},
    "newton": {"color": COLOURS[7], "linestyle": "-", "label": "rigid stick"},
}
"""Of the curves; those that no print could tell apart share one."""

POINTS: dict[str, Any] = {"color": "black", "markersize": 3.0, "elinewidth": 0.7, "zorder": 5, "mfc": "white"}


def _draw_misfits(ax: Axes, data: xarray.Dataset) -> None:
    rows = [row for row in misfit_rows(data) if "no restitution" not in str(row["free"])][::-1]
    place = np.arange(len(rows))
    ax.barh(place, [float(str(row["all"])) for row in rows], color="#56B4E9", height=0.6)
    mean = [float(str(row["mean stiffness"])) for row in rows]
    ax.plot(mean, place, "|", color="black", markersize=7, label="with the stiffness of the mean")
    ax.set_yticks(place, [str(row["law"]) for row in rows])
    ax.set_ylim(-0.6, len(rows) + 0.8)
    ax.legend(loc="upper right")
    ax.set(xlabel="misfit (errors of digitisation)")


def misfit_rows(data: xarray.Dataset) -> list[dict[str, object]]:
    """Misfit of each quantity and of all, in errors of digitisation, and the lowest restitution."""
    rows = []
    for name in data.law.values:
        law = data.sel(law=name)
        each = {
            texts: spheres.rms(law.misfit.values[data.quantity.values == key]) for texts, key in NAMES.items()
        }
        rows.append(
            {
                "law": str(name),
                "kind": str(law.kind.values),
                **each,
                "all": spheres.rms(law.misfit.values),
                "both axes": spheres.rms(law.misfit_of_both_axes.values),
                "mean stiffness": float(law.misfit_averaged),
                "lowest": float(law.restitution.min()),
                "at": _place_of(law.restitution),
                "free": str(law.free.values),
            }
        )
    return sorted(
        rows,
        key=lambda row: (KINDS.index(str(row["kind"])), np.nan_to_num(float(str(row["all"])), nan=np.inf)),
    )


@dataclass(frozen=True, kw_only=True)
class ObliqueSpheres(Experiment):
    """Which friction gives the measured rebound of spheres, with nothing fitted?

    PATH is the rebound that Kharaz, Gorham and Salman (2001), Powder Technology 120, 281, measured, as
    digitised: a CSV file with the columns quantity, incidence_deg, value.
    """

    says = (
        "Kharaz et al. (2001): the tangential restitution of 5 mm alumina spheres on glass falls to 0.60 "
        "near 20 degrees. A rigid contact that sticks leaves 5/7."
    )

    path: Annotated[str, option("CSV file of the measured rebounds")]

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """What every law predicts at the measured incidences and over all, and how far it is off.

        Raises:
            ValueError: the file cannot be read or is no such table.
        """
        rebounds = spheres.read_rebounds(self.path)
        result = [*candidates(rebounds, ALUMINA_ON_GLASS)]
        off = [spheres.misfits(rebounds, each.predicted) for each in result]
        averaged = [each.averaged and spheres.misfits(rebounds, each.averaged)[0] for each in result]
        curves = [each.predicted(GRID) for each in result]
        unit = {"units": "1", "long_name": "misfit in errors of digitisation"}
        floors = {
            f"floor_{name}": spheres.rms(
                spheres.misfits(rebounds, spheres.floor(rebounds, both_axes=both))[both]
            )
            for name, both in (("value", False), ("both_axes", True))
        }
        return xarray.Dataset(
            {
                "measured": ("point", rebounds.value),
                "error": ("point", rebounds.error),
                "misfit": (("law", "point"), [value for value, _ in off], unit),
                "misfit_of_both_axes": (("law", "point"), [both for _, both in off], unit),
                "misfit_averaged": ("law", [nan if m is None else spheres.rms(m) for m in averaged], unit),
                **{name: (("law", "grid"), [c[key] for c in curves]) for name, key in NAMES.items()},
            },
            coords={
                "law": [each.name for each in result],
                "kind": ("law", [each.kind for each in result]),
                "free": ("law", [each.free for each in result]),
                "quantity": ("point", rebounds.quantity),
                "incidence": ("point", rebounds.incidence, {"units": "degree"}),
                "grid": ("grid", GRID, {"units": "degree"}),
            },
            attrs={
                "source": "Kharaz, Gorham and Salman (2001), Powder Technology 120, 281",
                "stiffness_ratio": ALUMINA_ON_GLASS.stiffness_ratio,
                "hertz_stiffness": ALUMINA_ON_GLASS.hertz,
                "scatter_of_incidence": spheres.scatter_of_incidence(rebounds),
                **floors,
            },
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return the misfits in errors of digitisation, and the lowest restitution."""
        return misfit_rows(data)

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """How far the restitution dips under Mindlin, and what is left of the misfit."""
        rows = {str(row["law"]): row for row in misfit_rows(data)}
        mindlin, patch, coulomb = (rows[name] for name in ("mindlin", "microslip", "coulomb"))
        rigid = [row for row in rows.values() if row["kind"] == "rigid"]
        least = float(np.nanmin([float(str(row["lowest"])) for row in rigid]))
        sentence = (
            f"Under mindlin the tangential restitution falls to {mindlin['lowest']:.3f} at {mindlin['at']:g} "
            f"degrees, measured 0.596 at 20, with nothing fitted; no rigid law comes below {least:.3f}. The "
            f"misfit is {mindlin['all']:.2g} errors of digitisation, of coulomb {coulomb['all']:.2g}; with "
            f"microslip it is {patch['all']:.2g}, where the data miss any curve by {data.floor_value:.2g}."
        )
        dips = abs(float(mindlin["lowest"]) - DIP) <= WITHIN
        return sentence, bool(dips and least >= RIGID_STICK - 1e-9 and mindlin["all"] < coulomb["all"])

    def draw(self, data: xarray.Dataset) -> Figure:
        """The three quantities over incidence, and the misfit of each law."""
        with context(STYLE):
            figure = Figure(figsize=(7.2, 6.4), layout="constrained")
            panels = figure.subplots(2, 2).ravel()
            texts = ("tangential restitution", "rebound angle (degrees)", "spin (rad/s)")
            for ax, (name, key), label in zip(panels, NAMES.items(), texts, strict=False):
                for law, look in LOOKS.items():
                    ax.plot(data.grid, data[name].sel(law=law), **look)
                here = data.quantity.values == key
                error = spheres.DIGITISED * spheres.FULL_SCALE[key]
                ax.errorbar(
                    data.incidence[here], data.measured[here], error, spheres.INCIDENCE_ERROR, "o", **POINTS
                )
                ax.set(xlabel="incidence (degrees)", ylabel=label, xlim=(0.0, 62.0))
            panels[0].axhline(RIGID_STICK, color="0.6", linewidth=0.6, zorder=0)
            panels[0].text(61.5, RIGID_STICK, "5/7", va="bottom", ha="right", color="0.4", fontsize=7)
            panels[0].set_ylim(0.55, 1.0)
            panels[1].set_ylim(0.0, None)
            panels[2].set_ylim(0.0, None)
            panels[0].legend(loc="upper center", ncols=2)
            _draw_misfits(panels[3], data)
        return figure


if __name__ == "__main__":
    main(__file__)
