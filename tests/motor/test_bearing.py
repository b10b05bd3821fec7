"""Claims on a rotor that a bearing presses on the tip: closed forms, limits, and the ledger."""

from dataclasses import replace
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.engine.equilibrium import at_rest
from contactlab.motor.bodies import FLAT, block

SILENT = ["drive.voltage_1=0", "drive.voltage_2=0"]


def stiff(mass: float = 1e6) -> cl.Motor:
    """A resonator that hardly moves: a heavy body, against which the rotor bounces."""
    motor = block(mass)
    return cl.Motor(motor.modes, geometry=cl.ContactGeometry(FLAT, FLAT, 0.0), rotor=motor.rotor)


def test_a_pressed_rotor_indents_by_hertz() -> None:
    """P = k d^(3/2) at rest."""
    setup = cl.build(["contact.preload=5 N", "rotor.bearing_damping=2e3", *SILENT])
    run = setup.run()
    assert isinstance(setup.law, cl.HertzPenalty)
    depth = (5.0 / setup.law.stiffness) ** (2.0 / 3.0)
    assert -run.series["gap"][-1] == pytest.approx(depth, rel=1e-5)
    assert run.series["normal_force"][-1] == pytest.approx(5.0, rel=1e-5)
    # The beam gives way as well: the rotor sinks by the clearance and both.
    modes = setup.motor.modes
    beam = slice(0, modes.stiffness.size - 1)
    static = 5.0 * float(np.sum(modes.tip_displacement[beam] ** 2 / modes.stiffness[beam]))
    expected = -(1e-6 + depth + static)
    assert run.series["rotor_normal_displacement"][-1] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("preload", [0.5, 20.0])
def test_the_mean_force_of_a_driven_motor_is_the_preload(preload: float) -> None:
    """The bearing has no stiffness: in the mean nothing else carries the contact force."""
    run = cl.build([f"contact.preload={preload}", "solver.duration=0.06"]).run()
    half = run.time.size // 2
    force = run.series["normal_force"][half:].mean()
    span = run.time[-1] - run.time[half]
    speed = np.gradient(run.series["rotor_normal_displacement"], run.time)
    mass = 2.0 * 4.8e-5 / 0.025**2
    # m dv = (N - P) dt, but for the turn of the tip, of the second order.
    assert force - preload == pytest.approx(mass * (speed[-1] - speed[half]) / span, abs=2e-3 * preload)


@pytest.mark.parametrize("law", ["hertz_penalty", "newton", "composed"])
@pytest.mark.parametrize("stiffness", [0.0, 1e5])
def test_a_pressed_motor_begins_at_rest(law: str, stiffness: float) -> None:
    """Nothing moves until the drive is on, and the force is that of spring and preload."""
    common = ["contact.preload=5 N", f"rotor.bearing_stiffness={stiffness}", f"law={law}"]
    run = cl.build([*common, *SILENT, "solver.duration=2e-3"]).run()
    lift = run.series["rotor_normal_displacement"]
    assert np.ptp(lift) < 1e-13
    assert run.series["normal_force"][-100:].mean() == pytest.approx(5.0 + stiffness * lift[-1], rel=1e-6)
    assert np.abs(run.series["energy_residual"]).max() < 1e-12


def test_a_stiff_bearing_may_hold_the_rotor_off() -> None:
    motor = cl.build(["contact.preload=5 N", "rotor.bearing_stiffness=1e8"]).motor
    assert motor.start is not None
    assert motor.start.displacement[-1] == pytest.approx(-5.0 / 1e8 * sqrt(2.0 * 4.8e-5) / 0.025)


def thrown(motor: cl.Motor, rate: float) -> cl.Motor:
    """Return a motor that begins with a rate of its last mode."""
    assert motor.start is not None
    velocity = motor.start.velocity.copy()
    velocity[-1] = rate
    return replace(motor, start=replace(motor.start, velocity=velocity))


