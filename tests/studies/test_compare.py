"""The study `compare` on settled motors: pairs of laws in motors that are drawn alike for all laws."""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from support.command_line import Command
from support.configurations import altered

import contactlab as cl
from contactlab.metrics import Run
from contactlab.parameter import Parameter
from contactlab.steady_state import NotSettledError, Steady, steady
from contactlab.studies.compare.factors import USUAL, Factor, as_configured, factors_of, left_fixed
from contactlab.studies.compare.hypercube import drawn
from contactlab.studies.compare.laws import run_of_setup
from contactlab.studies.compare.motors import Drawn, configuration_of, damped, on_other_basis
from contactlab.studies.compare.paired import EQUAL, GREATER, INCONCLUSIVE, LESS, NONE
from contactlab.studies.compare.pairs import Settled, population_of
from contactlab.studies.compare.posteriors import Posteriors
from contactlab.studies.compare.priors import Distribution, Prior

EXACT: dict[str, Distribution] = {factor.keys[0]: 0.0 for factor in USUAL}
"""The usual parameters, known exactly: only the start is drawn."""

OPPOSITE: dict[str, object] = {"contact.clearance": 3e-6}
"""A motor that Hertz's law turns forwards and rigid stick backwards."""


def configuration(law: str, **changes: object) -> dict[str, object]:
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    return altered({"solver.duration": 1e-3, "record.picture": False} | keys, law=law)


def setup_of(law: str, **changes: object) -> cl.Setup:
    return cl.build(configuration(law, **changes))


def run_of(law: str, **changes: object) -> Run:
    return run_of_setup(law, setup_of(law, **changes))


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("settled") / "out"


@pytest.fixture(scope="module")
def opposite(output: Path) -> cl.Result:
    """A motor that one law turns forwards and the other backwards."""
    setups = [setup_of(law, **OPPOSITE) for law in ("lagrange_stick", "hertz_penalty")]
    quantities = ["rotor_velocity", "tip_normal_amplitude"]
    return cl.compare(setups, output=output, samples=64, starts=2, vary=EXACT, observe=quantities, workers=1)


def pair(result: cl.Result, quantity: str = "rotor_velocity", cell: int = 0) -> xarray.Dataset:
    """Return what is known of the first law less the second."""
    data = result.data.to_dataset()
    return data.sel(quantity=quantity).isel(law=0, other_law=1, cell=cell)


def test_sums_over_contacts_are_those_of_a_drive_period_however_long_the_motion() -> None:
    """That of the first law repeats after one, that of the other never: sixteen of it are recorded."""
    setups = [setup_of(law) for law in ("lagrange_stick", "lagrange_slip")]
    card = cl.compare(setups, refine=False).data.to_dataset()
    # A motor made in Python has a period without a configuration.
    made = cl.compare(setups[1].motor, setups[1].law, refine=False)["value"].squeeze("law")
    assert made.sel(metric="contact_count") == card["value"].sel(law="lagrange_slip", metric="contact_count")
    for setup in setups:
        impulse, values = cl.steady(setup).details.impulse, card["value"].sel(law=setup.law.name)
        assert values.sel(metric="total_impulse") == pytest.approx(impulse.value, rel=0.02)
        assert values.sel(metric="contact_count") == pytest.approx(1.0, rel=0.1)
    meanings = card["meaning"].sel(metric=["total_impulse", "mean_impulse"]).values
    assert [text.endswith("in a drive period") for text in meanings] == [True, False]


@pytest.mark.long
def test_an_order_that_no_draw_changes_is_that_of_the_motors_drawn(opposite: cl.Result) -> None:
    """Speed counts in the sense of the median law: here of the faster one."""
    difference = pair(opposite)
    stick, hertz = opposite.lagrange_stick.value, opposite.hertz_penalty.value
    assert stick * hertz < 0.0
    faster = abs(stick) > abs(hertz)
    assert int(difference["order"]) == (GREATER if faster else LESS)
    assert abs(float(difference["difference"])) == pytest.approx(abs(stick) + abs(hertz), rel=1e-4)
    assert abs(float(difference["relative_difference"])) > 1.0
    assert float(difference["outcome_share"].max()) == 1.0
    assert 0.0 < float(difference["difference_error"]) < 0.01 * abs(float(difference["difference"]))
    mirrored = opposite.data.to_dataset().sel(quantity="rotor_velocity").isel(law=1, other_law=0, cell=0)
    assert {int(mirrored["order"]), int(difference["order"])} == {GREATER, LESS}
    assert float(mirrored["difference"]) == pytest.approx(-float(difference["difference"]), rel=1e-12)
    # Draws end once the order is known: 0.8^16 of two claims on two quantities exceeds a third of 5 %.
    assert opposite.data.sizes["draw"] == 32
    assert float(difference["p_value"]) == pytest.approx(4.0 * 0.8**32)
    assert np.isnan(difference["factor_share"]).all()
    assert float(opposite["spread"].max()) < 1e-4


