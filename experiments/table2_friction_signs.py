"""Table 2: the sign of v_T - R Omega and the direction of the friction force (eqs. 43-47)."""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure

import contactlab as cl

CASES = (
    (1.0, 0.5, "+", "left"),
    (0.5, 1.0, "-", "right"),
    (-0.5, 1.0, "-", "right"),
    (0.5, -1.0, "+", "left"),
    (-0.5, -1.0, "+", "left"),
    (-1.0, -0.5, "-", "right"),
)
"""v_T and R Omega [m/s], and what is printed for them."""


def computed(data: xarray.Dataset) -> list[tuple[str, str]]:
    """Sign of the slip and direction of the friction, in the table's words."""
    slips = (data.tip_velocity - data.rim_velocity).values
    return [
        ("+" if slip > 0.0 else "-", "right" if friction > 0.0 else "left")
        for slip, friction in zip(slips, data.friction_impulse.values, strict=True)
    ]


class Table2FrictionSigns(Experiment):
    """Does the friction of an impact have the sign that Table 2 prints?"""

    says = (
        "Table 2 lists the sign of the slip and the direction of the friction on the tip for all signs "
        "of the tip's velocity and the rotor's: left where the tip is ahead of the rotor, right where "
        "it is behind."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """The friction impulse of an impact of the configured motor in every case."""
        rows, rotor = np.stack(setup.motor.rows_at_rest), setup.motor.rotor
        delassus = rows @ rows.T
        delassus[1, 1] += setup.motor.geometry.rotor_radius**2 / rotor.inertia
        law = cl.LagrangeSlip(setup.configuration["contact"]["friction_coefficient"])
        before = [(-0.1, tip - rim) for tip, rim, _, _ in CASES]
        # Along t = (1, 0): to the right.
        impulses = cl.impact(law, delassus, before).impulse.sel(direction="tangential").values
        tips, rotors, signs, directions = zip(*CASES, strict=True)
        return xarray.Dataset(
            {
                "tip_velocity": ("case", np.array(tips), {"units": "m s-1"}),
                "rim_velocity": ("case", np.array(rotors), {"units": "m s-1"}),
                "friction_impulse": ("case", impulses, {"units": "N s"}),
                "printed_sign": ("case", list(signs)),
                "printed_direction": ("case", list(directions)),
            }
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a case."""
        return [
            {
                "v_T [m/s]": float(data.tip_velocity[i]),
                "R Omega [m/s]": float(data.rim_velocity[i]),
                "sign": sign,
                "printed sign": str(data.printed_sign[i].item()),
                "friction": direction,
                "printed friction": str(data.printed_direction[i].item()),
            }
            for i, (sign, direction) in enumerate(computed(data))
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Both velocities and the friction as arrows, a row a case."""
        figure, axes = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
        height, nothing = np.arange(data.case.size)[::-1], np.zeros(data.case.size)
        for values, lift, label in (
            (data.tip_velocity, 0.18, "tip, $v_T$"),
            (data.rim_velocity, 0.0, r"rotor, $R\Omega$"),
            (0.6 * np.sign(data.friction_impulse), -0.18, "friction on the tip"),
        ):
            colour = axes.plot([], [], label=label)[0].get_color()
            scale = {"angles": "xy", "scale_units": "xy", "scale": 1.0}
            axes.quiver(nothing, height + lift, values, nothing, color=colour, width=0.008, **scale)
        axes.set_xlim(-1.2, 1.2)
        axes.set_ylim(-0.6, data.case.size - 0.4)
        axes.set_yticks(height, [f"{k + 1}" for k in range(height.size)])
        axes.set_ylabel("case")
        axes.set_xlabel("velocity (m/s), to the right")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.18), ncols=3)
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether sign and direction are as printed in every case."""
        right = sum(
            row["sign"] == row["printed sign"] and row["friction"] == row["printed friction"]
            for row in self.rows(data)
        )
        return f"Sign and direction are as printed in {right} of {len(CASES)} cases.", right == len(CASES)


if __name__ == "__main__":
    main(__file__)
