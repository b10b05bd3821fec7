"""Contact questions have the answers of closed forms, and laws those answers."""

from math import isclose, pi, sqrt

import numpy as np
import pytest
from support.command_line import Command
from support.tensile_dashpot import TensileDashpot

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab_data.studies.bench.questions import Case, errors_of, questions
from contactlab_data.studies.bench.responses import responses_of
from contactlab_data.studies.bench.study import Bench

CASES = questions()[0]
HERTZ = cl.Composed(damping=cl.Flores())

TOLERANCE = {"poisson": 1e-6, "composed": 1e-3}
"""Of answers, absolute. A compliant ball is in contact for a while, and is still later: 1e-4 s in 0.4 s."""


def of(question: str, quantity: str) -> list[Case]:
    return [case for case in CASES if (case.question, case.quantity) == (question, quantity)]


def exact(question: str, quantity: str) -> list[float]:
    return [case.exact for case in of(question, quantity)]


def test_exact_answers_are_those_derived_by_another_way() -> None:
    assert exact("slide", "velocity") == pytest.approx([0.1 * 0.5 * 9.81])
    # Of the ball with e = 1/2 the bounces last 1, 1/2, 1/4 ... of the first fall's time twice.
    fall = sqrt(0.2 / 9.81)
    time = fall + 2.0 * fall * sum(0.5**i for i in range(1, 6))
    up = 9.81 * fall * 0.5**6
    # Down through the threshold: the larger root of up t - g t^2 / 2 = 10 um.
    time += (up + sqrt(up**2 - 2.0 * 9.81 * 1e-5)) / 9.81
    assert exact("rest", "time") == pytest.approx([time], rel=1e-12)
    assert exact("belt", "period") == pytest.approx([0.2 * pi])


def test_the_energy_of_an_oblique_ball_follows_from_its_velocities() -> None:
    for case in of("oblique", "energy"):
        numbers = case.numbers
        m, inertia, radius = numbers["mass"], numbers["inertia"], numbers["radius"]
        normal = (1.0 + numbers["restitution"]) * m * numbers["down"]
        along = numbers["along"] - numbers["friction"] * normal / m
        turning = numbers["friction"] * normal * radius / inertia
        if along < turning * radius:
            # It rolls: the angular momentum about the contact is kept.
            along = m * radius**2 * numbers["along"] / (inertia + m * radius**2)
            turning = along / radius
        up = numbers["restitution"] * numbers["down"]
        energy = (m * (along**2 + up**2) + inertia * turning**2) / (m * numbers["speed"] ** 2)
        assert isclose(energy, case.exact, rel_tol=1e-12)


def test_the_delassus_matrix_of_kanes_pendulum_is_that_of_its_mass_matrix() -> None:
    for case in of("kane", "energy"):
        numbers = case.numbers
        tilts = np.deg2rad([numbers["tilt_1"], numbers["tilt_2"]])
        cos = np.cos(tilts[0] - tilts[1])
        mass = np.array([[4.0 / 3.0, 0.5 * cos], [0.5 * cos, 1.0 / 3.0]])
        rates = np.array([numbers["rate_1"], numbers["rate_2"]])
        jacobian = np.array([np.sin(tilts), np.cos(tilts)])
        delassus = jacobian @ np.linalg.inv(mass) @ jacobian.T
        np.testing.assert_allclose(
            [numbers[name] for name in ("nn", "nt", "tt")], delassus[[0, 0, 1], [0, 1, 1]], rtol=1e-12
        )
        np.testing.assert_allclose([numbers["rate"], numbers["slip"]], jacobian @ rates, rtol=1e-12)
        assert numbers["kinetic"] == pytest.approx(0.5 * rates @ mass @ rates, rel=1e-12)


def test_painleves_rod_is_beyond_the_paradox() -> None:
    numbers = of("jam", "slip")[0].numbers
    assert numbers["nn"] - numbers["friction"] * numbers["nt"] < 0.0 < numbers["slip"]
    assert numbers["friction"] > numbers["nt"] / numbers["tt"] > 0.0


@pytest.mark.parametrize("law", [cl.Poisson(), HERTZ], ids=lambda law: law.name)
def test_laws_have_the_exact_answers(law: cl.ContactLaw) -> None:
    responses, seconds = responses_of(law)
    for case, response in zip(CASES, responses, strict=True):
        if np.isnan(case.exact):
            assert response <= 1.0, case
        else:
            assert response == pytest.approx(case.exact, rel=0.0, abs=TOLERANCE[law.name]), case
    assert (seconds > 0.0).all()


def test_newton_creates_energy_of_rods_and_has_exact_answers_else() -> None:
    responses, _ = responses_of(cl.Newton())
    gains = {case.question: x - 1.0 for case, x in zip(CASES, responses, strict=True) if x > 1.0 + 1e-9}
    assert {"rod", "kane"} == {name for name in gains if name in ("rod", "kane", "jam", "oblique")}
    errors = {variable.name: x for variable, x in errors_of(responses).items()}
    assert errors.pop("energy_created") > 1.0
    assert max(errors.values()) < 1e-6


def test_the_error_is_that_of_the_answers() -> None:
    responses = np.array([case.exact for case in CASES])
    wrong = responses + np.array([0.02 * (case.question == "rebound") for case in CASES])
    wrong[[case.question == "belt" for case in CASES]] *= 1.5
    errors = {variable.name: x for variable, x in errors_of(wrong).items()}
    assert errors["restitution"] == pytest.approx(0.02)
    assert [errors["stick_slip_amplitude"], errors["stick_slip_period"]] == pytest.approx([0.5, 0.5])
    assert errors["creep"] == errors["drift"] == 0.0
    missing = np.where([case.question == "creep" for case in CASES], np.nan, responses)
    assert [variable.name for variable, x in errors_of(missing).items() if np.isnan(x)] == ["creep"]


def test_a_law_without_a_restitution_answers_the_rest() -> None:
    responses, _ = responses_of(cl.LagrangeStick())
    silent = {case.question for case, x in zip(CASES, responses, strict=True) if np.isnan(x)}
    assert silent == {"rebound", "oblique", "rod", "jam", "kane", "rest"}


def test_a_law_of_ones_own_gets_the_restitution_by_the_number_that_has_it() -> None:
    responses, _ = responses_of(TensileDashpot(1e7, 10.0))
    (rebounds,) = [[x for case, x in zip(CASES, responses, strict=True) if case.question == "rebound"]]
    np.testing.assert_allclose(rebounds, 0.8, rtol=1e-7)


def test_the_verb_says_which_law_creates_energy(command: Command) -> None:
    status, out, _ = command("bench", "law=newton,poisson", "output=asked")
    assert status == 0
    result = cl.load("asked/bench.nc")
    assert (
        result.numbers["newton.energy_created"].value > 1.0 > result.numbers["poisson.energy_created"].value
    )
    assert result.numbers["newton.seconds"].value > 0.0
    assert "newton" in out


def test_laws_made_in_python_are_asked() -> None:
    result = cl.bench([cl.Poisson(), TensileDashpot(1e7, 10.0)])
    assert result.numbers["poisson.energy_created"].value == 0.0
    assert result.numbers["tensile_dashpot.restitution"].value < 1e-7


def test_without_a_law_there_is_no_answer(command: Command) -> None:
    with pytest.raises(ConfigurationError, match="law"):
        Bench()({})
    status, _, err = command("bench")
    assert (status, len(err.splitlines())) == (2, 1)