def test_everything_but_the_law_is_equal_in_a_draw() -> None:
    """The configurations of a draw differ in the section of the law and the step of the solver alone."""
    setups = [setup_of(law) for law in ("newton", "hertz_penalty")]
    factors = factors_of([run_of("newton"), run_of("hertz_penalty")], {"rotor.inertia": 0.1})
    assert {factor.name for factor in USUAL} - {"preload"} < {factor.name for factor in factors}
    for draw in drawn(factors, 4):
        both = [configuration_of(setup, factors, draw) for setup in setups]
        rest = [{k: x for k, x in each.items() if k not in ("law", "solver")} for each in both]
        assert rest[0] == rest[1]
        assert rest[0]["rotor"]["inertia"] != setups[0].configuration["rotor"]["inertia"]


PRESSED = {"contact.preload": 5.0, "rotor.bearing_damping": 300.0}


def test_what_is_drawn_follows_from_what_the_motor_has() -> None:
    """A preload closes the clearance, unless a spring of the bearing holds the rotor there."""

    def names(**changes: object) -> set[str]:
        return {factor.name for factor in factors_of([run_of("hertz_penalty", **changes)], {})}

    assert {"clearance"} == names() - names(**PRESSED)
    assert {"preload"} == names(**PRESSED) - names()
    assert {"clearance", "preload"} <= names(**PRESSED, rotor__bearing_stiffness=1e5)
    for changes, kept in (({}, False), (PRESSED, True)):
        run = run_of("newton", **changes)
        assert ("preload" in as_configured([run], [])) == kept
        assert "preload" not in as_configured([run], factors_of([run], {}))


def test_a_factor_that_moves_nothing_is_named() -> None:
    """The clearance of a pressed rotor moves no digit, the preload does."""
    setups = [setup_of(law, **PRESSED) for law in ("newton", "hertz_penalty")]
    vary: dict[str, Distribution] = EXACT | {"contact.preload": 0.2, "contact.clearance": (0.5e-6, 2e-6)}
    result = cl.compare(setups, samples=1, starts=1, vary=vary, observe=["rotor_velocity"], workers=1)
    effect = result["effect"].max("law").to_series()
    assert effect["contact.clearance"] < 1e-6 < 1e-3 < effect["preload"]
    assert any("contact.clearance" in text and "preload" not in text for text in result.findings)


def test_the_values_are_those_of_the_steady_states(opposite: cl.Result) -> None:
    state = cl.steady(cl.build(altered(OPPOSITE, law="hertz_penalty")))
    velocity, error = state.velocity
    assert error < 1e-6 * abs(velocity)
    assert opposite.hertz_penalty.value == pytest.approx(velocity, rel=1e-6)
    law = opposite.data.to_dataset().sel(law="hertz_penalty")
    # The balance of a period, not of the transient.
    assert abs(float(law["value"].sel(metric="torque"))) < 1e-8
    stored = float(law["energy"].sel(term="stored_energy"))
    assert stored == pytest.approx(0.0, abs=1e-8 * float(law["drive_work"]))
    nominal = law["nominal"].isel(cell=0, step=0)
    assert float(nominal.sel(quantity="rotor_velocity")) == pytest.approx(velocity, rel=1e-9)
    across = np.ptp(state.data["tip_normal_displacement"].values) / 2
    assert float(nominal.sel(quantity="tip_normal_amplitude")) == pytest.approx(across, rel=1e-3)


def test_the_page_tables_and_figures_are_made_from_the_file(opposite: cl.Result, output: Path) -> None:
    with xarray.open_datatree(output / "compare.nc") as file:
        read = cl.Result(opposite.study, {}, file.load())
    assert read.findings == opposite.findings
    assert len(read.findings) <= 7
    assert repr(read) == repr(opposite)
    figures = list(read.study.figures(read.data))
    # No factor turns an order that all motors have.
    assert figures == ["differences", "contact_force", "tip_trajectory", "energy_flow", "phase_portrait"]
    for name in figures:
        assert (output / f"{name}.png").stat().st_size > 5000, name


