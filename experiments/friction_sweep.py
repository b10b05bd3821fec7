"""Rotor velocity over the friction coefficient, which the paper does not give, under every law."""

import sys

import numpy as np
import xarray
from harness import changed, laws_of, main
from matplotlib.figure import Figure
from tqdm import tqdm

from contactlab.config import Setup
from contactlab.engine import simulate

SAYS = (
    "Coulomb friction is assumed and its coefficient appears in every equation of the contact, "
    "but not in a table."
)
LAWS = ("lagrange_slip", "lagrange_stick", "hertz_penalty")
RIGID_STEP = 1e-7
"""Contact step of the rigid laws [s]."""


def study(setup: Setup, short: bool = False) -> xarray.Dataset:
    """Velocity at the end of a run from rest, and the share of the contact that sticks."""
    coefficients = np.array([0.1, 0.3]) if short else np.linspace(0.02, 0.8, 27)
    velocity = np.full((len(LAWS), coefficients.size), np.nan)
    sticking = np.zeros_like(velocity)
    efficiency_loss = np.zeros_like(velocity)
    for j, mu in enumerate(tqdm(coefficients, unit=" coefficients", disable=None)):
        rubbing = changed(setup, {"contact.friction_coefficient": float(mu)})
        for i, law in enumerate(laws_of(rubbing).values()):
            run = simulate(
                setup.motor,
                law,
                duration=setup.duration,
                record_interval=setup.duration / 20.0,
                contact_step=RIGID_STEP if i < 2 else None,
            )
            if run.complete:
                velocity[i, j] = run.series["rotor_velocity"][-1]
                touching = run.contacts["duration"].sum()
                sticking[i, j] = run.contacts["stick_duration"].sum() / max(touching, 1e-300)
                lost = run.series["friction_loss"][-1] + run.series["contact_loss"][-1]
                efficiency_loss[i, j] = lost / run.series["drive_work"][-1]
    return xarray.Dataset(
        {
            "rotor_velocity": (("law", "friction_coefficient"), velocity, {"units": "rad s-1"}),
            "stick_share": (("law", "friction_coefficient"), sticking, {"units": "1"}),
            "contact_loss_share": (
                ("law", "friction_coefficient"),
                efficiency_loss,
                {"units": "1"},
            ),
        },
        coords={
            "law": list(LAWS),
            "friction_coefficient": ("friction_coefficient", coefficients, {"units": "1"}),
        },
    )


def table(data: xarray.Dataset) -> list[dict[str, object]]:
    """One row a coefficient."""
    return [
        {"friction coefficient": float(mu)}
        | {f"{law} [rad/s]": float(data.rotor_velocity.sel(law=law)[j]) for law in LAWS}
        for j, mu in enumerate(data.friction_coefficient.values)
    ]


def draw(data: xarray.Dataset) -> Figure:
    """Velocities on the left, stick on the right."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.8), layout="constrained")
    for i, law in enumerate(LAWS):
        left.plot(data.friction_coefficient, data.rotor_velocity[i], "os^"[i] + "-", label=law)
        right.plot(
            data.friction_coefficient, 100.0 * data.stick_share[i], "os^"[i] + "-", label=law
        )
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
        "goes from "
        f"{hertz[0]:.3g} to {hertz[-1]:.3g} rad/s. The law that always slips is more than a "
        "tenth of the highest "
        f"velocity away {parting}."
    )
    return sentence, bool(np.abs(hertz[-1]) > np.abs(hertz[0]))


if __name__ == "__main__":
    sys.exit(main(__name__))
