"""Impacts of a rigid law by itself: drawn states, and what its impulses leave and cost."""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from contactlab.engine.rigid import remaining_slip
from contactlab.laws import MultiplierLaw
from contactlab.laws.base import SLIP, STICK
from contactlab.testing.claim import Claim
from contactlab.testing.kernel_properties import impacts_of
from contactlab.testing.plants import Bench, impulses_of

Delassus = tuple[float, float, float]
Solution = tuple[float, float, int]


def drawn_impacts(count: int, coupling: float = 0.99) -> Iterator[tuple[float, float, Delassus, float]]:
    """Draw gap rates and slips [m/s], matrices [1/kg] and friction coefficients, none of them special."""
    rng = np.random.default_rng(7)
    for _ in range(count):
        d_nn, d_tt = 10.0 ** rng.uniform(1.0, 4.0, 2)
        d_nt = rng.uniform(-coupling, coupling) * sqrt(d_nn * d_tt)
        normal, slip = -(10.0 ** rng.uniform(-3.0, 0.0)), rng.normal() * 10.0 ** rng.uniform(-3.0, 0.0)
        yield (
            float(normal),
            float(slip),
            (float(d_nn), float(d_nt), float(d_tt)),
            float(rng.uniform(0.0, 1.5)),
        )


def impact_of(law: MultiplierLaw, normal: float, slip: float, d: Delassus) -> Solution:
    """Impulses and mode of an impact in which nothing else acts."""
    p_n, p_t = impulses_of(law, normal, slip, d)
    return p_n, p_t, STICK if remaining_slip(slip, p_n, p_t, d[1], d[2]) == 0.0 else SLIP


def after(normal: float, slip: float, d: Delassus, solution: Solution) -> tuple[float, float]:
    """Gap rate and slip behind an impulse [m/s]."""
    p_n, p_t, _ = solution
    return normal + d[0] * p_n + d[1] * p_t, slip + d[1] * p_n + d[2] * p_t


def loss(normal: float, slip: float, d: Delassus, solution: Solution) -> float:
    """Energy that an impulse takes: minus impulse times mean velocity [J]."""
    end = after(normal, slip, d, solution)
    return -0.5 * (solution[0] * (normal + end[0]) + solution[1] * (slip + end[1]))


def round_off(normal: float, slip: float, d: Delassus, solution: Solution) -> float:
    """Round-off of a velocity [m/s], larger where the matrix is near to singular."""
    p_n, p_t, _ = solution
    terms = [normal, slip, d[0] * p_n, d[1] * p_t, d[1] * p_n, d[2] * p_t]
    return 1e-12 * max(abs(term) for term in terms) / (1.0 - d[1] ** 2 / (d[0] * d[2]))


def contact_energy(normal: float, slip: float, d: Delassus) -> float:
    """Energy that an impact can take at most: v' D^-1 v / 2 [J]."""
    v = np.array([normal, slip])
    return float(0.5 * v @ np.linalg.solve([[d[0], d[1]], [d[1], d[2]]], v))


def broken(law: MultiplierLaw) -> dict[str, list[str]]:
    """Claims of the contract on the kernel that do not come out as the law declares, by property."""
    result = impacts_of(Bench(law))
    return {
        name: wrong
        for name, claims in result.items()
        if (wrong := _wrong(list(claims.values()), law.violations.get(name, "")))
    }


def _wrong(claims: list[Claim], excuse: str) -> list[str]:
    failing = [str(claim) for claim in claims if not claim.true]
    if excuse:
        return [] if failing else [f"declared broken, and holds: {excuse}"]
    return failing


def double_pendulum() -> tuple[float, float, tuple[float, float, float]]:
    """Two equal rods that swing down onto the floor, after Kane and Levinson (1985).

    Angles of 20 and 30 degrees from the vertical, rates of -0.1 and -0.2 rad/s; mass and length one.
    """
    first_angle, second_angle = np.radians([20.0, 30.0])
    along = np.cos([first_angle, second_angle])
    # Of the free end: its gap, which grows with the angles, and its way along the floor.
    rows = np.array([np.sin([first_angle, second_angle]), along])
    coupling = 0.5 * np.cos(second_angle - first_angle)
    inverse = np.linalg.inv([[4.0 / 3.0, coupling], [coupling, 1.0 / 3.0]])
    (d_nn, d_nt), (_, d_tt) = rows @ inverse @ rows.T
    normal, slip = rows @ [-0.1, -0.2]
    return float(normal), float(slip), (float(d_nn), float(d_nt), float(d_tt))