def test_a_motor_without_a_steady_state_is_an_outcome(
    opposite: cl.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nine of sixteen motors fail under one law: no order, and the other seven are stated as such."""
    setups = [setup_of(law, **OPPOSITE) for law in ("lagrange_stick", "hertz_penalty")]
    values = iter([opposite.lagrange_stick, opposite.hertz_penalty] * 40)
    count = iter(range(80))

    def observed(setup: cl.Setup, names: Any) -> tuple[str, dict[str, cl.Estimate]]:
        value, number = next(values), next(count)
        # The first eight are four motors as configured, those of `REPEATS`.
        if number % 2 and number >= 8 and number // 2 % 16 < 9:
            raise NotSettledError("It drifts.")
        return "periodic", dict.fromkeys(names, value)

    monkeypatch.setattr("contactlab.studies.compare.observables.observed", observed)
    result = cl.compare(setups, samples=16, starts=1, vary=EXACT, observe=["rotor_velocity"], workers=1)
    here = pair(result)
    assert int((here["outcome"] == NONE).sum()) == 9
    assert float(here["outcome_share"].max()) == pytest.approx(9 / 16)
    assert int(here["order"]) == INCONCLUSIVE


def test_a_law_without_a_steady_state_as_configured_has_no_numbers_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def drifting(setup: cl.Setup) -> tuple[Steady, bool]:
        if setup.law.name == "newton":
            raise NotSettledError("It drifts.")
        return steady(setup), True

    monkeypatch.setattr("contactlab.studies.compare.scorecard.settled_soon", drifting)
    setups = [setup_of(law) for law in ("newton", "hertz_penalty")]
    data = cl.compare(setups, samples=0, starts=1, observe=["rotor_velocity"], workers=1).data.to_dataset()
    for name in ("nominal", "other_basis"):
        known = np.isfinite(data[name]).all([dim for dim in data[name].dims if dim != "law"])
        assert known.values.tolist() == [False, True]
    assert "newton 4" in data.attrs["notes"]


def test_every_steady_state_is_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps, basis and start as configured serve scorecard and pairs; no law's number moves the other law."""
    computed: Counter[tuple[str, ...]] = Counter()

    def counted(setup: cl.Setup, **options: Any) -> Steady:
        start = setup.motor.start
        computed[str(setup.configuration), str(start), str(options.get("belt"))] += 1
        return steady(setup, **options)

    for module in ("steady_state.means", "steady_state.basins", "studies.compare.observables"):
        monkeypatch.setattr(f"contactlab.{module}.steady", counted)
    setups = [setup_of(law) for law in ("lagrange_stick", "hertz_penalty", "newton")]
    quantities, vary = ["rotor_velocity", "stall_torque"], EXACT | {"law.stiffness": 0.3}
    cl.compare(setups, samples=1, starts=2, vary=vary, observe=quantities, workers=1)
    # Three steps, basis, friction, another start, four repeats, a draw; the rotor at rest in nine of them.
    assert {*computed.values()} == {1}
    # Of Hertz's law one with another stiffness, moving and at rest.
    assert computed.total() == 3 * (11 + 9) + 2


def test_another_start_shows_that_a_response_is_no_function_of_its_inputs() -> None:
    """Two attractors: the start decides between a rotor that turns and one that nothing touches."""
    setups = [setup_of(law, contact__clearance=3.895e-6) for law in ("newton", "lagrange_stick")]
    spread = cl.compare(setups, samples=0, starts=1, observe=["rotor_velocity"])["spread"]
    assert spread.sel(law="newton").item() > 0.05


def verdict_of(velocities: Any, spread: float = 1e-6, error: float = 0.0, margin: float = 0.05) -> int:
    """Return the order of the first of two laws with settled velocities as drawn, shape (law, draw)."""
    drawn = np.asarray(velocities, float)[:, None, None]
    middle = np.nan_to_num(drawn[..., 0], nan=1.0)
    nominal = np.repeat(middle[:, :, None], 3, axis=2)
    repeats = middle[:, :, None] * np.linspace(1.0 - spread, 1.0, 4)[:, None]
    moved = nominal[:, :, :0]
    settled = Settled(nominal, middle, repeats, moved, drawn, np.full_like(drawn, error), [1.0, 1.0])
    pairs = population_of(settled, ["rotor_velocity"], margin, 1)
    return int(pairs.orders.verdict[0, 1, 0, 0])


def test_orders_are_those_of_speed_against_the_margin() -> None:
    first, second = -3.0 * np.ones(32), -2.0 * np.ones(32)
    # Backwards, the law with the smaller velocity is the faster one.
    assert verdict_of([first, second]) == verdict_of([-first, -second]) == GREATER
    assert verdict_of([second, first]) == LESS
    assert verdict_of([first, 0.96 * first]) == EQUAL
    assert verdict_of([first, 0.96 * first], margin=0.03) == GREATER
    assert verdict_of([first, np.full(32, np.nan)]) == NONE
    # The mean of an irregular motion counts with its error.
    assert verdict_of([first, second], error=0.5) == GREATER
    assert verdict_of([first, second], error=1.0) == NONE
    # No order where a millionth of friction, or the start, moves the response beyond the margin.
    assert verdict_of([first, second], spread=0.1) == INCONCLUSIVE


def test_without_refinement_values_have_no_errors_and_no_order_is_stated() -> None:
    data = cl.compare([setup_of("newton"), setup_of("hertz_penalty")], refine=False).data.to_dataset()
    assert np.isfinite(data["value"].sel(metric="rotor_velocity")).all()
    assert np.isnan(data["numerical_error"]).all()
    assert "order" not in data


def test_a_motor_and_laws_of_python_are_compared_without_draws() -> None:
    setup = setup_of("newton")
    laws = [cl.Newton(0.3, 0.5), cl.Newton(0.3, 0.9)]
    result = cl.compare(setup.motor, laws, starts=1, observe=["rotor_velocity", "stall_torque"])
    assert len(result.numbers) == 2
    assert all(estimate.error < 0.1 * abs(estimate.value) for estimate in result.numbers.values())
    assert int(pair(result)["order"]) == INCONCLUSIVE
    assert np.isfinite(pair(result)["difference_error"])
    stall = cl.steady(setup.with_("law.restitution=0.9", "contact.friction_coefficient=0.3"), belt=0.0).torque
    made = result.data["nominal"].isel(law=1, cell=0, step=0).sel(quantity="stall_torque")
    assert float(made) == pytest.approx(stall.value, rel=1e-9)


@pytest.fixture(scope="module")
def three() -> cl.Result:
    """Two laws that symmetry makes equal and a third, at two phases on the converged beam."""
    setups = [
        setup_of(
            law,
            **{
                "drive.phase": phase,
                "resonator": cl.build(["resonator=finite_element"]).configuration["resonator"],
            },
        )
        for phase in (-0.6, 0.0)
        for law in ("newton", "poisson", "hertz_penalty")
    ]
    return cl.compare(setups, samples=2, starts=1, vary=EXACT, observe=["rotor_velocity"], workers=1)


@pytest.mark.long
def test_the_order_of_two_laws_reverses_between_operating_points(three: cl.Result) -> None:
    data = three.data.to_dataset().sel(quantity="rotor_velocity")
    assert data.sizes["cell"] == 2
    # In the sense in which the motor turns, backwards.
    between = data["difference"].sel(law="newton", other_law="hertz_penalty")
    assert between[0] > 0.0 > between[1]
    outcome = data["outcome"].sel(law="newton", other_law="hertz_penalty")
    assert (outcome[0] == GREATER).all()
    assert (outcome[1] == LESS).all()
    # Converged, at phase 0: -0.574 and -0.889 rad/s.
    settled = data["nominal"].sel(law=["newton", "hertz_penalty"]).isel(cell=1, step=2)
    np.testing.assert_allclose(settled, [-0.574, -0.889], atol=1e-3)
    assert {"operating_points", "pairs"} < {*three.study.figures(three.data)}
    # Two draws show no order.
    assert (data["order"].sel(law="newton", other_law=["poisson", "hertz_penalty"]) == INCONCLUSIVE).all()


@pytest.mark.long
def test_laws_that_symmetry_makes_equal_are_equal(three: cl.Result) -> None:
    data = three.data.to_dataset()
    assert (data["normal_tangential_coupling"] < 1e-12).all()
    outcome = data["outcome"].sel(quantity="rotor_velocity", law="newton", other_law="poisson")
    assert (outcome == EQUAL).all()
    assert 4 <= len(three.findings) <= 9


def test_priors_are_those_of_the_option_in_place_of_the_usual() -> None:
    stated = run_of("hertz_penalty")
    priors: dict[str, Distribution] = {"rotor.inertia": (4e-5, 5e-5), "drive.phase": cl.Estimate(-0.6, 0.1)}
    priors |= {"law.stiffness": 0.1, "contact.clearance": 0.05, "contact.friction_coefficient": 0.0}
    priors |= {"resonator.stiffness_damping": (1e-7, 2e-5), "rotor.radius": ("20 mm", "25 mm")}
    priors |= {"drive.voltage_1": 0.0, "drive.frequency": "log(2 kHz..2.2 kHz)"}
    factors = {factor.name: factor for factor in factors_of([stated], priors) if factor.keys}
    assert {name: (x.kind, x.a, x.b) for name, x in factors.items()} == {
        "contact stiffness": ("share", 0.1, 0.0), "clearance": ("share", 0.05, 0.0),
        "rotor.inertia": ("uniform", 4e-5, 5e-5), "rotor.radius": ("uniform", 20e-3, 25e-3),
        "drive.phase": ("normal", -0.6, 0.1), "resonator.stiffness_damping": ("log", 1e-7, 2e-5),
        "drive.frequency": ("log", 2000.0, 2200.0),
    }  # fmt: skip
    half = np.array([0.5])
    assert factors["drive.phase"].at(half) == -0.6
    assert factors["rotor.inertia"].at(half) == pytest.approx(4.5e-5)
    assert factors["resonator.stiffness_damping"].at(half) == pytest.approx(np.sqrt(1e-7 * 2e-5))
    shares = factors["contact stiffness"].at(np.array([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(shares, [0.9, 1.0, 1.1])


UNDAMPED = {"resonator.mass_damping": 0.0, "resonator.stiffness_damping": 0.0, "drive.frequency": 3000.0}


@pytest.mark.parametrize("changes", [{}, {"resonator.damping_ratio": 0.01}, UNDAMPED])
def test_the_damping_ratio_drawn_is_that_of_the_first_mode(changes: dict[str, float]) -> None:
    """The others keep their proportions, whatever keys the resonator has; without damping they are equal."""
    setup = setup_of("hertz_penalty", **changes)
    factors = factors_of([run_of("hertz_penalty", **changes)], {})
    (place,) = [n for n, factor in enumerate(factors) if factor.name == "damping ratio"]
    before = setup.motor.modes.damping_ratio
    for draw in drawn(factors, 4):
        ratio = Drawn({"law": setup}, factors, draw).under("law").motor.modes.damping_ratio
        assert 0.002 <= ratio[0] <= 0.2
        assert ratio[0] == pytest.approx(draw[place], rel=1e-12)
        shape = before / before[0] if before[0] > 0.0 else np.ones(before.size)
        np.testing.assert_allclose(ratio / ratio[0], shape, rtol=1e-6)
    exact = factors_of([run_of("hertz_penalty")], {"resonator.damping_ratio": 0.0})
    assert damped(setup, exact, drawn(exact, 1)[0]) == setup
    # Where it tells operating points apart it is not drawn.
    other = run_of("hertz_penalty", resonator__stiffness_damping=1e-6)
    assert "damping ratio" not in {factor.name for factor in factors_of([run_of("newton"), other], {})}


@pytest.mark.parametrize(
    ("key", "prior"),
    [
        ("rotor.mass", 0.1),
        ("contact.clearance", 1.5),
        ("contact.clearance", (2e-6, 1e-6)),
        ("rotor.inertia", (-1e-5, 1e-5)),
        ("rotor.inertia", (4e-5,)),
        ("rotor.inertia", ("a", "b")),
        ("rotor.inertia", ("4 mm", "5 mm")),
        ("rotor.inertia", cl.Estimate(4e-5, 0.0)),
        ("rotor.inertia", None),
        ("rotor.inertia", "log(0..5e-5)"),
        ("resonator.damping_ratio", (0.5, 1.5)),
    ],
)
def test_a_faulty_prior_is_refused_by_its_key(key: str, prior: Any) -> None:
    with pytest.raises(cl.ComparisonError, match=key.replace(".", r"\.")):
        factors_of([run_of("hertz_penalty")], {key: prior})


def test_arguments_of_the_command_are_the_data_of_python(command: Command) -> None:
    texts = ["contact.clearance=0.5 um..2e-6", "drive.phase=-0.6+-0.05", "rotor.inertia=+-0.1"]
    texts += ["resonator.stiffness_damping=log(2e-6..2e-5)", "margin=0.02"]
    assert command("compare", "law=newton", "refine=false", *texts)[0] == 0
    made = cl.load("compare/compare.nc")
    assert isinstance(made, cl.Result)
    assert isinstance(made.study, cl.Compare)
    vary: dict[str, Distribution] = {"contact.clearance": ("0.5 um", 2e-6), "rotor.inertia": 0.1}
    vary = {"contact.clearance": ("0.5 um", 2e-6), "drive.phase": cl.Estimate(-0.6, 0.05)} | vary
    vary |= {"resonator.stiffness_damping": "log(2e-6..2e-5)"}
    study = cl.Compare(refine=False, margin=0.02, vary=vary)
    assert made.study.priors == study.priors
    assert made.study.options == study.options
    (setup,) = made.setups.values()
    # By default the command compares on the converged basis.
    assert setup.configuration["resonator"]["basis"] == "finite_element"


def test_a_drive_at_the_resonance_follows_it_and_its_prior_is_relative() -> None:
    setup = setup_of("hertz_penalty")
    factors = factors_of(
        [run_of("hertz_penalty")], EXACT | {"resonator.length": 0.1, "drive.frequency": 0.05}
    )
    for draw in drawn(factors, 4):
        there = cl.build(configuration_of(setup, factors, draw)).motor
        names = [factor.name for factor in factors]
        relative = draw[names.index("drive frequency")]
        assert there.drive.frequency[0] == pytest.approx(
            relative * there.modes.natural_frequency[0], rel=1e-12
        )
    same = cl.build(configuration_of(setup, (), np.empty(0)))
    assert same.configuration == setup.configuration


def test_the_posterior_of_a_fit_is_drawn_for_its_law(tmp_path: Path) -> None:
    samples = np.linspace(1e9, 2e9, 50)
    tree = xarray.DataTree()
    tree["hertz_penalty/posterior"] = xarray.DataTree(
        xarray.Dataset({"stiffness": (("chain", "draw"), samples[None])})
    )
    tree.to_netcdf(tmp_path / "fit.nc")
    posterior = Posteriors.read(str(tmp_path))
    factors = (Factor("posterior", "uniform", 0.0, 1.0),)
    for law, expected in (("hertz_penalty", samples[25]), ("newton", None)):
        there = configuration_of(setup_of(law), factors, np.array([0.5]), posterior)
        assert there["law"].get("stiffness") == expected
    with pytest.raises(cl.ComparisonError, match="nothing"):
        Posteriors.read(str(tmp_path / "nothing"))


def test_a_file_that_is_no_fit_of_the_laws_is_no_posterior(tmp_path: Path) -> None:
    xarray.Dataset({"stiffness": ("draw", np.ones(3))}).to_netcdf(tmp_path / "plain.nc")
    xarray.DataTree.from_dict({"newton/posterior": xarray.Dataset()}).to_netcdf(tmp_path / "fit.nc")
    for name in ("plain.nc", "fit.nc"):
        with pytest.raises(cl.ComparisonError, match=name):
            Posteriors.read(str(tmp_path / name))
    data = xarray.Dataset({"restitution": (("chain", "draw"), np.ones((1, 3)))})
    xarray.DataTree.from_dict({"newton/posterior": data}).to_netcdf(tmp_path / "other.nc")
    study = cl.Compare(posterior=str(tmp_path / "other.nc"), samples=4)
    with pytest.raises(cl.ComparisonError, match="posterior"):
        list(study.tasks({f"law={law}": setup_of(law) for law in ("hertz_penalty", "lagrange_stick")}))


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
    monkeypatch.setattr("contactlab.studies.compare.factors.declared_in", lambda _: declared)
    factors = factors_of([own], {})
    named = {factor.name: (factor.keys, factor.a) for factor in factors}
    assert named["law.k1"] == (("law.k1",), 0.4)
    assert "contact stiffness" not in named
    assert "k2" in left_fixed(own, factors, {})
    assert "k2" not in left_fixed(own, factors, {"law.k2": 0.0})


def test_laws_at_different_points_are_refused() -> None:
    setups = [setup_of("newton", drive__phase=0.0), setup_of("hertz_penalty", drive__phase=-0.6)]
    with pytest.raises(cl.ComparisonError):
        cl.compare(setups)
    with pytest.raises(cl.ComparisonError, match="observe"):
        cl.compare(setups[:1], observe=["speed"])
    twice = [Prior("rotor.inertia", 0.1), Prior("rotor.inertia", 0.2)]
    with pytest.raises(cl.ComparisonError, match=r"rotor\.inertia"):
        cl.compare(setups[:1], vary=twice)


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
