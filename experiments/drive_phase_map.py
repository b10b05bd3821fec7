"""Settled rotor velocity over phase and frequency of the drive, compliant and rigid: where the laws agree.

Every cell is the steady state that a motor comes to from rest. The two laws share motor and friction; where
they differ, what the impact does decides what the motor does.
"""

from collections.abc import Sequence
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import main
from matplotlib.figure import Figure
from variations import SettledMap, laws_of, quantity

import contactlab as cl

LAWS = ("hertz_penalty", "lagrange_stick")


def _difference(data: xarray.Dataset) -> xarray.DataArray:
    return data.rotor_velocity.sel(law=LAWS[1]) - data.rotor_velocity.sel(law=LAWS[0])


def turn(data: xarray.DataArray) -> tuple[float, float]:
    """Amplitude a [rad/s] and best phase p [rad] of v = a cos(2 (phase - p)), all frequencies together.

    Turning the first tone by pi moves the tip through the same figure, so that the map has this period.
    """
    waves = np.exp(-2j * data.phase.values[:-1])
    mean = complex((data.values[:, :-1] @ waves).mean() / waves.size)
    return 2.0 * abs(mean), 0.5 * float(np.angle(mean))


class DrivePhaseMap(SettledMap):
    """Where do a rigid and a compliant law agree over phase and frequency of the drive?"""

    says = (
        "The phase between the tones was found by trial: -pi/5 gives the highest acceleration, though not "
        "the highest final velocity. No map is given, and the frequency of the contact runs is not stated."
    )

    metrics = ("contact_count",)

    def axes(self, setup: cl.Setup) -> dict[str, xarray.DataArray]:
        """Return frequencies and phases; the short form has two by three."""
        frequency = setup.configuration["drive"]["frequency"] * np.linspace(
            0.95, 1.02, 2 if self.short else 15
        )
        phase = np.linspace(-np.pi, np.pi, 3 if self.short else 21)
        return {"frequency": quantity(frequency, "Hz"), "phase": quantity(phase, "rad")}

    def laws(self, setup: cl.Setup) -> dict[str, cl.ContactLaw]:
        """Return a compliant law and a rigid one."""
        return {name: laws_of(setup)[name] for name in LAWS}

    def varied(self, setup: cl.Setup, law: cl.ContactLaw, **values: float) -> tuple[cl.Motor, cl.ContactLaw]:
        """Return the motor with another drive."""
        numbers = {key: value for key, value in setup.configuration["drive"].items() if key != "signal"}
        drive = cl.Drive.two_mode(**{**numbers, **values})
        return replace(setup.motor, drive=drive), law

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return the maps."""
        data = SettledMap.join(self, setup, parts)
        for name, units in (("rotor_velocity", "rad s-1"), ("error", "rad s-1"), ("periods", "1")):
            data[name].attrs["units"] = units
        return data

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """The fastest cell of each direction, and how far the laws are apart."""
        rows: list[dict[str, object]] = []
        for law in LAWS:
            for word, cell in (
                ("fastest forward", data.rotor_velocity.sel(law=law).argmax(...)),
                ("fastest backward", data.rotor_velocity.sel(law=law).argmin(...)),
            ):
                place = data.rotor_velocity.sel(law=law).isel(cell)
                rows.append(
                    {
                        "law": law,
                        "cell": word,
                        "frequency [Hz]": float(place.frequency),
                        "phase [rad]": float(place.phase),
                        "rotor velocity [rad/s]": float(place),
                    }
                )
        return rows

    def draw(self, data: xarray.Dataset) -> Figure:
        """Both maps on one scale, and their difference."""
        figure, axes = plt.subplots(1, 3, figsize=(7.2, 2.6), layout="constrained", sharey=True)
        most = float(np.nanmax(np.abs(data.rotor_velocity)))
        maps = [*(data.rotor_velocity.sel(law=law) for law in LAWS), _difference(data)]
        for ax, values, title in zip(axes, maps, [*LAWS, "difference"], strict=True):
            mesh = ax.pcolormesh(
                data.phase / np.pi, 1e-3 * data.frequency, values, cmap="RdBu_r", vmin=-most, vmax=most
            )
            ax.set_title(title)
            ax.set_xlabel("phase (π rad)")
        axes[0].set_ylabel("first tone (kHz)")
        figure.colorbar(mesh, ax=axes, label="rotor velocity (rad/s)")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """In how many cells the laws agree, and how far their maps are turned against each other."""
        hertz, stick = (data.rotor_velocity.sel(law=law).values for law in LAWS)
        moves = (np.abs(hertz) > 0.1) | (np.abs(stick) > 0.1)
        apart = np.abs(stick - hertz)[moves] / np.maximum(np.abs(hertz), np.abs(stick))[moves]
        ratio = np.maximum(np.abs(stick), 1e-12)[moves] / np.maximum(np.abs(hertz), 1e-12)[moves]
        twofold = np.abs(np.log(ratio)) > np.log(2.0)
        opposite = (stick[moves] * hertz[moves] < 0.0).mean()
        (size_hertz, best_hertz), (size_stick, best_stick) = (
            turn(data.rotor_velocity.sel(law=law)) for law in LAWS
        )
        shift = (best_hertz - best_stick + 0.5 * np.pi) % np.pi - 0.5 * np.pi
        sentence = (
            f"Where the motor turns ({int(moves.sum())} cells), rigid stick and Hertz agree within 10 % in "
            f"{100.0 * (apart < 0.1).mean():.0f} %, differ more than twofold in {100.0 * twofold.mean():.0f} "
            f"%, and turn in opposite directions in {100.0 * opposite:.0f} %. The first harmonics of "
            f"the maps over the phase have amplitudes of {size_hertz:.2f} (Hertz) and {size_stick:.2f} rad/s "
            f"(rigid) and lie {shift / np.pi:.2f} pi apart."
        )
        return sentence, bool((apart < 0.1).any() and twofold.any())


if __name__ == "__main__":
    main(__file__)
