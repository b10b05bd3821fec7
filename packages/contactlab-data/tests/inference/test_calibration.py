"""Claims on numbers of laws from quantities of impacts and from materials."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, exp, gamma, log, log1p, pi, radians, sqrt, tan
from typing import Annotated, Any, final

import numpy as np
import pytest
import scipy
from hypothesis import example, given, settings, strategies as st
from numpy.testing import assert_allclose
from support.tensile_dashpot import TensileDashpot

import contactlab as cl
from contactlab.compiler.kernels import kernel
from contactlab.impacts import NORMAL
from contactlab.laws.registry import PARTS
from contactlab.parameter import positive
from contactlab_data.inference.calibration import Datum, calibrated
from contactlab_data.inference.free_parameters import free_parameters, with_values
from contactlab_data.inference.materials import MATERIALS, Material, effective_modulus

MASS, SPEED = 2.5e-3, 0.5

BALL = np.array([[400.0, 0.0], [0.0, 1400.0]])
"""A free ball of 2.5 g."""


@settings(max_examples=5)
@given(st.floats(0.2, 0.9), st.floats(0.05, 0.5))
def test_laws_of_both_families_get_the_restitution(value: float, speed: float) -> None:
    datum = Datum("restitution", value, speed)
    for law in (cl.Newton(0.3, 0.5), cl.build(["law=composed", "law/damping=hunt_crossley"]).law):
        numbers = calibrated(law, datum, BALL)
        assert numbers
        for name, x in numbers.items():
            law = law.changed(name, x)
        assert datum.measured(law, BALL) == pytest.approx(value, rel=1e-6)


def test_hertz_gets_a_contact_time_by_the_closed_form_of_its_stiffness() -> None:
    """t = 2.943 (m^2 / (k^2 v))^(1/5) for (5/4)^(2/5)-scaled k: t^5 k^2 is constant."""
    law = cl.build(["law=hertz_penalty"]).law
    times = (40e-6, 80e-6)
    numbers = [calibrated(law, Datum("contact_time", t, 0.1), BALL) for t in times]
    assert all([*each] == ["stiffness"] for each in numbers)
    k = [each["stiffness"] for each in numbers]
    assert k[0] / k[1] == pytest.approx((times[1] / times[0]) ** 2.5, rel=1e-6)


def test_a_law_without_loss_has_no_restitution_to_be_set() -> None:
    assert not calibrated(cl.build(["law=hertz_penalty"]).law, Datum("restitution", 0.5, 0.1), BALL)


@pytest.mark.parametrize(
    ("quantity", "value", "speed", "key"),
    [
        ("restitution", 1.5, 0.1, "restitution"),
        ("contact_time", -1.0, 1.0, "contact_time"),
        ("e", 0.5, 1.0, "quantity"),
        ("restitution", "a", 1.0, "restitution"),
        ("restitution", 0.5, 0.0, "speed"),
    ],
)
def test_a_faulty_datum_is_refused(quantity: str, value: Any, speed: float, key: str) -> None:
    with pytest.raises(ValueError, match=key):
        Datum(quantity, value, speed)


def hertz(stiffness: float, mass: float, speed: float) -> tuple[float, float]:
    """Contact time [s] and peak force [N] (Johnson 1985, sec. 11.4); the factor of d_max/v is 2.94."""
    depth = (1.25 * mass * speed**2 / stiffness) ** 0.4
    return 2.0 * depth / speed * sqrt(pi) * gamma(1.4) / gamma(0.9), stiffness * depth**1.5


def number(result: Any, name: str) -> float:
    """A number of an identified law."""
    return float(result.law.describe()[name])


@settings(max_examples=15)
@given(st.floats(6.0, 13.0), st.floats(-5.0, 0.0), st.floats(-3.0, 1.0))
def test_the_contact_time_and_the_peak_force_of_hertz_have_his_stiffness(
    k: float, m: float, v: float
) -> None:
    stiffness, mass, speed = 10.0**k, 10.0**m, 10.0**v
    time, force = hertz(stiffness, mass, speed)
    made = cl.normal_impact(cl.HertzPenalty(stiffness), speed, mass=mass, tolerance=1e-11)
    assert_allclose([made.contact_time[0], made.peak_force[0]], [time, force], rtol=1e-8)
    for known in ({"contact_time": (time, speed)}, {"peak_force": (force, speed)}):
        result = cl.identify(cl.HertzPenalty(), mass=mass, **known)  # type: ignore[arg-type]
        assert number(result, "stiffness") == pytest.approx(stiffness, rel=1e-8)
        assert result.free == ("friction_coefficient",)


def test_the_constant_of_the_contact_time_of_a_ball_is_2_87() -> None:
    """t = 2.8683 (m^2 / (R E*^2 v))^(1/5)."""
    constant = 2.0 * sqrt(pi) * gamma(1.4) / gamma(0.9) * (15.0 / 16.0) ** 0.4
    assert constant == pytest.approx(2.868, abs=1e-3)
    radius, modulus = 3e-3, effective_modulus("steel on alumina")
    time = constant * (MASS**2 / (radius * modulus**2 * SPEED)) ** 0.2
    law = cl.identify(cl.HertzPenalty(), materials="steel on alumina", radius=radius).law
    made = cl.normal_impact(law, SPEED, mass=MASS, tolerance=1e-11)
    assert_allclose(made.contact_time, time, rtol=1e-8)


def test_two_moduli_and_poisson_numbers_set_effective_modulus_radius_and_stiffness() -> None:
    modulus = 1.0 / ((1.0 - 0.3**2) / 210e9 + (1.0 - 0.22**2) / 400e9)
    pair = (Material(210e9, 0.3), Material("400 GPa", 0.22))  # type: ignore[arg-type]
    known: dict[str, Any] = {"materials": pair, "radius": "3 mm"}
    assert (
        effective_modulus("steel on alumina") == effective_modulus(pair) == pytest.approx(modulus, rel=1e-14)
    )
    stiffness = 4.0 / 3.0 * modulus * sqrt(3e-3)
    for law in (cl.HertzPenalty(), cl.Composed(), cl.Archard()):
        result = cl.identify(law, **known)
        (name,) = (x for x in law.describe() if x.endswith("stiffness"))
        assert number(result, name) == pytest.approx(stiffness, rel=1e-14)
        assert name not in result.free
    for part in (cl.Thornton(), cl.Jkr(), cl.Dmt()):
        result = cl.identify(cl.Composed(part), **known)
        assert number(result, "normal.effective_modulus") == pytest.approx(modulus, rel=1e-14)
        assert number(result, "normal.radius") == 3e-3
    # A sphere on a plate, whose circle is an ellipse of equal axes.
    sphere = cl.identify(cl.Composed(cl.HertzElliptic()), **known).law
    alike = cl.identify(cl.HertzPenalty(), **known).law
    peaks = [cl.normal_impact(law, SPEED, mass=MASS, tolerance=1e-11).peak_force for law in (sphere, alike)]
    assert_allclose(*peaks, rtol=1e-8)


def test_steel_on_steel_is_the_modulus_that_laws_have_by_default() -> None:
    result = cl.identify(cl.Composed(cl.Thornton()), materials="steel on steel")
    assert number(result, "normal.effective_modulus") == pytest.approx(
        cl.Thornton().effective_modulus, rel=1e-14
    )


def test_every_handbook_material_is_an_elastic_solid() -> None:
    assert all(1e8 < x.youngs_modulus < 1e12 and 0.1 < x.poisson_ratio < 0.5 for x in MATERIALS.values())


def test_an_incline_sets_the_friction_of_every_law_that_has_one() -> None:
    for law in (cl.Newton(), cl.HertzPenalty(), cl.Composed(friction=cl.Mindlin())):
        result = cl.identify(law, friction_angle="17 deg")  # type: ignore[arg-type]
        (name,) = (x for x in law.describe() if x.endswith("friction_coefficient"))
        assert number(result, name) == pytest.approx(tan(radians(17.0)), rel=1e-14)
        assert name not in result.free


@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.8])
def test_a_dashpot_that_may_pull_has_the_stiffness_and_the_damping_of_its_closed_form(ratio: float) -> None:
    """e = exp(-pi z / sqrt(1 - z^2)), t = pi / (w0 sqrt(1 - z^2)): of a law of a user's own."""
    stiffness, rate = 3e6, sqrt(3e6 / MASS)
    e = exp(-pi * ratio / sqrt(1.0 - ratio**2))
    time = pi / (rate * sqrt(1.0 - ratio**2))
    law = TensileDashpot(1e7, 10.0)
    result = cl.identify(law, mass=MASS, restitution=(e, SPEED), contact_time=(time, SPEED))
    assert number(result, "stiffness") == pytest.approx(stiffness, rel=1e-8)
    assert number(result, "damping") == pytest.approx(2.0 * ratio * rate * MASS, rel=1e-8)
    assert result.free == ()
    assert set(result.parameters["from"]) == {"restitution, contact_time"}


