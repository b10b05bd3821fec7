"""What is written in another form than the command's leads to what was meant."""

import os
from pathlib import Path

import pytest
import yaml
from support.command_line import Command, left_behind
from support.sweeps import Simulations

from contactlab.cli import next_step
from contactlab.cli.arguments import VERBS
from contactlab.config import build
from contactlab.config.slips import joined, line_for
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
        (["run", "--law", "hertz"], "Did you mean contactlab law=hertz_penalty, without a verb?"),
        (["law", "Newton"], "There is no verb 'law'. Did you mean contactlab law=newton?"),
        (["law", "=", "newton"], "Did you mean contactlab law=newton?"),
        (["contact.clearance", "-0.1"], "Did you mean contactlab contact.clearance=-0.1?"),
        (
            ["contact.clearance", "=", "1", "um", "law", "newton"],
            "Did you mean contactlab 'contact.clearance=1 um' law=newton?",
        ),
        (["contact.clearance=1", "um"], "Did you mean 'contact.clearance=1 um'?"),
        (["-m", "contact.clearance=1", "um,2", "um"], "Did you mean 'contact.clearance=1 um,2 um'?"),
        (["contact.clearance = 1 um"], "Did you mean 'contact.clearance=1 um'?"),
        (["rotor.load_torque=1", "mN", "m"], "Did you mean 'rotor.load_torque=1 mN m'?"),
        (["steady", "contact.clearance=1", "um"], "Did you mean 'contact.clearance=1 um'?"),
        (["branch", "contact.clearance=1", "um..4", "um"], "Did you mean 'contact.clearance=1 um..4 um'?"),
        (["branch", "contact.clearance=1um-4um"], "Write it like 'contact.clearance=1 um..4 um'."),
        (["branch", "solver.duration=1..2"], "says how runs are made or kept; an orbit has nothing of that."),
        (["branch", "drive.phase=0..1", "record.interval=1"], "an orbit has nothing of that. Leave it out."),
        (["basins", "solver.until=steady"], "a map of basins has nothing of that. Leave it out."),
        (["characterise", "solver={duration:1}"], "a data sheet has nothing of that. Leave it out."),
        (["characterise", "uncertainty.clearance_spread=0.1"], "a data sheet has nothing of that."),
        (["steady", "solver.until=steady"], "a steady state has nothing of that. Leave it out."),
        (["branch", "belt=-2..2", "--belt", "1"], "belt=-2..2 and --belt are both given;"),
        (["branch", "law=newton..poisson"], "law is a group of keys; it must be one of them, law.KEY."),
        (["animate", "nowhere", "--start", "1", "ms"], "Did you mean --start '1 ms'?"),
        (["steady", "--brake", "-1e-3"], "The brake is -0.001 N m; it must be positive"),
        (["characterise", "--law="], "an argument is empty, as of a shell variable that is not set"),
        (["law=newton", ""], "An argument is empty, as of a shell variable that is not set."),
        ([" "], "An argument is empty, as of a shell variable that is not set."),
        (["-V"], "Did you mean --version?"),
        (["-help"], "Did you mean --help?"),
        (["-n", "4"], "unrecognized arguments: -n. contactlab --help lists what there is."),
        (["-o", "there"], "Did you mean hydra.run.dir=there?"),
        (["-c", "conf.yaml"], "-c is 'conf.yaml'; it must be one of job, hydra, all, as in -c job."),
        (["--cfg"], "--cfg has no value; it must be one of job, hydra, all"),
        (["--config-name"], "--config-name has no value; one must follow it."),
        (["output=there"], "Did you mean hydra.run.dir=there?"),
        (["mu=0.3"], "Did you mean contact.friction_coefficient=0.3?"),
        (["solver.dt=1e-8"], "Did you mean solver.contact_step?"),
        (["law.e=0.5"], "Did you mean law.restitution?"),
        (["drive.voltage=100"], "Did you mean drive.voltage_1 or drive.voltage_2?"),
        (["LAW=newton"], "LAW is not a known key. Did you mean law?"),
        (["seed=3"], "seed is not a known key; it must be one of law, resonator,"),
        (["law=coulomb"], "Did you mean law=composed law/friction=coulomb?"),
        (["law=[newton,poisson]"], "run all by contactlab -m law=newton,poisson."),
        (["~law=newton"], "~law=newton would take away what is not there;"),
        (["collect", "here", "--output", "all.csv"], "--output is 'all.csv'; it must end in .nc."),
        (["-m", "contact.clearance=linspce(0,2 um,3)"], "Values are listed by linspace(FIRST,LAST,COUNT),"),
        (["-m", "contact.clearance=logspace(0,2 um,3)"], "geomspace(FIRST,LAST,COUNT) or range"),
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
    for place, verb in (("mine/run.nc", "verify"), ("many/job/run.nc", "collect"), ("drops/drops.csv", "")):
        Path(place).parent.mkdir(parents=True)
        Path(place).touch()
        status, _, err = command(word := Path(place).parts[0] if verb else place)
        assert status == 2
        assert (
            f"It stands before a run or a folder of runs, as in contactlab {verb or 'validate'} {word}."
            in err
        )


