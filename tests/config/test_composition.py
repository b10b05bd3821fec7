"""Configurations come from overrides wherever one is: in a script, in a notebook, inside a Hydra job."""

import re
from pathlib import Path

import hydra
import pytest
import yaml
from hydra.core.global_hydra import GlobalHydra
from support.command_line import Command
from support.configurations import composed

from contactlab.config import ConfigurationError, build, compose
from contactlab.config.composition import RUN, VERSION_BASE, started
from contactlab.config.options import conf_directory
from contactlab.laws import law_class


def test_overrides_compose_what_the_files_and_declarations_say() -> None:
    assert compose() == composed()
    assert compose(["law=newton", "placement=placement_1"]) == composed(law="newton", placement="placement_1")


def test_a_setup_is_built_from_overrides_from_a_mapping_or_from_nothing() -> None:
    assert build().configuration == build(composed()).configuration
    setup = build(["law=newton", "drive.phase=0", "contact.clearance=2 um"])
    assert isinstance(setup.law, law_class("newton"))
    assert setup.configuration["drive"]["phase"] == 0.0
    assert setup.motor.geometry.clearance == 2e-6
    assert build(setup.configuration).configuration == setup.configuration


def test_a_text_is_no_list_of_overrides() -> None:
    with pytest.raises(TypeError, match="law=newton"):
        build("law=newton")


@pytest.mark.parametrize(
    ("override", "key"),
    [
        ("law=rubber", "law"),
        ("law=newtn", "newton"),
        ("law=stribeck", "law=composed law/friction=stribeck"),
        ("law.friction=stribeck", "law=composed"),
        ("rotor.inertai=1", "rotor.inertia"),
        ("um", "um"),
        ("solver.duration=[1", "solver.duration"),
        ("solver.duration=1,2", "solver.duration"),
        ("law=null", "law=null"),
        ("rotor.inertia=${nothing}", "nothing"),
        ("rotor.inertia=${oc.env:HOME}", "rotor.inertia"),
    ],
)
def test_a_fault_of_composition_names_its_key(override: str, key: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(key)) as caught:
        build([override])
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize("override", ["um", "solver.duration=[1", "drive.phase={", "rotor.inertia='1"])
def test_an_override_that_cannot_be_read_is_named_among_others(override: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(override)) as caught:
        build(["law=newton", "contact.clearance=1e-6", override])
    assert "contact.clearance" not in str(caught.value)


def test_composing_leaves_a_hydra_that_runs_as_it_is() -> None:
    with hydra.initialize_config_dir(str(conf_directory()), **VERSION_BASE):
        outer = GlobalHydra.instance().hydra
        assert compose(["law=newton"]) == composed(law="newton")
        assert GlobalHydra.instance().hydra is outer
        with pytest.raises(ConfigurationError):
            compose(["law=rubber"])
        assert GlobalHydra.instance().hydra is outer
        assert hydra.compose(RUN)["law"]["name"] == "hertz_penalty"
    assert not GlobalHydra.instance().is_initialized()
    with started():
        assert compose() == composed()
    assert not GlobalHydra.instance().is_initialized()


def test_a_file_has_precedence_over_what_is_declared(command: Command, tmp_path: Path) -> None:
    for option in ("rotor/default", "law/mine"):
        (tmp_path / option).parent.mkdir()
    (tmp_path / "rotor/default.yaml").write_text("radius: 0.05\ninertia: 2e-5\n", encoding="utf-8")
    (tmp_path / "law/mine.yaml").write_text("name: newton\nrestitution: 0.4\n", encoding="utf-8")
    status, out, err = command("--config-dir", str(tmp_path), "law=mine", "--cfg", "job")
    assert status == 0, err
    result = yaml.safe_load(out)
    assert result["rotor"] == {"radius": 0.05, "inertia": 2e-5}
    assert result["law"] == {"name": "newton", "restitution": 0.4}
    assert compose()["rotor"] == composed()["rotor"]


@pytest.mark.parametrize("override", ["sweep.keep=metrics", "study.brake=1e-3", "hydra.verbose=true"])
def test_what_is_the_commands_is_no_part_of_a_run(override: str) -> None:
    for attempt in (lambda: build([override]), lambda: build().with_(override)):
        with pytest.raises(ConfigurationError) as caught:
            attempt()
        assert override.partition(".")[0] in str(caught.value)


def test_an_experiment_of_ones_own_in_a_folder_of_ones_own(tmp_path: Path, command: Command) -> None:
    (tmp_path / "experiment").mkdir()
    lines = ["# @package _global_", "defaults:", "  - override /law: newton", "contact:", "  clearance: 5e-7"]
    (tmp_path / "experiment/soft.yaml").write_text("\n".join(lines))
    own = build(["experiment=soft"], tmp_path)
    assert own.configuration == build(["law=newton", "contact.clearance=0.5 um"]).configuration
    assert build({"experiment": "soft"}, tmp_path).configuration == own.configuration
    status, out, err = command("--config-dir", str(tmp_path), "experiment=soft", "--cfg", "job")
    assert status == 0, err
    assert yaml.safe_load(out)["contact"]["clearance"] == 5e-7
    for configuration, folder in ((["experiment=soft"], None), (["experiment=soft"], tmp_path / "none")):
        with pytest.raises(ConfigurationError):
            build(configuration, folder)