def test_a_dashpot_that_is_released_without_pull_has_those_of_its_closed_form() -> None:
    """e = exp[-(b/w) a], t = a/w, a = pi - atan2(2 b w, w^2 - b^2), b = z w0, w = w0 sqrt(1 - z^2)."""
    ratio, rate = 0.3, sqrt(3e6 / MASS)
    b, w = ratio * rate, rate * sqrt(1.0 - ratio**2)
    angle = pi - atan2(2.0 * b * w, w * w - b * b)
    law = cl.Composed(cl.Linear(1e7), cl.LinearDamping(0.8, MASS, SPEED))
    free = ["normal.stiffness", "damping.restitution"]
    known = {"restitution": (exp(-b / w * angle), SPEED), "contact_time": (angle / w, SPEED)}
    result = cl.identify(law, mass=MASS, free=free, **known)  # type: ignore[arg-type]
    assert number(result, "normal.stiffness") == pytest.approx(3e6, rel=1e-8)
    assert number(result, "damping.restitution") == pytest.approx(exp(-b / w * angle), rel=1e-8)


@final
@dataclass(frozen=True)
class Tsuji(cl.PenaltyLaw):
    """Hertz with a dashpot in proportion to d^(1/4), as a user may write it."""

    name = "tsuji"
    equation = "N = K d^1.5 + c d^0.25 dd/dt"
    source = "Tsuji et al. (1992), Powder Technol. 71, 239"
    default_contact_step = 4e-6
    allows_tension = True

    stiffness: Annotated[float, positive("K", "N m-1.5", "contact stiffness")] = 1e10
    damping: Annotated[float, positive("c", "N s m-1.25", "damping")] = 100.0

    @staticmethod
    @kernel
    def force(depth, depth_rate, stiffness, damping):
        elastic = stiffness * depth**1.5
        dissipative = damping * depth**0.25 * depth_rate
        return elastic + dissipative, 0.0, 0.4 * elastic * depth, dissipative * depth_rate