def test_the_word_help_lists_the_verbs_or_gives_the_help_of_one(command: Command) -> None:
    status, out, err = command("help")
    assert (status, err) == (0, "")
    assert all(f"  {verb} " in out for verb in VERBS)
    assert "rotor.inertia" not in out
    assert command("help", "steady") == command("steady", "--help")


def test_the_help_tells_of_every_verb(command: Command) -> None:
    _, out, _ = command("--help")
    assert [verb for verb in VERBS if f"contactlab {verb} " not in out] == []


@pytest.mark.parametrize("plus", ["+", "++"])
def test_a_plus_before_a_choice_is_no_fault(command: Command, plus: str) -> None:
    status, out, err = command(f"{plus}experiment=case_a", f"{plus}law=newton", "--cfg", "job")
    assert status == 0, err
    shown = yaml.safe_load(out)
    assert (shown["law"]["name"], shown["drive"]["frequency"]) == ("newton", 3210.0)
    assert build([f"{plus}law=newton"]).law.name == "newton"


@pytest.mark.parametrize(
    ("argument", "key", "value"),
    [
        ("drive.phase=90°", "drive.phase", 1.5707963267948966),
        ("contact.clearance=1 µm", "contact.clearance", 1e-6),
    ],
)
def test_units_with_letters_of_their_own_need_no_more_quotes_than_others(
    argument: str, key: str, value: float
) -> None:
    group, _, name = key.partition(".")
    assert build([argument]).configuration[group][name] == pytest.approx(value, rel=1e-15)


def test_what_others_split_is_put_together_and_nothing_else() -> None:
    assert joined(["law=newton", "drive.phase=1", "-m"]) == [["law=newton"], ["drive.phase=1"], ["-m"]]
    assert joined(["drive.phase=0..0.8", "--points"]) == [["drive.phase=0..0.8"], ["--points"]]
    assert joined(["drive.phase=1", "poisson"]) == [["drive.phase=1"], ["poisson"]]
    assert line_for(["hydra.run.dir=a b", "drive.phase=0"]) == "'hydra.run.dir=a b' drive.phase=0"


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


@pytest.mark.usefixtures("simulations")
def test_the_line_has_the_folder_as_it_is_seen_from_where_the_command_was_given(command: Command) -> None:
    here = Path.cwd()
    try:
        status, out, err = command("hydra.job.chdir=true", "record.picture=false", "hydra.run.dir=there")
    finally:
        os.chdir(here)
    assert status == 0, err
    assert "Next: `contactlab animate there` shows" in out


def test_a_long_command_is_not_spelled_again() -> None:
    words = [f"drive.phase={phase}" for phase in range(20)]
    assert next_step.command("steady", *words) == "`contactlab steady` with these arguments"


@pytest.mark.long
def test_a_sweep_over_laws_says_what_can_be_done_next(command: Command, simulations: Simulations) -> None:
    _, out, _ = command("-m", "law=newton,poisson", "record.picture=false", "hydra.sweep.dir=two")
    assert out.splitlines()[-1] == "Next: `contactlab compare two` sets the laws side by side."
    _, out, _ = command("-m", "drive.phase=0,1", "record.picture=false", "hydra.sweep.dir=other")
    assert "Next" not in out
