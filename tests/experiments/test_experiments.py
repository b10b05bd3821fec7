"""Every experiment in its short form leaves its files, and one number of it is physics."""

import sys
from collections.abc import Callable
from pathlib import Path

import all as everything
import experiment
import numpy as np
import pytest
import xarray
from support.command_line import cases
from support.configurations import CONF

Number = Callable[[xarray.Dataset], float]

NUMBERS: dict[str, tuple[Number, float, float]] = {
    # First natural frequency of placement 2 [Hz], which is printed as 3.21 kHz.
    "table1_placement": (lambda d: float(d.computed[1, 3]), 3210.121, 1e-3),
    # A tip that is ahead of the rotor is pushed to the left.
    "table2_friction_signs": (lambda d: float(np.sign(d.friction_impulse[0])), -1.0, 0.0),
    # The curvature of a clamped beam's first shape at the clamp, 2 b^2.
    "fig3_mode_curvature": (lambda d: float(d.curvature[0, 0]) * 0.057**2, 2.0 * 4.730040744862704**2, 1e-6),
    # Placement 1 keeps 30 % of its height away from the first resonance.
    "fig4_trajectories": (
        lambda d: float(np.ptp(d.height[0, 0].values) / np.ptp(d.height[0, 1].values)),
        0.2993,
        1e-3,
    ),
    # Without clearance the rotor cuts the eight in half: nothing stays above it.
    "fig7_constrained_trajectories": (
        lambda d: float(d.tip_normal_displacement.sel(law="lagrange_slip", clearance=0.0).max()),
        0.0,
        2e-8,
    ),
    # Hertz at 1 um after 5 ms, near the reference case [rad/s].
    "fig8_rotor_velocity": (lambda d: float(d.transient[2, 1, -1]), -0.44676, 1e-3),
    # A quarter of the step, four times the peak.
    "fig9_normal_force": (lambda d: float(d.peak[1] / d.peak[0]), 4.0, 0.1),
    # What sticks has no slip [m/s].
    "fig10_sticking": (
        lambda d: float(np.abs((d.tip_velocity - d.rim_velocity)[2][d.contact_mode[2] == 2]).median()),
        0.0,
        1e-6,
    ),
    # Tip mass from Table 1 [g].
    "identify_table1": (lambda d: 1e3 * float(d.fitted.sel(input="tip mass")), 1.181, 2e-3),
    # On the curve the frequencies have a ratio of two.
    "optimum_placement": (lambda d: float(np.abs(d.curve_ratio - 2.0).max()), 0.0, 1e-3),
    # Converged first natural frequency [Hz].
    "basis_convergence": (lambda d: float(d.first_frequency[-1]), 2137.532, 5e-3),
    # Peak over step of the slip law.
    "impact_step_study": (lambda d: float(d.peak_exponent[0]), -1.0, 0.02),
    # With residual modes an impact meets the tip's mass [g].
    "impact_mass": (lambda d: 1e3 * float(d.mass.isel(residual_mass=1, step=-1).min()), 1.181, 1e-3),
    # Turning the phase by pi changes nothing: from -pi to pi the velocity comes back [rad/s].
    "drive_phase_map": (
        lambda d: float(np.abs(d.rotor_velocity[0, :, 0] - d.rotor_velocity[0, :, -1]).max()),
        0.0,
        1e-6,
    ),
    # The last contact goes where the tip just bridges the clearance [m].
    "orbits_over_clearance": (lambda d: float(d["last"][0] / d.bridged), 1.0, 1e-3),
    # The period of an oscillator with a stop doubles where Shaw and Holmes say.
    "impact_oscillator": (lambda d: float(d.found[0] / d.published[0]), 1.0, 1e-6),
    # More friction turns a settled motor slower.
    "friction_sweep": (
        lambda d: float(np.sign(np.abs(d.rotor_velocity[1]).diff("friction_coefficient"))[0]),
        -1.0,
        0.0,
    ),
    # A run that has settled does what shooting says [rad/s].
    "steady_states": (
        lambda d: float(np.ptp(d.velocity.sel(law="newton", way=["shooting", "run"])[0].values)),
        0.0,
        1e-7,
    ),
    # A foot that friction does not disturb: the speed is the median of its free velocity.
    "published_motor": (lambda d: float(d.constant_load_run[0] / d.constant_load[0]), 1.0, 0.02),
    # A millionth of friction, another start and a coarse tolerance leave ln |speed|.
    "law_contrasts": (
        lambda d: float(
            np.abs(d.contrast_size[[c.startswith("null") for c in d.contrast.values], :, 0]).max()
        ),
        0.0,
        1e-4,
    ),
    # The law of the motor itself, whose numbers are the drawn ones, predicts it.
    "law_practice": (lambda d: float(d.prediction_error[:, 1].max()), 0.0, 1e-6),
    # The configured motor's stall torque [N m], as a run of its own on a belt at rest has it.
    "optimise_motor": (lambda d: float(d.stall_torque.sel(motor=-1)), 5.2094e-3, 1e-6),
}


SHORT = ("table1_placement", "table2_friction_signs", "fig3_mode_curvature", "basis_convergence")
"""Of less than two seconds; the physics and the parts of the others have tests of their own."""


@pytest.mark.parametrize("name", cases(NUMBERS, SHORT))
def test_the_short_form_leaves_its_files_and_its_number(name: str, tmp_path: Path) -> None:
    result = experiment.perform(name, tmp_path, short=True)
    assert result.data.attrs["says"]
    assert (tmp_path / f"{name}.png").stat().st_size > 5000
    assert (tmp_path / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    assert len((tmp_path / "table.csv").read_text().splitlines()) == 1 + len(result.tables["table"])
    number, expected, tolerance = NUMBERS[name]
    with xarray.open_dataset(tmp_path / f"{name}.nc") as data:
        assert number(data) == pytest.approx(expected, rel=0.0, abs=tolerance)
    page = everything.page([(result, tmp_path)])
    assert "data:image/png;base64," in page
    assert 'src="http' not in page


def test_every_experiment_is_tested_shown_and_configured() -> None:
    assert set(NUMBERS) == {*everything.PAPER, *everything.BEYOND}
    assert {path.stem for path in (CONF / "experiment").glob("*.yaml")} == {*NUMBERS, "case_a"}


@pytest.mark.usefixtures("command")
@pytest.mark.parametrize(
    ("overrides", "status", "key"),
    [
        pytest.param(["drive.frequency=3 kHz"], 0, "finding", marks=pytest.mark.long),
        # Patches of another length: not the numbers of Table 1.
        (["resonator.tip_mass=2 g"], 1, "finding"),
        (["contact.clearance=-1"], 2, "contact.clearance"),
    ],
)
def test_the_exit_status_is_that_of_the_finding_or_of_a_refusal(
    overrides: list[str],
    status: int,
    key: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(sys, "argv", ["table1_placement.py", "output=out", *overrides])
    with pytest.raises(SystemExit) as ended:
        experiment.main("table1_placement.py")
    assert ended.value.code == status
    if status == 2:
        assert key in capfd.readouterr().err
        assert not (tmp_path / "out").exists()
    else:
        assert xarray.load_dataset(tmp_path / "out" / "table1_placement.nc").attrs["holds"] == 1 - status