def test_the_law_of_tsuji_has_the_damping_of_a_linear_oscillator() -> None:
    """y = d^(5/4) over ds = d^(1/4) dt is linear, z = c/sqrt(5 K m): e = exp(-pi z/sqrt(1 - z^2))."""
    e = 0.7
    ratio = -log(e) / sqrt(pi**2 + log(e) ** 2)
    known = {"restitution": (e, SPEED), "materials": "steel on glass", "radius": "3 mm"}
    result = cl.identify(Tsuji(), mass=MASS, **known)  # type: ignore[arg-type]
    stiffness = number(result, "stiffness")
    assert stiffness == pytest.approx(4.0 / 3.0 * effective_modulus("steel on glass") * sqrt(3e-3), rel=1e-14)
    assert number(result, "damping") == pytest.approx(ratio * sqrt(5.0 * stiffness * MASS), rel=1e-8)
    over = cl.normal_impact(result.law, [1e-3, 0.1, 10.0], mass=MASS, tolerance=1e-11)
    assert_allclose(over.restitution, e, rtol=1e-8)


def test_a_dashpot_of_one_mass_has_the_mass_of_the_impacts() -> None:
    """It has the restitution at its own mass, so that the restitution is the number itself."""
    law = cl.Composed(damping=cl.Tsuji())
    result = cl.identify(law, mass="1 g", restitution="0.82 @ 0.5 m/s")
    assert result.law.damping.effective_mass == 1e-3
    assert result.law.damping.restitution == pytest.approx(0.82, abs=1e-9)
    assert result.parameters.loc["damping.effective_mass", "from"] == "mass"
    assert "damping.effective_mass" not in result.free


# Viscous bodies are elastic in the limit alone.
ASKED = [(x, e) for x in PARTS["damping"] for e in (0.05, 0.82, 1.0) if (x, e) != ("kuwabara_kono", 1.0)]
"""Every damping of the package with restitutions."""


