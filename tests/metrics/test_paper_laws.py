"""Verdicts of the metrics on the paper's laws and the paper's motor."""

from math import isnan

import numpy as np
import pytest
from support.configurations import DURATION, case_a_tree, composed, configured, datatree

import contactlab as cl
from contactlab.laws.registry import PARTS
from contactlab.metrics import FAIL, METRICS, PASS, STEP_METRICS, Run, assess, assess_steps, read_run
from contactlab.steady_state.means import motion_of

RIGID_STEPS = (2e-7, 1e-7, 5e-8)
STEPS = {"lagrange_slip": RIGID_STEPS, "lagrange_stick": RIGID_STEPS, "hertz_penalty": (8e-6, 4e-6, 2e-6)}
GIVING = {"default": 0, "high friction": 1, "near the steady state, loaded": 1, "far from the second mode": 1}
"""Whether friction drives the slip-only law over whole contacts, or only reverses its slip."""

VARIED = {
    "default": {},
    "placement 1": {"placement": {"start": 15.968e-3, "end": 25.065e-3}},
    "high friction": {"contact": {"friction_coefficient": 0.6}},
    "near the steady state, loaded": {"rotor": {"initial_velocity": -2.0, "load_torque": -5e-3}},
    "touching at rest, another phase": {"contact": {"clearance": 0.0}, "drive": {"phase": 2.0}},
    "far from the second mode": {"drive": {"frequency_ratio": 1.9}},
}
"""Motors unlike the paper's, whose verdicts are the same."""


def failed(values: dict[str, float]) -> set[str]:
    table = METRICS | STEP_METRICS
    return {key for key, value in values.items() if table[key].verdict(value) == FAIL}


def ladder(law: str, interval: float) -> dict[str, float]:
    return assess_steps([(step, case_a_tree(law, step, interval)) for step in STEPS[law]])


@pytest.mark.parametrize("interval", [1e-6, 1e-7])
@pytest.mark.parametrize("law", STEPS)
def test_the_scorecard_tells_the_papers_laws_apart_as_the_paper_does(law: str, interval: float) -> None:
    each = assess(case_a_tree(law, None, interval))
    assert failed(each | ladder(law, interval)) == set()
    assert (each["slip_reversal"] > 0.9) == (law == "lagrange_slip")


@pytest.mark.parametrize("law", STEPS)
@pytest.mark.parametrize("motor", VARIED)
def test_other_motors_have_the_same_verdicts(motor: str, law: str) -> None:
    result = assess(datatree(configured(law, **VARIED[motor])))
    assert failed(result) <= ({"friction_work"} if law == "lagrange_slip" else set())
    if law == "lagrange_slip" and motor in GIVING:
        assert len(failed(result)) == GIVING[motor]


@pytest.mark.parametrize("interval", [1e-6, 1e-7])
@pytest.mark.parametrize("law", STEPS)
def test_single_precision_has_the_same_verdicts(law: str, interval: float) -> None:
    # All but the time, whose differences would not survive.
    single = case_a_tree(law, None, interval).map_over_datasets(lambda node: node.astype(np.float32))
    assert failed(assess(read_run(single))) == set()


def test_the_peak_of_rigid_laws_goes_as_one_over_the_step_and_their_impulse_stays() -> None:
    for law in ("lagrange_slip", "lagrange_stick"):
        result = ladder(law, 1e-6)
        # The impulse of the largest impact converges with the step.
        assert result["peak_force_exponent"] == pytest.approx(-1.0, abs=0.01)
        # An impulse has no peak force that could converge.
        assert isnan(result["peak_force_step_dependence"])
        assert result["impulse_step_dependence"] < 1e-3
    result = ladder("hertz_penalty", 1e-6)
    assert result["peak_force_step_dependence"] < 1e-6


def test_tangential_restitution_reverses_slips_and_takes_energy() -> None:
    """What a compliance gives back: nine in ten impacts reverse the slip, and friction makes no energy."""
    sections = configured("chatterjee_ruina")
    sections["law"] |= {"tangential_restitution": 0.8}
    result = assess(datatree(sections))
    assert result["slip_reversal"] > 0.9
    assert result["friction_work"] == 0.0
    assert failed(result) == set()


def test_rigid_stick_shows_its_order() -> None:
    result = ladder("lagrange_stick", 1e-6)
    assert result["velocity_order"] == pytest.approx(1.0, abs=0.05)
    # The error of the finest step is the distance to the limit, and half of that of the step before.
    fine, coarse = (
        assess(case_a_tree("lagrange_stick", h, 1e-6))["rotor_velocity"] for h in RIGID_STEPS[:0:-1]
    )
    exact = result["extrapolated_rotor_velocity"]
    assert abs(fine - exact) == pytest.approx(0.5 * abs(coarse - exact), rel=0.1)
    assert result["velocity_error"] == pytest.approx(abs(fine / exact - 1.0), rel=0.05)