def test_a_rotor_bounces_in_the_period_of_its_weight() -> None:
    """Thrown off at v under a force P without stiffness, a mass m comes back after 2 m v / P."""
    mass, preload, velocity = 0.2, 3.0, 0.05
    motor = cl.on_bearing(stiff(), cl.Bearing(mass, preload))
    assert motor.start is not None
    motor = thrown(motor, sqrt(mass) * velocity)
    run = cl.simulate(motor, cl.Newton(restitution=1.0), duration=0.05, record_interval=1e-4)
    starts = run.contacts["start_time"].values
    assert np.diff(starts) == pytest.approx(2.0 * mass * velocity / preload, rel=1e-5)


def test_a_free_rotor_swings_on_its_bearing() -> None:
    mass, stiffness, preload, clearance = 0.2, 1e6, 0.5, 1e-6
    motor = cl.build(SILENT).motor
    pressed = cl.on_bearing(motor, cl.Bearing(mass, preload, stiffness))
    assert pressed.start is not None
    rest = -preload / stiffness
    assert pressed.start.displacement[-1] / sqrt(mass) == pytest.approx(rest)
    assert abs(rest) < clearance
    pressed = thrown(pressed, sqrt(mass) * 1e-4)
    run = cl.simulate(pressed, cl.HertzPenalty(), duration=3e-3, record_interval=1e-6)
    omega = sqrt(stiffness / mass)
    expected = rest + 1e-4 / omega * np.sin(omega * run["time"].values)
    assert run["rotor_normal_displacement"].values == pytest.approx(expected, abs=1e-13)
    assert 2.0 * pi / omega < 3e-3


def test_an_infinitely_stiff_bearing_is_the_fixed_axle() -> None:
    """The difference falls with one over the stiffness, for the bearing gives way by N / k."""
    common = ["solver.duration=4e-3", "resonator=finite_element"]
    fixed = cl.build(common).run().series["rotor_velocity"][-1]
    apart = []
    for stiffness in (1e9, 1e10):
        pressed = [*common, "contact.preload=0", f"rotor.bearing_stiffness={stiffness}"]
        apart.append(abs(cl.build(pressed).run().series["rotor_velocity"][-1] - fixed))
    assert apart[0] < 0.02 * abs(fixed)
    assert apart[1] < 0.2 * apart[0]


@pytest.mark.parametrize("law", ["hertz_penalty", "lagrange_stick"])
def test_a_load_below_the_friction_of_the_preload_is_held(law: str) -> None:
    """The drive off, the rotor holds against mu P R, and no more."""
    holding = 0.3 * 5.0 * 0.025
    common = [
        f"law={law}",
        "contact.preload=5 N",
        "rotor.bearing_damping=2e3",
        *SILENT,
        "solver.duration=0.03",
    ]
    sticks = cl.build([*common, f"rotor.load_torque={0.9 * holding}"]).run()
    slips = cl.build([*common, f"rotor.load_torque={1.1 * holding}"]).run()
    late = sticks.time.size // 2
    # What sticks to the tip swings with it, and stays.
    assert abs(sticks.series["rotor_velocity"][late:].mean()) < 0.01 * abs(slips.series["rotor_velocity"][-1])
    acceleration = -0.1 * holding / 4.8e-5
    time = slips.time[late:]
    fitted = np.polyfit(time, slips.series["rotor_velocity"][late:], 1)[0]
    assert fitted == pytest.approx(acceleration, rel=0.02)


def test_the_stall_torque_has_an_optimum_over_the_preload(tmp_path: Path) -> None:
    """Friction carries at most mu P R, and what presses harder takes the vibration away."""
    lines = [
        "frequency [kHz],damping_ratio,uy,ux,coupling_1 [N/V],coupling_2 [N/V]",
        "38.2,0.005,4.1,0.3,2.1,2.1",
        "39.4,0.005,-0.2,4.4,1.9,-1.9",
    ]
    path = tmp_path / "modes.csv"
    path.write_text("\n".join(lines))
    common = ["resonator=modal", f"resonator.file={path}", "drive=two_phase", "drive.frequency=38800"]
    common += ["drive.voltage_1=60", "drive.voltage_2=60", "rotor.bearing_damping=300"]
    preloads = (1.0, 5.0, 20.0, 80.0)
    torques = [
        abs(cl.steady(cl.build([*common, f"contact.preload={preload}"]), belt=0.0).torque.value)
        for preload in preloads
    ]
    assert all(torque <= 0.3 * preload * 0.025 for torque, preload in zip(torques, preloads, strict=True))
    assert 0 < int(np.argmax(torques)) < len(preloads) - 1


