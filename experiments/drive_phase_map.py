"""Settled rotor velocity over phase and frequency of the drive, compliant and rigid: where the laws agree.

Every cell is the steady state that a motor comes to from rest. The two laws share motor and friction; where
they differ, what the impact does decides what the motor does.
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import xarray
from harness import laws_of, main, quantity, settled
from matplotlib.figure import Figure

import contactlab as cl

SAYS = (
    "The phase between the tones was found by trial: -pi/5 gives the highest acceleration, "
    "though not the highest "
    "final velocity. No map is given, and the frequency of the contact runs is not stated."
)
LAWS = ("hertz_penalty", "lagrange_stick")
STICK_STEP = 2e-7
"""Contact step of the rigid law [s]: its first-order error is 0.5 % in the reference case."""


def study(setup: cl.Setup, short: bool = False) -> xarray.Dataset:
    """The map for both laws; the short form is three by two cells."""
    drive = setup.configuration["drive"]
    frequency = drive["frequency"] * np.linspace(0.95, 1.02, 2 if short else 15)
    found = settled(
        setup,
        {
            "frequency": quantity(frequency, "Hz"),
            "phase": quantity(np.linspace(-np.pi, np.pi, 3 if short else 21), "rad"),
        },
        motor=lambda **tone: replace(setup.motor, drive=cl.Drive.two_mode(**{**drive, **tone})),
        laws={name: laws_of(setup)[name] for name in LAWS},
        rigid_step=STICK_STEP,
        metrics=("contact_count",),
    )
    for name, units in (("rotor_velocity", "rad s-1"), ("error", "rad s-1"), ("periods", "1")):
        found[name].attrs["units"] = units
    return found


def table(data: xarray.Dataset) -> list[dict[str, object]]:
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


def draw(data: xarray.Dataset) -> Figure:
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


def _difference(data: xarray.Dataset) -> xarray.DataArray:
    return data.rotor_velocity.sel(law=LAWS[1]) - data.rotor_velocity.sel(law=LAWS[0])


def turn(data: xarray.DataArray) -> tuple[float, float]:
    """Amplitude a [rad/s] and best phase p [rad] of v = a cos(2 (phase - p)), all frequencies together.

    Turning the first tone by pi moves the tip through the same figure, so that the map has this period.
    """
    waves = np.exp(-2j * data.phase.values[:-1])
    mean = complex((data.values[:, :-1] @ waves).mean() / waves.size)
    return 2.0 * abs(mean), 0.5 * float(np.angle(mean))


def finding(data: xarray.Dataset) -> tuple[str, bool]:
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
        f"Where the motor turns ({int(moves.sum())} cells), rigid stick and Hertz agree within 10 "
        f"% in {100.0 * (apart < 0.1).mean():.0f} %, differ more than twofold in "
        f"{100.0 * twofold.mean():.0f} %, and turn in opposite directions in "
        f"{100.0 * opposite:.0f} %. The maps are alike, of {size_hertz:.2f} (Hertz) and "
        f"{size_stick:.2f} rad/s (rigid), but turned by {shift / np.pi:.2f} pi: a rigid impact "
        "gives its impulse at the touch-down, a compliant contact later, when the tip moves "
        "sideways otherwise. They agree where the map is flat."
    )
    return sentence, bool((apart < 0.1).any() and twofold.any())


if __name__ == "__main__":
    sys.exit(main(__name__))
