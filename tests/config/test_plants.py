"""Small plants by keys are those of Python, in setups, files, branches and sweeps."""

import numpy as np
import pytest

import contactlab as cl
from contactlab.config import rebuild
from contactlab.config.groups import PLANTS
from contactlab.config.schema import Examination

DRIVEN = ["plant=slider", "plant.mass=10 g", "plant.tip.rise=0.8", "law=newton"]
SLIDER = cl.slider(0.01, tip=cl.Sawtooth(rise=0.8))


@pytest.mark.parametrize("name", PLANTS)
def test_a_plant_by_its_name_is_that_of_python(name: str) -> None:
    arguments = {"tip": cl.Sawtooth()} if name == "slider" else {}
    setup = cl.build([f"plant={name}"])
    assert setup.motor == PLANTS[name](**arguments)
    # What is recorded builds it again, derived numbers included.
    assert rebuild(setup.configuration).motor == setup.motor
    assert cl.build(setup.source).configuration == setup.configuration
    assert setup.command() == f"contactlab plant={name}"


def test_keys_have_the_names_of_the_arguments() -> None:
    setup = cl.build([*DRIVEN, "plant.load=1 mN", "contact.friction_coefficient=0.2"])
    assert setup.motor == cl.slider(0.01, tip=cl.Sawtooth(rise=0.8), load=1e-3)
    assert setup.law.friction_coefficient == 0.2
    assert setup.configuration["rotor"]["load_torque"] == 1e-3
    shaken = cl.build({"plant": "block", "plant.table.amplitude": "1 um", "plant.base.amplitude": 1e-3})
    assert shaken.motor == cl.block(base=cl.Vibration(1e-3), table=cl.Vibration(1e-6))
    assert setup.with_({"plant.mass": 0.02}).motor.plant.numbers["mass"][0] == 0.02


def test_a_motor_has_no_plant_in_its_configuration() -> None:
    setup = cl.build(["plant=motor", "law=newton"])
    assert "plant" not in {**setup.configuration, **setup.source}
    assert setup.configuration == cl.build(["law=newton"]).configuration


@pytest.mark.parametrize(
    ("lines", "key"),
    [
        (["plant=ball", "rotor.damping=1"], "rotor.damping"),
        (["plant=ball", "contact.clearance=2 um"], "contact.clearance"),
        (["plant=ball", "resonator.shapes=2"], "resonator.shapes"),
        (["plant=ball", "drive.frequency=1 kHz"], "drive.frequency"),
        (["plant=ball", "plant.mass=0"], "plant.mass"),
        (["plant=ball", "plant.tip.stroke=1"], "plant.tip.stroke"),
        (["plant=block", "plant.base.frequency=3"], "plant.base.amplitude"),
        (["plant=slider", "plant.tip.rise=0.95", "plant.tip.corner=0.1"], "plant.tip"),
        (["plant=oscillator", "plant.stiffness=-1"], "plant=oscillator"),
        (["plant.mass=1"], "plant.mass"),
        (["plant=table"], "plant"),
    ],
)
def test_what_a_plant_does_not_have_is_refused_by_its_key(lines: list[str], key: str) -> None:
    with pytest.raises(cl.ConfigurationError, match=key):
        cl.build(lines)


def test_a_recorded_number_that_the_plant_does_not_have_is_refused() -> None:
    recorded = cl.build(["plant=ball"]).configuration
    changed = {**recorded, "rotor": {**recorded["rotor"], "inertia": 1.0}}
    assert Examination(changed).follows["rotor.inertia"] == 1.0
    with pytest.raises(cl.ConfigurationError, match=r"rotor\.inertia"):
        rebuild(changed)


def test_branches_and_sweeps_of_a_plant_by_keys_are_those_of_python() -> None:
    built = cl.build(DRIVEN)
    over = "plant.tip.frequency", 1e3, 1.1e3
    branches = [cl.branch(built, *over).details, cl.branch(SLIDER, *over, law=built.law).details]
    values = [[(point.value, point.velocity) for point in each.points] for each in branches]
    assert np.array_equal(*values)
    rises = {"plant.tip.rise": [0.7, 0.8], "law": ["newton", "lagrange_stick"]}
    swept = cl.sweep(rises, [*DRIVEN[:-1], "solver.duration=5 ms"], workers=1)
    alone = cl.simulate(SLIDER, built.law, duration=5e-3)
    rigid = swept["final_rotor_velocity"].sel(rise=0.8, law="newton")
    assert rigid == alone["rotor_velocity"][-1]
    python = cl.sweep({"plant.tip.rise": [0.7, 0.8]}, cl.Setup.of(SLIDER, built.law, 5e-3), workers=1)
    assert np.array_equal(python["final_rotor_velocity"], swept["final_rotor_velocity"].sel(law="newton"))
