"""Claims on the count of who beats whom over seeds, and on the published ellipses themselves."""

import measured_impacts
import numpy as np
import pytest
import xarray
from support.measurements import ELLIPSES

import contactlab as cl
from contactlab.studies.validate import agreement, opposite_orders


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
    turned = _study({"a": 0.15, "b": 0.10, "c": 0.20}, 0.02, [])

    first, last = agreement([item, other])
    assert "3 pairs of laws 2 are" in first
    assert "explains 1 impacts" in last
    assert opposite_orders([item, other]) == []
    assert opposite_orders([other, turned, turned]) == [("a", "b")]


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
    data = cl.validate(ELLIPSES, ["newton", "poisson"]).data.to_dataset()

    assert data["law"].values[0] == "poisson"
    assert float(data["difference_interval"].sel(law="newton", other="poisson", end="low")) > 0.004
    assert float(data["prediction_error"].sel(law="frictionless")) == pytest.approx(0.286, abs=0.003)
    assert float(data["prediction_error"][-1]) == pytest.approx(0.040, abs=0.001)
