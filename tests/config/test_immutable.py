"""Claims on setups: nothing in one changes, what is recorded is what ran, and `with_` makes another."""

import copy
import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings, strategies as st

import contactlab as cl
from contactlab.config.nesting import flat, nested

SETUP = cl.build(["drive=chirp", "solver.changes=['1 ms; rotor.load_torque=1e-3']"])
COPIES: list[Callable[[Any], Any]] = [
    lambda x: x,
    copy.copy,
    copy.deepcopy,
    lambda x: pickle.loads(pickle.dumps(x)),
]


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize(
    "change",
    [
        lambda c: c.update(contact={}),
        lambda c: c["contact"].update(clearance=5e-7),
        lambda c: c["contact"].__setitem__("clearance", 5e-7),
        lambda c: c["contact"].__delitem__("clearance"),
        lambda c: c["contact"].setdefault("mass", 1.0),
        lambda c: c["contact"].pop("clearance"),
        lambda c: c["contact"].popitem(),
        lambda c: c["contact"].clear(),
        lambda c: c["contact"].__ior__({"clearance": 5e-7}),
        lambda c: c["solver"]["changes"].append("2 ms; drive.phase=0"),
    ],
)
def test_a_configuration_cannot_be_changed(
    copied: Callable[[Any], Any], change: Callable[[Any], object]
) -> None:
    before = json.dumps(SETUP.configuration)
    setup = copied(SETUP)
    with pytest.raises((TypeError, AttributeError)):
        change(setup.configuration)
    assert json.dumps(setup.configuration) == before
    # A TypeError since Python 3.13.
    with pytest.raises((TypeError, ValueError), match="configuration"):
        replace(setup, configuration={})


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize(
    "array",
    [
        "modes.stiffness",
        "modes.coupling",
        "modes.capacitance",
        "modes.tip_displacement",
        "drive.frequency",
        "drive.phasors",
        "drive.waveform.pieces.c",
        "drive.waveform.pieces.x",
    ],
)
def test_no_array_of_a_motor_can_be_made_writable(copied: Callable[[Any], Any], array: str) -> None:
    setup = copied(SETUP)
    for motor in (setup.motor, setup.changes[0][1]):
        values = attrgetter(array)(motor)
        with pytest.raises(ValueError, match=r"read-only|WRITEABLE"):
            values[...] = 0.0
        with pytest.raises(ValueError, match="WRITEABLE"):
            values.flags.writeable = True


def test_a_motor_has_its_own_numbers() -> None:
    stiffness = np.array([1e8])
    row, coupling = np.ones(1), np.ones((1, 2))
    modes = cl.NormalModes(stiffness, 0.0 * row, coupling, row, row, points={"foot": row})
    stiffness[0] = coupling[0, 0] = row[0] = 5.0
    assert modes.stiffness[0] == 1e8
    assert modes.coupling[0, 0] == modes.tip_displacement[0] == modes.points["foot"][0] == 1.0


def test_the_written_configuration_is_the_one_of_the_setup() -> None:
    assert yaml.safe_load(yaml.safe_dump(cl.build().configuration)) == cl.build().configuration
    assert cl.build(SETUP.configuration).configuration == SETUP.configuration


def test_with_is_build_with_another_value() -> None:
    changes = ["contact.clearance=0.5 um", "resonator.length=50 mm"]
    for setup in (cl.build(), pickle.loads(pickle.dumps(cl.build()))):
        other = setup.with_(*changes)
        assert other.configuration == cl.build(changes).configuration
        assert other.motor.geometry.clearance == 5e-7
        assert setup.motor.geometry.clearance == 1e-6
        assert other.with_("contact.clearance=1e-6").configuration == cl.build(changes[1:]).configuration


def test_with_chooses_options_and_keeps_the_rest() -> None:
    setup = cl.build(["contact.clearance=2 um"]).with_("law=newton", "drive=two_phase", "drive.phase=90 deg")
    assert (
        setup.configuration
        == cl.build(
            ["contact.clearance=2 um", "law=newton", "drive=two_phase", "drive.phase=90 deg"]
        ).configuration
    )
    composed = setup.with_("law=composed", "law/normal=linear", "law.normal.stiffness=20 N/um")
    assert composed.with_("law/friction=stribeck").law == cl.Composed(
        normal=cl.Linear(2e7), friction=cl.Stribeck()
    )


