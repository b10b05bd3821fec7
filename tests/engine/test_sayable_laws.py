"""Laws that depend on what few do: an edge that lifts off, an end at N = 0, films, bounds that differ."""

from dataclasses import dataclass
from math import atan2, exp, pi, sqrt
from typing import Annotated

import pytest

import contactlab as cl
from contactlab.compiler.kernels import kernel
from contactlab.laws import Damping, Friction, NormalForce
from contactlab.parameter import not_negative, positive
from contactlab.testing.plants import block, first, last, run


@dataclass(frozen=True)
class KelvinVoigt(NormalForce):
    """A spring and a dashpot side by side; the body leaves where they would pull."""

    name = "kelvin_voigt"
    equation = "N = k d + c dd/dt, until N = 0"
    source = "Goldsmith, Impact (1960)"

    stiffness: Annotated[float, positive("k", "N m-1", "contact stiffness")] = 1e7
    damping: Annotated[float, not_negative("c", "N s m-1", "contact damping")] = 20.0

    @staticmethod
    @kernel
    def force(depth, depth_rate, stiffness, damping):
        spring, dashpot = stiffness * depth, damping * depth_rate
        return spring + dashpot, 0.5 * spring * depth, stiffness, 0.0, dashpot * depth_rate

    @staticmethod
    @kernel
    def limits(gap_rate, stiffness, damping):
        return 0.0, min(-damping * gap_rate / stiffness, 0.0)


def test_a_dashpot_is_left_where_its_force_ends() -> None:
    """After (pi - atan2(2 b w, w^2 - b^2))/w with the restitution exp(-b t), b = c/2m, w^2 = k/m - b^2."""
    mass, speed, stiffness, damping = 1e-2, 0.5, 1e7, 60.0
    b = 0.5 * damping / mass
    w = sqrt(stiffness / mass - b * b)
    duration = (pi - atan2(2.0 * b * w, w * w - b * b)) / w
    law = cl.Composed(KelvinVoigt(stiffness, damping), friction=cl.Coulomb(0.0))
    made = run(block(mass, height=1e-6, gap_rate=-speed), law, 1e-6 / speed + 4.0 * duration)
    assert made.contacts["duration"].size == 1
    assert first(made, "duration") == pytest.approx(duration, rel=1e-6)
    assert first(made, "separation_velocity") == pytest.approx(speed * exp(-b * duration), rel=1e-6)
    lost = 0.5 * mass * speed**2 * (1.0 - exp(-2.0 * b * duration))
    assert first(made, "energy_loss") == pytest.approx(lost, rel=1e-5)


@dataclass(frozen=True)
class Film(NormalForce):
    """A squeeze film: it resists the approach before the bodies touch, and holds them back as they part."""

    name = "film"
    equation = "N = -C gdot/g^3, g < h"
    source = "Reynolds (1886)"
    allows_tension = True
    convergence_order = 0.5

    viscosity: Annotated[float, positive("C", "N s m2", "of the film")] = 1e-18
    thickness: Annotated[float, positive("h", "m", "of the film")] = 1e-5

    @staticmethod
    @kernel
    def force(gap, gap_rate, viscosity):
        force = -viscosity * gap_rate / gap**3
        return force, 0.0, 3.0 * force / gap, 12.0 * force / gap**2, -force * gap_rate

    @staticmethod
    @kernel
    def limits(thickness):
        return thickness, thickness


def test_a_film_stops_a_body_before_it_touches() -> None:
    """m v = C/2 (1/g^2 - 1/h^2) at the gap g where it stops."""
    mass, speed, film = 1e-2, 0.1, Film()
    law = cl.Composed(film, friction=cl.Coulomb(0.0))
    made = run(block(mass, height=2e-5, gap_rate=-speed), law, 5e-3, record_interval=1e-5)
    expected = (1.0 / film.thickness**2 + 2.0 * mass * speed / film.viscosity) ** -0.5
    assert last(made, "gap") == pytest.approx(expected, rel=1e-5)
    assert made.series["contact_loss"][-1] == pytest.approx(0.5 * mass * speed**2, rel=1e-6)