@pytest.mark.parametrize(("mass", "speed"), [(1e-3, 0.5), (3e-7, 2e-4)])
@pytest.mark.parametrize(("name", "e"), ASKED)
def test_the_restitution_that_is_required_is_that_of_the_law(
    name: str, e: float, mass: float, speed: float
) -> None:
    """A damping with a restitution states the required one, at the mass and the speed of the impact.

    Hunt and Crossley admit none below 0.488, and have it as a higher one at a lower speed.
    """
    part: Any = PARTS["damping"][name]
    law, known = cl.Composed(damping=part()), {"mass": mass, "restitution": (e, speed)}
    least = {"none": 1.0, "lankarani_nikravesh": 0.663}.get(name, 0.0)
    if e < least:
        with pytest.raises(ValueError, match="restitution"):
            cl.identify(law, **known)
        return
    result = cl.identify(law, **known)
    made = cl.normal_impact(result.law, speed, mass=mass, tolerance=1e-11)
    assert float(made.restitution[0]) == pytest.approx(e, rel=1e-7)
    stated = {} if name == "hunt_crossley" and e < 0.4877 else result.law.describe()
    required = {"restitution": e, "effective_mass": mass, "impact_speed": speed}
    for field, value in required.items():
        if (key := f"damping.{field}") in stated:
            assert stated[key] == pytest.approx(value, rel=1e-7)
            assert key not in result.free


def test_hunt_and_crossley_have_the_loss_of_the_speed_at_which_it_was_measured() -> None:
    """(1 + e) D = ln((1 + D)/(1 - e D)) with D = a v, so that at another speed v_0 it is a v_0."""

    def loss(e: float) -> float:
        f = lambda d: (1.0 + e) * d - log((1.0 + d) / (1.0 - e * d))  # noqa: E731
        return float(scipy.optimize.brentq(f, 1e-3, (1.0 - 1e-12) / e, xtol=1e-14))

    law = cl.Composed(damping=cl.HuntCrossley(0.8, impact_speed=0.1))
    result = cl.identify(law, mass=MASS, restitution="0.6 @ 0.3 m/s", free=["damping.restitution"])
    e = number(result, "damping.restitution")
    assert loss(e) / 0.1 == pytest.approx(loss(0.6) / 0.3, rel=1e-8)
    parts = {
        "normal.stiffness",
        "damping.impact_speed",
        "friction.friction_coefficient",
        "friction.static_ratio",
    }
    assert {*result.free} == parts
    # Its speed would do as well, and the table says so.
    assert result.parameters.loc["damping.impact_speed", "acts on"] == "restitution"
    assert result.parameters.loc["normal.stiffness", "acts on"] == ""


@example(1.0)
@example(1.0 - 1e-9)
@settings(max_examples=10)
@given(st.floats(0.01, 1.0))
def test_a_rigid_law_has_the_restitution_itself(e: float) -> None:
    for law in (cl.Newton(), cl.Poisson(), cl.Stronge(), cl.Brach()):
        result = cl.identify(law, mass=MASS, restitution=(e, SPEED))
        assert number(result, "restitution") == pytest.approx(e, rel=1e-9)
        assert result.free == ("friction_coefficient",)


COMPLIANT: list[cl.ContactLaw] = [
    cl.HertzPenalty(),
    cl.Archard(),
    *(cl.Composed(part()) for part in PARTS["normal"].values()),  # type: ignore[arg-type]
    *(
        cl.Composed(damping=cl.Tsuji(effective_mass=MASS) if name == "tsuji" else d())  # type: ignore[arg-type]
        for name, d in PARTS["damping"].items()
        if name != "linear"
    ),
]
"""Every compliant normal direction of the package; the linear dashpot has its closed form."""


def quantities_of(law: cl.ContactLaw) -> dict[str, float]:
    """Every quantity of a normal impact at SPEED."""
    return {name: Datum(name, 1.0, SPEED).measured(law, np.eye(2) / MASS) for name in NORMAL}


