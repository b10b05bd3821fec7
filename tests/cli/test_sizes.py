"""What does not fit is refused by its key before anything is read, allocated or written."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given, strategies as st
from support.command_line import Command, left_behind
from support.declared import TABLES, declare

import contactlab as cl
from contactlab.results.yaml_text import MOST_VALUES, check_expansion, read_yaml


def bomb(levels: int) -> str:
    """Return YAML whose aliases repeat 10^levels values."""
    lines = ["l0: &l0 [x]", *(f"l{n}: &l{n} [{','.join(10 * [f'*l{n - 1}'])}]" for n in range(1, levels))]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (["contact.preload=1e9"], "contact.preload"),
        (["steady", "contact.preload=1e9"], "contact.preload"),
        (["-m", "contact.preload=1,1e9"], "contact.preload"),
        (["drive=chirp", "drive.duration=1e6"], "drive.duration"),
        (["drive=chirp", "drive.last_frequency=1e9"], "drive.last_frequency"),
        (["solver.duration=8567"], "record.interval"),
        (["solver.duration=1e4", "record.interval=1e-6"], "record.interval"),
        (["drive=tones", "drive.file=/dev/zero"], "drive.file"),
        (["resonator=modal", "resonator.file=/dev/zero"], "resonator.file"),
        (["-m", "sweep.samples=/dev/zero"], "sweep.samples"),
        (["drive", "/dev/zero", "law=newton"], "/dev/zero"),
        (["compare", "law=newton,poisson", "samples=1e9"], "samples"),
    ],
)
def test_a_size_that_does_not_fit_is_refused_by_its_key_and_nothing_is_written(
    command: Command, arguments: list[str], key: str
) -> None:
    status, out, err = command(*arguments)
    assert (status, out) == (2, "")
    assert key in err
    assert "Warning" not in err
    assert left_behind() == []


@pytest.mark.parametrize("file", TABLES)
@pytest.mark.parametrize(
    "arguments",
    [
        ["drive=sampled", "drive.file=FILE"],
        ["resonator=modal", "resonator.file=FILE"],
        ["drive", "FILE", "law=newton"],
        ["verify", "FILE"],
        ["animate", "FILE"],
        ["compare", "law=newton,poisson", "posterior=FILE"],
        ["-m", "sweep.samples=FILE"],
    ],
    ids=" ".join,
)
def test_a_small_file_that_declares_many_rows_is_refused_unread(
    command: Command, arguments: list[str], file: str
) -> None:
    declare(Path(file), TABLES[file])
    assert Path(file).stat().st_size < 1e4
    status, out, err = command(*(each.replace("FILE", file) for each in arguments))
    assert (status, out) == (2, "")
    assert file in err
    assert "GB" in err
    assert left_behind() == [Path(file)]


@pytest.mark.parametrize("flag", ["--config-dir", "hydra.searchpath"])
def test_aliases_that_multiply_are_refused_by_their_file(command: Command, flag: str) -> None:
    folder = Path("own", "experiment")
    folder.mkdir(parents=True)
    (folder / "bomb.yaml").write_text(f"# @package _global_\n{bomb(9)}\n")
    before = left_behind()
    where = [flag, "own"] if flag.startswith("--") else [f"{flag}=[file://{Path('own').absolute()}]"]
    status, out, err = command(*where, "experiment=bomb")
    assert (status, out) == (2, "")
    assert "bomb.yaml" in err
    assert left_behind() == before


def test_a_run_whose_configuration_multiplies_has_no_setup(tmp_path: Path) -> None:
    run = cl.simulate(cl.build(), duration=1e-5)
    run.tree.attrs["configuration"] = bomb(12)
    run.save(tmp_path / "run.nc")
    assert cl.load(tmp_path / "run.nc").setup is None


def test_a_list_of_lists_as_a_value_is_refused_at_once() -> None:
    configuration = cl.build().configuration
    value: list[object] = ["x"]
    for _ in range(40):
        value = [value] * 10
    with pytest.raises(cl.ConfigurationError, match=r"rotor\.radius"):
        cl.build({**configuration, "rotor": {**configuration["rotor"], "radius": value}})


@given(st.recursive(st.none() | st.booleans() | st.integers() | st.text(), st.lists, max_leaves=20))
def test_yaml_without_too_many_aliases_is_read_as_it_is(value: object) -> None:
    assert read_yaml(yaml.safe_dump([value, value])) == [value, value]


def test_a_text_that_contains_itself_is_refused() -> None:
    with pytest.raises(ValueError, match="aliases"):
        check_expansion("&a [*a]")
    with pytest.raises(ValueError, match="aliases"):
        check_expansion(bomb(len(str(MOST_VALUES)) + 1))
