"""Two of the benchmarks of Chung and Ooi (2011) at the level of one impact, each reduced to one contact.

Two spheres that meet with masses m_1, m_2 are one body of the mass m = m_1 m_2/(m_1 + m_2) along the normal;
as a solid sphere's moment of inertia is 2/5 m R^2, a friction impulse p changes the slip of the contact by
7/2 p/m: along the belt the body has the mass 2/7 m. A rigid plane is a sphere of no curvature and infinite
mass.

    4  a plane, 3.9 m/s at 5 to 85 degrees          the whole of it
    5  a plane, one normal speed                    steel; the polyethylene's constants are not to be had here

The others are Hertz's impact, the restitution that a damping is solved for, and gross sliding, which the
`tests/support/closed_forms.py` has. What sticks for a time is held to the curves of the paper and to
finite elements within what is said there: friction here slides as a whole (a Jenkins element), where spheres
slip from the rim inwards.

Source: Chung and Ooi (2011), Granular Matter 13, 643; test 5 Wu, Thornton and Li (2003), Adv. Powder
Technol. 14, 435; test 4 Kharaz, Gorham and Salman (2001), Powder Technol. 120, 281.
"""

from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, sqrt
from typing import final

import pytest

from contactlab.laws import ContactLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import Flores
from contactlab.laws.friction import Mindlin
from contactlab.laws.normal import HertzPoint
from contactlab.motor.motor import ModalState, Motor
from contactlab.testing.plants import block, first, run
from contactlab.trajectory import Trajectory

HEIGHT = 1e-9  # [m] from which everything falls


@final
@dataclass(frozen=True)
class Material:
    """Young's modulus [Pa], Poisson's ratio and density [kg/m^3]."""

    modulus: float
    ratio: float
    density: float

    def mass(self, radius: float) -> float:
        return self.density * 4.0 / 3.0 * pi * radius**3

    @property
    def stiffness_ratio(self) -> float:
        """Tangential over normal stiffness, with its like or what is rigid (Mindlin 1949)."""
        return 2.0 * (1.0 - self.ratio) / (2.0 - self.ratio)

    def hertz(self, radius: float, bodies: int = 1) -> float:
        """K = 4/3 E* sqrt(R*) of a contact in which one or both bodies give way [N m^-3/2]."""
        return 4.0 / 3.0 * self.modulus / (bodies * (1.0 - self.ratio**2)) * sqrt(radius)


OXIDE = Material(3.8e11, 0.23, 4000.0)
ALLOY, STEEL = Material(7.0e10, 0.33, 2700.0), Material(2.08e11, 0.30, 7850.0)


def body(mass: float, speed: float, slip: float = 0.0) -> Motor:
    """A sphere above a plane: m along the normal, 2/7 m along it."""
    motor, share = block(mass, height=HEIGHT, gap_rate=-speed, velocity=slip), sqrt(2.0 / 7.0)
    modes = replace(motor.modes, tip_slope=motor.modes.tip_slope / share)
    assert motor.start is not None
    start = ModalState(motor.start.displacement, motor.start.velocity * [1.0, share])
    return replace(motor, modes=modes, start=start)


def deepest(mass: float, speed: float, stiffness: float) -> float:
    return float((1.25 * mass * speed**2 / stiffness) ** 0.4)


def met(law: ContactLaw, mass: float, speed: float, slip: float, stiffness: float) -> Trajectory:
    """The impact, which lasts 2.94 d_max / v without damping, and longer with it."""
    lasts = HEIGHT / speed + 6.0 * deepest(mass, speed, stiffness) / speed
    made = run(body(mass, speed, slip), law, lasts, lasts)
    assert made.contacts["duration"].size == 1
    return made


def impulse(
    material: Material, stiffness: float, mass: float, speed: float, slip: float, mu: float, e: float
) -> float:
    """The friction impulse against the slip [N s], of Mindlin's spring and a damping that achieves e."""
    law = Composed(HertzPoint(stiffness), Flores(e), Mindlin(mu, material.stiffness_ratio))
    return -first(met(law, mass, speed, slip, stiffness), "friction_impulse")


