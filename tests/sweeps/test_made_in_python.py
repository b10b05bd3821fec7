"""Sweeps, branches and data sheets of a motor and a law made in Python are those of their configuration."""

import re
from dataclasses import dataclass, replace
from typing import Annotated, Any, final

import numpy as np
import pytest
from support.motors import default_motor

import contactlab as cl


def setup_at(phase: float) -> cl.Setup:
    return cl.Setup.of(default_motor(phase=phase), cl.Newton(), 1e-3)


SETUP = cl.build(["law=newton"])
OWN = cl.Setup.of(SETUP.motor, SETUP.law, 1e-3, contact_step=SETUP.contact_step)


@final
@dataclass(frozen=True)
class Spring(cl.Friction):
    """Friction with a number whose name is that of one of the normal force."""

    name = "spring"
    equation = "|F| <= mu N"
    source = "none"

    stiffness: Annotated[float, cl.Parameter("k", "N m-1", "stiffness", above=0.0)] = 1e6


def test_the_numbers_of_a_motor_vary_as_the_keys_of_a_configuration_do() -> None:
    over = {"clearance": "linspace(0.5 um, 1 um, 2)", "law.restitution": [0.3, 0.6], "rotor.inertia": [4e-5]}
    made, built = (cl.sweep(over, base, workers=1) for base in (OWN, replace(SETUP, duration=1e-3)))
    assert dict(made.sizes) == dict(built.sizes) == {"clearance": 2, "law_restitution": 2, "inertia": 1}
    assert made["clearance"].attrs["units"] == "m"
    for name in ("final_rotor_velocity", "total_impulse", "contact_count"):
        assert np.array_equal(made[name], built[name])


def test_the_rows_of_a_table_are_runs_of_it_and_parts_of_its_law_vary() -> None:
    law = cl.Composed(normal=cl.Linear(stiffness=1e7))
    rows = [{"law.normal.stiffness": 1e7, "friction_coefficient": 0.2}, {"law.normal.stiffness": 2e7}]
    rows[1]["friction_coefficient"] = 0.3
    result = cl.sweep(rows, cl.Setup.of(SETUP.motor, law, 1e-3), workers=1)
    for run, row in enumerate(rows):
        other = cl.Composed(
            cl.Linear(row["law.normal.stiffness"]), friction=cl.Coulomb(row["friction_coefficient"])
        )
        alone = cl.simulate(SETUP.motor, other, duration=1e-3)
        assert result["final_rotor_velocity"][run] == alone["rotor_velocity"][-1]


SPRUNG = cl.Setup.of(SETUP.motor, cl.Composed(normal=cl.Linear(), friction=Spring()), 1e-3)


@pytest.mark.parametrize(
    ("over", "base", "options", "key"),
    [
        # What the motor does not have or admit.
        ({"drive.phase": [0.1]}, OWN, {}, "drive.phase"),
        ({"law.stiffness": [1e9]}, OWN, {}, "law.stiffness"),
        ({"rotor.inertia": [1e-5, 0.0]}, OWN, {}, "rotor.inertia"),
        ({"law.restitution": ["2 kg"]}, OWN, {}, "law.restitution"),
        ({"contact.clearance": ["linspace(0,1)"]}, OWN, {}, "contact.clearance"),
        # A name of two numbers, and two names of one.
        ({"stiffness": [1e9]}, SPRUNG, {}, "stiffness"),
        ({"clearance": [1e-6], "contact.clearance": [2e-6]}, SPRUNG, {}, "contact.clearance"),
        (
            {"law.friction.friction_coefficient": [0.2], "contact.friction_coefficient": [0.3]},
            SPRUNG,
            {},
            "contact.friction_coefficient",
        ),
        # What cannot be kept, and a sweep without values.
        ({"phase": [0.0]}, setup_at, {"metrics": ["peak_farce"]}, "peak_farce"),
        ({"phase": [0.0]}, setup_at, {"series": ["gab"]}, "gab"),
        ({"phase": [0.0]}, setup_at, {"metrics": []}, "metric"),
        ({"phase": [0.0]}, setup_at, {"output": "here"}, "output"),
        ({"rotor.inertia": [2e-5]}, (), {"study": cl.Steady(), "metrics": "all"}, "metrics"),
        ({}, setup_at, {}, "swept"),
        ({"phase": []}, setup_at, {}, "phase"),
    ],
    ids=lambda each: str([*each]) if isinstance(each, dict) else None,
)
def test_what_cannot_be_swept_or_kept_is_refused_by_its_key(
    over: dict[str, Any], base: Any, options: dict[str, Any], key: str
) -> None:
    kind = cl.ConfigurationError if isinstance(base, cl.Setup) else ValueError
    with pytest.raises(kind, match=re.escape(key)):
        cl.sweep(over, base, **options)


@pytest.mark.long
def test_its_data_sheet_branch_and_basins_are_those_of_its_setup() -> None:
    sheets = cl.characterise(SETUP), cl.characterise(SETUP.motor, SETUP.law)
    for name in ("stall_torque", "no_load_velocity", "velocity"):
        assert np.array_equal(*(sheet[name] for sheet in sheets), equal_nan=True)
    over: Any = ("contact.clearance", 1e-6, 1.01e-6)
    branches = cl.branch(SETUP, *over), cl.branch(SETUP.motor, *over, law=SETUP.law)
    assert np.array_equal(*(each.to_xarray()["rotor_velocity"] for each in branches))
    with pytest.raises(cl.ConfigurationError, match=r"drive\.phase"):
        cl.branch(SETUP.motor, "drive.phase", 0.0, 0.1, law=SETUP.law)
    axes = {"rotor_velocity": np.array([-2.0, 2.0]), "drive_phase": np.array([0.0])}
    assert np.array_equal(cl.basins(SETUP, axes).labels, cl.basins(SETUP.motor, axes, law=SETUP.law).labels)
    result = cl.attractors(SETUP, 2), cl.attractors(SETUP.motor, 2, law=SETUP.law)
    assert np.array_equal(*([(each.share, *each.steady.velocity) for each in item] for item in result))
