"""Claims on the drives of a configuration: tones and samples of files are those of the formula."""

from pathlib import Path

import numpy as np
import pytest

import contactlab as cl

TONE = "voltage_1 [V],phase_1 [rad],voltage_2 [V],phase_2 [rad]\n"


def samples(path: Path, time: np.ndarray, voltage: np.ndarray) -> Path:
    rows = [",".join(repr(float(x)) for x in row) for row in zip(1e3 * time, *voltage, strict=True)]
    path.write_text("\n".join(["time [ms],voltage_1 [V],voltage_2 [V]", *rows]) + "\n")
    return path


def test_two_phases_are_what_they_say() -> None:
    drive = cl.build(["drive=two_phase", "drive.frequency=38.8 kHz", "drive.phase=30 deg"]).motor.drive
    time = np.linspace(0.0, 1e-4, 57)
    omega = 2.0 * np.pi * 38.8e3
    expected = [100.0 * np.sin(omega * time), 100.0 * np.sin(omega * time + np.pi / 6.0)]
    assert drive.voltage(time) == pytest.approx(np.array(expected), abs=1e-10)


def test_tones_of_a_file_are_the_drive_of_the_paper(tmp_path: Path) -> None:
    two = cl.build(["drive.frequency=3210", "drive.phase=-36 deg"]).motor.drive
    path = tmp_path / "tones.csv"
    path.write_text(
        "frequency [kHz];voltage_1 [V];phase_1 [deg];voltage_2 [V];phase_2 [deg]\n"
        "3,21;100;-36;100;-36\n6,42;100;0;100;180\n"
    )
    read = cl.build(["drive=tones", f"drive.file={path}"]).motor.drive
    assert read.frequency == pytest.approx(two.frequency)
    assert read.phasors == pytest.approx(two.phasors, abs=1e-10)


def test_nine_tones_are_as_good_as_two(tmp_path: Path) -> None:
    """Silent tones change nothing."""
    path = tmp_path / "tones.csv"
    rows = [f"{1000.0 * k},0,0,0,0" for k in range(1, 8)]
    head = "frequency [Hz],voltage_1 [V],phase_1 [rad],voltage_2 [V],phase_2 [rad]"
    sound = ["3210,100,-0.6,100,-0.6", "6420,100,0,100,3.14"]
    path.write_text("\n".join([head, *sound]))
    two = cl.build(["drive=tones", f"drive.file={path}", "solver.duration=2e-3"]).run()
    path.write_text("\n".join([head, *sound, *rows]))
    nine = cl.build(["drive=tones", f"drive.file={path}", "solver.duration=2e-3"]).run()
    assert nine.series["rotor_velocity"][-1] == pytest.approx(two.series["rotor_velocity"][-1], rel=1e-9)


@pytest.mark.parametrize("interpolation", ["linear", "cubic", "quintic", "septic"])
def test_samples_of_a_file_are_met(tmp_path: Path, interpolation: str) -> None:
    time = np.linspace(0.0, 1e-3, 101)
    voltage = np.stack([np.sin(1e4 * time), np.cos(2e4 * time)])
    path = samples(tmp_path / "volt.csv", time, voltage)
    chosen = ["drive=sampled", f"drive.file={path}", f"drive.interpolation={interpolation}"]
    drive = cl.build(chosen).motor.drive
    assert drive.voltage(time) == pytest.approx(voltage, abs=1e-12)
    assert not drive.voltage(np.array([-1e-6, 1.001e-3])).any()
    periodic = cl.build([*chosen, "drive.period=1.01 ms"]).motor.drive
    assert periodic.voltage(time + 7 * 1.01e-3) == pytest.approx(voltage, abs=1e-10)


@pytest.mark.parametrize(
    ("drive", "content", "named"),
    [
        ("sampled", "voltage_1 [V],voltage_2 [V]\n1,1\n", "time"),
        ("sampled", "time [s],voltage_1 [V]\n0,1\n1,2\n", "voltage_2"),
        ("sampled", "time [s],voltage_1 [V],voltage_2 [V],voltage_3 [V]\n0,1,1,1\n", "voltage_3"),
        ("sampled", "time [V],voltage_1 [V],voltage_2 [V]\n0,1,1\n", "time"),
        ("sampled", "time,voltage_1 [V],voltage_2 [V]\n0,1,1\n", "time"),
        ("sampled", "time [s],voltage_1 [V],voltage_2 [V]\n0,1,1\n0,1,1\n1,1,1\n2,1,1\n", "increase"),
        ("sampled", "time [s],voltage_1 [V],voltage_2 [V]\n0,1,1\n1,1,1\n", "samples"),
        ("sampled", "time [s],voltage_1 [V],voltage_2 [V]\n0,1,x\n", "voltage_2"),
        ("sampled", "", "columns"),
        ("tones", "frequency [Hz],voltage_1 [V]\n1000,1\n", "voltage_2"),
        (
            "tones",
            "frequency [s],voltage_1 [V],phase_1 [rad],voltage_2 [V],phase_2 [rad]\n1,1,0,1,0\n",
            "freq",
        ),
        (
            "tones",
            "frequency [Hz],voltage_1 [V],phase_1 [rad],voltage_2 [V],phase_2 [rad]\n-1,1,0,1,0\n",
            "-1",
        ),
    ],
)
def test_a_wrong_file_is_refused_by_name(tmp_path: Path, drive: str, content: str, named: str) -> None:
    path = tmp_path / "file.csv"
    path.write_text(content)
    with pytest.raises(cl.ConfigurationError, match=r"^drive\.file is") as refused:
        cl.build([f"drive={drive}", f"drive.file={path}"])
    assert named in str(refused.value)


def test_a_drive_without_its_file_or_with_another_is_refused(tmp_path: Path) -> None:
    with pytest.raises(cl.ConfigurationError, match=r"drive\.file"):
        cl.build(["drive=sampled"])
    time = np.linspace(0.0, 1e-3, 11)
    path = samples(tmp_path / "volt.csv", time, np.zeros((2, 11)))
    recorded = cl.build(["drive=sampled", f"drive.file={path}"]).configuration
    assert cl.build(recorded).configuration == recorded
    samples(path, time, np.ones((2, 11)))
    with pytest.raises(cl.ConfigurationError, match=r"drive\.digest"):
        cl.build(recorded)


@pytest.mark.parametrize("signal", ["two_mode", "two_phase", "chirp"])
def test_a_drive_of_two_electrodes_needs_two(tmp_path: Path, signal: str) -> None:
    path = tmp_path / "modes.csv"
    path.write_text("frequency [Hz],damping_ratio,uy,ux,coupling_1 [N/V]\n1000,0.01,10,2,0.1\n")
    with pytest.raises(cl.ConfigurationError, match=rf"drive={signal}"):
        cl.build(["resonator=modal", f"resonator.file={path}", f"drive={signal}"])
