"""What Table 1 says of the inputs that the paper does not give: eight numbers from ten, with uncertainty.

The residuals are the misses over the standard deviation of rounding, half a unit over sqrt(3). With the
Jacobian J at the best fit the covariance is (J' J)^-1; the singular values of J in relative inputs tell
how well every combination is known.
"""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from references import PLACEMENTS
from scipy.optimize import least_squares
from table1_placement import HALF_UNITS, PRINTED, row_of
from variations import changed

import contactlab as cl

INPUTS = {
    "placement 1 start": (15.968e-3, "m"),
    "placement 1 end": (25.065e-3, "m"),
    "placement 2 start": (0.914e-3, "m"),
    "placement 2 end": (10.146e-3, "m"),
    "tip mass": (1.181e-3, "kg"),
    "tip inertia": (1.321e-7, "kg m2"),
    "bending modulus": (94.295e9, "Pa"),
    "bending coupling": (9.196, "C m-2"),
}
"""The project's defaults, which the fit has to find again from a start that is off by some percent."""

KEYS = (
    "resonator.tip_mass",
    "resonator.tip_inertia",
    "piezoceramic.bending_modulus",
    "piezoceramic.bending_coupling",
)
"""Of the last four inputs."""

QUANTITIES = ("G11", "G21", "G31", "f1", "f2")


def _table_of(setup: cl.Setup, inputs: np.ndarray) -> np.ndarray:
    """The numbers of Table 1 that these inputs give [N/V], [Hz], a row a placement."""
    rows = []
    shared = dict(zip(KEYS, (float(x) for x in inputs[4:]), strict=True))
    for start, end in (inputs[:2], inputs[2:4]):
        places = {"placement.start": float(start), "placement.end": float(end)}
        rows.append(row_of(changed(setup, shared | places).motor.modes))
    return np.array(rows)


class IdentifyTable1(Experiment):
    """Which inputs of the resonator follow from the numbers of Table 1?"""

    says = (
        "Table 1 gives couplings and frequencies for two placements of the patches. Where the patches "
        "lie is drawn, not written, and neither mass nor inertia of the tip nor the constants of the "
        "ceramic are given."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Fit all inputs to the table; a fit takes a second, so the short form is the whole one."""
        names, defaults = list(INPUTS), np.array([value for value, _ in INPUTS.values()])

        def misses(relative: np.ndarray) -> np.ndarray:
            """Misses of a set of inputs, in half units of the printed digit."""
            return ((_table_of(setup, relative * defaults) - PRINTED) / HALF_UNITS).ravel()

        # A rectangle of half width 1 has a standard deviation of 1/sqrt(3).
        start = 1.0 + 0.03 * np.array([1.0, -1.0] * 4)
        fit = least_squares(lambda x: np.sqrt(3.0) * misses(x), start, x_scale="jac", xtol=1e-12)
        covariance = np.linalg.inv(fit.jac.T @ fit.jac)
        _, singular, combinations = np.linalg.svd(fit.jac)
        return xarray.Dataset(
            {
                "fitted": ("input", fit.x * defaults, {"long_name": "fitted input"}),
                "default": ("input", defaults, {"long_name": "default of the project"}),
                "uncertainty": ("input", np.sqrt(np.diag(covariance)) * fit.x * defaults),
                "relative_uncertainty": ("input", np.sqrt(np.diag(covariance)) * fit.x, {"units": "1"}),
                "miss": (
                    ("placement", "quantity"),
                    misses(fit.x).reshape(2, 5),
                    {"units": "1", "long_name": "miss over half a unit of the printed digit"},
                ),
                "singular_value": ("combination", singular, {"units": "1"}),
                "combination_vector": (("combination", "input"), combinations, {"units": "1"}),
            },
            coords={
                "input": names,
                "unit": ("input", [unit for _, unit in INPUTS.values()]),
                "placement": list(PLACEMENTS),
                "quantity": list(QUANTITIES),
            },
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row an input."""
        return [
            {
                "input": name,
                "unit": str(data.unit[i].item()),
                "fitted": float(data.fitted[i]),
                "one sigma": float(data.uncertainty[i]),
                "default": float(data.default[i]),
            }
            for i, name in enumerate(data.input.values)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Uncertainty of every input, and what the fit leaves of every number of the table."""
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.8), layout="constrained")
        order = np.argsort(data.relative_uncertainty.values)
        left.barh(data.input.values[order], 100.0 * data.relative_uncertainty.values[order])
        left.set_xlabel("uncertainty, one sigma (%)")
        places = np.arange(len(QUANTITIES))
        for i, placement in enumerate(data.placement.values):
            right.plot(places, data.miss[i], "os"[i], label=str(placement))
        right.axhspan(-1.0, 1.0, alpha=0.15, color="0.5", label="rounding")
        right.set_xticks(places, [r"$\Gamma_{11}$", r"$\Gamma_{21}$", r"$\Gamma_{31}$", "$f_1$", "$f_2$"])
        right.set_ylabel("miss (half units)")
        right.legend()
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether the ten numbers are met and eight inputs follow from them."""
        worst = float(np.abs(data.miss).max())
        loosest = int(np.argmax(data.relative_uncertainty.values))
        vector = data.combination_vector[-1]
        share = vector.values**2
        pair = data.input.values[np.argsort(share)[-2:]]
        sentence = (
            f"The ten couplings and frequencies are met within {worst:.2f} half units. Of the eight inputs "
            f"the least sure is the {data.input.values[loosest]} to "
            f"{100.0 * float(data.relative_uncertainty[loosest]):.1f} %; {pair[1]} and {pair[0]} are "
            "known less together than each alone. Friction, drive frequency, tip radius, rotor damping "
            "and time steps do not enter Table 1 and stay undetermined."
        )
        return sentence, worst <= 1.0 and float(data.relative_uncertainty.max()) < 0.1


if __name__ == "__main__":
    main(__file__)
