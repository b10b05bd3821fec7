"""Claims on resonators of files: they are what was written, whatever the form, and faults have a name."""

from dataclasses import replace
from difflib import SequenceMatcher
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays

import contactlab as cl
from contactlab.motor import NormalModes
from contactlab.motor.modal import read_modes, write_modes

HEAD = "frequency [Hz],damping_ratio,uy,ux,coupling_1 [N/V]"
ROW = "1000,0.01,10,2,0.1"


def written(path: Path, *lines: str) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("name", ["modes.csv", "modes.nc"])
def test_a_motor_of_a_file_is_the_one_that_was_written_bit_for_bit(tmp_path: Path, name: str) -> None:
    beam = cl.build(["solver.duration=2e-3"])
    write_modes(beam.motor.modes, tmp_path / name)
    again = cl.build(["resonator=modal", f"resonator.file={tmp_path / name}", "solver.duration=2e-3"])
    for field in ("stiffness", "damping", "coupling", "tip_displacement", "tip_slope", "capacitance"):
        assert np.array_equal(getattr(again.motor.modes, field), getattr(beam.motor.modes, field))
    first, second = beam.run(), again.run()
    assert first.contacts["start_time"].size
    for series, values in first.series.items():
        assert np.array_equal(second.series[series], values), series


@pytest.mark.parametrize("name", ["modes.csv", "modes.nc"])
def test_a_point_of_a_file_is_the_one_that_was_written_and_the_run_records_it(
    tmp_path: Path, name: str
) -> None:
    modes = cl.build().motor.modes
    write_modes(replace(modes, points={"foot": modes.tip_displacement}), tmp_path / name)
    again = cl.build(["resonator=modal", f"resonator.file={tmp_path / name}", "solver.duration=1e-3"])
    assert np.array_equal(again.motor.modes.points["foot"], modes.tip_displacement)
    tree = cl.simulate(again).to_xarray()
    assert tree["point_foot"].attrs["units"] == "m"
    assert tree["point_foot_velocity"].attrs["units"] == "m s-1"
    np.testing.assert_allclose(tree["point_foot"], tree["tip_normal_displacement"], rtol=1e-13, atol=1e-20)


def test_shapes_of_any_scale_have_the_same_modes(tmp_path: Path) -> None:
    """A shape with the modal mass m is m^-1/2 times as large per unit mass, and its coupling as well."""
    unit = read_modes(written(tmp_path / "one.csv", HEAD, ROW), 0.02)
    other = read_modes(
        written(tmp_path / "two.csv", f"{HEAD},modal_mass [g]", "1000,0.01,1,0.2,0.01,10"), 0.02
    )
    for field in ("stiffness", "damping", "coupling", "tip_displacement", "tip_slope"):
        assert getattr(other, field) == pytest.approx(getattr(unit, field), rel=1e-12)
    omega = 2e3 * np.pi
    assert unit.stiffness[0] == pytest.approx(omega**2, rel=1e-15)
    assert unit.damping[0] == pytest.approx(2 * 0.01 * omega, rel=1e-15)


def test_displacement_and_rotation_of_a_rigid_tip_are_one_motion(tmp_path: Path) -> None:
    length = 0.02
    along = read_modes(written(tmp_path / "ux.csv", HEAD, ROW), length)
    head = HEAD.replace("ux", "rotation [rad/m]")
    turned = read_modes(written(tmp_path / "turn.csv", head, f"1000,0.01,10,{-2 / length},0.1"), length)
    assert along.tip_slope == pytest.approx(turned.tip_slope, rel=1e-15)
    assert -length * along.tip_slope == pytest.approx([2.0])


def test_modal_stiffness_and_damping_are_those_of_the_frequency(tmp_path: Path) -> None:
    omega = 2e3 * np.pi
    head = HEAD.replace("frequency [Hz],damping_ratio", "stiffness [N/m],damping [N s/m]")
    made = read_modes(written(tmp_path / "k.csv", head, f"{omega**2!r},{0.02 * omega!r},10,2,0.1"), 0.02)
    assert made.natural_frequency[0] == pytest.approx(1000.0, rel=1e-14)
    assert made.damping_ratio[0] == pytest.approx(0.01, rel=1e-14)


def test_modes_are_sorted_and_the_lowest_are_taken(tmp_path: Path) -> None:
    rows = ["3000,0.01,1,1,0.1", "1000,0.01,2,1,0.1", "2000,0.01,3,1,0.1"]
    path = written(tmp_path / "modes.csv", HEAD, *rows)
    assert read_modes(path, 0.02).tip_displacement.tolist() == [2.0, 3.0, 1.0]
    assert read_modes(path, 0.02, 2).natural_frequency == pytest.approx([1000.0, 2000.0])
    setup = cl.build(["resonator=modal", f"resonator.file={path}", "resonator.modes=1", *tone_of(tmp_path)])
    assert setup.motor.modes.stiffness.size == 1