@pytest.mark.parametrize(
    "override",
    [
        "law=rubber",
        "um",
        "contact.clearance",
        "contact.clearance=1 s",
        "contact.clearence=1",
        "study=steady",
        "experiment=case_a",
        "~contact.clearance",
        "contact.clearance=1,2",
        "contact.x=1",
        "solver=fast",
    ],
)
def test_with_refuses_what_build_does(override: str) -> None:
    with pytest.raises(cl.ConfigurationError, match=override.lstrip("~").partition("=")[0]):
        cl.build().with_(override)


def test_a_motor_that_was_replaced_is_recorded_as_such() -> None:
    setup = cl.build(["solver.duration=1e-3"])
    closer = replace(setup.motor, geometry=replace(setup.motor.geometry, clearance=5e-7))
    for other in (replace(setup, motor=closer), replace(setup, motor=closer).with_("rotor.damping=1e-5")):
        assert other.configuration["contact"]["clearance"] == 5e-7
        assert "resonator" not in other.configuration
    loaded = replace(setup, motor=replace(setup.motor, rotor=replace(setup.motor.rotor, load_torque=1e-3)))
    assert loaded.configuration["rotor"]["load_torque"] == 1e-3
    rebuilt = loaded.with_("contact.clearance=2 um")
    assert (rebuilt.motor.rotor.load_torque, rebuilt.motor.geometry.clearance) == (1e-3, 2e-6)
    silent = replace(setup, motor=replace(setup.motor, drive=cl.Drive()))
    assert "resonator" not in silent.configuration
    other_law = replace(setup, law=cl.Newton())
    assert other_law.configuration["law"]["name"] == "newton"
    shorter = replace(setup, duration=5e-4)
    assert shorter.configuration["solver"]["duration"] == 5e-4


def test_with_changes_a_number_of_a_motor_made_in_python() -> None:
    setup = replace(cl.build(), law=cl.Newton())
    other = setup.with_("contact.clearance=0.5 um", "law.restitution=0.3", "solver.duration=5 ms")
    assert other.motor.geometry.clearance == 5e-7
    assert other.law == cl.Newton(restitution=0.3)
    assert other.duration == other.configuration["solver"]["duration"] == 5e-3
    with pytest.raises(cl.ConfigurationError, match=r"drive\.phase"):
        setup.with_("drive.phase=0")
    with pytest.raises(cl.ConfigurationError, match="law"):
        setup.with_("law=newton")


KEYS = {
    key: value
    for key, value in flat(cl.build().configuration).items()
    if type(value) is float and key not in ("solver.precision", "rotor.bearing_stiffness")
}


@settings(max_examples=6)
@given(st.sets(st.sampled_from(sorted(KEYS)), max_size=4))
def test_a_mapping_is_completed_from_the_defaults(keys: set[str]) -> None:
    assert cl.build(nested({key: KEYS[key] for key in keys})).configuration == cl.build().configuration


@pytest.mark.parametrize(
    ("mapping", "overrides"),
    [
        ({"contact": {"clearance": 5e-7}}, ["contact.clearance=5e-7"]),
        ({"contact": {"clearance": "0.5 um"}}, ["contact.clearance=0.5 um"]),
        ({"law": "newton", "placement": "placement_1"}, ["law=newton", "placement=placement_1"]),
        ({"law": {"name": "newton", "restitution": 0.3}}, ["law=newton", "law.restitution=0.3"]),
        ({"drive": {"signal": "two_phase"}}, ["drive=two_phase"]),
        ({"piezoceramic": {"constants": "tensor"}}, ["piezoceramic=pz26_datasheet"]),
        ({"experiment": "case_a"}, ["experiment=case_a"]),
        (
            {"law": {"name": "composed", "normal": {"name": "linear"}, "friction": "lugre"}},
            ["law=composed", "law/normal=linear", "law/friction=lugre"],
        ),
    ],
)
def test_a_mapping_chooses_as_overrides_do(mapping: dict[str, Any], overrides: list[str]) -> None:
    assert cl.build(mapping).configuration == cl.build(overrides).configuration


