"""Settled rotor velocity over the friction coefficient, which the paper does not give, under every law."""

import sys
from dataclasses import replace
from functools import partial

import matplotlib.pyplot as plt
import numpy as np
import xarray
from harness import laws_of, main, quantity, settled
from matplotlib.figure import Figure

import contactlab as cl

SAYS = (
    "Coulomb friction is assumed and its coefficient appears in every equation of the contact, "
    "but not in a table."
)
RIGID_STEP = 1e-7
"""Contact step of the rigid laws [s]."""


def study(setup: cl.Setup, short: bool = False) -> xarray.Dataset:
    """Mean velocity of the settled motor, and the share of the contact that sticks."""
    found = settled(
        setup,
        {"friction_coefficient": quantity([0.1, 0.3] if short else np.linspace(0.02, 0.8, 27), "1")},
        laws={
            name: partial(replace, law)
            for name, law in laws_of(setup).items()
            if not short or name in ("lagrange_stick", "hertz_penalty")
        },
        rigid_step=RIGID_STEP,
        metrics=("stick_share", "friction_share", "normal_loss_share"),
    )
    lost = (found.friction_share + found.normal_loss_share).assign_attrs(units="1")
    return xarray.Dataset(
        {
            "rotor_velocity": found.rotor_velocity.assign_attrs(units="rad s-1"),
            "error": found.error.assign_attrs(units="rad s-1"),
            "settling_time": found.settling_time.assign_attrs(units="s"),
            "periods": found.periods.assign_attrs(units="1"),
            "stick_share": found.stick_share.assign_attrs(units="1"),
            "contact_loss_share": lost,
        }
    )


def table(data: xarray.Dataset) -> list[dict[str, object]]:
    """One row a coefficient."""
    return [
        {"friction coefficient": float(mu)}
        | {f"{law} [rad/s]": float(data.rotor_velocity.sel(law=law)[j]) for law in data.law.values}
        for j, mu in enumerate(data.friction_coefficient.values)
    ]


def draw(data: xarray.Dataset) -> Figure:
    """Speeds on the left, times to settle in the middle, stick on the right."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(7.6, 2.8), layout="constrained")
    for i, law in enumerate(data.law.values):
        left.plot(data.friction_coefficient, data.rotor_velocity[i], "os^"[i] + "-", label=law)
        middle.plot(data.friction_coefficient, 1e3 * data.settling_time[i], "os^"[i] + "-", label=law)
        right.plot(data.friction_coefficient, 100.0 * data.stick_share[i], "os^"[i] + "-", label=law)
    left.set_ylabel("settled rotor velocity (rad/s)")
    middle.set(ylabel="time to settle by e (ms)", ylim=(0.0, None))
    right.set_ylabel("part of the contact that sticks (%)")
    for axes in (left, middle, right):
        axes.set_xlabel("friction coefficient")
    left.legend()
    return figure


def finding(data: xarray.Dataset) -> tuple[str, bool]:
    """What hangs on the coefficient: how fast a settled motor turns, and how long it takes to get there."""
    mu, velocity = data.friction_coefficient.values, np.abs(data.rotor_velocity)
    said = ", ".join(
        f"{law} from {float(velocity.sel(law=law)[0]):.3g} to {float(velocity.sel(law=law)[-1]):.3g}"
        for law in data.law.values
    )
    time = data.settling_time.sel(law="hertz_penalty").values
    exponent = float(np.polyfit(np.log(mu), np.log(time), 1)[0])
    sentence = (
        f"Between coefficients of {mu[0]:.2g} and {mu[-1]:.2g} the settled speed goes, in rad/s, {said}: it "
        "is not friction that makes a settled motor fast. What friction buys is time: with Hertz contact the "
        f"motor settles in {1e3 * time[0]:.3g} ms at the lowest and {1e3 * time[-1]:.3g} ms at the highest "
        f"coefficient, as the coefficient to the power {exponent:.2g}."
    )
    return sentence, bool(velocity.sel(law="hertz_penalty")[0] > velocity.sel(law="hertz_penalty")[-1])


if __name__ == "__main__":
    sys.exit(main(__name__))