def identifiable(law: cl.ContactLaw, factor: float) -> Iterator[tuple[str, str, float, float]]:
    """Every number with every quantity that tells it, the number's changed value and the quantity."""
    before = quantities_of(law)
    for item in free_parameters(law):
        value = law.describe()[item.name] * factor
        if item.parameter.admits(value):
            after = quantities_of(with_values(law, [item], [value]))
            yield from ((item.name, q, value, x) for q, x in after.items() if abs(x - before[q]) > 1e-5 * x)


@pytest.mark.parametrize("law", COMPLIANT, ids=lambda law: law.title)
def test_every_number_that_a_quantity_tells_comes_back_from_it(law: cl.ContactLaw) -> None:
    every = [*identifiable(law, 0.87)]
    assert every
    for name, quantity, value, x in every:
        result = cl.identify(law, mass=MASS, free=[name], **{quantity: (x, SPEED)})  # type: ignore[arg-type]
        assert number(result, name) == pytest.approx(value, rel=1e-7), quantity
        assert result.parameters.loc[name, "from"] == quantity
        assert_allclose(result.quantities["residual"], 0.0, atol=1e-9)


@pytest.mark.long
@settings(max_examples=15)
@given(st.floats(6.0, 13.0), st.floats(0.05, 0.99), st.floats(-5.0, 0.0))
def test_two_quantities_bring_two_numbers_back_and_the_table_says_which_from_which(
    k: float, e: float, m: float
) -> None:
    stiffness, mass = 10.0**k, 10.0**m
    truth = cl.normal_impact(
        cl.Composed(cl.HertzPoint(stiffness), cl.Flores(e)), SPEED, mass=mass, tolerance=1e-11
    )
    known: dict[str, Any] = {x: (float(truth[x][0]), SPEED) for x in ("restitution", "contact_time")}
    result = cl.identify(cl.Composed(damping=cl.Flores()), mass=mass, **known)
    assert number(result, "normal.stiffness") == pytest.approx(stiffness, rel=1e-8)
    assert number(result, "damping.restitution") == pytest.approx(e, rel=1e-8)
    # The restitution is that of the damping alone, the contact time that of both.
    source = result.parameters["from"]
    assert source["damping.restitution"] == "restitution"
    assert source["normal.stiffness"] == "restitution, contact_time"
    assert result.free == ("damping.least_speed", "friction.friction_coefficient", "friction.static_ratio")
    assert all(name in str(result) for name in result.parameters.index)


def test_a_yield_pressure_is_found_from_below_first_yield_where_it_changes_nothing() -> None:
    truth = cl.Composed(cl.Thornton(yield_pressure=1e9))
    law = cl.Composed(cl.Thornton(yield_pressure=1e11))
    e = quantities_of(truth)["restitution"]
    assert e < 0.9 < quantities_of(law)["restitution"]
    result = cl.identify(law, mass=MASS, restitution=(e, SPEED), free=["normal.yield_pressure"])
    assert number(result, "normal.yield_pressure") == pytest.approx(1e9, rel=1e-7)


def test_numbers_that_act_as_one_are_not_all_solved_for() -> None:
    """Johnson's restitution (E / (m v^2))^(1/8) at two speeds determines no more than at one."""
    law = cl.Johnson()
    known = [(0.6, 1.0), (0.6 * 0.5**-0.25, 0.5)]
    result = cl.identify(law, mass=MASS, restitution=known)
    assert result.free == ("friction_coefficient", "yield_strength", "radius")
    assert_allclose(result.quantities["reached"], [x for x, _ in known], rtol=1e-9)


def test_what_a_law_has_whatever_its_numbers_determines_none() -> None:
    result = cl.identify(cl.HertzPenalty(), mass=MASS, restitution="1 @ 0.5 m/s")
    assert result.law == cl.HertzPenalty()
    assert result.free == ("stiffness", "friction_coefficient")


def test_measured_quantities_agree_within_their_tolerance() -> None:
    time, force = hertz(2e9, MASS, SPEED)
    known: dict[str, Any] = {"contact_time": (1.01 * time, SPEED), "peak_force": (0.995 * force, SPEED)}
    with pytest.raises(ValueError, match=r"contact_time.*peak_force"):
        cl.identify(cl.HertzPenalty(), mass=MASS, **known)
    result = cl.identify(cl.HertzPenalty(), mass=MASS, tolerance="1 %", **known)  # type: ignore[arg-type]
    # Least squares of logarithms, of which time falls and force grows with 2/5 of that of K.
    share = 0.5 * (log(0.995) - log(1.01)) / 0.4
    assert number(result, "stiffness") == pytest.approx(2e9 * exp(share), rel=1e-6)
    assert (result.quantities["residual"].abs() < 0.01).all()