def slanted(material: Material, degrees_off: float) -> tuple[float, float]:
    """Test 4, spheres of 5 mm at 3.9 m/s: what friction takes of the centre, and what sliding does [m/s]."""
    mass, stiffness = material.mass(2.5e-3), material.hertz(2.5e-3)
    speed, slip = 3.9 * cos(radians(degrees_off)), 3.9 * sin(radians(degrees_off))
    taken = impulse(material, stiffness, mass, speed, slip, 0.092, 0.98) / mass
    return taken, 0.092 * 1.98 * speed


SPINS = {
    "aluminium oxide": (
        OXIDE,
        {4.95: 19.3, 10.08: 213.0, 14.97: 377.8, 19.94: 510.6, 24.91: 599.4, 29.96: 616.5, 39.98: 544.8}
        | {50.0: 457.0, 60.02: 357.5, 69.96: 246.2, 80.06: 126.3},
    ),
    "aluminium alloy": (
        ALLOY,
        {4.95: 35.3, 9.92: 223.7, 14.97: 389.6, 20.02: 519.1, 24.91: 599.4, 30.04: 617.6, 39.98: 544.8}
        | {50.0: 458.1, 60.02: 358.6, 69.96: 245.1, 80.06: 125.2},
    ),
}
"""Spin after the impact [rad/s] by the angle of incidence [degrees], read off the paper's figure."""


@pytest.mark.parametrize("name", SPINS)
def test_4_spins_are_the_published_ones_and_those_of_sliding_exact(name: str) -> None:
    """Sliding to the reading error of 4 rad/s, sticking to 9 from 15 degrees on, below to 4 % of the largest.

    There the contact swings back and forth, and the unloading decides, which the paper's codes take
    otherwise.
    """
    material, published = SPINS[name]
    for angle, spin in published.items():
        taken, sliding = slanted(material, angle)
        result = 2.5 * taken / 2.5e-3
        error = 4.0 if angle > 29.0 else 9.0 if angle > 14.0 else 27.0
        assert result == pytest.approx(spin, abs=error), angle
        if angle > 31.0:
            assert taken == pytest.approx(sliding, rel=1e-6)


RECOIL = {
    0.876: -0.080,
    1.553: -0.373,
    1.915: -0.627,
    2.785: -1.253,
    3.317: -1.520,
    3.970: -1.720,
    4.755: -1.707,
    5.758: -1.200,
    7.124: 0.133,
    9.118: 2.147,
    12.356: 5.427,
}
"""Slip of the contact after the impact by that before it, over mu v_n, of finite elements (Wu et al. 2003),
read off the paper's figure."""

PUBLISHED = {2.0: -1.533, 2.991: -2.440, 4.006: -2.787, 4.997: -2.0, 6.0: -1.013, 9.988: 3.013, 12.961: 6.013}
"""The same of the codes in the paper."""


def recoil(slip: float) -> float:
    """Test 5, steel spheres of 10 um at 5 m/s, mu 0.3, elastic."""
    mass, stiffness, unit = STEEL.mass(1e-5), STEEL.hertz(1e-5), 0.3 * 5.0
    return slip - 3.5 * impulse(STEEL, stiffness, mass, 5.0, slip * unit, 0.3, 1.0) / (mass * unit)


def test_5_recoil_slides_as_published_and_is_nearer_to_finite_elements_than_the_codes_in_the_paper() -> None:
    """Sliding x - 7, which the figures show to their reading error of 0.08; sticking within 0.6 of them."""
    for x, y in (RECOIL | PUBLISHED).items():
        result = recoil(x)
        if x > 6.5:
            assert result == pytest.approx(x - 7.0, rel=1e-6)
            assert result == pytest.approx(y, abs=0.08)
        elif x in RECOIL:
            assert result == pytest.approx(y, abs=0.61), x
    # The codes miss the finite elements by 1.07 at 4.0, where they have not slid yet.
    assert abs(recoil(3.97) - RECOIL[3.97]) < 0.4 < abs(PUBLISHED[4.006] - RECOIL[3.97])