def tone_of(folder: Path) -> list[str]:
    path = written(folder / "tones.csv", "frequency [Hz],voltage_1 [V],phase_1 [rad]", "1500,10,0")
    return ["drive=tones", f"drive.file={path}"]


def test_capacitances_are_those_of_the_comments(tmp_path: Path) -> None:
    comments = ["# capacitance_1_1: 2 nF", "# capacitance_2_2: 3 nF", "# capacitance_1_2: -0.1 nF"]
    lines = f"{HEAD},coupling_2 [N/V]", f"{ROW},0.2"
    made = read_modes(written(tmp_path / "modes.csv", *comments, *lines), 0.02)
    assert made.capacitance is not None
    assert made.capacitance == pytest.approx(np.array([[2e-9, -1e-10], [-1e-10, 3e-9]]))


def test_an_impact_meets_the_tips_mass_where_the_residual_is_known(tmp_path: Path) -> None:
    numbers = ["residual_uu: 1e-7 m/N", "residual_ur: 0 1/N", "residual_rr: 0.01 rad/(N m)"]
    tip = ["tip_mass: 1.5 g", "tip_inertia: 2e-7 kg m^2"]
    head = HEAD.replace("ux", "rotation [rad/m]")
    lines = [*(f"# {each}" for each in [*numbers, *tip]), head, ROW]
    modes = read_modes(written(tmp_path / "modes.csv", *lines), 0.02)
    assert 1.0 / float(modes.tip_displacement @ modes.tip_displacement) == pytest.approx(1.5e-3)
    kept = slice(1, None)
    yields = modes.tip_displacement[kept] ** 2 @ (1.0 / modes.stiffness[kept])
    assert yields == pytest.approx(1e-7)


@pytest.mark.parametrize(
    ("head", "row", "named"),
    [
        (f"# residual_uu: 1e-7 m/N\n{HEAD}", ROW, "residual_ur"),
        (f"# tip_mass: 1 g\n{HEAD}", ROW, "residual_uu"),
        (HEAD.replace("uy,", ""), "1000,0.01,2,0.1", "uy"),
        (HEAD.replace("ux,", ""), "1000,0.01,2,0.1", "rotation"),
        (f"{HEAD},rotation [rad/m]", f"{ROW},1", "rotation"),
        (HEAD.replace("frequency [Hz],", ""), "0.01,10,2,0.1", "stiffness"),
        (f"{HEAD},stiffness [N/m]", f"{ROW},1", "stiffness"),
        (HEAD.replace("damping_ratio", "damping [N s/m]"), ROW, "damping"),
        (HEAD.replace("[Hz]", "[m]"), ROW, "frequency"),
        (HEAD.replace("[N/V]", ""), ROW, "coupling_1"),
        (HEAD.replace("coupling_1", "coupling_2"), ROW, "coupling_1"),
        (HEAD.replace("coupling_1", "force"), ROW, "coupling_1"),
        (f"{HEAD},uz", f"{ROW},1", "uz"),
        (f"{HEAD},uy", f"{ROW},1", "uy"),
        (HEAD, "-1000,0.01,10,2,0.1", "frequency"),
        (HEAD, "1000,-0.01,10,2,0.1", "damping_ratio"),
        (HEAD, "1000,0.01,nan,2,0.1", "uy"),
        (HEAD, "1000,0.01,inf,2,0.1", "uy"),
        (HEAD, "1000,0.01,ten,2,0.1", "uy"),
        (HEAD, "1000,0.01,10,2", "4 cells"),
        (f"{HEAD},modal_mass [kg]", f"{ROW},0", "modal_mass"),
        (f"# capacitance_2_2: 1 nF\n{HEAD}", ROW, "capacitance_2_2"),
        (f"# capacitance_1_1: 1 m\n{HEAD}", ROW, "capacitance_1_1"),
    ],
)
def test_a_wrong_file_is_refused_by_the_name_of_its_column(
    tmp_path: Path, head: str, row: str, named: str
) -> None:
    path = written(tmp_path / "modes.csv", head, row)
    with pytest.raises(cl.ConfigurationError, match=r"^resonator\.file is") as refused:
        cl.build(["resonator=modal", f"resonator.file={path}"])
    assert named in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"\x89HDF\r\n\x1a\n", b"\xff\xfe\x00"])
def test_what_is_no_table_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "modes.csv"
    path.write_bytes(content)
    with pytest.raises(cl.ConfigurationError, match=r"^resonator\.file is"):
        cl.build(["resonator=modal", f"resonator.file={path}"])


def test_a_file_that_is_not_there_or_has_changed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "modes.csv"
    with pytest.raises(cl.ConfigurationError, match=r"resonator\.file"):
        cl.build(["resonator=modal", f"resonator.file={path}"])
    write_modes(cl.RitzResonator().modes, path)
    recorded = cl.build(["resonator=modal", f"resonator.file={path}"]).configuration
    assert cl.build(recorded).configuration == recorded
    write_modes(cl.RitzResonator(shapes=3).modes, path)
    with pytest.raises(cl.ConfigurationError, match=r"resonator\.digest"):
        cl.build(recorded)