@pytest.mark.parametrize(
    ("law", "known", "text"),
    [
        (cl.HertzPenalty(), {"restitution": (0.7, 0.2)}, r"restitution=0\.7.* 1 with.*stiffness"),
        (cl.Newton(), {"contact_time": (1e-5, 0.2)}, r"contact_time=1e-05.* 0 s"),
        (cl.Newton(), {"peak_force": "1 N @ 0.2 m/s"}, r"peak_force=1\.0.* none"),
        (cl.Newton(), {"restitution": [(0.7, 0.2), (0.6, 0.3)]}, r"restitution=0\.7.*restitution=0\.6"),
        (cl.Newton(), {"restitution": (1.2, 0.2)}, "restitution is 1.2.* 1"),
        (cl.Newton(), {"restitution": (-0.2, 0.2)}, "restitution is -0.2.* 0"),
        (cl.Newton(), {"restitution": "0.8 @ 2 kg"}, "speed of restitution"),
        (cl.Newton(), {"restitution": "0.8"}, "restitution.*speed"),
        (cl.Newton(), {"restitution": 0.8}, "restitution.*speed"),
        (cl.HertzPenalty(), {"contact_time": (-1e-5, 0.2)}, "contact_time is -1e-05.* 0"),
        (
            cl.Composed(damping=cl.LankaraniNikravesh()),
            {"restitution": (0.4, 0.2)},
            r"restitution=0\.4.*0\.662962",
        ),
        (
            cl.HertzPenalty(),
            {"contact_time": (1e-3, 0.2), "materials": "steel on steel", "radius": 3e-3},
            "1e-3|0.001",
        ),
        (cl.HertzPenalty(), {"contact_time": (1e-5, 0.2), "free": ["stifness"]}, "stifness.*stiffness"),
        (cl.HertzPenalty(), {"materials": "steel on steel"}, "materials.* K "),
        (cl.HertzPenalty(), {"radius": "3 mm"}, "radius.* K "),
        (cl.HertzPenalty(), {"materials": "steel on wood", "radius": "3 mm"}, "wood.*alumina"),
        (cl.HertzPenalty(), {"materials": "steel", "radius": "3 mm"}, "materials is 'steel'"),
        (cl.HertzPenalty(), {"materials": 3.0, "radius": "3 mm"}, "materials"),
        (cl.Newton(), {"restitution": (0.8, -0.2)}, "speed of restitution"),
        (cl.Newton(), {"restitution": (0.8, 0.2), "tolerance": -1e-6}, "tolerance"),
        (cl.Newton(), {"restitution": (0.8, 0.2), "tolerance": np.nan}, "tolerance"),
        (cl.HertzPenalty(), {"materials": "steel on steel", "radius": "-3 mm"}, "radius is -0.003"),
        (cl.LagrangeStick(), {"friction_angle": "120 deg"}, "friction_angle"),
        (TensileDashpot(1e7, 1.0), {"friction_angle": 0.3}, "friction_angle sets no number"),
        (cl.HertzPenalty(), {}, "quantity"),
    ],
)
def test_what_a_law_cannot_have_is_refused_with_key_value_and_bound(
    law: cl.ContactLaw, known: dict[str, Any], text: str
) -> None:
    with pytest.raises((TypeError, ValueError), match=text):
        cl.identify(law, mass=MASS, **known)


def test_an_impact_needs_a_mass() -> None:
    for mass in (None, 0.0, "-2 g"):
        with pytest.raises(ValueError, match="mass"):
            cl.identify(cl.Newton(), restitution="0.8 @ 0.5 m/s", mass=mass)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="law"):
        cl.identify("newton", restitution="0.8 @ 0.5 m/s", mass=MASS)  # type: ignore[arg-type]
    for names in ("restitution", [3], 3):
        with pytest.raises(TypeError, match="free"):
            cl.identify(cl.Newton(), restitution="0.8 @ 0.5 m/s", mass=MASS, free=names)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="materials"):
        cl.identify(cl.HertzPenalty(), materials=("steel", 3.0), radius=3e-3)  # type: ignore[arg-type]


