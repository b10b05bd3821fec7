"""Rotor velocity over the friction coefficient, which the paper does not give, under every law."""

import sys
from dataclasses import replace
from functools import partial

import matplotlib.pyplot as plt
import numpy as np
import xarray
from harness import laws_of, main, quantity, swept
from matplotlib.figure import Figure

import contactlab as cl

SAYS = (
    "Coulomb friction is assumed and its coefficient appears in every equation of the contact, "
    "but not in a table."
)
RIGID_STEP = 1e-7
"""Contact step of the rigid laws [s]."""


def study(setup: cl.Setup, short: bool = False) -> xarray.Dataset:
    """Velocity at the end of a run from rest, and the share of the contact that sticks."""
    found = swept(
        setup,
        {"friction_coefficient": quantity([0.1, 0.3] if short else np.linspace(0.02, 0.8, 27), "1")},
        laws={name: partial(replace, law) for name, law in laws_of(setup).items()},
        rigid_step=RIGID_STEP,
        metrics=("final_rotor_velocity", "stick_share", "friction_share", "normal_loss_share"),
    )
    lost = (found.friction_share + found.normal_loss_share).assign_attrs(units="1")
    return xarray.Dataset(
        {
            "rotor_velocity": found.final_rotor_velocity,
            "stick_share": found.stick_share,
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
    """Velocities on the left, stick on the right."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.8), layout="constrained")
    for i, law in enumerate(data.law.values):
        left.plot(data.friction_coefficient, data.rotor_velocity[i], "os^"[i] + "-", label=law)
        right.plot(data.friction_coefficient, 100.0 * data.stick_share[i], "os^"[i] + "-", label=law)
    left.set_ylabel("rotor velocity (rad/s)")
    right.set_ylabel("part of the contact that sticks (%)")
    for axes in (left, right):
        axes.set_xlabel("friction coefficient")
    left.legend()
    return figure


def finding(data: xarray.Dataset) -> tuple[str, bool]:
    """How much hangs on the coefficient, and from where on the laws part."""
    hertz = data.rotor_velocity.sel(law="hertz_penalty").values
    slip = data.rotor_velocity.sel(law="lagrange_slip").values
    mu = data.friction_coefficient.values
    apart = np.abs(slip - hertz) > 0.1 * np.nanmax(np.abs(hertz))
    parting = f"from {mu[apart][0]:.2g} on" if apart.any() else "nowhere"
    sentence = (
        f"Between coefficients of {mu[0]:.2g} and {mu[-1]:.2g} the velocity with Hertz contact "
        f"goes from {hertz[0]:.3g} to {hertz[-1]:.3g} rad/s. The law that always slips is more "
        f"than a tenth of the highest velocity away {parting}."
    )
    return sentence, bool(np.abs(hertz[-1]) > np.abs(hertz[0]))


if __name__ == "__main__":
    sys.exit(main(__name__))
