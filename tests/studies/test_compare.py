"""The study `compare` on settled motors: an effect of the law is one that exceeds all others."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.configurations import altered, datatree

import contactlab as cl
from contactlab.metrics import METRICS, Run
from contactlab.parameter import Parameter
from contactlab.studies.compare_causes import (
    Difference,
    largest_differences,
    samples_needed,
    unclear,
    written_share,
)
from contactlab.studies.compare_draws import (
    BASIS,
    Factor,
    drawn,
    factors_of,
    left_fixed,
    on_other_basis,
    shares,
)
from contactlab.studies.compare_scorecard import CAUSES, PARAMETERS, START

EXACT = {"contact.friction_coefficient": 0.0, "law.stiffness": 0.0, "contact.clearance": 0.0}
"""Ranges of parameters that are known exactly."""

OPPOSITE: dict[str, object] = {"contact.clearance": 3e-6}
"""A motor that Hertz's law turns forwards and rigid stick backwards."""

COEXISTING: dict[str, object] = {
    "drive.frequency": 3400.0,
    "contact.clearance": 1.6583e-5,
    "resonator.stiffness_damping": 1e-6,
}
"""A motor that is driven above its resonance and hardly damped: it turns, or its tip never gets there."""


def configuration(law: str, **changes: object) -> dict[str, object]:
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    return altered({"solver.duration": 1e-3, "record.picture": False} | keys, law=law)


def setup_of(law: str, **changes: object) -> cl.Setup:
    return cl.build(configuration(law, **changes))


def run_of(law: str, **changes: object) -> Run:
    return Run.of(datatree(configuration(law, **changes)))


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("settled") / "out"


@pytest.fixture(scope="module")
def opposite(output: Path) -> cl.Result:
    """What remains is the law: parameters that are known, starts that lead to one motion."""
    runs = [datatree(configuration(law, **OPPOSITE)) for law in ("lagrange_stick", "hertz_penalty")]
    return cl.compare(runs, output=output, samples=0, starts=2, ranges=EXACT)


def test_what_exceeds_all_other_causes_is_due_to_the_law(opposite: cl.Result) -> None:
    (velocity, *_) = largest_differences(opposite.data.to_dataset())
    assert velocity.laws == ("lagrange_stick", "hertz_penalty")
    assert velocity.values[0] < 0.0 < velocity.values[1]
    assert velocity.due_to_law
    assert velocity.size > 2.0 * velocity.effects[BASIS] > 0.0
    assert velocity.effects[PARAMETERS] == 0.0


def test_the_values_are_those_of_the_steady_states(opposite: cl.Result) -> None:
    velocity, error = cl.steady(cl.build(altered(OPPOSITE, law="hertz_penalty"))).velocity
    assert error < 1e-6 * abs(velocity)
    assert opposite.hertz_penalty.value == pytest.approx(velocity, rel=1e-6)
    law = opposite.data.to_dataset().sel(law="hertz_penalty")
    # The balance of a period, not of the transient.
    assert abs(float(law["value"].sel(metric="torque"))) < 1e-8
    stored = float(law["energy"].sel(term="stored_energy"))
    assert stored == pytest.approx(0.0, abs=1e-8 * float(law["drive_work"]))


def test_a_recorded_run_that_has_not_settled_is_reported(opposite: cl.Result) -> None:
    assert "not settled" in opposite.findings[0]


def test_the_page_tables_and_figures_are_made_from_the_file(opposite: cl.Result, output: Path) -> None:
    with xarray.open_datatree(output / "compare.nc") as file:
        read = cl.Result(opposite.study, {}, file.load())
    assert read.findings == opposite.findings
    assert repr(read) == repr(opposite)
    figures = read.study.figures(read.data)
    assert set(figures) == {
        "settled_quantities", "contact_force", "tip_trajectory", "energy_flow", "phase_portrait"
    }  # fmt: skip
    for name in figures:
        assert (output / f"{name}.png").stat().st_size > 5000, name


