"""Peak force and impulse against the contact step: what the rigid laws' impact means, beside Hertz.

A rigid impact takes one step h, so that its force is impulse / h (eq. 59); the impulse converges.
"""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from variations import laws_of

import contactlab as cl

STEPS = tuple(10.0**-k for k in np.arange(6.0, 8.01, 0.25))


def _exponents(steps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Slopes of straight lines through the logarithms."""
    return np.array([np.polyfit(np.log(steps), np.log(row), 1)[0] for row in values])


class ImpactStepStudy(Experiment):
    """How do peak force and impulse depend on the contact step?"""

    says = (
        "Figure 9 shows peaks of the normal force at every impact. The paper calls them a product of "
        "the multiplier, which stops the tip within one time step, without physical meaning; the "
        "velocity of the rotor has one, since it follows from the impulse. Contact stiffness, by "
        "Hertz, is proposed as the remedy."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """All steps for every law; the step of the Hertz contact is its longest."""
        steps = STEPS[::4] if self.short else STEPS
        laws = laws_of(setup)
        runs = [
            cl.sweep(
                {"law": [*laws]},
                lambda law, step=step: cl.Setup.of(setup.motor, laws[law], setup.duration, contact_step=step),
                metrics=("peak_force", "total_impulse"),
            )
            for step in steps
        ]
        result = xarray.concat(runs, "contact_step").transpose("law", ...)
        exponents = _exponents(np.array(steps), result.peak_force.values)
        return xarray.Dataset(
            {
                "peak_normal_force": result.peak_force,
                "normal_impulse": result.total_impulse,
                "peak_exponent": ("law", exponents, {"units": "1"}),
            },
            coords={"contact_step": ("contact_step", list(steps), {"units": "s"})},
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a law and step."""
        return [
            {
                "law": law,
                "contact step [s]": float(step),
                "peak normal force [N]": float(data.peak_normal_force.sel(law=law, contact_step=step)),
                "normal impulse [N s]": float(data.normal_impulse.sel(law=law, contact_step=step)),
            }
            for law in data.law.values
            for step in data.contact_step.values
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Peaks on the left, impulses on the right."""
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.8), layout="constrained")
        step = 1e6 * data.contact_step.values
        for i, law in enumerate(data.law.values):
            # The rigid laws lie upon each other: the first shows as a ring.
            ring = {"markersize": 7, "markerfacecolor": "none"} if i == 0 else {}
            left.loglog(step, data.peak_normal_force[i], "os^"[i] + "-", label=law, **ring)
            change = data.normal_impulse[i] / data.normal_impulse[i, -1] - 1.0
            right.semilogx(step, 100.0 * change, "os^"[i] + "-", label=law, **ring)
        left.set_ylabel("peak normal force (N)")
        right.set_ylabel("change of the normal impulse (%)")
        for axes in (left, right):
            axes.set_xlabel("contact step (µs)")
        left.legend()
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether the peaks of the rigid laws grow as 1/h while all impulses converge."""
        slip, stick, hertz = (float(x) for x in data.peak_exponent)
        peak = float(data.peak_normal_force.sel(law="hertz_penalty").values[-1])
        drift = float(np.abs(data.normal_impulse[:, -1] / data.normal_impulse[:, -2] - 1.0).max())
        sentence = (
            f"The peak force of the rigid laws goes with the step to the power {slip:.3f} (slip) and "
            f"{stick:.3f} (stick), that of Hertz to {hertz:.4f}: it is {peak:.2f} N. The last "
            f"refinement changes the impulses by {100.0 * drift:.2g} % at most."
        )
        grows = abs(slip + 1.0) < 0.02 and abs(stick + 1.0) < 0.02
        return sentence, grows and abs(hertz) < 1e-3 and drift < 1e-3


if __name__ == "__main__":
    main(__file__)
