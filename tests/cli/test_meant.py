"""What is written in another form than the command's leads to what was meant."""

from pathlib import Path

import pytest
import yaml
from support.command_line import Command, left_behind
from support.sweeps import Simulations

from contactlab.config import build
from contactlab.metrics import METRICS
from contactlab.suggestion import suggestion


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run"], "Did you mean contactlab, without a verb?"),
        (
            ["run", "law=newton", "contact.clearance=1 um"],
            "Did you mean contactlab law=newton 'contact.clearance=1 um', without a verb?",
        ),
        (["list"], "Did you mean contactlab laws? contactlab --help lists what there is."),
        (["sweep", "law=newton,poisson"], "Did you mean contactlab -m law=newton,poisson?"),
        (["version"], "Did you mean contactlab --version?"),
        (["warmup"], "Did you mean warm-up?"),
        (["help", "staedy"], "Did you mean steady?"),
        (["frobnicate"], "An argument of a run has the form KEY=VALUE or GROUP=OPTION."),
        (["law=newton", "steady"], "steady is a verb; it stands first: contactlab steady law=newton"),
        (["newton"], "Did you mean contactlab law=newton?"),
        (["case_a"], "Did you mean contactlab experiment=case_a?"),
        (["drive.phase:0"], "Did you mean contactlab drive.phase=0?"),
        (["law=newton", "drive.phase:0"], "Did you mean drive.phase=0?"),
        (["law=newton", "finite_element"], "Did you mean resonator=finite_element?"),
        (["--law", "newton"], "Did you mean law=newton?"),
        (["--law=newton"], "Did you mean law=newton?"),
        (["-law", "newton"], "Did you mean law=newton?"),
        (["-m", "--law", "newton,hertz"], "Did you mean law=newton,hertz_penalty?"),
        (["--law", "hertz"], "Did you mean law=hertz_penalty?"),
        (["--law"], "Did you mean law=NAME?"),
        (["--law", "drive.phase=0"], "Did you mean law=NAME?"),
        (["--clearance", "1 um"], "Did you mean 'contact.clearance=1 um'?"),
        (["--clearence=1e-6"], "Did you mean contact.clearance=1e-6?"),
        (["--output", "there"], "Did you mean hydra.run.dir=there?"),
        (["--metrics", "rotor_speed"], "Did you mean sweep.metrics=rotor_velocity?"),
        (
            ["-m", "drive.phase=0,1", "sweep.keep=metrics", "sweep.metrics=rotor_speed"],
            "Did you mean rotor_velocity?",
        ),
        (["steady", "--law", "newton"], "Did you mean law=newton, without dashes?"),
        (["steady", "newton"], "Did you mean law=newton?"),
        (["steady", "--breake", "1e-3"], "Did you mean --brake?"),
        (["steady", "--brake", "1 mN"], "it must be a number in N m, or a text with a unit such as '2 mN m'"),
        (
            ["branch", "contact.clearance=1 um..4 kg"],
            "The end of contact.clearance is '4 kg', whose unit 'kg' cannot be converted to m;",
        ),
        (["branch", "contact.clearance=1 um..4 um", "--belt", "x"], "--belt is 'x', which is not a number;"),
        (["basins", "--over", "tip_velocity=a..3", "drive_phase=0..1"], "must be a number in m/s"),
        (["rotor.load_torque=1 kg"], "it must be a number in N m, for example '2 mN m'"),
        (["+experiment=case_b"], "experiment is 'case_b'; it must be one of basis_convergence, case_a,"),
        (["+drive.phase=2"], "it must be set, drive.phase=VALUE. Leave out the +."),
    ],
)
def test_another_form_is_refused_with_what_was_meant(
    command: Command, arguments: list[str], words: str
) -> None:
    status, out, err = command(*arguments)
    assert (status, out) == (2, "")
    assert words in err
    assert len(err.splitlines()) == 1
    assert left_behind() == []


def test_a_run_where_a_verb_stands_is_told_that_the_verb_stands_first(command: Command) -> None:
    Path("mine").mkdir()
    status, _, err = command("mine")
    assert status == 2
    assert "It stands before a run or a folder of runs, as in contactlab verify mine." in err


def test_the_word_help_gives_the_help_of_the_command_or_of_a_verb(command: Command) -> None:
    assert command("help") == command("--help")
    assert command("help", "steady") == command("steady", "--help")


def test_the_help_tells_of_every_verb(command: Command) -> None:
    from contactlab.cli.arguments import VERBS

    _, out, _ = command("--help")
    assert [verb for verb in VERBS if f"contactlab {verb} " not in out] == []


@pytest.mark.parametrize("plus", ["+", "++"])
def test_a_plus_before_a_choice_is_no_fault(command: Command, plus: str) -> None:
    status, out, err = command(f"{plus}experiment=case_a", f"{plus}law=newton", "--cfg", "job")
    assert status == 0, err
    shown = yaml.safe_load(out)
    assert (shown["law"]["name"], shown["drive"]["frequency"]) == ("newton", 3210.0)
    assert build([f"{plus}law=newton"]).law.name == "newton"


def test_a_word_of_others_leads_to_the_name_of_ours() -> None:
    assert suggestion("rotor_speed", METRICS) == "Did you mean rotor_velocity?"
    assert suggestion("max_force", METRICS) == "Did you mean peak_force?"
    assert "settled_velocity" in suggestion("speed", METRICS)
    assert suggestion("parsnip", METRICS, "None.") == "None."


@pytest.mark.usefixtures("simulations")
def test_a_run_says_in_a_line_what_can_be_done_next(command: Command) -> None:
    arguments = ("law=newton", "contact.clearance=1 um", "record.picture=false", "hydra.run.dir=a b")
    status, out, err = command(*arguments)
    assert status == 0, err
    last = out.splitlines()[-1]
    assert last == (
        "Next: `contactlab animate 'a b'` shows it in slow motion, "
        "`contactlab steady law=newton 'contact.clearance=1 um'` finds the settled motor."
    )


@pytest.mark.long
def test_a_sweep_over_laws_says_what_can_be_done_next(command: Command, simulations: Simulations) -> None:
    _, out, _ = command("-m", "law=newton,poisson", "record.picture=false", "hydra.sweep.dir=two")
    assert out.splitlines()[-1] == "Next: `contactlab compare two` sets the laws side by side."
    _, out, _ = command("-m", "drive.phase=0,1", "record.picture=false", "hydra.sweep.dir=other")
    assert "Next" not in out