def test_what_a_file_has_is_no_option_beside_it(tmp_path: Path) -> None:
    write_modes(cl.RitzResonator().modes, tmp_path / "modes.csv")
    chosen = ["resonator=modal", f"resonator.file={tmp_path / 'modes.csv'}"]
    with pytest.raises(cl.ConfigurationError, match=r"placement\.end"):
        cl.build([*chosen, "placement.end=8 mm"])
    with pytest.raises(cl.ConfigurationError, match=r"piezoceramic\.density"):
        cl.build([*chosen, "piezoceramic.density=7000"])


def test_a_motor_of_three_electrodes_closes_its_ledger(tmp_path: Path) -> None:
    """Three electrodes are two, where the third couples like the sum of both."""
    beam = cl.build(["solver.duration=3e-3"]).motor
    modes, drive = beam.modes, beam.drive
    wide = NormalModes(
        stiffness=modes.stiffness,
        damping=modes.damping,
        coupling=np.column_stack([modes.coupling, modes.coupling.sum(axis=1)]),
        tip_displacement=modes.tip_displacement,
        tip_slope=modes.tip_slope,
    )
    # U1 + U3 and U2 + U3 are the voltages of the two.
    split = np.vstack([0.5 * drive.phasors, 0.0 * drive.phasors[:1]])
    split[2] = 0.5 * drive.phasors[0]
    split[1] = drive.phasors[1] - split[2]
    motors = [beam, cl.Motor(wide, cl.Drive(drive.frequency, split))]
    two, three = (cl.simulate(motor, cl.HertzPenalty(), duration=3e-3) for motor in motors)
    assert three["rotor_velocity"].values == pytest.approx(two["rotor_velocity"].values, abs=1e-9)
    assert abs(float(three["energy_residual"][-1])) < 1e-9 * float(three["drive_work"][-1])


CAPACITOR = f"{HEAD},coupling_2 [N/V]", f"{ROW},0.2"


@pytest.mark.parametrize(
    "lines",
    [
        ("# capacitance_1_1: 2 nF", "# capacitance_2_2: 2 nF", "# capacitance_1_2: 3 nF", *CAPACITOR),
        (
            *("# capacitance_1_1: 2 nF", "# capacitance_2_2: 2 nF", "# capacitance_1_2: 1 nF"),
            *("# capacitance_2_1: -1 nF", *CAPACITOR),
        ),
        ("# capacitance_1_1: -2 nF", "# capacitance_2_2: 2 nF", *CAPACITOR),
        ("# loss_tangent: -2", HEAD, ROW),
        (HEAD,),
        (HEAD, "1000,0.01,0,2,0.1"),
        (HEAD, "1000,3,10,2,0.1"),
    ],
)
def test_a_file_without_the_motion_or_with_a_negative_energy_is_refused(
    tmp_path: Path, lines: tuple[str, ...]
) -> None:
    path = written(tmp_path / "modes.csv", *lines)
    with pytest.raises(cl.ConfigurationError, match=r"^resonator\.file is"):
        cl.build(["resonator=modal", f"resonator.file={path}"])


@settings(max_examples=30)
@given(arrays(np.float64, (2, 2), elements=st.floats(-1e-8, 1e-8)))
def test_a_capacitance_is_symmetric_and_stores_no_negative_energy(matrix: np.ndarray) -> None:
    modes = cl.RitzResonator().modes
    sound = matrix @ matrix.T
    assert replace(modes, capacitance=sound).capacitance is not None
    least = float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min())
    if abs(matrix[0, 1] - matrix[1, 0]) > 1e-15 or least < -1e-15:
        with pytest.raises(ValueError, match="capacitance"):
            replace(modes, capacitance=matrix)


def test_a_table_of_tones_without_a_row_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "tones.csv", "frequency [Hz],voltage_1 [V],voltage_2 [V],phase_1,phase_2")
    with pytest.raises(cl.ConfigurationError, match=r"^drive\.file is"):
        cl.build(["drive=tones", f"drive.file={path}"])


@settings(max_examples=10)
@given(st.text(min_size=61, max_size=400))
def test_the_refusal_of_a_file_shows_60_of_its_characters_and_no_control(content: str) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "modes.csv"
        path.write_text("SECRET=" + content, encoding="utf-8")
        with pytest.raises(cl.ConfigurationError) as refused:
            cl.build(["resonator=modal", f"resonator.file={path}"])
    shown = str(refused.value).replace(str(path), "")
    assert shown.isprintable()
    longest = SequenceMatcher(None, shown, "SECRET=" + content, autojunk=False).find_longest_match()
    assert longest.size <= 60
