"""Settled rotor velocity over the friction coefficient, which the paper does not give, under every law."""

from collections.abc import Sequence
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import main
from matplotlib.figure import Figure
from variations import SettledMap, laws_of, quantity

import contactlab as cl


class FrictionSweep(SettledMap):
    """How does the settled velocity depend on the friction coefficient?"""

    says = (
        "Coulomb friction is assumed and its coefficient appears in every equation of the contact, "
        "but not in a table."
    )

    metrics = ("stick_share", "friction_share", "normal_loss_share")

    def axes(self, setup: cl.Setup) -> dict[str, xarray.DataArray]:
        """Return the coefficients; the short form has two."""
        return {
            "friction_coefficient": quantity([0.1, 0.3] if self.short else np.linspace(0.02, 0.8, 27), "1")
        }

    def laws(self, setup: cl.Setup) -> dict[str, cl.ContactLaw]:
        """Return the three laws; the short form has two."""
        every = laws_of(setup)
        return {name: every[name] for name in every if not self.short or name != "lagrange_slip"}

    def varied(self, setup: cl.Setup, law: cl.ContactLaw, **values: float) -> tuple[cl.Motor, cl.ContactLaw]:
        """Return the law with another coefficient."""
        return setup.motor, replace(law, **values)

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return velocity and settling time, and the shares of stick and of contact losses."""
        result = SettledMap.join(self, setup, parts)
        lost = (result.friction_share + result.normal_loss_share).assign_attrs(units="1")
        return xarray.Dataset(
            {
                "rotor_velocity": result.rotor_velocity.assign_attrs(units="rad s-1"),
                "error": result.error.assign_attrs(units="rad s-1"),
                "settling_time": result.settling_time.assign_attrs(units="s"),
                "periods": result.periods.assign_attrs(units="1"),
                "stick_share": result.stick_share.assign_attrs(units="1"),
                "contact_loss_share": lost,
            }
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a coefficient."""
        return [
            {"friction coefficient": float(mu)}
            | {f"{law} [rad/s]": float(data.rotor_velocity.sel(law=law)[j]) for law in data.law.values}
            for j, mu in enumerate(data.friction_coefficient.values)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
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

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Return how velocity and settling time depend on the coefficient."""
        mu, velocity = data.friction_coefficient.values, np.abs(data.rotor_velocity)
        text = ", ".join(
            f"{law} from {float(velocity.sel(law=law)[0]):.3g} to {float(velocity.sel(law=law)[-1]):.3g}"
            for law in data.law.values
        )
        time = data.settling_time.sel(law="hertz_penalty").values
        exponent = float(np.polyfit(np.log(mu), np.log(time), 1)[0])
        sentence = (
            f"Between coefficients of {mu[0]:.2g} and {mu[-1]:.2g} the settled speed goes, in rad/s, {text}. "
            f"With a Hertz contact the motor settles in {1e3 * time[0]:.3g} ms at the lowest and "
            f"{1e3 * time[-1]:.3g} ms at the highest coefficient, as this to the power {exponent:.2g}."
        )
        return sentence, bool(velocity.sel(law="hertz_penalty")[0] > velocity.sel(law="hertz_penalty")[-1])


if __name__ == "__main__":
    main(__file__)
