"""The numbers that a branch names are those that it takes, of motors configured and made in Python."""

import re

import numpy as np
import pytest
from support.command_line import cases

import contactlab as cl
from contactlab.cli.completion import candidates
from contactlab.cli.study import without_effect
from contactlab.config.nesting import flat
from contactlab.steady_state.branches import family
from contactlab.studies.registry import SIMULATE, studies, study_class

MOTOR = cl.build().motor
OWN = cl.Setup.of(MOTOR, cl.Composed(friction=cl.Dahl()), 1e-2)

SETUPS = {
    "default": cl.build(),
    "rigid": cl.build(["law=newton"]),
    "pressed": cl.build(["law=lagrange_stick", "contact.preload=5 N"]),
    "elements": cl.build(["law=composed", "resonator=finite_element", "resonator.rod_length=19 mm"]),
    "two phases": cl.build(["drive=two_phase"]),
    "made in Python": OWN,
    "oscillator": cl.Setup.of(cl.oscillator(1.0, 1e4, force=5.0, frequency=12.0), cl.Newton(0.3, 1.0), 1e-2),
}


@pytest.mark.parametrize("name", cases(SETUPS, ("rigid", "pressed", "made in Python")))
def test_every_number_that_is_named_is_taken(name: str) -> None:
    setup = SETUPS[name]
    with pytest.raises(cl.ConfigurationError) as fault:
        cl.branch(setup, "nonsense", 1.0, 2.0)
    named = re.findall(r"\b(?:[a-z_]\w*\.)+[a-z_]\w*", str(fault.value))
    assert {"contact.clearance", "drive.frequency", "rotor.inertia"} <= {*named}
    for key in named:
        value = float(flat(setup.configuration).get(key, 0.0))
        for near in (value + 1e-9 * (abs(value) or 1.0), value - 1e-9 * abs(value)):
            try:
                reached = family(setup, key, None)(near).setup.configuration
            except ValueError:
                continue
            assert flat(reached)[key] == pytest.approx(near, rel=1e-12, abs=0.0), key
            break
        else:
            pytest.fail(f"{key} takes no value beside {value}")


@pytest.mark.parametrize(
    ("setup", "key"),
    [
        (cl.build(), "solver.duration"),
        (cl.build(), "record.interval"),
        (OWN, "solver.duration"),
        (cl.Setup.of(cl.block(1.0, weight=1.0), cl.Newton(), 1e-2), "drive.frequency"),
    ],
)
def test_a_number_on_which_no_orbit_depends_is_refused(setup: cl.Setup, key: str) -> None:
    with pytest.raises(cl.ConfigurationError, match=key):
        cl.branch(setup, key, 1e-3, 2e-3)


def test_the_frequency_of_a_motor_made_in_python_is_that_of_the_configured_one() -> None:
    law = cl.Newton()
    every = [
        cl.branch(motor, "drive.frequency", 3210.0, 3240.0, law=own, step=0.5)
        for motor, own in ((MOTOR, law), (cl.build(["law=newton"]), None))
    ]
    mine, configured = (np.array([[p.value, p.velocity] for p in branch.points]) for branch in every)
    np.testing.assert_allclose(mine, configured, rtol=1e-9)
    assert every[0].points[-1].orbit.map.setup.motor.drive.frequency.tolist() == [3240.0, 6480.0]


@pytest.mark.parametrize("verb", sorted({*studies()} - {SIMULATE}))
def test_completion_offers_nothing_that_the_study_refuses(verb: str) -> None:
    study = study_class(verb)
    groups = [each for each in candidates(f"{verb} ") if each.endswith(".")]
    keys = [each for group in groups for each in candidates(f"{verb} {group}")]
    assert any(each.startswith("contact.") for each in keys)
    assert [*without_effect(study, [*groups, *keys])] == []