def test_setups_and_recorded_runs_have_the_same_numbers() -> None:
    setups = [setup_of(law, **OPPOSITE) for law in ("newton", "hertz_penalty")]
    direct = cl.compare(setups, refine=False).data.to_dataset()
    recorded = cl.compare([cl.simulate(setup) for setup in setups], refine=False).data.to_dataset()
    xarray.testing.assert_identical(direct["value"], recorded["value"].assign_coords(direct["value"].coords))
    assert np.isnan(direct["numerical_error"]).all()
    assert not any(each.due_to_law for each in largest_differences(direct))


def test_a_motor_and_laws_of_python_are_compared() -> None:
    setup = setup_of("newton")
    laws = [cl.Newton(0.3, 0.5), cl.Newton(0.3, 0.9)]
    result = cl.compare(setup.motor, laws, starts=1)
    assert len(result.numbers) == 2
    assert all(estimate.error < 0.1 * abs(estimate.value) for estimate in result.numbers.values())
    assert largest_differences(result.data.to_dataset())[0].unknown == [BASIS, PARAMETERS, START]


def test_the_converged_basis_explains_the_default_motors_difference() -> None:
    laws = [setup_of(law) for law in ("lagrange_stick", "hertz_penalty")]
    data = cl.compare(laws, samples=0, starts=1, ranges=EXACT).data.to_dataset()
    velocity = largest_differences(data)[0]
    assert velocity.size == pytest.approx(0.76, abs=0.01)
    assert velocity.possible == [BASIS]
    assert velocity.unknown == [START]
    assert not velocity.due_to_law


@pytest.mark.long
def test_parameters_within_their_ranges_explain_what_laws_that_are_close_differ_by() -> None:
    setups = [setup_of("hertz_penalty", law__stiffness=k) for k in (1e10, 1.1e10)]
    result = cl.compare(setups, samples=8, starts=1)
    data = result.data.to_dataset()
    assert PARAMETERS in largest_differences(data)[0].possible
    assert data.sizes["draw"] == 8 * (data.sizes["factor"] + 2)
    assert data["drawn_value"].dims == ("law", "draw", "quantity")
    assert (data["drawn_value"].notnull().all("quantity").sum("law") == 1).all()
    assert "variance_shares" in result.study.figures(result.data)


def test_a_coexisting_motion_may_explain_a_difference() -> None:
    setups = [setup_of("hertz_penalty", **COEXISTING, law__stiffness=k) for k in (1e10, 5e9)]
    data = cl.compare(setups, samples=0, starts=5, ranges=EXACT).data.to_dataset()
    assert START in largest_differences(data)[0].possible


@pytest.mark.parametrize("cause", CAUSES)
def test_each_cause_alone_withholds_the_law(cause: str) -> None:
    def with_effect(x: float) -> Difference:
        effects = dict.fromkeys(CAUSES, 0.0) | {cause: x}
        return Difference(METRICS["rotor_velocity"], ("stick", "hertz"), (-2.95, -2.19), effects)

    assert with_effect(0.5).due_to_law
    assert not with_effect(0.8).due_to_law
    assert with_effect(0.8).possible == [cause]
    assert not with_effect(np.nan).due_to_law
    assert with_effect(np.nan).unknown == [cause]


