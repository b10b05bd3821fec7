"""Residual modes: mass, statics and frequency response at the tip, and impacts over the number of modes."""

from dataclasses import replace
from math import gamma

import numpy as np
import pytest

import contactlab as cl
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.patched_beam import PatchedBeam
from contactlab.trajectory import openness

DAMPED = {"damping_ratio": 0.02}
SPEED = 0.1
TRUNCATED = {"finite_element": {"static_correction": False}}


def resonator(basis: str, modes: int, **options: object) -> PatchedBeam:
    """Return the default beam with so many shapes or kept modes and the residual modes."""
    options = {"residual_mass": True, **options}
    if basis == "ritz":
        return cl.RitzResonator(shapes=modes, **options)  # type: ignore[arg-type]
    return cl.FiniteElementResonator(kept_modes=modes, **options)  # type: ignore[arg-type]


def interface(modes: cl.NormalModes) -> np.ndarray:
    return np.stack([modes.tip_displacement, modes.tip_slope])


def test_static_response_of_a_uniform_beam_is_that_of_the_handbook() -> None:
    """Clamped at both ends: u = F L^3 / (192 E I) and theta = M L / (16 E I) in the middle."""
    beam = cl.RitzResonator(patch_thickness=1e-12, length=0.06)
    rigidity = beam.steel_rigidity
    expected = [beam.length**3 / (192.0 * rigidity), beam.length / (16.0 * rigidity)]
    np.testing.assert_allclose(beam.static_response[:, :2], np.diag(expected), rtol=1e-8, atol=1e-18)


@pytest.mark.parametrize("placement", [{}, {"patch_start": 0.0}, {"patch_end": 28.5e-3}])
def test_static_response_is_that_of_finite_elements(placement: dict[str, float]) -> None:
    beam = cl.FiniteElementResonator(**placement)
    mesh = beam.discretise((1,) * len(beam.mesh))
    static = mesh.shapes.T @ mesh.loads
    scale = np.abs(static[:, :2].T @ static).max(axis=1, keepdims=True)
    np.testing.assert_allclose(beam.static_response / scale, static[:, :2].T @ static / scale, atol=1e-13)


@pytest.mark.parametrize("count", [4, 12, 40])
@pytest.mark.parametrize("basis", ["ritz", "finite_element"])
def test_an_impulse_meets_the_tip_alone_and_statics_are_those_of_the_beam(basis: str, count: int) -> None:
    beam = resonator(basis, count)
    modes = beam.modes
    assert modes.stiffness.size == count + 2
    shapes = interface(modes)
    scale = np.sqrt([beam.tip_mass, beam.tip_inertia])
    np.testing.assert_allclose(scale[:, None] * (shapes @ shapes.T) * scale, np.eye(2), atol=1e-12)
    response = shapes / modes.stiffness @ np.hstack([shapes.T, modes.coupling])
    size = np.abs(beam.static_response).max(axis=1, keepdims=True)
    np.testing.assert_allclose(response / size, beam.static_response / size, atol=1e-10)
    truncated = resonator(basis, count, residual_mass=False, **TRUNCATED.get(basis, {})).modes
    assert np.array_equal(modes.stiffness[:count], truncated.stiffness)
    assert np.array_equal(modes.coupling[:count], truncated.coupling)


def receptances(modes: cl.NormalModes, frequency: float) -> np.ndarray:
    """Return displacement per force and slope per moment at a frequency, without damping."""
    dynamic = modes.stiffness - (2.0 * np.pi * frequency) ** 2
    return np.array([(rows**2 / dynamic).sum() for rows in interface(modes)])


