"""A rotor beside the tip's axis: normal and tangential motion are coupled, and restitutions differ."""

from dataclasses import replace
from math import cos, sin

import numpy as np
import pytest
from support.motors import default_motor

import contactlab as cl
from contactlab.engine.plant import delassus, plant_of
from contactlab.metrics import INVARIANTS, assess
from contactlab.plot.recording import recording_of

ANGLE = 0.5


@pytest.mark.parametrize("angle", [0.0, 0.3, -1.2])
def test_the_coupling_of_a_symmetric_motor_is_that_of_its_angle(angle: float) -> None:
    """D_nt = sin(beta) cos(beta) (1/m_u - L^2/I_th), with 1/m_u and 1/I_th of unit impulses on u and th."""
    motor = default_motor(angle=angle)
    light, turning = (float(row @ row) for row in (motor.modes.approach, motor.modes.tip_slope))
    lever = motor.geometry.tip_length**2
    d_nn, d_nt, d_tt = delassus(plant_of(motor), *motor.geometry.frame(0.0, 0.0)[1:])
    sine, cosine = sin(angle), cos(angle)
    assert d_nt == pytest.approx(sine * cosine * (light - lever * turning), rel=1e-9, abs=1e-9)
    assert d_nn == pytest.approx(cosine**2 * light + sine**2 * lever * turning, rel=1e-9)
    rotor = motor.geometry.rotor_radius**2 / motor.rotor.inertia
    assert d_tt == pytest.approx(sine**2 * light + cosine**2 * lever * turning + rotor, rel=1e-9)


def velocities(angle: float) -> list[float]:
    result = []
    for law in ("newton", "poisson"):
        setup = cl.build([f"law={law}", f"contact.angle={angle}", "solver.duration=3 ms"])
        run = cl.simulate(setup)
        assert run.complete
        invariants = assess(run.to_xarray(), set(INVARIANTS))
        assert all(not value > INVARIANTS[key].bound for key, value in invariants.items()), invariants
        result.append(float(run["rotor_velocity"][-1]))
    return result


def test_restitutions_are_one_on_the_axis_and_differ_beside_it() -> None:
    """On the axis a normal impulse changes the slip as far as the tip leans, by some 1e-4 rad."""
    newton, poisson = velocities(0.0)
    assert newton == pytest.approx(poisson, rel=1e-5)
    newton, poisson = velocities(ANGLE)
    assert abs(newton - poisson) > 1e-3 * abs(newton)


def test_a_preload_on_a_rotor_that_the_tip_passes_by_is_refused() -> None:
    beside = ["contact.angle=1.57", "contact.clearance=0.5 mm"]
    assert cl.build(beside).motor.geometry.way_to_touch == np.inf
    with pytest.raises(cl.ConfigurationError, match=r"contact\.angle is 1\.57 rad"):
        cl.build([*beside, "contact.preload=5", "rotor.bearing_damping=300"])


def test_left_and_right_exchange_with_the_angle() -> None:
    motor, law = (
        default_motor(angle=ANGLE, friction_coefficient=0.4, phase=0.2),
        cl.law("hertz_penalty", stiffness=5e9),
    )
    mirrored = replace(
        motor,
        modes=replace(motor.modes, tip_slope=-motor.modes.tip_slope),
        geometry=replace(motor.geometry, angle=-ANGLE),
    )
    ends = [float(cl.simulate(each, law, duration=1e-3)["rotor_velocity"][-1]) for each in (motor, mirrored)]
    assert ends[0] == -ends[1] != 0.0


def test_the_drawn_path_meets_the_drawn_rotor() -> None:
    run = cl.simulate(cl.build([f"contact.angle={ANGLE}", "solver.duration=1 ms"]))
    recording = recording_of(run.to_xarray())
    x, y = recording.path
    centre = recording.radius + recording.clearance
    assert np.hypot(x, y - centre) - recording.radius == pytest.approx(run["gap"].values, abs=1e-16)
