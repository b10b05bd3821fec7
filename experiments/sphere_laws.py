"""The laws that are held against the rebound of spheres, each as the materials and measurements have it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import gamma, pi, sqrt

import numpy as np
import sphere_rebounds as spheres
from sphere_rebounds import FRICTION, MASS, RADIUS, RESTITUTION, SPEED

import contactlab as cl

Predictions = Callable[[np.ndarray], dict[str, np.ndarray]]
"""The quantities at incidences [degrees]."""

AVERAGE = gamma(0.6) * sqrt(pi) / gamma(1.1) / 2.0
"""Of kappa dN/dd and N in an elastic impact: ratio of their means, over that at the greatest depth."""

KINDS = ("bound", "reference", "friction", "rigid", "rigid, no stick")
"""What the data allow, the contact with microslip, frictions over Hertz, rigid laws."""


@dataclass(frozen=True)
class Pair:
    """Two elastic bodies: Young's moduli [Pa] and Poisson's ratios."""

    moduli: tuple[float, float]
    ratios: tuple[float, float]

    @property
    def effective(self) -> float:
        """E* [Pa], 1/E* = sum (1 - nu^2)/E."""
        return 1.0 / sum((1.0 - nu**2) / e for e, nu in zip(self.moduli, self.ratios, strict=True))

    @property
    def stiffness_ratio(self) -> float:
        """Mindlin's kappa = k_t/k_n = 4 G*/E* [1], 1/G* = sum 2 (2 - nu) (1 + nu)/E.

        A contact of the radius a has k_n = 2 E* a and k_t = 8 G* a. Of equal bodies it is
        2 (1 - nu)/(2 - nu).
        """
        each = zip(self.moduli, self.ratios, strict=True)
        return 4.0 / sum(2.0 * (2.0 - nu) * (1.0 + nu) / e for e, nu in each) / self.effective

    @property
    def hertz(self) -> float:
        """K = 4/3 E* sqrt(R) of a sphere on the flat [N m^-3/2]."""
        return 4.0 / 3.0 * self.effective * sqrt(RADIUS)


ALUMINA_ON_GLASS = Pair((3.8e11, 7.0e10), (0.23, 0.25))


@dataclass(frozen=True)
class Candidate:
    """A law that is held against the measurements, made for an approach [m/s].

    Args:
        name, kind: one of `KINDS`.
        predicted: the quantities at incidences.
        averaged: the same where the stiffness is a mean over the impact, None where that is nothing to it.
        free: what no material gives, and what it is; empty if nothing.
    """

    name: str
    kind: str
    predicted: Predictions
    averaged: Predictions | None = None
    free: str = ""


def candidates(rebounds: spheres.Rebounds, pair: Pair) -> Iterator[Candidate]:
    """Every friction, the rigid laws, the contact with microslip, and the best that any curve can do."""
    mu, kappa = FRICTION, pair.stiffness_ratio
    over_hertz: dict[str, tuple[cl.Friction, str]] = {
        "coulomb": (cl.Coulomb(mu), ""),
        "stribeck": (cl.Stribeck(mu), "mu_s/mu 1.3, v_s 10 mm/s"),
        "cohesive": (cl.Cohesive(mu), "cohesion 0.1 N"),
        "ageing_stick": (cl.AgeingStick(mu), "delta 0.01, t_0 10 us"),
        "regularised": (cl.Regularised(mu), "creep velocity 1 mm/s"),
        "rate_and_state": (cl.RateAndState(mu, reference_velocity=1.0), "a 0.01, b 0.015, D 1 um, v_0 1 m/s"),
        "mindlin": (cl.Mindlin(mu, kappa), ""),
        "microslip": (cl.Microslip(mu, kappa), ""),
    }
    for name, (friction, free) in over_hertz.items():
        law = _over_hertz(pair, friction)
        yield Candidate(name, "friction", spheres.law_predictions(lambda _, law=law: law), free=free)
    # Their tangential stiffness is sigma N, Hertz's is kappa dN/dd: equal at one depth only.
    of_stiffness: dict[str, tuple[Callable[[float], cl.Friction], str]] = {
        "iwan": (lambda sigma: cl.Iwan(mu, full_slip=1.5 * mu / sigma), "depth"),
        "dahl": (lambda sigma: cl.Dahl(mu, sigma), "depth; i 1"),
        "bouc_wen": (lambda sigma: cl.BoucWen(mu, mu / sigma), "depth; beta 0.5, n 2"),
        "lugre": (
            lambda sigma: cl.LuGre(mu, bristle_stiffness=sigma, bristle_damping=0.0),
            "depth; sigma_1 0",
        ),
        "elasto_plastic": (
            lambda sigma: cl.ElastoPlastic(mu, bristle_stiffness=sigma, bristle_damping=0.0),
            "depth; sigma_1 0, z_ba/z_ss 0.7",
        ),
    }
    for name, (make, free) in of_stiffness.items():
        both = [_of_depth(pair, make, share) for share in (1.0, AVERAGE)]
        yield Candidate(name, "friction", both[0], both[1], free)
    for rigid, free in _rigid(pair):
        predictions = spheres.law_predictions(lambda _, law=rigid: law)
        kind = "rigid" if rigid.exact_stick else "rigid, no stick"
        yield Candidate(rigid.name, kind, predictions, free=free)
    patch = spheres.microslip(pair.effective, kappa)
    yield Candidate("200 springs", "reference", patch)
    yield Candidate("any curve", "bound", spheres.floor(rebounds), free="8 values")


def _over_hertz(pair: Pair, friction: cl.Friction) -> cl.Composed:
    return cl.Composed(cl.HertzPoint(pair.hertz), cl.Flores(RESTITUTION), friction)


def _of_depth(pair: Pair, make: Callable[[float], cl.Friction], share: float) -> Predictions:
    """The answers of a friction of the stiffness sigma N, a share of Hertz's at the greatest depth."""

    def law(speed: float) -> cl.ContactLaw:
        deepest = (1.25 * MASS * speed**2 / pair.hertz) ** 0.4
        return _over_hertz(pair, make(share * 1.5 * pair.stiffness_ratio / deepest))

    return spheres.law_predictions(law)


def _rigid(pair: Pair) -> Iterator[tuple[cl.ContactLaw, str]]:
    e, mu = RESTITUTION, FRICTION
    yield cl.LagrangeSlip(mu), "no restitution"
    yield cl.LagrangeStick(mu), "no restitution"
    yield cl.LagrangeAgeing(mu), "no restitution; mu_s/mu 1.2, delta 0.01, t_0 10 us"
    yield cl.Newton(mu, e), ""
    yield cl.MoreauJean(mu, e), ""
    yield cl.Poisson(mu, e), ""
    yield cl.Stronge(mu, e), ""
    yield cl.Brach(mu, e), ""
    yield cl.ChatterjeeRuina(mu, e, 0.0), "e_t 0"
    johnson = cl.Johnson(mu, pair.effective, radius=RADIUS)
    # e falls as Y^(5/8); at the speed of the impacts it is that measured.
    energy = RESTITUTION**8 * MASS * SPEED**2
    strength = johnson.yield_strength * (energy / johnson.parameters()[1]) ** 0.2
    yield replace(johnson, yield_strength=strength), f"Y {strength:.3g} Pa, which gives e at 3.9 m/s"
