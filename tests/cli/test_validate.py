"""`contactlab validate`: what it leaves, and what it refuses in a sentence."""

from pathlib import Path

import pytest
import xarray
from support.struck_discs import struck_discs

import contactlab as cl
from contactlab.cli.law_words import models_of
from contactlab.cli.terminal import RefusalError
from contactlab.cli.validate import main
from contactlab.measured.files import write_impacts

FILES = ("validation.nc", "validation.html", "prediction_error.png", "impacts.pdf", "residuals.png")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("measured") / "discs.csv"
    write_impacts(struck_discs(cl.Poisson(0.2, 0.6), 60, seed=0, spread=0.05), path)
    return path


def test_a_table_a_page_figures_and_a_dataset_say_the_same(
    measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["law=newton,poisson", "contact.friction_coefficient=0.05..0.5", "--folds", "3", "--workers", "1"]
    assert main([str(measured), *words, "--output", str(tmp_path)]) == 0

    out = capsys.readouterr().out
    with xarray.open_dataset(tmp_path / "validation.nc") as data:
        best = str(data["law"].values[0])
        error = f"{float(data['prediction_error'][0]):.4f}"
        assert data.attrs["folds"] == 3
        assert len(data.attrs["data_digest"]) == 64
        assert data["range"].sel(law="newton", parameter="friction_coefficient").values.tolist() == [
            0.05,
            0.5,
        ]
    page = (tmp_path / "validation.html").read_text(encoding="utf-8")
    assert f"{best} predicts best: {error}" in out
    assert f"{best} predicts best: {error}" in page
    assert "<img" in page
    assert "http" not in page
    for name in FILES:
        assert (tmp_path / name).stat().st_size > 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["law=newtn"], "Did you mean newton"),
        (["law=newton", "law.restitutio=0.5"], "Did you mean law.restitution"),
        (["law=newton", "law.restitution=0.5..1.5"], "at most 1"),
        (["law=newton", "law.restitution=hard"], "which is not a number"),
        (["law=newton", "law.restitution=0.5", "law.restitution=0.6"], "given twice"),
        (["drive.voltage_1=3"], "no motor is needed"),
        (["law=newton", "law/friction=sticky"], "There is no friction 'sticky'"),
        (["law/frictions=lugre"], "no part of a law"),
        (["newton"], "it must have the form"),
    ],
)
def test_words_that_name_no_law_are_refused_in_a_sentence(words: list[str], said: str) -> None:
    with pytest.raises(RefusalError, match=said):
        models_of(words)


def test_a_file_that_is_none_and_too_few_impacts_leave_nothing(tmp_path: Path) -> None:
    few = tmp_path / "few.csv"
    write_impacts(struck_discs(cl.Newton(), 6, seed=0), few)
    output = tmp_path / "out"
    with pytest.raises(RefusalError, match="There are 6 impacts"):
        main([str(few), "law=newton", "--output", str(output), "--workers", "1"])
    with pytest.raises(RefusalError, match="cannot be read"):
        main([str(tmp_path / "none.csv"), "law=newton", "--output", str(output)])
    assert not output.exists()


def test_parts_make_every_combination_and_numbers_are_held_or_free() -> None:
    found = models_of(
        [
            "law=newton",
            "law/damping=flores",
            "law/friction=coulomb,mindlin",
            "contact.friction_coefficient=0.2",
        ]
    )

    assert [model.label for model in found] == [
        "newton",
        "hertz_point + flores + coulomb",
        "hertz_point + flores + mindlin",
    ]
    assert [one.name for one in found[0].free] == ["restitution"]
    assert found[2].law.describe()["friction.friction_coefficient"] == 0.2
    free = models_of(["law/normal=linear", "law.normal.stiffness=1 N/um..1 kN/um"])[0].free
    assert [(one.low, one.high) for one in free if one.name == "normal.stiffness"] == [(1e6, 1e9)]
