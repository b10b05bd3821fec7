"""The measured impacts among the examples."""

import numpy as np
import pytest

import contactlab as cl
from contactlab.cli.verbs.example import examples


def test_the_measured_example_is_explained_by_the_law_that_it_names_and_by_no_other() -> None:
    impacts = cl.read_impacts(next(each.source for each in examples() if each.name == "drops"))

    def left(restitution: float) -> float:
        """Mean square of what the law leaves, in standard deviations of gap rate and slip."""
        law = cl.Newton(friction_coefficient=0.25, restitution=restitution)
        result = cl.impact(law, impacts.delassus, impacts.velocity_before)
        rest = result.velocity_after.values - impacts.velocity_after
        return float(np.einsum("ij,ijk,ik->i", rest, np.linalg.inv(impacts.covariance), rest).mean() / 2.0)

    assert left(0.6) == pytest.approx(1.0, abs=0.35)
    assert left(0.4) > 10.0
