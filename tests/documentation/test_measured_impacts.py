"""Claims on the count of who beats whom over seeds, and on the published ellipses themselves."""

import measured_impacts
import numpy as np
import pytest
import xarray
from support.measurements import ELLIPSES

from contactlab.inference.candidates import usual_law
from contactlab.inference.study import study
from contactlab.measured.files import read_impacts


def _study(errors: dict[str, float], reach: float, odd: list[int]) -> xarray.Dataset:
    """Return what the count reads of a study whose intervals all reach as far."""
    mean = np.array([*errors.values()])
    apart = mean[:, None] - mean[None]
    impact = np.arange(1, 6)
    return xarray.Dataset(
        {
            "kind": ("law", ["rigid"] * mean.size),
            "prediction_error": ("law", mean),
            "difference_interval": (
                ("law", "other", "end"),
                np.stack([apart - reach, apart + reach], axis=-1),
            ),
            "unexplained": ("impact", np.isin(impact, odd).astype(int)),
        },
        coords={"law": [*errors], "other": [*errors], "impact": impact},
    )


def test_an_order_holds_where_no_two_seeds_contradict_each_other() -> None:
    item = _study({"a": 0.10, "b": 0.11, "c": 0.20}, 0.02, [1, 2])
    other = _study({"a": 0.10, "b": 0.15, "c": 0.20}, 0.02, [2, 3])

    first, second, _ = measured_impacts.weighed([item, other])
    assert (first.wins, first.losses, first.settled, first.contradicts) == (1, 0, False, False)
    assert second.settled
    stated = measured_impacts.finding([item, other])
    assert "Of 3 pairs of laws 2 are parted" in stated[0]
    assert stated[-1] == "No law explains 1 impacts under any seed, and 3 under one at least."
    turned = _study({"a": 0.15, "b": 0.10, "c": 0.20}, 0.02, [])
    assert "b and a beat each other" in " ".join(measured_impacts.finding([other, turned, turned]))


def test_the_page_has_a_place_for_the_tables() -> None:
    text = measured_impacts.PAGE.read_text(encoding="utf-8")

    assert text.count(measured_impacts.BEGIN) == text.count(measured_impacts.END) == 1


@pytest.mark.long
@pytest.mark.skipif(
    not ELLIPSES.exists(),
    reason=f"The published impacts of ellipses are not here; "
    f"docs/measurements.md says where they are had. Then put them into {ELLIPSES}.",
)
def test_poisson_beats_newton_on_the_published_ellipses() -> None:
    impacts = read_impacts(ELLIPSES)
    data = study(impacts, [usual_law("newton"), usual_law("poisson")], workers=1)

    assert data["law"].values[0] == "poisson"
    assert float(data["difference_interval"].sel(law="newton", other="poisson", end="low")) > 0.004
    assert float(data["prediction_error"].sel(law="frictionless")) == pytest.approx(0.286, abs=0.003)
    assert float(data["prediction_error"][-1]) == pytest.approx(0.040, abs=0.001)