def test_texts_with_units_are_their_numbers() -> None:
    law = cl.Composed(damping=cl.HuntCrossley())
    texts = cl.identify(law, mass="2.5 g", restitution="80 % @ 0.5 m/s", contact_time="50 us @ 50 cm/s")  # type: ignore[arg-type]
    numbers = cl.identify(law, mass=2.5e-3, restitution=(0.8, 0.5), contact_time=(5e-5, 0.5))
    assert texts.law == numbers.law
    assert Datum("contact_time", "50 us", "50 cm/s") == Datum("contact_time", 5e-5, 0.5)


@pytest.mark.parametrize(
    "law", [cl.Composed(damping=cl.HuntCrossley()), cl.Composed(cl.Thornton()), cl.Johnson()]
)
def test_the_table_over_the_speed_is_that_of_impacts(law: cl.ContactLaw) -> None:
    speeds = np.geomspace(0.02, 2.0, 7)
    table = cl.normal_impact(law, speeds, mass=MASS)
    made = cl.impact(law, np.diag([1.0, 3.5]) / MASS, np.column_stack([-speeds, 0.0 * speeds]))
    assert_allclose(table.speed, speeds)
    assert_allclose(table.restitution, made.velocity_after.sel(direction="normal") / speeds, rtol=1e-12)
    assert_allclose(table.contact_time, made.duration, rtol=1e-12)
    assert_allclose(table.peak_force, made.peak_normal_force, rtol=1e-12)
    assert_allclose(table.penetration, made.max_penetration, rtol=1e-12)
    assert (np.diff(table.restitution) < 0.0).all()
    assert {name: table[name].attrs["units"] for name in NORMAL} == {n: v.units for n, v in NORMAL.items()}


def test_the_table_over_the_speed_has_the_closed_forms_of_hertz_hunt_and_crossley_and_tsuji() -> None:
    speeds, stiffness = np.geomspace(1e-3, 1.0, 9), 1e9
    table = cl.normal_impact(cl.HertzPenalty(stiffness), speeds, mass=MASS, tolerance=1e-11)
    time, force = np.transpose([hertz(stiffness, MASS, v) for v in speeds])
    columns = np.ones(9), time, force, (force / stiffness) ** (2.0 / 3.0)
    for name, expected in zip(NORMAL, columns, strict=True):
        assert_allclose(table[name], expected, rtol=1e-8, err_msg=name)

    tuned = cl.Composed(damping=cl.HuntCrossley(0.8, impact_speed=0.1))
    table = cl.normal_impact(tuned, speeds, mass=MASS, tolerance=1e-11)

    def balance(e: float, loss: float) -> float:
        return (1.0 + e) * loss - log1p(loss) + log1p(-e * loss)

    # (1 + e) D = ln((1 + D)/(1 - e D)) with D = a v, which a restitution of 0.8 at 0.1 m/s determines.
    a = scipy.optimize.brentq(lambda a: balance(0.8, 0.1 * a), 0.1, 10.0, xtol=1e-14)
    ends = [min(1.0, (1.0 - 1e-12) / (a * v)) for v in speeds]
    e = [scipy.optimize.brentq(balance, 0.0, x, (a * v,), 1e-14) for v, x in zip(speeds, ends, strict=True)]
    assert_allclose(table.restitution, e, rtol=1e-8)

    always = cl.Composed(damping=cl.Tsuji(0.6, MASS))
    table = cl.normal_impact(always, speeds, mass=MASS, tolerance=1e-11)
    assert_allclose(table.restitution, 0.6, rtol=1e-8)


def test_bodies_that_do_not_part_have_no_restitution() -> None:
    sticky = cl.Composed(cl.Jkr(work_of_adhesion=10.0))
    table = cl.normal_impact(sticky, [1e-3, 1.0], mass=1e-6)
    assert np.isnan(table.restitution[0])
    assert np.isnan(table.contact_time[0])
    assert 0.0 < table.restitution[1] < 1.0


@pytest.mark.parametrize("speed", [0.0, [-0.1, 0.1], "1 kg", np.nan])
def test_a_faulty_speed_is_refused(speed: Any) -> None:
    with pytest.raises(ValueError, match="speed"):
        cl.normal_impact(cl.Newton(), speed, mass=MASS)
