"""Figure 10: rotor and tip velocity where the contact would stick, with and without that state."""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from variations import laws_of

import contactlab as cl

COARSE, FINE = 2e-7, 1e-7
"""Contact steps [s]."""


def longest(flags: np.ndarray) -> slice:
    """The longest stretch of true records."""
    edges = np.diff(np.concatenate([[0], flags.astype(int), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    if not starts.size:
        return slice(0, 0)
    most = int(np.argmax(ends - starts))
    return slice(int(starts[most]), int(ends[most]))


def stretch(data: xarray.Dataset, case: int) -> slice:
    """Records of the longest stick, or of the longest chatter: a change of sign every other step."""
    if str(data.case.values[case]) == "lagrange_stick":
        return longest(data.contact_mode[case].values == 2)
    slip = (data.tip_velocity - data.rim_velocity)[case].values
    touching = data.contact_mode[case].values == 1
    changes = np.concatenate([[0], np.abs(np.diff(np.sign(slip))) > 0])
    # A record is of the chatter where the sign changes within two coarse steps of it.
    width = 2 * round(2.0 * COARSE / float(data.time[1] - data.time[0])) + 1
    near = np.convolve(changes, np.ones(width), mode="same") > 1.5
    return longest(near & touching)


def chatter(data: xarray.Dataset, case: int) -> tuple[float, float, int]:
    """Length [s], root mean square of the slip [m/s] and changes of its sign in the stretch."""
    part = stretch(data, case)
    slip = (data.tip_velocity - data.rim_velocity)[case].values[part][1:-1]
    if not slip.size:
        return 0.0, np.nan, 0
    length = float(data.time.values[part][-1] - data.time.values[part][0])
    changes = int(np.count_nonzero(np.diff(np.sign(slip))))
    return length, float(np.sqrt(np.mean(slip**2))), changes


class Fig10Sticking(Experiment):
    """Is the oscillation of the slip velocity under the slip-only law a stick?"""

    says = (
        "Figure 10 shows the velocities of rotor and tip during a contact. For a while both oscillate about "
        "each other, from which the paper concludes that tip and rotor stick and the model needs that state."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Return a run under the slip law at two steps and under the law with stick."""
        laws = laws_of(setup)
        cases = {
            "lagrange_slip, coarse": (laws["lagrange_slip"], COARSE),
            "lagrange_slip, fine": (laws["lagrange_slip"], FINE),
            "lagrange_stick": (laws["lagrange_stick"], FINE),
        }
        times = {"duration": setup.duration, "record_interval": setup.record_interval}
        runs = [cl.simulate(setup.motor, law, contact_step=step, **times) for law, step in cases.values()]
        names = ["rotor_velocity", "slip_velocity", "contact_mode"]
        result = xarray.concat([run.tree.to_dataset()[names] for run in runs], "case")
        rim = setup.motor.geometry.rotor_radius * result.rotor_velocity
        speed = {"units": "m s-1"}
        return xarray.Dataset(
            {
                "rim_velocity": rim.drop_attrs(deep=False).assign_attrs(speed),
                "tip_velocity": (rim + result.slip_velocity).drop_attrs(deep=False).assign_attrs(speed),
                "contact_mode": result.contact_mode,
            },
            coords={"case": [*cases]},
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a case."""
        rows: list[dict[str, object]] = []
        for i, case in enumerate(data.case.values):
            length, slip, changes = chatter(data, i)
            rows.append(
                {
                    "case": str(case),
                    "longest stick or chatter [us]": 1e6 * length,
                    "slip in it, rms [m/s]": slip,
                    "changes of sign": changes,
                }
            )
        return rows

    def draw(self, data: xarray.Dataset) -> Figure:
        """The slip law's contact and a zoom into its chatter, and the same of the law with stick."""
        figure, axes = plt.subplots(2, 2, figsize=(7.0, 4.4), layout="constrained")
        for row, i in zip(axes, (1, 2), strict=True):
            part = stretch(data, i)
            begin, end = (float(x) for x in data.time.values[part][[0, -1]])
            for ax, left, right in zip(
                row,
                (begin - 2e-5, 0.5 * (begin + end) - 1e-6),
                (end + 2e-5, 0.5 * (begin + end) + 1e-6),
                strict=True,
            ):
                shown = data.isel(case=i).sel(time=slice(left, right))
                ax.plot(1e6 * (shown.time - begin), shown.tip_velocity, "-", label="tip")
                ax.plot(1e6 * (shown.time - begin), shown.rim_velocity, "--", label="rotor's rim")
                ax.set_xlabel("time since it began (µs)")
            row[0].set_title(str(data.case.values[i]).partition(",")[0])
            row[1].set_title("zoom")
            row[0].set_ylabel("velocity (m/s)")
        axes[0, 0].legend()
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether the oscillation is the slip law's way to stick: at the step, and smaller with it."""
        _, coarse, _ = chatter(data, 0)
        length, fine, changes = chatter(data, 1)
        sticks, stuck, _ = chatter(data, 2)
        return (
            f"The slip-only law changes the sign of the slip {changes} times in {1e6 * length:.0f} us, "
            f"by {1e3 * coarse:.2g} and {1e3 * fine:.2g} mm/s at steps of {1e6 * COARSE:g} and "
            f"{1e6 * FINE:g} us: a chatter at the step. Under the law with stick "
            f"the slip is {stuck:.0e} m/s for {1e6 * sticks:.0f} us.",
            changes > 20 and stuck < 1e-6 and fine < 0.8 * coarse,
        )


if __name__ == "__main__":
    main(__file__)
