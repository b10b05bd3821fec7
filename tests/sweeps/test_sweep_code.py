"""A run is complete only for the code that made it: ours, and that of a law from elsewhere."""

import dataclasses
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.command_line import Elsewhere
from support.configurations import composed
from support.sweeps import QUICK

from contactlab.config import build
from contactlab.results import provenance
from contactlab.studies import run_state as state

THREE = ("-m", "contact.clearance=1e-6,2e-6,3e-6", *QUICK)


def test_a_change_of_any_source_that_a_run_depends_on_changes_the_digest(tmp_path: Path) -> None:
    for name in ("engine/loop.py", "plot/run.py"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_bytes(b"x = 1\n")
    first = provenance.digest_of(tmp_path)
    (tmp_path / "plot/run.py").write_bytes(b"x = 2\n")
    (tmp_path / "engine/loop.py").write_bytes(b"x = 1\r\n")
    assert provenance.digest_of(tmp_path) == first
    (tmp_path / "engine/loop.py").write_bytes(b"x = 2\n")
    changed = provenance.digest_of(tmp_path)
    (tmp_path / "engine/loop.py").rename(tmp_path / "engine/other.py")
    assert len({first, changed, provenance.digest_of(tmp_path)}) == 3


FRAGILE = """
from dataclasses import dataclass
from typing import ClassVar
from contactlab.laws import PenaltyLaw

@dataclass(frozen=True)
class Fragile(PenaltyLaw):
    name: ClassVar[str] = "fragile"
    equation: ClassVar[str] = "none"
    source: ClassVar[str] = "a test"
    default_contact_step: ClassVar[float] = 4e-6

    @staticmethod
    def force(gap):
        # Between the depths at which it is evaluated before it runs.
        if -5e-7 < gap < -2e-7:
            return {"text": [f"{gap}"]}["FOUND"], 0.0, 0.0, 0.0
        return -1e7 * gap, 0.0, 5e6 * gap * gap, 0.0
"""
FAULT = '{"text": [f"{gap}"]}["FOUND"], 0.0, 0.0, 0.0'


@pytest.mark.long
def test_a_law_that_raises_harms_no_other_and_is_run_again_when_it_is_mended(tmp_path: Path) -> None:
    elsewhere = Elsewhere(tmp_path / "packages", tmp_path)
    law = {"fragile": "fragile:Fragile"}
    elsewhere.install(elsewhere.wheel("fragile-law", "0.1", law, {"fragile": FRAGILE}))
    lines = ("-m", "law=fragile,hertz_penalty", "solver.duration=0.5 ms", *QUICK)
    status, out, err = elsewhere.command(*lines)
    assert status == 1
    assert "The run ended because the law fragile raised KeyError: 'FOUND'" in out
    assert "Traceback" not in err
    assert "1 complete\n1 failed\n" in out
    place = tmp_path / "sweep/law=fragile,record.picture=false,solver.duration=0.5_ms"
    assert "KeyError: 'FOUND'" in (place / "run.log").read_text(encoding="utf-8")
    with xarray.open_dataset(tmp_path / "sweep/sweep.nc") as result:
        assert result["status"].sel(law="fragile") == 4
        assert "raised KeyError: 'FOUND'" in str(result["reason"].sel(law="fragile").values)
        assert np.isfinite(result["rotor_velocity"].sel(law="hertz_penalty"))
        assert np.isnan(result["rotor_velocity"].sel(law="fragile"))
    # The same version of the package with other code in it.
    mended = elsewhere.packages / "fragile.py"
    mended.write_text(mended.read_text().replace(FAULT, "-1e7 * gap, 0.0, 5e6 * gap * gap, 0.0"))
    assert elsewhere.command(*lines)[0] == 0
    assert not (place / "run.log").exists()


def test_the_key_of_a_law_of_another_package_follows_its_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    setup = build(composed())
    keys = []
    for text in (FRAGILE, FRAGILE, FRAGILE.replace("FOUND", "text")):
        (tmp_path / "fragile.py").write_text(text)
        spec = spec_from_file_location("fragile", tmp_path / "fragile.py")
        assert spec is not None
        assert spec.loader is not None
        module = module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "fragile", module)
        spec.loader.exec_module(module)
        keys.append(state.key_of(dataclasses.replace(setup, law=module.Fragile())))
    assert keys[0] == keys[1] != keys[2]
    assert state.key_of(setup) == state.key_of(build(setup.configuration))
