"""Figure 9: the normal force over time under the paper's law at two steps, and under Hertz."""

import matplotlib.pyplot as plt
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from variations import laws_of

import contactlab as cl

STEPS = (1e-6, 2.5e-7)
"""Contact steps of the paper's law [s]; records are as fine as the finer one."""


class Fig9NormalForce(Experiment):
    """Does the peak of the normal force depend on the contact step?"""

    says = (
        "Figure 9 shows the normal force with a high peak at every impact. The peak is called without "
        "physical meaning, made by a multiplier that stops the tip within one step."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Forces over the same stretch of time."""
        laws = laws_of(setup)
        cases = {f"lagrange_slip, step {1e6 * h:g} µs": (laws["lagrange_slip"], h) for h in STEPS}
        cases["hertz_penalty"] = (laws["hertz_penalty"], None)
        times = {"duration": setup.duration, "record_interval": setup.record_interval}
        runs = [cl.simulate(setup.motor, law, contact_step=step, **times) for law, step in cases.values()]
        force = xarray.concat([run["normal_force"] for run in runs], "case")
        return xarray.Dataset(
            {
                "normal_force": force,
                "peak": ("case", [run.contacts.peak_normal_force.max() for run in runs], {"units": "N"}),
                "impulse": ("case", [run.contacts.normal_impulse.sum() for run in runs], {"units": "N s"}),
            },
            coords={"case": [*cases]},
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a case."""
        return [
            {"case": str(case), "peak [N]": float(data.peak[i]), "impulse [N s]": float(data.impulse[i])}
            for i, case in enumerate(data.case.values)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """All forces over one period, the peaks on a logarithmic axis."""
        figure, axes = plt.subplots(figsize=(5.0, 2.8), layout="constrained")
        late = data.time >= data.time[-1] - 4.2e-4
        for i, case in enumerate(data.case.values):
            force = data.normal_force[i][late]
            line, width = ["-", "--", "-"][i], [0.8, 0.8, 1.4][i]
            axes.semilogy(1e6 * data.time[late], force.where(force > 1e-2), line, lw=width, label=str(case))
        axes.set_xlabel("time (µs)")
        axes.set_ylabel("normal force (N)")
        axes.legend()
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether the peak is the step's and not the motor's."""
        coarse, fine, hertz = (float(x) for x in data.peak)
        change = float(data.impulse[1] / data.impulse[0]) - 1.0
        ratio = fine / coarse
        return (
            f"A step {STEPS[0] / STEPS[1]:g} times as short makes the peak {ratio:.2f} times as high "
            f"({coarse:.0f} to {fine:.0f} N) and changes the impulse by {100 * change:.2f} %. The "
            f"Hertz contact peaks at {hertz:.1f} N.",
            abs(ratio / (STEPS[0] / STEPS[1]) - 1.0) < 0.05 and abs(change) < 0.01,
        )


if __name__ == "__main__":
    main(__file__)