@dataclass(frozen=True)
class KuwabaraKono(Damping):
    """Viscoelastic spheres: a loss that grows with the root of the depth."""

    name = "kuwabara_kono"
    equation = "N = f(d) + 3/2 A K d^(1/2) dd/dt, N >= 0"
    source = "Kuwabara and Kono (1987), Jpn. J. Appl. Phys. 26, 1230"
    convergence_order = 0.6
    violations = {"mirrors": "to be seen in the composed law"}  # noqa: RUF012

    viscous: Annotated[float, positive("A K", "N s m-1.5", "viscous stiffness")] = 1e4

    @staticmethod
    @kernel
    def damped(elastic_force, depth, depth_rate, viscous):
        return max(elastic_force + 1.5 * viscous * sqrt(depth) * depth_rate, 0.0)


def test_restitution_of_viscoelastic_spheres_is_the_published_series() -> None:
    """e = 1 - 1.153 x + 0.798 x^2 + 0.267 x^(5/2), x = 3/2 A (K/m)^(2/5) v^(1/5), released at N = 0.

    Source: Schwager and Poeschel (2008), Phys. Rev. E 78, 051304.
    """
    mass, stiffness, speed, viscous = 2e-3, 1e10, 0.1, 2e3
    law = cl.Composed(cl.HertzPoint(stiffness), KuwabaraKono(viscous), cl.Coulomb(0.0))
    made = run(block(mass, height=1e-6, gap_rate=-speed), law, 1e-3)
    x = 1.5 * viscous / stiffness * (stiffness / mass) ** 0.4 * speed**0.2
    assert 0.005 < x < 0.05
    expected = 1.0 - 1.153449 * x + 0.798267 * x * x + 0.266666 * x**2.5
    assert first(made, "separation_velocity") == pytest.approx(expected * speed, rel=x**3)
    assert law.convergence_order == 0.6
    assert "mirrors" in law.violations


@dataclass(frozen=True)
class Fur(Friction):
    """Friction that is larger against the hair."""

    name = "fur"
    equation = "-mu N <= F <= r mu N"
    source = "this test"

    against: Annotated[float, positive("r", "1", "friction against the hair over that along it")] = 2.0

    @property
    def friction_limit(self) -> float:
        return self.friction_coefficient * self.against

    @staticmethod
    @kernel
    def bounds(normal, friction_coefficient, against):
        along = friction_coefficient * max(normal, 0.0)
        return -along, along * against


@pytest.mark.parametrize(("push", "force"), [(1.4, -1.4), (2.0, -1.5), (-2.0, 2.0), (-2.9, 2.9), (-4.0, 3.0)])
def test_friction_that_differs_in_both_directions_sticks_between_its_bounds(
    push: float, force: float
) -> None:
    """Over 10 N: it slides from 1.5 N on in one direction, from 3 N in the other."""
    law = cl.Composed(cl.Linear(1e7), friction=Fur(0.15, 2.0))
    made = run(block(1.0, height=-1e-6, weight=10.0, push=push), law, 0.01, record_interval=1e-3)
    assert last(made, "friction_force") == pytest.approx(force, rel=1e-6)
    assert last(made, "slip_velocity") == pytest.approx((push + force) * 0.01, abs=1e-9)


@pytest.mark.parametrize(("velocity", "drag"), [(0.01, -1.5), (-0.01, 3.0)])
def test_slip_that_ends_over_fur_sticks(velocity: float, drag: float) -> None:
    law = cl.Composed(cl.Linear(1e7), friction=Fur(0.15, 2.0))
    made = run(block(1.0, height=-1e-6, weight=10.0, velocity=velocity), law, 0.02, record_interval=1e-3)
    assert 0.02 - first(made, "stick_duration") == pytest.approx(-velocity / drag, rel=1e-6)
