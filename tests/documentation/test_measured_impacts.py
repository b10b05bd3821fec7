"""Claims on the count of who beats whom over seeds, and on the published ellipses themselves."""

from pathlib import Path

import pytest
from ellipses import convert
from support.measurements import ELLIPSES

import contactlab as cl


@pytest.mark.long
@pytest.mark.skipif(
    not ELLIPSES.exists(),
    reason=f"The published impacts of ellipses are not here; "
    f"docs/measurements.md says where they are had. Then put them into {ELLIPSES}.",
)
def test_poisson_beats_newton_on_the_published_ellipses(tmp_path: Path) -> None:
    convert(ELLIPSES, tmp_path / "ellipses.csv")
    data = cl.validate([cl.Newton(), cl.Poisson()], data=tmp_path / "ellipses.csv").data.to_dataset()

    assert data["law"].values[0] == "poisson"
    assert float(data["difference_interval"].sel(law="newton", other="poisson", end="low")) > 0.004
    assert float(data["prediction_error"].sel(law="frictionless")) == pytest.approx(0.286, abs=0.003)
    assert float(data["prediction_error"][-1]) == pytest.approx(0.040, abs=0.001)
