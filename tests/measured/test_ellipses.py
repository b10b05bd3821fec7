"""The published impacts of an ellipse, which lie beside the project or not at all."""

from pathlib import Path

import numpy as np
import pandas
import pytest
import scipy.io
from support.measurements import ELLIPSES

from contactlab.measured.ellipses import AXES, MASS, read_ellipses
from contactlab.measured.files import read_impacts
from contactlab.measured.impacts import MeasuredImpacts

pytestmark = pytest.mark.skipif(
    not ELLIPSES.is_file(),
    reason=f"The published impacts of ellipses are not here; "
    f"docs/measurements.md says where they are had. Then put them into {ELLIPSES}.",
)


@pytest.fixture(scope="module")
def ellipses() -> MeasuredImpacts:
    return read_ellipses(ELLIPSES)


def test_no_impulse_explains_the_ellipses_better_than_to_four_percent(ellipses: MeasuredImpacts) -> None:
    """The norm of the published comparisons, on the impacts that no flag marks."""
    assert (len(ellipses), ellipses.left_out) == (1718, 282)
    assert ellipses.errors(ellipses.velocity_after).mean() == pytest.approx(0.040, abs=5e-4)


def test_without_friction_the_ellipses_are_missed_by_more_than_a_quarter(ellipses: MeasuredImpacts) -> None:
    before, delassus = ellipses.velocity_before, ellipses.delassus
    errors = []
    for restitution in np.linspace(0.4, 0.7, 31):
        impulse = -(1.0 + restitution) * before[:, 0] / delassus[:, 0, 0]
        errors.append(ellipses.errors(before + delassus[:, :, 0] * impulse[:, None]).mean())
    assert min(errors) == pytest.approx(0.287, abs=0.005)


def test_every_ellipse_approaches_and_leaves_and_is_pushed(ellipses: MeasuredImpacts) -> None:
    jump = ellipses.velocity_after - ellipses.velocity_before
    impulse = np.linalg.solve(ellipses.delassus, jump[..., None])[:, 0, 0]
    assert (ellipses.velocity_before[:, 0] < 0.0).all()
    assert (ellipses.velocity_after[:, 0] > 0.0).all()
    assert (impulse > 0.0).all()


def test_the_sign_of_the_tangential_arm_is_found_and_told(ellipses: MeasuredImpacts) -> None:
    assert "reversed" in ellipses.notes[0]
    assert "0.05 %" in ellipses.notes[0]
    assert "3.07 %" in ellipses.notes[0]


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["as printed", "reversed"])
def test_through_the_format_the_sign_as_printed_is_refused_and_the_other_gives_the_same_impacts(
    tmp_path: Path, ellipses: MeasuredImpacts, sign: float
) -> None:
    table = scipy.io.loadmat(ELLIPSES)["bounce_array"].ravel()
    states, normal, tangential = (np.vstack(table[name]) for name in ("states", "n", "d"))
    inertia = MASS * sum(axis**2 for axis in AXES) / 4.0
    words = f"# mass_x: {MASS} kg\n# mass_y: {MASS} kg\n# mass_angle: {inertia!r} kg m^2\n"
    columns = {"flag": [int(flags.any()) for flags in table["flags"]]}
    for at, (name, velocity, arm) in enumerate(
        [("x", "m/s", ""), ("y", "m/s", ""), ("angle", "rad/s", " [m]")]
    ):
        columns[f"before_{name} [{velocity}]"] = states[:, 3 + at]
        columns[f"after_{name} [{velocity}]"] = states[:, 9 + at]
        columns[f"normal_{name}{arm}"] = normal[:, at]
        columns[f"tangential_{name}{arm}"] = tangential[:, at] * (sign if at == 2 else 1.0)
    path = tmp_path / "ellipses.csv"
    path.write_text(words + pandas.DataFrame(columns).to_csv(index=False))
    if sign > 0.0:
        told = r"3\.1 % of the jump's energy .* and 0\.05 % with the sign of tangential_angle reversed"
        with pytest.raises(ValueError, match=told):
            read_impacts(path)
    else:
        found = read_impacts(path)
        assert found.left_out == ellipses.left_out
        for name in ("delassus", "velocity_before", "velocity_after", "kinetic_energy", "outside", "number"):
            assert getattr(found, name) == pytest.approx(getattr(ellipses, name), rel=1e-9, abs=1e-12), name
