"""Table 1: couplings and natural frequencies of two placements of the patches (eqs. 19-33)."""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from references import PLACEMENTS, TABLE_1
from variations import placed

import contactlab as cl

QUANTITIES = ("Gamma_11", "Gamma_21", "Gamma_31", "f_1", "f_2")
UNITS = ("N V-1", "N V-1", "N V-1", "Hz", "Hz")
HALF_UNITS = np.array([0.5e-3, 0.5e-3, 0.5e-3, 5.0, 5.0])
"""Half a unit of the last printed digit."""

PRINTED = np.array([np.concatenate(TABLE_1[placement]) for placement in PLACEMENTS])


def row_of(modes: cl.NormalModes) -> np.ndarray:
    """The numbers of one placement: three couplings [N/V], two natural frequencies [Hz]."""
    return np.concatenate([modes.shape_coupling[:3, 0], modes.natural_frequency[:2]])


def misses(data: xarray.Dataset) -> xarray.DataArray:
    """Differences over half a unit of the last printed digit."""
    return (data.computed - data.printed) / data.half_unit


class Table1Placement(Experiment):
    """Do computed couplings and natural frequencies agree with Table 1?"""

    says = (
        "Table 1 prints the coupling of the first patch set to three shapes and two natural frequencies, for "
        "two placements. Placement 2 is chosen; the third coupling is said to be small in both."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Both placements with the resonator's other inputs as they are configured."""
        rows = [row_of(placed(setup, start, end)) for start, end in PLACEMENTS.values()]
        return xarray.Dataset(
            {
                "computed": (("placement", "quantity"), np.array(rows)),
                "printed": (("placement", "quantity"), PRINTED),
                "half_unit": ("quantity", HALF_UNITS),
            },
            coords={
                "placement": list(PLACEMENTS),
                "quantity": list(QUANTITIES),
                "unit": ("quantity", list(UNITS)),
            },
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Computed beside printed."""
        return [
            {
                "placement": str(placement),
                "quantity": f"{quantity} [{UNITS[j]}]",
                "computed": float(data.computed[i, j]),
                "printed": float(data.printed[i, j]),
                "difference / half unit": float(misses(data)[i, j]),
            }
            for i, placement in enumerate(data.placement.values)
            for j, quantity in enumerate(QUANTITIES)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """The differences against the rounding of the table."""
        figure, axes = plt.subplots(figsize=(3.4, 2.4), layout="constrained")
        places = np.arange(len(QUANTITIES))
        axes.axhspan(-1.0, 1.0, color="0.9", label="rounding of the table")
        for i, placement in enumerate(data.placement.values):
            axes.plot(places + 0.1 * (2 * i - 1), misses(data)[i], "os"[i], label=str(placement))
        labels = [r"$\Gamma_{11}$", r"$\Gamma_{21}$", r"$\Gamma_{31}$", "$f_1$", "$f_2$"]
        axes.set_xticks(places, labels)
        axes.set_ylabel("difference (half units)")
        axes.legend()
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether all ten numbers are those that are printed."""
        worst = float(np.abs(misses(data)).max())
        inside = int((np.abs(misses(data)) <= 1.0).sum())
        return (
            f"{inside} of ten numbers agree with the table within its rounding; the largest difference "
            f"is {worst:.2f} half units.",
            inside == 10,
        )


if __name__ == "__main__":
    main(__file__)