@pytest.mark.parametrize(
    ("mapping", "key"),
    [
        ({"law": "rubber"}, "law"),
        ({"contact": 3}, "contact"),
        ({"contact": {"clearence": 1}}, "clearance"),
        ({"solver": "fast"}, "solver"),
        ({"foo": 1}, "foo"),
        ({"law": {"name": "rubber"}}, r"law\.name"),
    ],
)
def test_a_faulty_mapping_is_refused_by_its_key(mapping: dict[str, Any], key: str) -> None:
    with pytest.raises(cl.ConfigurationError, match=key):
        cl.build(mapping)


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
@pytest.mark.parametrize("then", [Path.unlink, lambda path: path.write_text("changed")])
def test_a_run_goes_on_after_its_files_are_gone_or_changed(
    tmp_path: Path, suffix: str, then: Callable[[Path], object]
) -> None:
    modes, tones, run = tmp_path / f"modes{suffix}", tmp_path / "tones.csv", tmp_path / "run.nc"
    cl.write_modes(cl.RitzResonator(shapes=2).modes, modes)
    head = "frequency [Hz],voltage_1 [V],voltage_2 [V],phase_1 [rad],phase_2 [rad]"
    tones.write_text(f"{head}\n3210,100,100,0,0\n6420,100,-100,0,0\n")
    chosen = ["resonator=modal", f"resonator.file={modes}", "drive=tones", f"drive.file={tones}"]
    setup = cl.build([*chosen, "solver.duration=5e-4"])
    first = cl.simulate(setup)
    whole = cl.simulate(start=first, duration=5e-4)
    first.save(run)
    then(modes)
    then(tones)
    again = cl.load(run)
    assert again.setup is not None
    assert "gap" in again
    assert "gasp" not in again
    assert all(again[name].size for name in again)
    assert again.attrs["complete"] == 1
    assert again.to_dataframe()["gap"].size == again["time"].size
    assert again.setup.configuration == setup.configuration
    later = cl.simulate(start=again, duration=5e-4)
    assert np.array_equal(later["rotor_velocity"], whole["rotor_velocity"])
    other = pickle.loads(pickle.dumps(again.setup)).with_("contact.clearance=2 um")
    assert np.array_equal(other.motor.modes.stiffness, setup.motor.modes.stiffness)


def test_a_run_that_is_moved_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    cl.write_modes(cl.RitzResonator(shapes=2).modes, "modes.csv")
    setup = cl.build(["resonator=modal", "resonator.file=modes.csv", "solver.duration=5e-4"])
    whole = cl.simulate(setup, duration=1e-3)
    cl.simulate(setup).save("run.nc")
    Path("modes.csv").rename("renamed.csv")
    Path("far/away").mkdir(parents=True)
    Path("run.nc").rename("far/away/run.nc")
    monkeypatch.chdir("far")
    cl.simulate(start=cl.load("away/run.nc"), duration=2e-4).save("later.nc")
    later = cl.simulate(start=cl.load("later.nc"), duration=3e-4)
    assert np.array_equal(later["rotor_velocity"][-1], whole["rotor_velocity"][-1])


@pytest.mark.parametrize("copied", COPIES)
def test_copies_of_a_setup_are_equal_to_it_and_others_are_not(copied: Callable[[Any], Any]) -> None:
    tones = cl.build(["drive=two_mode"])
    for setup in (SETUP, tones):
        assert copied(setup) == setup
        assert copied(setup.motor) == setup.motor
        assert copied(setup) != setup.with_("contact.clearance=0.7 um")
        assert copied(setup) != setup.with_("drive.voltage_1=50 V")
    assert copied(SETUP) != tones
    assert SETUP.motor.drive.waveform != replace(SETUP.motor.drive.waveform, start=1e-6)
    assert SETUP != "a setup"


def test_a_solution_cannot_be_changed(tmp_path: Path) -> None:
    run = cl.simulate(cl.build(), duration=5e-4)
    run.save(tmp_path / "run.nc")
    for each in (run, cl.load(tmp_path / "run.nc")):
        gap, units = each["gap"].values.copy(), each["gap"].attrs["units"]
        series, contacts, tree = each["gap"], each.contacts, each.to_xarray()
        for values in (series.values, contacts["start_time"].values, tree["gap"].values):
            with pytest.raises(ValueError, match="read-only"):
                values[0] = 9.0
        with pytest.raises(ValueError, match=r"read-only|view"):
            series[0] = 9.0
        series.values = 2.0 * gap
        series.attrs["units"] = "mm"
        tree["gap"] = 2.0 * tree["gap"]
        tree.attrs["ending"] = "stalled"
        contacts["start_time"] = -contacts["start_time"]
        assert np.array_equal(each["gap"].values, gap)
        assert each["gap"].attrs["units"] == units
        assert each.ending is cl.Ending.COMPLETE
        assert (each.contacts["start_time"] >= 0.0).all()
        deep = each.to_xarray().copy(deep=True)
        deep["gap"].values[0] = 9.0