def test_the_ledger_of_a_pressed_motor_closes() -> None:
    run = cl.build(["contact.preload=5 N", "rotor.bearing_stiffness=1e5", "rotor.bearing_damping=10"]).run()
    residual = np.abs(run.series["energy_residual"]).max()
    assert residual < 1e-9 * run.series["drive_work"][-1]


@pytest.mark.parametrize("key", ["mass", "bearing_stiffness", "bearing_damping"])
def test_a_fixed_axle_has_no_bearing(key: str) -> None:
    with pytest.raises(cl.ConfigurationError, match=rf"rotor\.{key}"):
        cl.build([f"rotor.{key}=1"])
    with pytest.raises(cl.ConfigurationError, match=rf"rotor\.{key}"):
        cl.build(["contact.preload=1", f"rotor.{key}=-1"])


@pytest.mark.parametrize("stiffness", [0.0, 1e5])
@pytest.mark.parametrize("preload", [0.5, 5.0, 500.0])
def test_a_pressed_tip_that_leans_rests_at_the_gap_of_its_law(preload: float, stiffness: float) -> None:
    """Modes that move and turn the tip: its gap is not its displacement by up to 2 um here."""
    omega, mass = 2.0 * pi * np.array([3e3, 7e3]), np.array([5e-3, 1e-2])
    modes = cl.NormalModes(
        stiffness=omega**2,
        damping=0.02 * omega,
        coupling=np.ones((2, 2)),
        tip_displacement=np.array([1.0, 0.4]) / np.sqrt(mass),
        tip_slope=np.array([50.0, -80.0]) / np.sqrt(mass),
    )
    geometry = cl.ContactGeometry(tip_length=19e-3, rotor_radius=25e-3, clearance=1e-6)
    motor = cl.Motor(modes, cl.Drive(), geometry, cl.Rotor(inertia=4.8e-5))
    bearing = cl.Bearing(mass=0.15, preload=preload, stiffness=stiffness)
    motor = at_rest(cl.on_bearing(motor, bearing), cl.law("newton"))
    assert motor.start is not None
    q, m = motor.start.displacement, motor.modes
    gap, n_u, n_th, _, _ = geometry.frame(float(m.approach @ q), float(m.tip_slope @ q))
    assert gap == pytest.approx(1e-15, rel=1e-2)
    # One force along the normal holds every coordinate.
    row = -n_u * m.approach - n_th * m.tip_slope
    forces = (motor.preload - m.stiffness * q) / row
    assert forces == pytest.approx(forces[-1], rel=1e-6)
    assert forces[-1] > 0.0


def test_a_preload_that_a_free_mode_gives_way_to_is_refused() -> None:
    modes = cl.NormalModes(
        stiffness=np.array([0.0, 4e8]),
        damping=np.zeros(2),
        coupling=np.ones((2, 2)),
        tip_displacement=np.array([5.0, 20.0]),
        tip_slope=np.zeros(2),
    )
    motor = cl.Motor(modes, cl.Drive(), cl.ContactGeometry(clearance=1e-6), cl.Rotor(inertia=4.8e-5))
    pressed = cl.on_bearing(motor, cl.Bearing(mass=0.15, preload=5.0, stiffness=1e5))
    with pytest.raises(ValueError, match="preload"):
        at_rest(pressed, cl.law("newton"))


def test_a_start_in_a_neck_is_one_on_a_bearing_too() -> None:
    pulled = block(1.0, height=1e-9, touching=True)
    start = cl.on_bearing(pulled, cl.Bearing(mass=1.0, stiffness=1e6)).start
    assert start is not None
    assert start.touching
