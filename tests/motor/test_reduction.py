"""Claims on the reduction of matrices: closed forms of a chain, a finite-element beam, and exact statics."""

import numpy as np
import pytest
from scipy.sparse import csr_array

import contactlab as cl
from contactlab.arrays import Array
from contactlab.motor.bodies import FLAT

COUNT, SPRING = 40, 1e8


def chain() -> tuple[Array, Array]:
    """Masses of 1 kg between springs, both ends held."""
    k = 2.0 * np.eye(COUNT) - np.eye(COUNT, k=1) - np.eye(COUNT, k=-1)
    return np.eye(COUNT), SPRING * k


def loads() -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(2)
    return np.eye(COUNT)[7], rng.normal(size=COUNT), rng.normal(size=(COUNT, 3))


@pytest.mark.parametrize("form", [np.asarray, csr_array])
def test_the_modes_of_a_chain_are_those_of_the_closed_form(form: type) -> None:
    m, k = chain()
    made = cl.reduced(form(m), form(k), *loads(), modes=5, static_correction=False)
    number = np.arange(1, 6)
    omega = 2.0 * np.sqrt(SPRING) * np.sin(0.5 * number * np.pi / (COUNT + 1))
    assert np.sqrt(made.stiffness) == pytest.approx(omega, rel=1e-10)
    shape = np.sqrt(2.0 / (COUNT + 1)) * np.sin(8 * number * np.pi / (COUNT + 1))
    assert np.abs(made.tip_displacement) == pytest.approx(np.abs(shape), rel=1e-8, abs=1e-10)
    assert made.damping_ratio == pytest.approx(np.full(5, 0.01))


@pytest.mark.parametrize("modes", [1, 4, 20])
def test_statics_are_exact_with_any_number_of_modes(modes: int) -> None:
    m, k = chain()
    uy, ux, coupling = loads()
    made = cl.reduced(m, k, uy, ux, coupling, modes=modes)
    rows = np.column_stack([made.tip_displacement, -FLAT * made.tip_slope, made.coupling])
    exact = np.column_stack([uy, ux, coupling])
    statics = exact.T @ np.linalg.solve(k, exact)
    assert rows.T @ (rows / made.stiffness[:, None]) == pytest.approx(statics, rel=1e-9)


def test_matrices_of_the_beam_are_the_beam() -> None:
    beam = cl.FiniteElementResonator()
    mesh = beam.discretise(beam.mesh)
    stiffness = np.linalg.inv(mesh.shapes @ mesh.shapes.T)
    uy, slope, *electrodes = mesh.loads.T
    made = cl.reduced(
        mesh.mass,
        0.5 * (stiffness + stiffness.T),
        uy,
        -0.019 * slope,
        np.stack(electrodes, axis=1),
        modes=beam.kept_modes,
        tip_length=0.019,
    )
    kept = slice(0, beam.kept_modes)
    assert made.natural_frequency[kept] == pytest.approx(beam.modes.natural_frequency[kept], rel=1e-6)
    for name in ("tip_displacement", "tip_slope"):
        mine, other = getattr(made, name)[kept], getattr(beam.modes, name)[kept]
        assert np.abs(mine) == pytest.approx(np.abs(other), rel=1e-4, abs=1e-4 * np.abs(other).max())


@pytest.mark.parametrize(
    "change",
    [
        {"stiffness": np.zeros((COUNT, COUNT))},
        {"stiffness": np.eye(COUNT - 1)},
        {"mass": np.eye(COUNT - 1)},
        {"uy": np.ones(3)},
        {"coupling": np.ones(COUNT)},
        {"modes": 0},
        {"modes": COUNT},
    ],
)
def test_what_is_no_held_structure_is_refused(change: dict[str, object]) -> None:
    m, k = chain()
    uy, ux, coupling = loads()
    with pytest.raises(ValueError, match=r"must"):
        cl.reduced(**{"mass": m, "stiffness": k, "uy": uy, "ux": ux, "coupling": coupling, **change})  # type: ignore[arg-type]
