"""Claims on texts with units: every public function takes them, and refuses another dimension."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import contactlab as cl

SETUP = cl.build()
D = [[1.0, 0.0], [0.0, 3.5]]


@given(st.floats(1e-3, 1e3))
def test_a_text_is_its_number(value: float) -> None:
    assert cl.Rotor(inertia=f"{value!r} kg m^2").inertia == cl.Rotor(inertia=value).inertia  # type: ignore[arg-type]
    text, number = cl.oscillator(f"{value!r} kg", gap="1 mm"), cl.oscillator(value, gap=1e-3)  # type: ignore[arg-type]
    assert np.array_equal(text.modes.stiffness, number.modes.stiffness)
    assert text.geometry == number.geometry
    assert cl.Steady(brake=f"{value!r} N m").brake == value  # type: ignore[arg-type]


EACH: list[tuple[Callable[[Any], Any], str, str]] = [
    (lambda x: cl.Rotor(load_torque=x), "1 mN*m", "load_torque"),
    (lambda x: cl.HertzPenalty(stiffness=x), "1 GN/m^1.5", "stiffness"),
    (lambda x: cl.law("hertz_penalty", stiffness=x), "1 GN/m^1.5", "stiffness"),
    (lambda x: cl.ContactGeometry(clearance=x), "1 um", "clearance"),
    (lambda x: cl.Bearing(mass=x), "100 g", "mass"),
    (lambda x: cl.Steel(density=x), "7.8 g/cm^3", "density"),
    (lambda x: cl.RitzResonator(length=x), "40 mm", "length"),
    (lambda x: cl.TwoPhase(voltage_1=x), "1 kV", "voltage_1"),
    (lambda x: cl.Drive.two_mode(x, 1.0, 1e3), "1 kV", "voltage_1"),
    (lambda x: cl.ball(height=x), "1 mm", "height"),
    (lambda x: cl.belt(weight=x), "1 mN", "weight"),
    (lambda x: cl.cantilever(length=x), "10 cm", "length"),
    (lambda x: cl.hertz_stiffness(x, 1.0), "1 mm", "tip_radius"),
    (lambda x: cl.impact(cl.Newton(), D, [x, 0.0]), "-1 mm/s", "velocity"),
    (lambda x: cl.Steady(load=x), "1 mN*m", "load"),
]


@pytest.mark.parametrize(("make", "text", "key"), EACH)
def test_every_function_takes_a_unit_and_refuses_another_dimension(
    make: Callable[[Any], Any], text: str, key: str
) -> None:
    make(text)
    with pytest.raises(ValueError, match=key):
        make("1 mol")


@pytest.mark.parametrize("argument", ["duration", "record_interval", "contact_step"])
def test_a_run_refuses_a_time_in_metres(argument: str) -> None:
    with pytest.raises(ValueError, match=argument):
        cl.simulate(SETUP, **{argument: "5 mm"})  # type: ignore[arg-type]


def test_a_run_lasts_as_its_text_says() -> None:
    run = cl.simulate(SETUP, duration="0.2 ms", record_interval="2 us")  # type: ignore[arg-type]
    assert run["time"].values[-1] == run.setup.configuration["solver"]["duration"] == 2e-4  # type: ignore[union-attr]
    assert run.setup.configuration["record"]["interval"] == 2e-6  # type: ignore[union-attr]
