"""What is left out of the kept modes stays in the contact: flexibility, voltages, forces, rotor."""

import numpy as np
import pytest
from oracle.stepped_beam import response
from support.motors import PLACEMENT_1, PLACEMENT_2, final, hertz, run, stepped_beam

from contactlab.motor import FiniteElementResonator, NormalModes
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.motor.patched_beam import Piezoceramic
from contactlab.trajectory import Trajectory

PLACEMENTS = [PLACEMENT_1, PLACEMENT_2]
ROUND_OFF = 1e-11
"""Of the transfer matrices at low frequency, whose tip motion is a difference of large numbers."""


def modal_response(modes: NormalModes, frequency: float) -> np.ndarray:
    """(u / N, u / V in phase, theta / N m, theta / V in opposition) at a frequency, shape (4,)."""
    omega = 2.0 * np.pi * frequency
    compliance = 1.0 / (modes.stiffness - omega**2 + 1j * omega * modes.damping)
    lift, turn = modes.tip_displacement * compliance, modes.tip_slope * compliance
    return np.array(
        [
            lift @ modes.tip_displacement,
            lift @ (modes.coupling[:, 0] + modes.coupling[:, 1]),
            turn @ modes.tip_slope,
            turn @ (modes.coupling[:, 0] - modes.coupling[:, 1]),
        ]
    )


def response_error(resonator: FiniteElementResonator, frequency: float) -> np.ndarray:
    """Relative error of `modal_response` against the exact one, shape (4,)."""
    beam = stepped_beam(resonator)
    exact = [*response(beam, frequency, lifting=True), *response(beam, frequency, lifting=False)]
    return np.abs(modal_response(resonator.modes, frequency) / np.array(exact) - 1.0)


@pytest.mark.parametrize("kept", [1, 4, 12])
@pytest.mark.parametrize("placement", PLACEMENTS)
def test_response_to_constant_loads_and_voltages_is_exact_with_any_number_of_modes(
    placement: dict[str, float], kept: int
) -> None:
    # At 0.1 Hz inertia and damping are 1e-8 of the elastic forces, in both models alike.
    resonator = FiniteElementResonator(kept_modes=kept, **placement)
    assert response_error(resonator, 0.1).max() < ROUND_OFF


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_at_the_drive_frequencies_six_modes_with_correction_are_exact_to_1e_6(
    placement: dict[str, float],
) -> None:
    corrected = FiniteElementResonator(kept_modes=6, **placement)
    truncated = FiniteElementResonator(kept_modes=6, static_correction=False, **placement)
    for frequency in (1000.0, 2137.5, 4275.0):
        assert response_error(corrected, frequency).max() < 1e-6
        assert response_error(truncated, frequency).max() > 1e-3


@pytest.mark.parametrize(
    "changes",
    [
        # From clamp to tip, a patch works by its moment on the tip alone.
        {"patch_start": 0.0, "patch_end": 28.5e-3},
        {"piezoceramic": Piezoceramic(bending_coupling=0.0)},
    ],
)
def test_loads_that_add_nothing_make_no_pseudo_mode(changes: dict[str, object]) -> None:
    modes = FiniteElementResonator(kept_modes=4, **changes).modes  # type: ignore[arg-type]
    assert modes.stiffness.size == 4 + 2
    flexibility = np.sum(modes.tip_slope**2 / modes.stiffness)
    full = FiniteElementResonator(kept_modes=12, **changes).modes  # type: ignore[arg-type]
    assert flexibility == pytest.approx(np.sum(full.tip_slope**2 / full.stiffness), rel=1e-11)


def driven(modes: NormalModes) -> Trajectory:
    """Case A at the converged first natural frequency, 5 ms from rest."""
    return run(Motor(modes, Drive.two_mode(100.0, 100.0, 2137.5, 2.0, -np.pi / 5.0)), hertz())


def contact_errors(modes: NormalModes, reference: Trajectory) -> np.ndarray:
    """Relative errors of peak force, normal impulse and final rotor velocity, shape (3,)."""
    measures = [
        np.array(
            [
                trajectory.contacts["peak_normal_force"].max(),
                trajectory.contacts["normal_impulse"].sum(),
                final(trajectory, "rotor_velocity"),
            ]
        )
        for trajectory in (driven(modes), reference)
    ]
    return np.abs(measures[0] / measures[1] - 1.0)


@pytest.fixture(scope="module")
def reference() -> Trajectory:
    """Twenty modes and their correction."""
    return driven(FiniteElementResonator(kept_modes=20).modes)


@pytest.mark.parametrize(("kept", "bound"), [(4, 2e-4), (6, 2e-6)])
def test_forces_and_rotor_of_a_few_corrected_modes_are_those_of_twenty(
    reference: Trajectory, kept: int, bound: float
) -> None:
    corrected = contact_errors(FiniteElementResonator(kept_modes=kept).modes, reference)
    truncated = FiniteElementResonator(kept_modes=kept, static_correction=False).modes
    assert corrected.max() < bound
    assert contact_errors(truncated, reference).max() > 20.0 * bound
