"""What the sections of results record of pairs of laws and of measured impacts."""

import measurement_results
import motor_findings
import numpy as np
import pytest
import xarray

from contactlab.studies.compare.paired import GREATER, LESS, factor_shares


@pytest.mark.parametrize(
    ("decides", "roles"),
    [
        pytest.param(lambda u: u[:, 0] < 0.5, {"damping ratio": "alone"}, id="one factor"),
        pytest.param(lambda u: (u[:, 0] < 0.5) ^ (u[:, 1] < 0.5),
                     {"damping ratio": "together", "voltage": "together"}, id="two together"),
        pytest.param(lambda u: u[:, 3] < 0.5, {}, id="none of them"),
    ],
)  # fmt: skip
def test_a_pair_has_the_roles_of_its_factors(decides: object, roles: dict[str, str]) -> None:
    draws = np.random.default_rng(0).random((64, 4))
    outcome = np.where(decides(draws), GREATER, LESS)
    shares = factor_shares(outcome, draws[:, :3])
    ends = ("nominal", "other", "difference_low", "difference", "difference_high")
    here = xarray.Dataset(
        {
            "outcome": ("draw", outcome),
            "drawn": (("draw", "factor"), draws[:, :3]),
            "factor_share": ("factor", shares.first),
            "factor_role": ("factor", shares.role),
            "chance_share": shares.chance,
            "order": 4,
            **{f"relative_{name}": 0.0 for name in ends},
        },
        coords={"factor": ["damping ratio", "voltage", "clearance"]},
    )
    assert motor_findings.pair(here, "damping")["roles"] == roles


def test_the_gain_of_a_law_has_the_interval_of_paired_impacts() -> None:
    """Errors that differ by the same in all impacts differ by that, however wide they scatter."""
    errors = np.random.default_rng(0).exponential(1.0, 200)
    apart = measurement_results.less_by(errors, errors + 0.1)
    assert [apart[name] for name in ("gain", "low", "high")] == pytest.approx([0.1] * 3, abs=1e-9)
    noise = 0.01 * np.random.default_rng(1).normal(size=200)
    other = measurement_results.less_by(errors, errors + 0.1 + noise)
    assert other["high"] - other["low"] == pytest.approx(2.0 * 1.96 * 0.01 / np.sqrt(200.0), rel=0.2)