def test_receptances_converge_by_orders_faster_than_truncation() -> None:
    """Modes left out have phi^2 of n^-2, slopes^2 of n^-4 and k of n^4: n^-5 and n^-7, and n^-4 beyond it."""
    counts = np.array([4, 8, 16])
    full = cl.FiniteElementResonator(kept_modes=40, static_correction=False)
    exact = receptances(cl.FiniteElementResonator(kept_modes=40).modes, 3000.0)
    mass = np.diag([full.tip_mass, full.tip_inertia])
    errors = []
    for n in counts:
        per_mode = ("stiffness", "damping", "coupling", "tip_displacement", "tip_slope")
        kept = replace(full.modes, **{name: getattr(full.modes, name)[:n] for name in per_mode})
        shapes = interface(kept)
        flexibility = full.static_response[:, :2] - shapes / kept.stiffness @ shapes.T
        both = kept, cl.add_residual_modes(kept, mass, flexibility)
        errors.append([np.abs(receptances(modes, 3000.0) / exact - 1.0) for modes in both])
    none, residual = -np.polyfit(np.log(counts), np.log(np.reshape(errors, (3, 4))), 1)[0].reshape(2, 2)
    np.testing.assert_allclose(none, [5.0, 7.0], atol=0.7)
    np.testing.assert_allclose(residual, [9.0, 11.0], atol=1.0)
    assert (residual > none + 3.0).all()


def moving(modes: cl.NormalModes, velocity: np.ndarray) -> cl.Motor:
    """Return a motor whose tip approaches a wall with `SPEED` at once, the modes moving in proportion."""
    shape = modes.tip_displacement
    return cl.Motor(
        modes,
        geometry=ContactGeometry(clearance=1e-13),
        rotor=cl.Rotor(inertia=1e9),
        start=cl.ModalState(np.zeros_like(shape), velocity * SPEED / (shape @ velocity)),
    )


def impulse(modes: cl.NormalModes, restitution: float, step: float) -> float:
    """Return the impulse of an impact of the tip alone over (1 + e) v [kg]."""
    motor = moving(modes, modes.tip_displacement)
    law = cl.Newton(friction_coefficient=0.0, restitution=restitution)
    run = cl.simulate(motor, law, duration=20.0 * step, contact_step=step, record_interval=step)
    # The contact after a plastic impact lasts, and has no force that is as large.
    first = run.contacts.peak_normal_force[0] if restitution == 0.0 else None
    whole = first * step if first is not None else run.contacts.normal_impulse[0]
    return float(whole) / ((1.0 + restitution) * SPEED)


@pytest.mark.parametrize(("damping", "step"), [(DAMPED, 1e-8), ({}, 1e-11)])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_the_impulse_of_an_impact_is_the_same_from_4_to_40_modes(
    restitution: float, damping: dict[str, float], step: float
) -> None:
    """Damped in proportion to stiffness, the beam is viscous: there an impact needs a shorter step."""
    counts = (4, 6, 12, 24, 40)
    attached = [impulse(resonator("finite_element", n, **damping).modes, restitution, step) for n in counts]
    np.testing.assert_allclose(attached, cl.FiniteElementResonator().tip_mass, rtol=1e-2)
    whole = [
        impulse(resonator("finite_element", n, residual_mass=False, **damping).modes, restitution, step)
        for n in (4, 40)
    ]
    assert whole[0] > 1.4 * whole[1] > 1.4 * 1.05 * attached[0]


def test_the_impulse_of_a_whole_contact_is_the_same_from_4_to_40_modes() -> None:
    """The beam moves in its first mode and pushes on after the impact."""
    impulses = []
    for count in (4, 8, 40):
        modes = resonator("finite_element", count).modes
        motor = moving(modes, np.eye(count + 2)[0])
        law = cl.Newton(friction_coefficient=0.0, restitution=0.0)
        run = cl.simulate(motor, law, duration=3e-4, contact_step=5e-8)
        impulses.append(float(run.contacts.normal_impulse[0]) / SPEED)
    np.testing.assert_allclose(impulses, 3.956e-3, rtol=1e-3)