LOADED = VARIED["near the steady state, loaded"]


@pytest.mark.parametrize(
    ("friction", "lines"),
    [
        ("coulomb", set()),
        ("regularised", set()),
        ("mindlin", set()),
        ("lugre", {"friction_gain"}),
        ("elasto_plastic", {"friction_gain"}),
    ],
)
def test_frictions_fail_where_they_declare_a_violation(friction: str, lines: set[str]) -> None:
    sections = composed(**{"law": "composed", "law/friction": friction})
    tree = datatree(configured("composed", law=sections["law"], **LOADED))
    result = assess(tree)
    assert failed(result) == lines
    # A spring that gives way while it holds is no drift.
    assert isnan(result["stick_slip"]) == (friction != "coulomb")
    declared = PARTS["friction"][friction].violations
    assert bool(lines) == ("friction_opposes_slip" in declared)


def test_the_bandwidth_of_a_smooth_force_does_not_depend_on_the_records() -> None:
    smooth = [assess(case_a_tree("hertz_penalty", None, i))["force_bandwidth"] for i in (1e-6, 1e-7)]
    # The lines of the spectrum are 200 Hz apart.
    assert smooth[0] == pytest.approx(smooth[1], abs=200.0)
    # Three to four times the reciprocal of a contact's 62 us hold a pulse's energy; a jump has no end.
    assert smooth[0] < 4.0 / 62e-6
    rigid = assess(case_a_tree("lagrange_stick", None, 1e-7))["force_bandwidth"]
    assert rigid > 0.9 * 0.5 / 1e-7


def test_a_run_recorded_at_its_ends_only_has_every_metric_that_takes_no_records() -> None:
    tree = datatree(configured("lagrange_stick", record={"interval": DURATION}))
    result, full = assess(tree), assess(case_a_tree("lagrange_stick", None, 1e-6))
    assert tree["time"].size == 2
    assert failed(result) == set()
    assert result["impulse_balance"] < 1e-12
    for key, metric in METRICS.items():
        # Records follow from one another but for round-off.
        assert metric.needs_records or result[key] == pytest.approx(full[key], rel=1e-12, nan_ok=True), key
        assert not (metric.usual and metric.needs_records), key
    assert isnan(result["slip_reversal"])
    assert isnan(result["rotor_velocity"])


def test_a_contact_lasts_longer_than_hertzs_free_impact_by_little() -> None:
    ratio = assess(case_a_tree("hertz_penalty", None, 1e-6))["hertz_duration_ratio"]
    assert 1.0 < ratio < 1.3
    assert isnan(assess(case_a_tree("lagrange_stick", None, 1e-6))["hertz_duration_ratio"])


def test_the_stiffness_of_a_composed_law_is_found_among_its_parts() -> None:
    parts = assess(datatree(configured("composed")))
    alone = assess(case_a_tree("hertz_penalty", None, 1e-6))
    for key in ("hertz_duration_ratio", "penetration_over_radius"):
        assert parts[key] == pytest.approx(alone[key], rel=1e-6)


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge", "moreau_jean"])
def test_laws_of_restitution_neither_reverse_the_slip_nor_make_energy(law: str) -> None:
    assert failed(assess(datatree(configured(law, **LOADED)))) == set()


def test_hertz_holds_for_the_yield_strength_and_the_roughness_of_the_closed_forms() -> None:
    """p_0 = 2 a E* / (pi R), a^2 = R d; smooth contact below sigma R / a^2 = 0.05."""
    tree = datatree(configured("hertz_penalty"))
    result, depth = assess(tree), float(tree["contacts"]["max_penetration"].max())
    modulus = 210e9 / (2.0 * (1.0 - 0.3**2))
    radius = (
        float(cl.build(["law=hertz_penalty"]).configuration["law"]["stiffness"]) / (4.0 / 3.0 * modulus)
    ) ** 2
    pressure = 2.0 * np.sqrt(radius * depth) * modulus / (np.pi * radius)
    # The largest force and the largest depth differ by the damping, of which there is none.
    assert result["yield_strength_needed"] == pytest.approx(pressure / 1.6, rel=1e-3)
    assert result["smooth_roughness"] == pytest.approx(0.05 * depth)
    assert isnan(assess(datatree(configured("newton")))["yield_strength_needed"])


def test_friction_that_does_no_work_is_not_judged_by_round_off() -> None:
    """The settled motor under Newton's impact sticks: its friction loss is round-off of the drive's work."""
    state = cl.steady(cl.build(["law=newton"]))
    run = Run.of_trajectory(motion_of(state.details), state.setups[""].configuration)
    values = assess(run)
    assert abs(values["friction_share"]) < 1e-12
    assert METRICS["friction_work"].verdict(values["friction_work"]) == PASS
