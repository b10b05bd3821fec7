"""The published impacts of an ellipse, which lie beside the project or not at all."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from ellipses import convert
from scipy.optimize import minimize
from support.measurements import ELLIPSES

from contactlab_data.inference.held_out import folds_of_measurements
from contactlab_data.inference.impact_problem import LawPredictor
from contactlab_data.inference.law_numbers import usual_laws
from contactlab_data.measured.files import read_impacts
from contactlab_data.measured.floors import with_constant_impulse
from contactlab_data.measured.impacts import MeasuredImpacts, squared_norm

pytestmark = pytest.mark.skipif(
    not ELLIPSES.is_file(),
    reason=f"The published impacts of ellipses are not here; "
    f"docs/measurements.md says where they are had. Then put them into {ELLIPSES}.",
)


@pytest.fixture(scope="module")
def ellipses(tmp_path_factory: pytest.TempPathFactory) -> MeasuredImpacts:
    path = tmp_path_factory.mktemp("ellipses") / "ellipses.csv"
    convert(ELLIPSES, path)
    return read_impacts(path)


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


def test_the_sign_as_printed_is_refused(tmp_path: Path) -> None:
    convert(ELLIPSES, tmp_path / "ellipses.csv", sign=1.0)
    with pytest.raises(ValueError, match="tangential_angle"):
        read_impacts(tmp_path / "ellipses.csv")


def _usual(name: str) -> tuple[LawPredictor, Callable[[float, float], np.ndarray]]:
    """A rigid law, and its parameters from restitution and friction coefficient."""
    model = next(each for each in usual_laws() if each.label == name)
    places = [each.name for each in model.free]
    return model, lambda e, mu: np.array([{"restitution": e, "friction_coefficient": mu}[n] for n in places])


@pytest.mark.parametrize(("scale", "power", "expected"), [("body", 1, 0.1707), ("contact", 2, 0.1666)])
def test_poissons_friction_coefficient_depends_on_what_is_minimised(
    ellipses: MeasuredImpacts, scale: str, power: int, expected: float
) -> None:
    """Mean error as in measurements.md; mean square over the contact's approach as in fitting.md."""
    model, values = _usual("poisson")
    approach = squared_norm(ellipses.delassus, ellipses.velocity_before)
    # What no impulse reaches is no function of the parameters: it does not move the optimum of the squares.
    weight = 1.0 if scale == "body" else np.sqrt(2.0 * ellipses.kinetic_energy / approach)

    def misfit(x: np.ndarray) -> float:
        errors = ellipses.errors(model.velocities_after(values(*x), ellipses)) * weight
        return float((errors**power).mean())

    result = minimize(misfit, [0.54, 0.17], method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-10})
    assert result.x[1] == pytest.approx(expected, abs=1e-3)


def test_a_constant_impulse_is_no_better_than_one_turned_with_the_slip(ellipses: MeasuredImpacts) -> None:
    def fixed(p: np.ndarray) -> np.ndarray:
        return ellipses.velocity_before + np.einsum("nij,j->ni", ellipses.delassus, p)

    fold = folds_of_measurements(np.arange(len(ellipses)), 5, 0)
    for expected, after in ((0.2815, fixed), (0.2846, lambda p: with_constant_impulse(ellipses, p))):
        errors = np.empty(len(ellipses))
        for stored in range(5):
            fitted = fold != stored
            result = min(
                (
                    minimize(
                        lambda p, m=after, f=fitted: ellipses.errors(m(p))[f].mean(), s, method="Nelder-Mead"
                    )
                    for s in ([0.13, 0.01], [0.13, -0.01])
                ),
                key=lambda result: result.fun,
            )
            errors[~fitted] = ellipses.errors(after(result.x))[~fitted]
        assert errors.mean() == pytest.approx(expected, abs=5e-4)


@pytest.mark.long
@pytest.mark.parametrize(("name", "slip", "incidence"), [("newton", 63, 54), ("poisson", 57, 47)])
def test_a_restitution_of_slip_or_incidence_gains_less_than_tangential_compliance(
    ellipses: MeasuredImpacts, name: str, slip: int, incidence: int
) -> None:
    """Held-out gain of a restitution that is free in eight ranges [1e-4], on a grid of parameters."""
    model, values = _usual(name)
    before = np.abs(ellipses.velocity_before)
    angle = np.arctan2(before[:, 1], before[:, 0])
    assert np.degrees(angle.max()) == pytest.approx(30.7, abs=0.05)
    errors = np.array(
        [
            [
                ellipses.errors(model.velocities_after(values(e, mu), ellipses))
                for mu in np.arange(0.155, 0.195, 0.001)
            ]
            for e in np.arange(0.44, 0.62, 0.0025)
        ]
    )
    fold = folds_of_measurements(np.arange(len(ellipses)), 5, 0)

    def held_out(part: np.ndarray) -> float:
        result = np.empty(len(ellipses))
        for stored in range(5):
            sums = [errors[:, :, (fold != stored) & (part == k)].sum(axis=2) for k in range(part.max() + 1)]
            mu = int(np.sum([each.min(axis=0) for each in sums], axis=0).argmin())
            for k, each in enumerate(sums):
                here = (fold == stored) & (part == k)
                result[here] = errors[each[:, mu].argmin(), mu, here]
        return float(result.mean())

    def eighths(of: np.ndarray) -> np.ndarray:
        return np.searchsorted(np.quantile(of, np.arange(1, 8) / 8), of, side="right")

    whole = held_out(np.zeros(len(ellipses), dtype=int))
    gains = [1e4 * (whole - held_out(eighths(of))) for of in (before[:, 1], angle)]
    assert gains == pytest.approx([slip, incidence], abs=1.0)
    assert max(gains) < 0.5 * 145
