"""Contact questions have the answers of closed forms, and the page of simulators is that of its results."""

from math import isclose, pi, sqrt

import pytest
import simulator_page
import with_contactlab
from questions import Question, questions

ALL = [*questions()]

TOLERANCE = {"poisson": 1e-6, "hertz_point + flores + coulomb": 1e-3}
"""Of answers, absolute. A compliant ball is in contact for a while, and is still later: 1e-4 s in 0.4 s."""


def exact(name: str, quantity: str) -> list[float]:
    return [question.exact[quantity] for question in ALL if question.name == name]


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
    for question in (each for each in ALL if each.name == "oblique"):
        numbers = question.numbers
        thrown = with_contactlab.entrant.thrown(numbers)
        m, inertia, radius = numbers["mass"], numbers["inertia"], numbers["radius"]
        normal = (1.0 + numbers["restitution"]) * m * thrown["down"]
        along = thrown["along"] - numbers["friction"] * normal / m
        turning = numbers["friction"] * normal * radius / inertia
        if along < turning * radius:
            # It rolls: the angular momentum about the contact is kept.
            along = m * radius**2 * thrown["along"] / (inertia + m * radius**2)
            turning = along / radius
        up = numbers["restitution"] * thrown["down"]
        energy = (m * (along**2 + up**2) + inertia * turning**2) / (m * numbers["speed"] ** 2)
        assert isclose(energy, question.exact["energy"], rel_tol=1e-12)


@pytest.mark.parametrize("law", TOLERANCE)
@pytest.mark.parametrize("question", ALL, ids=lambda each: f"{each.name} {[*each.numbers.values()][-1]}")
def test_laws_of_contactlab_have_the_exact_answers(law: str, question: Question) -> None:
    values = with_contactlab.KINDS[question.kind](with_contactlab.SETTINGS[law], question.numbers)
    for name, value in question.exact.items():
        assert values[name] == pytest.approx(value, rel=0.0, abs=TOLERANCE[law])
    assert all(values[name] <= bound for name, bound in question.at_most.items())


def test_newton_creates_energy_in_the_impact_of_a_rod() -> None:
    rods = [question for question in ALL if question.name == "rod"]
    ratios = [with_contactlab.impact(with_contactlab.newton, rod.numbers)["energy"] for rod in rods]
    assert max(ratios) > 1.05


def test_the_page_is_that_of_the_results() -> None:
    page = simulator_page.PAGE.read_text(encoding="utf-8")
    assert page == simulator_page.page(), "python benchmarks/simulators/simulator_page.py"
    rows = simulator_page.results()["rows"]
    lines = [line for line in page.splitlines() if line.startswith(tuple(f"| {r['entrant']}:" for r in rows))]
    assert len(lines) == len(rows) > 10
