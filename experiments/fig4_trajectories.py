"""Figure 4: tip trajectories of both placements, driven at f2/2 and f2, and at f1 and 2 f1."""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from references import PLACEMENTS
from variations import placed, tip_phasors

import contactlab as cl

DRIVES = ("f2/2 and f2", "f1 and 2 f1")


def symmetric_phase(modes: cl.NormalModes, voltages: list[float], tone: float) -> float:
    """Phase of the first tone at which x ~ sin 2s where u ~ sin s [rad]."""
    u, th = tip_phasors(modes, cl.Drive.two_mode(*voltages, tone, 2.0, 0.0))
    shift = 0.5 * (np.angle(1j * th[1]) - 2.0 * np.angle(1j * u[0]))
    return float((shift + 0.5 * np.pi) % np.pi - 0.5 * np.pi)


def sizes(data: xarray.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Height and width of every eight [m], shape (placement, drive)."""
    return np.ptp(data.height.values, axis=-1), np.ptp(data.across.values, axis=-1)


class Fig4Trajectories(Experiment):
    """How do placement and drive frequency change the free trajectory of the tip?"""

    says = (
        "Figure 4 shows the tip's figure of eight for both placements. It is wider where the second tone "
        "meets the second natural frequency and higher where the first tone meets the first; with placement "
        "1 it loses much of its height when the first mode is not in resonance. Phases were found by trial."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Steady trajectories in closed form, each with the phase that makes its eight symmetric."""
        voltages = [setup.configuration["drive"][key] for key in ("voltage_1", "voltage_2")]
        arm = setup.motor.geometry.tip_length
        turns = np.linspace(0.0, 1.0, 401)
        across = np.empty((2, 2, turns.size))
        height = np.empty_like(across)
        phases = np.empty((2, 2))
        for i, (start, end) in enumerate(PLACEMENTS.values()):
            modes = placed(setup, start, end)
            first, second = modes.natural_frequency[:2]
            for j, tone in enumerate((0.5 * second, first)):
                phases[i, j] = symmetric_phase(modes, voltages, tone)
                u, th = tip_phasors(modes, cl.Drive.two_mode(*voltages, tone, 2.0, phases[i, j]))
                waves = np.exp(2j * np.pi * np.outer([1.0, 2.0], turns))
                height[i, j] = (u @ waves).real
                across[i, j] = -arm * np.sin((th @ waves).real)
        return xarray.Dataset(
            {
                "across": (("placement", "drive", "turn"), across, {"units": "m"}),
                "height": (("placement", "drive", "turn"), height, {"units": "m"}),
                "phase": (("placement", "drive"), phases, {"units": "rad"}),
            },
            coords={"placement": list(PLACEMENTS), "drive": list(DRIVES), "turn": turns},
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a trajectory."""
        height, width = sizes(data)
        return [
            {
                "placement": str(placement),
                "drive": str(drive),
                "phase [rad]": float(data.phase[i, j]),
                "height [um]": 1e6 * float(height[i, j]),
                "width [um]": 1e6 * float(width[i, j]),
            }
            for i, placement in enumerate(data.placement.values)
            for j, drive in enumerate(data.drive.values)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Four eights on one scale."""
        figure, axes = plt.subplots(2, 2, figsize=(4.6, 4.4), sharex=True, sharey=True, layout="constrained")
        letters = iter("cdab")
        for i, placement in enumerate(data.placement.values):
            for j, drive in enumerate(data.drive.values):
                ax = axes[1 - i, j]
                ax.plot(1e6 * data.across[i, j], 1e6 * data.height[i, j])
                ax.set_title(
                    f"({next(letters)}) {placement}, {drive},\n$\\phi$ = {float(data.phase[i, j]):.2f} rad"
                )
        for ax in axes[1]:
            ax.set_xlabel("along the rotor (µm)")
        for ax in axes[:, 0]:
            ax.set_ylabel("height (µm)")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether widths and heights are ordered as the paper says."""
        height, width = sizes(data)
        # Column 0 meets the second natural frequency, column 1 the first; row 1 is placement 2.
        wider, higher = width[:, 0] / width[:, 1], height[:, 1] / height[:, 0]
        return (
            f"With placement 2 the eight is {wider[1]:.2f} times as wide at the second natural "
            f"frequency and {higher[1]:.2f} times as high at the first. Away from the first resonance "
            f"placement 2 has {100 / higher[1]:.0f} % of its height there and placement 1 "
            f"{100 / higher[0]:.0f} %, and {100 * wider[0]:.0f} % of its width.",
            bool(wider[1] > 1.0 and higher[1] > 1.0 and higher[0] > 2.0 * higher[1]),
        )


if __name__ == "__main__":
    main(__file__)
