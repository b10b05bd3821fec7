"""Figure 3: the curvature of the shapes, and the patches that it drives (eq. 31)."""

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.figure import Figure
from references import PLACEMENTS
from variations import changed, placed

import contactlab as cl
from contactlab.motor.ritz import ClampedBeam

SHAPES = 5


class Fig3ModeCurvature(Experiment):
    """How large is the coupling of the patches to the third shape?"""

    says = (
        "Figure 3 shows the second derivatives of the first five shapes and two places for the "
        "patches. The coupling to a shape is its curvature integrated over a patch: the first two "
        "couplings are to be large against the others, and the third is small though not zero."
    )

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Curvatures along the beam and the couplings of both placements."""
        length = setup.configuration["resonator"]["length"]
        place = np.linspace(0.0, length, 401)
        curvature = ClampedBeam(length, SHAPES).evaluate(place, 2)
        five = changed(setup, {"resonator.shapes": SHAPES})
        coupling = [placed(five, start, end).shape_coupling[:, 0] for start, end in PLACEMENTS.values()]
        return xarray.Dataset(
            {
                "curvature": (("shape", "place"), curvature, {"units": "m-2"}),
                "coupling": (("placement", "shape"), np.array(coupling), {"units": "N V-1"}),
                "patch": (("placement", "edge"), np.array(list(PLACEMENTS.values())), {"units": "m"}),
            },
            coords={
                "shape": np.arange(1, SHAPES + 1),
                "place": ("place", place, {"units": "m"}),
                "placement": list(PLACEMENTS),
            },
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Couplings, a row a placement."""
        return [
            {"placement": str(placement)}
            | {f"Gamma_{j}1 [N/V]": float(data.coupling[i, j - 1]) for j in data.shape.values}
            for i, placement in enumerate(data.placement.values)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Curvatures over the beam, patches and their mirrors as bars below."""
        figure, axes = plt.subplots(figsize=(5.0, 2.8), layout="constrained")
        most = float(np.abs(data.curvature).max())
        styles = ["-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1))]
        for style, shape in zip(styles, data.shape.values, strict=True):
            axes.plot(1e3 * data.place, data.curvature.sel(shape=shape) / most, ls=style, label=f"{shape}")
        length = float(data.place[-1])
        for i, placement in enumerate(data.placement.values):
            start, end = (float(x) for x in data.patch[i])
            for left, right in ((start, end), (length - end, length - start)):
                axes.plot([1e3 * left, 1e3 * right], [-1.15 - 0.12 * i] * 2, lw=3, color="0.25")
            axes.annotate(str(placement), (1e3 * length + 1.0, -1.18 - 0.12 * i), fontsize=6)
        axes.set_xlabel("place along the beam (mm)")
        axes.set_ylabel("curvature over the largest")
        axes.legend(title="shape", loc="center left", bbox_to_anchor=(1.0, 0.5))
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Whether the third coupling is small against those that drive the motor."""
        coupling = np.abs(data.coupling.values)
        shares = coupling[:, 2] / coupling[:, :2].max(axis=1)
        higher = coupling[:, 3:].max(axis=1) / coupling[:, :2].max(axis=1)
        return (
            f"The third coupling is {100 * shares[0]:.0f} % and {100 * shares[1]:.0f} % of the largest "
            "of the first two. The fourth and fifth, which Table 1 leaves out, reach "
            f"{100 * higher[0]:.0f} % and {100 * higher[1]:.0f} %.",
            bool(np.all(shares < 0.25)),
        )


if __name__ == "__main__":
    main(__file__)