def test_ranges_are_those_that_the_runs_state_and_those_of_the_option() -> None:
    stated = run_of("hertz_penalty", uncertainty__clearance_spread=0.05, uncertainty__friction_spread=0.0)
    factors = factors_of([stated], {"law.stiffness": 0.1, "rotor.inertia": 0.02})
    named = {factor.name: factor.spread for factor in factors if factor.keys}
    assert named == {"stiffness": 0.1, "clearance": 0.05, "rotor.inertia": 0.02}
    with pytest.raises(cl.ComparisonError, match=r"rotor\.mass") as refused:
        factors_of([stated], {"rotor.mass": 0.1, "contact.clearance": 1.5})
    assert len(refused.value.faults) == 2
    scales = Factor("x", ("contact.clearance",), 0.2).at(np.array([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(scales, [0.8, 1.0, 1.2])


def test_what_a_law_of_ones_own_declares_is_varied_and_the_rest_is_left_fixed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two springs in series, of which the first declares how well it is known."""
    hertz = run_of("hertz_penalty")
    springs = {"name": "two_springs", "k1": 2e7, "k2": 3e7}
    own = replace(hertz, configuration={**hertz.configuration, "law": springs})
    declared = {
        "law.k1": Parameter("k1", "N m-1", "stiffness", above=0.0, spread=0.4),
        "law.k2": Parameter("k2", "N m-1", "stiffness", above=0.0),
    }
    monkeypatch.setattr("contactlab.studies.compare_draws.declared_in", lambda _: declared)
    factors = factors_of([own], {})
    named = {factor.name: (factor.keys, factor.spread) for factor in factors}
    assert named["law.k1"] == (("law.k1",), 0.4)
    assert "stiffness" not in named
    assert left_fixed(own, factors, {}) == ["k2"]
    assert left_fixed(own, factors, {"law.k2": 0.0}) == []
    assert left_fixed(hertz, factors_of([hertz, own], {}), {}) == []


def test_shares_of_levels_and_ranges_are_those_of_the_closed_form() -> None:
    """y = a l + b x + c l x of a level l: variances a^2 2/3, b^2 s^2/3, of both together c^2 2/3 s^2/3."""
    factors = (Factor("law", levels=3), Factor("x", ("contact.clearance",), 0.3), Factor("step", levels=3))
    draws = drawn(factors, 512)
    level, x = draws[:, 0] - 1.0, draws[:, 1] - 1.0
    a, b, c = 1.0, 4.0, 3.0
    values = np.column_stack([a * level + b * x + c * level * x, np.full(level.size, np.nan)])
    parts = np.array([a**2 * 2.0 / 3.0, b**2 * 0.03, c**2 * 2.0 / 3.0 * 0.03])
    first, total = shares(values, 3)
    np.testing.assert_allclose(first[0, :, 0], [*parts[:2] / parts.sum(), 0.0], atol=0.03)
    np.testing.assert_allclose(total[0, :, 0], [*(parts[:2] + parts[2]) / parts.sum(), 0.0], atol=0.03)
    assert np.isnan(total[1]).all()
    assert not unclear(*total[0, 0, 1:])
    # Rows without a steady state are left out.
    lost = np.where(np.arange(level.size)[:, None] == 5, np.nan, values)
    np.testing.assert_allclose(shares(lost, 3)[1][0, :, 0], total[0, :, 0], atol=0.1)


def test_a_share_with_a_wide_interval_is_inconclusive() -> None:
    assert unclear(0.0, 0.9)
    # A share of 0.89 with an interval from 0.57 to 1.33 is not known.
    assert unclear(0.57, 1.33)
    assert not unclear(-0.05, 0.03)
    assert written_share(-0.01, -0.05, 0.03) == "below 0.03"
    # The width falls with the root of the samples, here from 0.76 to below 0.3.
    assert samples_needed(np.array([[0.89, 0.57, 1.33]]), 32) == 256


def test_the_other_basis_is_the_converged_one_whose_first_frequency_the_drive_follows() -> None:
    changed, _ = on_other_basis(cl.build(altered({}, law="hertz_penalty")))
    there = cl.build(changed)
    assert there.motor.drive.frequency[0] == there.motor.modes.natural_frequency[0] == pytest.approx(2137.53)
    assert changed["resonator"]["length"] == pytest.approx(57e-3)
    # A frequency of one's own stays.
    fixed, _ = on_other_basis(cl.build(altered({"drive.frequency": 3000.0}, law="hertz_penalty")))
    assert cl.build(fixed).motor.drive.frequency[0] == 3000.0
    more, _ = on_other_basis(there)
    assert more["resonator"]["kept_modes"] == changed["resonator"]["kept_modes"] + 4
