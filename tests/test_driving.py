"""A law on a prescribed path, against closed forms and integrations of this module's own."""

from itertools import pairwise
from math import acos, pi, tanh
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from support.command_line import cases

import contactlab as cl
from contactlab.driving import DEGREE, Frame, LawOnPath, integrated
from contactlab.laws.registry import origins, own
from contactlab.parameter import declared_fields
from contactlab.studies.drive import Driven
from contactlab.testing.plants import Evaluator

DURATION = 1e-3
TIME = np.linspace(0.0, DURATION, 2001)
TURN = 2.0 * pi / DURATION

HERTZ = cl.HertzPenalty(stiffness=1e10, friction_coefficient=0.3)


def mean(integrals: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Means over the record intervals of what was integrated up to the records."""
    return np.diff(integrals) / np.diff(time)


def test_the_motion_is_the_path_and_the_force_that_of_the_gap() -> None:
    def gap(t):
        return 0.2e-6 - 1e-6 * np.sin(0.5 * TURN * t)

    run = cl.drive(HERTZ, TIME, gap=gap(TIME), slip=1e-6 * np.sin(2.0 * TURN * TIME), degree=7)
    assert run.complete
    time = run["time"].values
    np.testing.assert_allclose(run["gap"], gap(time), rtol=0.0, atol=1e-19)
    (contact,) = (run.contacts["start_time"].values,)
    np.testing.assert_allclose(contact, np.arcsin(0.2) / (0.5 * TURN), rtol=1e-12)
    some = slice(100, 120)
    expected = [
        quad(lambda t: 1e10 * max(-gap(t), 0.0) ** 1.5, a, b, epsabs=0.0, epsrel=1e-12)[0] / (b - a)
        for a, b in pairwise(time[some])
    ]
    np.testing.assert_allclose(run["normal_force"][some][1:], expected, rtol=1e-12)
    work = float(run["drive_work"][-1])
    assert abs(float(run["energy_residual"][-1])) < 1e-12 * work
    # All that comes in is lost by friction: elastic contact gives back the rest.
    np.testing.assert_allclose(run["friction_loss"][-1], work, rtol=1e-12)


def test_coulomb_loses_four_times_mu_n_x_in_a_cycle() -> None:
    way = 1e-3 * np.sin(TURN * TIME)
    run = cl.drive(
        HERTZ, TIME[:-1], gap=-1e-6, slip=way[:-1], degree=7, period=DURATION, duration=3 * DURATION
    )
    np.testing.assert_allclose(run["friction_loss"][-1], 3 * 4 * 0.3 * 10.0 * 1e-3, rtol=1e-9)
    assert set(run["contact_mode"].values.tolist()) == {1}


def test_a_velocity_in_place_of_the_slip() -> None:
    """Its integral has an error of fourth order, which is stated, and the loop that of the slip."""
    time = np.linspace(0.0, 1.0, 81)
    law = cl.Composed(friction=cl.Dahl(friction_coefficient=0.3, rest_stiffness=1e6))
    way, speed = 1e-6 * np.sin(2.0 * pi * time), 2e-6 * pi * np.cos(2.0 * pi * time)
    slip, text = integrated(time, speed)
    stated = float(text.split("differs by ")[1].split(" m")[0])
    assert np.abs(slip - way).max() < stated < 1e-4 * 1e-6
    path: dict[str, Any] = {"normal": 10.0, "frame_stiffness": 2e6}
    by_slip, by_speed = cl.drive(law, time, slip=way, **path), cl.drive(law, time, velocity=speed, **path)
    np.testing.assert_allclose(by_speed["friction_force"], by_slip["friction_force"], rtol=0.0, atol=3e-4)
    steady = cl.drive(HERTZ, time, gap=-1e-6, velocity=1e-3)
    assert float(steady["friction_loss"][-1]) == pytest.approx(0.3 * 10.0 * 1e-3, rel=1e-9)
    with pytest.raises(ValueError, match="velocity"):
        cl.drive(HERTZ, time, gap=-1e-6, slip=way, velocity=speed)


def test_the_default_spline_keeps_a_sampled_sine() -> None:
    """F = -mu N sign(v) - sigma v of 40 samples of a sine, and 4 mu N X + pi sigma X^2 omega a cycle."""
    load, mu, sigma, size, omega = 10.0, 0.3, 20.0, 1e-2, 2.0 * np.pi * 10.0
    time = np.linspace(0.0, 0.1, 41)
    law = cl.Composed(friction=cl.Coulomb(mu), viscous_friction=sigma)
    path: dict[str, Any] = {"normal": load, "slip": size * np.sin(omega * time + 0.3)}
    run = cl.drive(law, time, **path, record_interval=2.5e-5)
    records = run["time"].values
    speed = size * omega * np.cos(omega * 0.5 * (records[1:] + records[:-1]) + 0.3)
    slides = abs(speed) > 0.02 * size * omega
    expected = -mu * load * np.sign(speed) - sigma * speed
    error = (run["friction_force"].values[1:] - expected)[slides]
    assert abs(error).max() < 3e-7 * abs(expected).max()
    loss = 4.0 * mu * load * size + np.pi * sigma * size**2 * omega
    np.testing.assert_allclose(run["friction_loss"][-1], loss, rtol=1e-9)
    assert declared_fields(Driven)["degree"].default == DEGREE


def test_the_work_of_a_path_is_that_in_a_turned_frame() -> None:
    """Turned samples are the turned path; N n' + F t' of forces turned back is the same power."""
    c, s = np.cos(0.3), np.sin(0.3)
    normal, along = -1e-6 * TIME / DURATION, 1e-6 * np.sin(TURN * TIME)
    run = cl.drive(HERTZ, TIME, gap=c * normal - s * along - 1e-6, slip=s * normal + c * along, degree=1)
    push, rub = run["normal_force"].values[1:], run["friction_force"].values[1:]
    # Records are at the samples, between which the path is straight: mean forces times the way are the work.
    np.testing.assert_allclose(run["time"], TIME, atol=1e-15)
    work = (c * push + s * rub) @ np.diff(normal) + (c * rub - s * push) @ np.diff(along)
    np.testing.assert_allclose(run["drive_work"][-1], -work, rtol=1e-9)


@pytest.mark.parametrize("degree", [1, 3, 7])
def test_a_slip_turns_half_way_between_two_samples(degree: int) -> None:
    """There steps of powers of two end on the reversal but for the last digit of the clock."""
    time = np.linspace(-DURATION / 6.0, 7.0 * DURATION / 6.0, 2001)
    way = 1e-3 * np.sin(2.0 * TURN * time)
    run = cl.drive(HERTZ, time, gap=-1e-6, slip=way, degree=degree)
    assert run.complete
    # The way of a full swing of each period, and what comes before and after.
    length = quad(
        lambda t: abs(2e-3 * TURN * np.cos(2.0 * TURN * t)),
        time[0],
        time[-1],
        limit=500,
        points=np.arange(-1, 10) * DURATION / 8,
    )[0]
    np.testing.assert_allclose(
        run["friction_loss"][-1], 0.3 * 10.0 * length, rtol={1: 1e-4, 3: 1e-7, 7: 1e-9}[degree]
    )


def test_the_loop_of_dahl() -> None:
    """Settled, i = 1: the loss of a cycle is 4 F_c (X - F_c/sigma tanh(sigma X/F_c))."""
    law, amplitude = cl.Composed(friction=cl.Dahl(friction_coefficient=0.3, rest_stiffness=1e6)), 1e-6
    way = amplitude * np.sin(TURN * TIME[:-1])
    run = cl.drive(law, TIME[:-1], gap=-1e-6, slip=way, degree=7, period=DURATION, duration=8 * DURATION)
    normal, loss = float(run["normal_force"][-1]), run["friction_loss"].values
    energy = run["contact_energy"].values
    most, length = 0.3 * normal, 0.3 / 1e6
    count = (loss.size - 1) // 8
    last = loss[-1] - loss[-1 - count] + energy[-1] - energy[-1 - count]
    expected = 4.0 * most * (amplitude - length * tanh(amplitude / length))
    np.testing.assert_allclose(last, expected, rtol=1e-9)


def test_velocity_steps_of_rate_and_state() -> None:
    """Dieterich's ageing law: theta = D/v + (theta_0 - D/v) exp(-v t/D) at a velocity v."""
    a, b, distance, v0, mu = 0.01, 0.015, 1e-5, 1e-6, 0.6
    friction = cl.RateAndState(
        friction_coefficient=mu,
        direct_effect=a,
        evolution_effect=b,
        renewal_distance=distance,
        reference_velocity=v0,
        fresh_age=10.0,
        creep_velocity=1e-12,
    )
    time = np.array([0.0, 20.0, 30.0, 60.0])
    slow, fast = 1e-6, 1e-5
    way = np.array([0.0, 20.0 * slow, 20.0 * slow + 10.0 * fast, 50.0 * slow + 10.0 * fast])
    run = cl.drive(cl.Composed(friction=friction), time, gap=-1e-6, slip=way, degree=1, record_interval=0.05)

    theta, begins, ages = 10.0, 0.0, []
    for velocity, length in ((slow, 20.0), (fast, 10.0), (slow, 30.0)):
        steady, first = distance / velocity, theta
        ages.append(
            (
                begins,
                velocity,
                lambda t, s=steady, f=first, v=velocity: s + (f - s) * np.exp(-v * t / distance),
            )
        )
        theta, begins = ages[-1][2](length), begins + length
    recorded = run["time"].values
    for (start, _, age), end in zip(ages, (20.0, 30.0, 60.0), strict=True):
        inside = (recorded > start + 1e-9) & (recorded < end - 1e-9)
        expected = np.log(v0 * age(recorded[inside] - start) / distance)
        np.testing.assert_allclose(run["internal_age"].values[inside], expected, atol=1e-9)
    # The asinh of such a slip is the logarithm to 1e-16.
    ratio = -run["friction_force"].values[-1] / run["normal_force"].values[-1]
    middle = ages[-1][2](30.0 - 0.5 * 0.05)
    expected = mu + a * np.log(slow / v0) + b * np.log(v0 * middle / distance)
    np.testing.assert_allclose(ratio, expected, rtol=1e-8)


def test_relaxation_of_a_lining_at_a_held_gap() -> None:
    """Pressed in at once at t_0, N = k_inf d + k_1 d exp(-(t - t_0)/tau)."""
    law = cl.Composed(normal=cl.Prony(relaxed_stiffness=5e6, first_stiffness=5e6, first_time=1e-4))
    rise, depth = 1e-9, 1e-6
    time = np.array([0.0, rise, DURATION])
    run = cl.drive(law, time, gap=np.array([0.0, -depth, -depth]), degree=1, record_interval=1e-5)
    recorded = run["time"].values
    # The ramp creeps a little: its dashpot has gone rise/(2 tau) of the way to first order.
    expected = 5e6 * depth * (1.0 + 1e-4 / rise * -np.expm1(-rise / 1e-4) * np.exp(-(recorded - rise) / 1e-4))
    centres = [
        quad(
            lambda t: (
                5e6 * depth * (1.0 + 1e-4 / rise * -np.expm1(-rise / 1e-4) * np.exp(-(t - rise) / 1e-4))
            ),
            p,
            q,
        )[0]
        / (q - p)
        for p, q in pairwise(recorded[1:])
    ]
    assert expected[-1] < expected[1]
    np.testing.assert_allclose(run["normal_force"].values[2:], centres, rtol=1e-9)


def test_an_adhesive_contact_begins_at_the_touch_and_breaks_on_its_neck() -> None:
    law = cl.Composed(
        normal=cl.Jkr(radius=1e-3, effective_modulus=1e10, work_of_adhesion=0.05),
        friction=cl.Cohesive(friction_coefficient=0.0),
    )
    gap = 1e-7 * np.cos(TURN * TIME) + 0.2e-7
    run = cl.drive(law, TIME, gap=gap, degree=7)
    touch = 2.0 * pi * 0.05 * 1e-3
    length = (touch * 1e-3 / 1e10) ** (2.0 / 3.0) / 1e-3
    neck = 0.75 * 4.0 ** (-1.0 / 3.0) * length
    begins = acos(-0.2) / TURN
    ends = (2.0 * pi - acos((neck - 0.2e-7) / 1e-7)) / TURN
    np.testing.assert_allclose(run.contacts["start_time"].values, [begins], rtol=1e-10)
    np.testing.assert_allclose(run.contacts["duration"].values, [ends - begins], rtol=1e-9)
    # What is lost does not depend on the speed.
    loss = float(run["contact_loss"][-1])
    np.testing.assert_allclose(loss, 7.09 * (0.05**5 * 1e-3**4 / 1e10**2) ** (1.0 / 3.0), rtol=1e-3)


@pytest.mark.parametrize(
    "friction",
    [cl.Dahl(), cl.LuGre(), cl.ElastoPlastic(), cl.BoucWen(), cl.Regularised(), cl.RateAndState()],
    ids=lambda friction: friction.name,
)
def test_friction_on_a_path_of_two_tones(friction: cl.Friction) -> None:
    """Against an integration of its own, reversal by reversal; the gap swings besides."""
    law = cl.Composed(friction=friction)

    def gap(t):
        return -1e-6 * (0.6 - 0.35 * np.cos(TURN * t))

    def slip(t):
        return 1e-6 * np.sin(2.0 * TURN * t) + 0.3e-6 * np.sin(3.0 * TURN * t + 0.3)

    def velocity(t):
        return 2e-6 * TURN * np.cos(2.0 * TURN * t) + 0.9e-6 * TURN * np.cos(3.0 * TURN * t + 0.3)

    run = cl.drive(law, TIME, gap=gap(TIME), slip=slip(TIME), degree=7)
    time = run["time"].values
    fine = np.linspace(0.0, DURATION, 20001)
    turns = np.flatnonzero(velocity(fine[1:]) * velocity(fine[:-1]) < 0.0)
    edges = [0.0, *(brentq(velocity, fine[i], fine[i + 1], xtol=1e-18) for i in turns), DURATION]
    evaluator = Evaluator(law)

    def rates(t, y):
        at, kept = (gap(t), 0.0, velocity(t)), y[:-1]
        normal = evaluator.force(*at, 0.0, kept)[0]
        return [*evaluator.rates(*at, normal, kept), evaluator.friction(*at, normal, kept)[0]]

    impulse, state = np.zeros(time.size), np.append(evaluator.initial, 0.0)
    # Next to a reversal friction may change within femtoseconds, which a step must not pass over.
    near = np.geomspace(1e-15, 5e-7, 40)
    for begins, ends in pairwise(edges):
        inside = time[(time > begins) & (time < ends)]
        stops = np.unique([begins, *(begins + near), *inside, *(ends - near), ends])
        for start, end in pairwise(stops[(stops >= begins) & (stops <= ends)]):
            first = 0.25 * (end - start)
            flow = solve_ivp(
                rates, (start, end), state, method="DOP853", rtol=1e-13, atol=1e-25, first_step=first
            )
            state = flow.y[:, -1]
            impulse[time == end] = state[-1]
    expected = mean(impulse, time)
    np.testing.assert_allclose(
        run["friction_force"][1:], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
    )


@pytest.mark.parametrize("law", [cl.LagrangeSlip(0.3), cl.LagrangeStick(0.3), cl.Newton(restitution=0.5)])
def test_a_rigid_law_under_a_prescribed_load(law: cl.ContactLaw) -> None:
    """It has that normal force, and loses mu int N |v| dt."""

    def load(t):
        return 10.0 + 5.0 * np.cos(TURN * t)

    def velocity(t):
        return 1e-3 * TURN * np.cos(TURN * t)

    run = cl.drive(law, TIME, normal=load(TIME), slip=1e-3 * np.sin(TURN * TIME), degree=7)
    assert run.complete
    time = run["time"].values
    expected = mean(10.0 * time + 5.0 / TURN * np.sin(TURN * time), time)
    np.testing.assert_allclose(run["normal_force"][1:], expected, rtol=1e-9)
    lost = 0.3 * sum(
        abs(quad(lambda t: load(t) * velocity(t), a, b, epsrel=1e-12)[0])
        for a, b in pairwise(np.array([0.0, 0.25, 0.75, 1.0]) * DURATION)
    )
    np.testing.assert_allclose(run["friction_loss"][-1], lost, rtol=1e-9)


@pytest.mark.parametrize(
    ("law", "path", "key"),
    [
        (HERTZ, {}, "gap"),
        (cl.Composed(damping=cl.HuntCrossley()), {"normal": 1.0 + TIME}, "gap"),
        (cl.Composed(normal=cl.Prony()), {"normal": 1.0}, "gap"),
        (HERTZ, {"gap": -1e-6, "normal": 1.0}, "normal"),
        (cl.LagrangeStick(), {"gap": -1e-6}, "normal"),
        (cl.LagrangeStick(), {"normal": -1.0}, "normal"),
        (HERTZ, {"gap": TIME[1:]}, "gap"),
        (HERTZ, {"gap": -1e-6, "slip": TIME[1:]}, "slip"),
    ],
)
def test_a_path_of_another_kind_is_refused(law: cl.ContactLaw, path: dict[str, float], key: str) -> None:
    with pytest.raises(ValueError, match=key):
        cl.drive(law, TIME, **path)


@pytest.mark.parametrize("name", cases(own("damping"), {"tsuji", "hunt_crossley"}))
def test_a_constant_load_has_a_gap_under_a_law_with_damping(name: str) -> None:
    law = cl.build(["law=composed", f"law/damping={name}"]).law
    run = cl.drive(law, TIME, normal=5.0, slip=1e-3 * np.sin(TURN * TIME))
    # Constant to round-off, the rate of which a damping by the speed of impact enlarges.
    np.testing.assert_allclose(run["gap"], run["gap"][0], rtol=1e-13)
    np.testing.assert_allclose(run["normal_force"][1:], 5.0, rtol=1e-10)
    assert abs(float(run["contact_loss"][-1])) < 1e-15 * float(run["friction_loss"][-1])


def test_a_compliant_law_has_the_normal_force_that_is_prescribed() -> None:
    """Mindlin's spring, released: what the normal force can no longer hold is lost."""
    law = cl.Composed(friction=cl.Mindlin(friction_coefficient=0.3))
    time = TIME / DURATION
    run = cl.drive(law, TIME, normal=10.0 - 9.0 * time, slip=1e-7 * time, degree=7)
    load = 10.0 - 9.0 * 0.5 * (time[1:] + time[:-1])
    np.testing.assert_allclose(run["normal_force"].values[1:], load, rtol=1e-9)
    assert (np.abs(run["friction_force"].values[1:]) <= 0.3 * load * (1.0 + 1e-9)).all()
    assert {1, 2} <= set(run["contact_mode"].values.tolist())
    assert abs(float(run["energy_residual"][-1])) < 1e-11 * float(run["contact_energy"].max())


def test_a_waveform_is_the_path_of_its_samples() -> None:
    way = 1e-6 * np.sin(TURN * TIME)
    wave = cl.Waveform.sampled(TIME, way[None], 7)
    law = cl.Composed(friction=cl.Dahl())
    sampled, made = (cl.drive(law, TIME, gap=-1e-6, slip=path, degree=7) for path in (way, wave))
    np.testing.assert_allclose(made["friction_force"], sampled["friction_force"], rtol=1e-9, atol=1e-12)


def test_a_run_is_saved_read_and_drawn(tmp_path) -> None:
    law = cl.Composed(friction=cl.Mindlin())
    run = cl.drive(law, TIME, gap=-1e-6, slip=1e-6 * np.sin(TURN * TIME))
    run.save(tmp_path / "loop.nc")
    read = cl.load(tmp_path / "loop.nc")
    np.testing.assert_array_equal(read["friction_force"], run["friction_force"])
    assert read.attrs["prescribed"] == "gap"
    assert len(read.plot().axes) == 4


def every_law() -> list[tuple[str, ...]]:
    """Overrides of each law and of each part of a composed one; a pull has a friction of its own."""
    laws = [(f"law={each.name}",) for each in origins("")]
    parts = [
        ("law=composed", f"law/{family}={each.name}", *PULLS.get(each.name, ()))
        for family in ("normal", "damping", "friction")
        for each in origins(family)
    ]
    return laws + parts


PULLS = dict.fromkeys(("jkr", "dmt", "maugis"), ("law/friction=cohesive",))


@pytest.mark.parametrize("overrides", every_law(), ids=" ".join)
def test_the_work_of_a_path_is_stored_or_lost_by_every_law(overrides: tuple[str, ...]) -> None:
    law = cl.build([*overrides]).law
    swing = 0.6 - 0.35 * np.cos(TURN * TIME)
    path = {"gap": 0.1e-6 - 0.2e-6 * swing} if isinstance(law, cl.PenaltyLaw) else {"normal": 10.0 * swing}
    way = 1e-6 * np.sin(2.0 * TURN * TIME) + 0.3e-6 * np.sin(3.0 * TURN * TIME + 0.3)
    run = cl.drive(law, TIME, slip=way, degree=7, **path)
    assert run.complete
    # What a lining that relaxes turns over besides is not in the work.
    assert abs(float(run["energy_residual"][-1])) < 1e-11 * abs(float(run["drive_work"][-1]))
    assert float(run["friction_loss"][-1]) > 0.0


@pytest.mark.parametrize("seed", cases(range(200), range(8)))
def test_dahl_on_random_paths_is_its_closed_form_from_reversal_to_reversal(seed: int) -> None:
    """F = -N sigma z, and over a way x without a reversal z = s m + (z_0 - s m) exp(-|x|/m), m = mu/sigma."""
    draws = np.random.default_rng(seed)
    count = int(draws.integers(1, 6))
    frequencies, phases = draws.uniform(1.0, 6.0, count), draws.uniform(0.0, 2.0 * pi, count)
    sizes = 10.0 ** draws.uniform(-7.0, -5.5, count)
    stiffness, mu, depth = (
        10.0 ** draws.uniform(5.0, 7.0),
        draws.uniform(0.05, 0.8),
        10.0 ** draws.uniform(-7.0, -5.5),
    )

    def way(t, order=0):
        turns = TURN * frequencies
        return (sizes * turns**order * np.sin(np.multiply.outer(t, turns) + phases + 0.5 * pi * order)).sum(
            -1
        )

    fine = np.linspace(0.0, DURATION, 20001)
    speeds = way(fine, 1)
    turns = [
        brentq(lambda t: way(t, 1), *fine[i : i + 2], xtol=1e-20)
        for i in np.flatnonzero(speeds[1:] * speeds[:-1] < 0.0)
    ]
    law = cl.Composed(friction=cl.Dahl(friction_coefficient=mu, rest_stiffness=stiffness))
    run = cl.drive(law, TIME, gap=-depth, slip=way(TIME), degree=7)

    time, most = run["time"].values, mu / stiffness
    expected, last, z = np.zeros(time.size), 0.0, 0.0
    for end in (*turns, DURATION):
        inside = (time > last) & (time <= end)
        side = np.sign(way(end) - way(last))

        def deflection(t, last=last, z=z, side=side):
            return side * most + (z - side * most) * np.exp(-np.abs(way(t) - way(last)) / most)

        expected[inside] = deflection(time[inside])
        last, z = end, float(deflection(end))
    np.testing.assert_allclose(
        run["internal_deflection"].values[1:], expected[1:], rtol=0.0, atol=1e-9 * most
    )


@pytest.mark.parametrize(
    "law", [cl.LagrangeStick(0.3), cl.Composed(friction=cl.Coulomb(0.3))], ids=lambda law: law.name
)
def test_rigid_friction_behind_a_frame_is_a_jenkins_element(law: cl.ContactLaw) -> None:
    """A cycle of amplitude X loses 4 mu N (X - mu N/k), and sticks for as long as the spring turns over."""
    load, size, stiffness = 10.0, 1e-5, 1e6
    path = {"normal": load, "slip": size * np.sin(TURN * TIME[:-1]), "progress": (reached := []).append}
    run = cl.drive(law, TIME[:-1], **path, period=DURATION, duration=3 * DURATION, frame_stiffness=stiffness)
    assert run.complete
    assert reached == [pytest.approx(3 * DURATION)]
    loss = run["friction_loss"].values
    once = (loss.size - 1) // 3
    reach = 0.3 * load / stiffness
    np.testing.assert_allclose(loss[-1] - loss[-1 - once], 4.0 * 0.3 * load * (size - reach), rtol=1e-9)
    # It sticks at first for asin(reach / X), after each of the six reversals for acos(1 - 2 reach / X).
    sticks = (np.arcsin(reach / size) + 6.0 * np.arccos(1.0 - 2.0 * reach / size)) / TURN
    # The last reversal, at 2.75 periods, has 0.25 periods left.
    np.testing.assert_allclose(run.contacts["stick_duration"], [sticks], rtol=1e-9)
    assert abs(float(run["energy_residual"][-1])) < 1e-10 * loss[-1]


def test_a_spring_of_the_contact_and_a_frame_are_in_series() -> None:
    """F = -x k k_0 / (k + k_0) of a stretched contact, with k_0 = kappa dN/dd = 1.5 kappa N/d of a sphere."""
    law = cl.Composed(cl.HertzPoint(1e10), friction=cl.Mindlin(0.3, stiffness_ratio=0.8))
    reach, stiffness = 1e-8, 3e6
    path = {"normal": 10.0, "slip": reach * TIME / DURATION}
    run = cl.drive(law, TIME, **path, degree=1, frame_stiffness=stiffness)
    own = 0.8 * 1.5 * 10.0 / 1e-6
    middle = reach * 0.5 * (TIME[1:] + TIME[:-1]) / DURATION
    expected = -middle * own * stiffness / (own + stiffness)
    np.testing.assert_allclose(run["friction_force"].values[1:], expected, rtol=1e-8)


A, B, DISTANCE, V0, MU, LOAD = 0.01, 0.013, 1e-5, 1e-6, 0.6, 10.0
ROCK = cl.Composed(
    friction=cl.RateAndState(MU, A, B, DISTANCE, V0, fresh_age=DISTANCE / V0, creep_velocity=1e-14)
)
CRITICAL = (B - A) * LOAD / DISTANCE
"""Of steady sliding under the ageing law: Ruina (1983)."""


def test_velocity_steps_of_rate_and_state_behind_a_frame() -> None:
    """Against the literature's two equations, integrated by SciPy: the slip follows from spring and age."""
    stiffness, speeds, edges = 3.0 * CRITICAL, (V0, 10.0 * V0, V0), np.array([0.0, 10.0, 20.0, 40.0])
    way = np.append(0.0, np.cumsum(speeds * np.diff(edges)))
    instants = np.linspace(0.05, 39.95, 400)

    def rates(_, y, pull):
        slip = 2.0 * V0 * np.sinh(y[0] / (LOAD * A)) * np.exp(-(MU + B * y[1]) / A)
        return [stiffness * (pull - slip), (V0 * np.exp(-y[1]) - slip) / DISTANCE]

    expected, state = np.zeros(instants.size), [MU * LOAD, 0.0]
    for pull, begin, end in zip(speeds, edges[:-1], edges[1:], strict=True):
        inside = (instants > begin) & (instants <= end)
        stops = np.unique(np.append(instants[inside], end))
        flow = solve_ivp(rates, (begin, end), state, "LSODA", stops, args=(pull,), rtol=1e-11, atol=1e-12)
        expected[inside], state = flow.y[0][: inside.sum()], flow.y[:, -1]
    for tolerance in (1e-5, 1e-7, 1e-9):
        loop = LawOnPath(
            ROCK,
            edges,
            normal=LOAD,
            slip=way,
            degree=1,
            frame=Frame(stiffness, force=MU * LOAD),
            instants=instants,
            tolerance=tolerance,
        )
        loop.run(ROCK)
        error = np.abs(loop.path.forces[:, 1] + expected).max() / (MU * LOAD)
        assert error < max(10.0 * tolerance, 1e-9)


def test_a_frame_below_the_critical_stiffness_ends_the_run() -> None:
    edges, way = np.array([0.0, 10.0, 60.0]), np.array([0.0, 1e-5, 51e-5])
    path: dict[str, Any] = {"normal": LOAD, "slip": way, "degree": 1}
    ends = [
        cl.drive(ROCK, edges, **path, frame_stiffness=share * CRITICAL, frame_force=MU * LOAD).ending
        for share in (0.3, 5.0)
    ]
    assert ends == [cl.Ending.STALLED, cl.Ending.COMPLETE]
    loop = LawOnPath(ROCK, edges, **path, frame=Frame(0.3 * CRITICAL, force=MU * LOAD))
    loop.run(ROCK)
    assert loop.critical_stiffness() == pytest.approx(CRITICAL, rel=1e-4)


FRICTIONS = [
    *(cl.LuGre(), cl.Dahl(), cl.BoucWen(), cl.ElastoPlastic(), cl.Mindlin(0.3), cl.Iwan(), cl.Microslip()),
    *(cl.Regularised(), cl.Coulomb(0.3)),
]


@pytest.mark.parametrize("damping", [0.0, 3e2])
@pytest.mark.parametrize("friction", FRICTIONS, ids=lambda friction: friction.name)
def test_the_ledger_behind_a_frame_closes(friction: cl.Friction, damping: float) -> None:
    """In a loop with a minor one, of few and of many samples."""
    law = cl.Composed(friction=friction)
    for count, size, stiffness in ((41, 1e-6, 2e6), (401, 1e-5, 2e6), (401, 1e-4, 3e5)):
        time = np.linspace(0.0, 1.0, count)
        way = size * (np.sin(2.0 * pi * time) + 0.4 * np.sin(4.0 * pi * time))
        frame = {"frame_stiffness": stiffness, "frame_damping": damping}
        run = cl.drive(law, time, normal=10.0, slip=way, **frame)
        assert run.complete
        assert np.abs(run["energy_residual"]).max() < 1e-9 * np.abs(run["drive_work"]).max()


@pytest.mark.parametrize("speed", [1e-3, 5e-2])
def test_coulomb_behind_a_spring_and_a_dashpot(speed: float) -> None:
    """It sticks until k v t + c v = mu N, then x' = v (1 - exp(-t k/c)); a fast one slips at once."""
    stiffness, damping, most = 1e5, 1e2, 3.0
    relaxation, until = damping / stiffness, (most / speed - damping) / stiffness
    time = np.linspace(0.0, 0.05, 11)
    law = cl.Composed(friction=cl.Coulomb(0.3))
    frame = {"frame_stiffness": stiffness, "frame_damping": damping}
    run = cl.drive(law, time, normal=10.0, slip=speed * time, degree=1, **frame)
    slides = run["time"].values - max(until, 0.0)
    # What of the damper's pull is above the cone is slip at the start.
    at_once = max(speed - most / damping, 0.0)
    decays = relaxation * -np.expm1(-slides / relaxation)
    expected = np.where(slides > 0.0, speed * slides - (speed - at_once) * decays, 0.0)
    way = run["tip_tangential_displacement"].values
    np.testing.assert_allclose(way, expected, rtol=0.0, atol=1e-8 * way.max())
    assert run.complete
    assert abs(float(run["energy_residual"][-1])) < 1e-10 * float(run["drive_work"][-1])


def test_dahl_behind_a_spring_and_a_dashpot_converges_to_two_equations_in_scipy() -> None:
    """c e' = N sigma z - k e, z' = v - |v| sigma z / mu, v = x_L' - e'."""
    stiffness, damping, load, sigma, mu, size = 4e5, 2e3, 10.0, 1e6, 0.3, 4e-6
    law = cl.Composed(friction=cl.Dahl(friction_coefficient=mu, rest_stiffness=sigma))
    instants = np.linspace(0.003, 0.997, 300)

    def rates(t, y):
        stretches = (load * sigma * y[1] - stiffness * y[0]) / damping
        slip = 2.0 * pi * size * np.cos(2.0 * pi * t) - stretches
        return [stretches, slip - abs(slip) * sigma * y[1] / mu]

    options: Any = {"method": "Radau", "rtol": 1e-11, "atol": 1e-19}
    expected = -load * sigma * solve_ivp(rates, (0.0, 1.0), [0.0, 0.0], t_eval=instants, **options).y[1]
    time = np.linspace(0.0, 1.0, 401)
    for tolerance in (1e-4, 1e-6, 1e-8):
        loop = LawOnPath(
            law,
            time,
            normal=load,
            slip=size * np.sin(2.0 * pi * time),
            frame=Frame(stiffness, damping),
            instants=instants,
            tolerance=tolerance,
        )
        loop.run(law)
        error = np.abs(loop.path.forces[:, 1] - expected).max() / (mu * load)
        assert error < max(10.0 * tolerance, 3e-9)


@pytest.mark.parametrize(("exponent", "steepest"), [(1.0, 1.0), (2.0, np.sqrt(2.0 / np.e))])
def test_friction_that_falls_takes_a_damping_whatever_the_stiffness(exponent: float, steepest: float) -> None:
    """Stribeck's curve falls by (mu_s - mu) N/v_s with the exponent 1, by sqrt(2/e) of that with 2."""
    law = cl.Composed(friction=cl.Stribeck(0.3, 1.3, 1e-2, exponent))
    critical = 0.3 * 0.3 * 10.0 / 1e-2 * steepest
    time = TIME / DURATION
    path: dict[str, Any] = {"normal": 10.0, "slip": 1e-2 * np.sin(2.0 * pi * time)}
    for stiffness in (1e5, 1e8):
        ends = [
            cl.drive(law, time, **path, frame_stiffness=stiffness, frame_damping=share * critical).complete
            for share in (0.0, 1.05)
        ]
        assert ends == [False, True]
    loop = LawOnPath(law, time, **path, frame=Frame(1e8))
    loop.run(law)
    assert loop.critical_damping() == pytest.approx(critical, rel=1e-4)


RESTS = (cl.Coulomb(0.4), cl.Mindlin(0.4), cl.Dahl(0.4), cl.Iwan(0.4), cl.BoucWen(0.4))


@pytest.mark.parametrize("frame", [None, Frame(4e4), Frame(4e4, damping=2.0)], ids=str)
@pytest.mark.parametrize("friction", RESTS, ids=lambda each: each.name)
def test_a_load_point_that_rests_changes_nothing_of_rate_independent_friction(
    friction: cl.Friction, frame: Frame | None
) -> None:
    """At rest at the start, and on the bound: the same forces as of the path without its holds."""
    law = cl.Composed(cl.Linear(1e6), friction=friction)
    time, way = np.array([0.0, 0.2, 0.5, 0.6, 0.9]), np.array([0.0, 0.0, 1e-4, 1e-4, -1e-4])
    wanted = np.array([0.1, 0.2, 0.29, 0.3, 0.33, 0.45, 0.6])
    settings: dict[str, Any] = {"normal": 5.0, "degree": 1, "frame": frame, "tolerance": 1e-9}
    loops = [
        LawOnPath(law, time, slip=way, instants=wanted + 0.2 + 0.1 * (wanted > 0.3), **settings),
        LawOnPath(law, np.array([0.0, 0.3, 0.6]), slip=way[[0, 2, 4]], instants=wanted, **settings),
    ]
    assert [int(loop.run(law)["ending"]) for loop in loops] == [0, 0]
    np.testing.assert_allclose(loops[0].path.forces, loops[1].path.forces, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(
    ("law", "frame", "key"),
    [
        (HERTZ, {"frame_damping": 1.0}, "frame_stiffness"),
        (HERTZ, {"frame_stiffness": 0.0}, "frame_stiffness"),
        (HERTZ, {"frame_stiffness": 1.0, "frame_damping": -1.0}, "frame_damping"),
        (HERTZ, {"frame_stiffness": 1.0, "gap": 1e-6}, "gap"),
        (HERTZ, {"frame_stiffness": 1.0, "tolerance": 0.0}, "tolerance"),
    ],
)
def test_a_frame_of_another_kind_is_refused(law: cl.ContactLaw, frame: dict[str, float], key: str) -> None:
    with pytest.raises(ValueError, match=key):
        cl.drive(law, TIME, **{"gap": -1e-6, **frame})


@pytest.mark.parametrize("load", [1e-3, 1.0, 33.0, 1e3])
def test_a_constant_load_has_the_depth_of_hertz_and_rings_that_fit_its_patch(load: float) -> None:
    """On a path d = (N/K)^(2/3), and n r = dN/dd = 1.5 N/d all along: no ring is outgrown."""
    friction = cl.Microslip(0.3, rings=10, first_ring=1.0)
    law, time = cl.Composed(cl.HertzPoint(1e10), friction=friction), np.linspace(0.0, 1.0, 41)
    slip, records = 1e-8 * np.sin(2.0 * np.pi * time), np.array([0.0, 0.5, 1.0])
    loop = LawOnPath(law, time, normal=load, slip=slip, records=records)
    loop.run(law)
    depth = (load / 1e10) ** (2.0 / 3.0)
    assert -loop.path.series["gap"] == pytest.approx(depth, rel=1e-12)
    assert 10.0 * loop.path.traces[:, -1] == pytest.approx(1.5 * load / depth, rel=1e-6)