@pytest.mark.parametrize("step", [5e-8, 2e-7, 1e-6])
def test_a_step_meets_the_tip_and_what_a_viscous_beam_adds_to_it(step: float) -> None:
    """m + 2^(3/2) (beta E I)^(1/4) (rho A)^(3/4) h^(1/4) / Gamma(9/4), see the theory of the motor."""
    beam = resonator("finite_element", 40)
    modes = beam.modes
    # Flow of an overdamped or vibrating mode from rest under a unit force.
    half = modes.damping / 2.0
    root = np.sqrt(half**2 - modes.stiffness + 0j)
    rates = np.stack([-modes.stiffness / (half + root), -half - root])
    velocity = np.real((np.exp(rates[0] * step) - np.exp(rates[1] * step)) / (rates[0] - rates[1]))
    met = step / (modes.tip_displacement**2 @ velocity)
    viscous = (beam.stiffness_damping * beam.steel_rigidity) ** 0.25 * beam.steel_mass**0.75
    expected = beam.tip_mass + 2.0**1.5 * viscous * step**0.25 / gamma(2.25)
    assert met == pytest.approx(expected, rel=0.01)
    assert met > 1.3 * beam.tip_mass


def test_the_ledger_of_a_motor_with_residual_modes_is_closed() -> None:
    for law, bound in (("hertz_penalty", 1e-9), ("newton", 1e-3)):
        setup = cl.build(["resonator=finite_element", "resonator.residual_mass=true", f"law={law}"])
        run = cl.simulate(setup, duration=3e-3)
        assert run.contacts.sizes["contact"] > 3
        residual, work = (np.abs(run[name]).max() for name in ("energy_residual", "drive_work"))
        assert openness(float(residual), float(work), 0.0, 0.0) < bound


def test_residual_modes_have_by_default_the_damping_ratio_of_the_stiffest() -> None:
    beam = cl.RitzResonator(damping_ratio=0.03)
    mass = np.diag([beam.tip_mass, beam.tip_inertia])
    modes = cl.add_residual_modes(beam.modes, mass, np.array([[1e-7, 1e-6], [1e-6, 0.1]]))
    np.testing.assert_allclose(modes.damping_ratio, 0.03, rtol=1e-12)
    residual = interface(modes)[:, -2:]
    assert np.array_equal(modes.coupling[-2:], np.zeros((2, 2)))
    np.testing.assert_allclose(residual / modes.stiffness[-2:] @ residual.T, [[1e-7, 1e-6], [1e-6, 0.1]])


@pytest.mark.parametrize(
    ("mass", "flexibility", "message"),
    [
        (np.ones(2), np.diag([1e-7, 0.1]), "mass"),
        (np.diag([-1e-3, 1e-7]), np.diag([1e-7, 0.1]), "mass"),
        (np.diag([1e-3, 1e-7]), np.array([[1e-7, 1e-3], [0.0, 0.1]]), "flexibility"),
        (np.diag([1e-3, 1e-7]), np.diag([1e-7, 0.0]), "flexibility"),
        # The kept modes alone meet less.
        (np.diag([1e-1, 1e-7]), np.diag([1e-7, 0.1]), "the inverse mass"),
    ],
)
def test_a_mass_or_flexibility_that_no_body_has_is_refused(
    mass: np.ndarray, flexibility: np.ndarray, message: str
) -> None:
    with pytest.raises(ValueError, match=f"^{message} "):
        cl.add_residual_modes(cl.RitzResonator().modes, mass, flexibility)


@pytest.mark.parametrize("key", ["tip_mass", "tip_inertia", "rod_length", "static_correction"])
def test_the_option_refuses_what_it_has_no_use_for(key: str) -> None:
    value = {"rod_length": "19 mm", "static_correction": "false"}.get(key, "0")
    with pytest.raises(cl.ConfigurationError, match=key):
        cl.build(["resonator=finite_element", "resonator.residual_mass=true", f"resonator.{key}={value}"])


def test_without_the_option_nothing_changes() -> None:
    for beam in (cl.RitzResonator(), cl.FiniteElementResonator()):
        assert not beam.residual_mass
        assert np.array_equal(replace(beam, residual_mass=False).modes.coupling, beam.modes.coupling)
