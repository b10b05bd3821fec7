"""Where tip and rotor touch, and every sign of the contact.

The tip end is L = (-L_tip sin th, L_tip cos th + u); the rotor's centre lies at
(0, L_tip) + (clearance + R) (sin beta, cos beta), straight above the tip in the paper, where beta = 0
(eqs. 35-37). With d = L - centre:

    gap     g = |d| - R                        positive when open
    normal  n = d / |d|                        from the rotor's centre to the tip, (0, -1) at rest, beta = 0
    tangent t = n turned by +90 degrees        (1, 0) there; the paper's e_mu is -t (eqs. 43, 46)
    force on the tip   N n + F t,  N >= 0,  |F| <= mu N
    slip    v = t . Ldot - R Omega             friction opposes it: F = -mu N sign(v)
    rotor   J Omegadot = -R F - C_r Omega - tau   (eq. 48 prints the torque without R)
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, inf, pi, sin, sqrt
from typing import Annotated, Any, final

from contactlab.checks import Checked
from contactlab.compiler.kernels import kernel, part_kernel
from contactlab.compiler.lanes import COUNT, Lanes, largest, put, root
from contactlab.parameter import Parameter, positive

_ANGLE = Parameter(
    "beta",
    "rad",
    "angle from the tip's axis to the rotor's centre, seen from the tip, to positive x",
    above=-0.5 * pi,
    below=0.5 * pi,
)

Frame = tuple[float, float, float, float, float]
"""Gap [m], n.dL/du [1], n.dL/dth [m], t.dL/du [1], t.dL/dth [m]."""


@final
@dataclass(frozen=True)
class ContactGeometry(Checked):
    """Lengths of the contact, and how far the rotor lies off the tip's axis.

    A negative clearance, for compliant laws only, presses the tip on the rotor. With an angle the normal
    meets the tip's axis obliquely, as on a leg that leans, and a normal impulse changes the slip: D_nt of a
    motor that mirrors itself is sin(beta) cos(beta) (1/m_u - L_tip^2/I_th) instead of zero.

    >>> import contactlab as cl
    >>> cl.ContactGeometry(tip_length=19e-3, rotor_radius=25e-3, clearance=0.5e-6)
    ContactGeometry(tip_length=0.019, rotor_radius=0.025, clearance=5e-07, angle=0.0)
    """

    tip_length: Annotated[float, positive("L_tip", "m", "from the beam to the tip end")] = 19e-3
    rotor_radius: Annotated[float, positive("R", "m", "radius of the rotor")] = 25e-3
    clearance: Annotated[float, Parameter("g_0", "m", "gap at rest")] = 1e-6
    angle: Annotated[float, _ANGLE] = 0.0

    @cached_property
    def numbers(self) -> tuple[float, float, float, float, float]:
        """The last arguments of `contact_frame`."""
        return self.tip_length, self.rotor_radius, self.clearance, cos(self.angle), sin(self.angle)

    @property
    def way_to_touch(self) -> float:
        """How far the tip rises along its axis until it touches [m], infinite if it passes by the rotor.

        The smaller root of u^2 - 2 u (R + g_0) cos beta + g_0 (2 R + g_0) = 0.
        """
        radius, gap = self.rotor_radius, self.clearance
        half = (radius + gap) * cos(self.angle)
        square = half * half - gap * (2.0 * radius + gap)
        return gap * (2.0 * radius + gap) / (half + sqrt(square)) if square >= 0.0 else inf

    def frame(self, u: float, th: float) -> Frame:
        """Return gap and directions where the tip is displaced by u [m] and leans by th [rad]."""
        result: Frame = contact_frame(u, th, *self.numbers)
        return result


SMALL_ANGLE = 2.0**-5
"""Angle [rad] up to which Taylor's polynomials of degree 9 and 8 are the sine and 1 - cos to round-off."""


@part_kernel
def sine_and_versine(angle: float) -> tuple[float, float]:
    """Return sin x and 1 - cos x [1] of an angle x [rad], the latter without cancellation.

    A tip leans by a few milliradians; the library's functions took a sixth of a run under Hertz's law.
    """
    if angle * angle > SMALL_ANGLE * SMALL_ANGLE:
        half = sin(0.5 * angle)
        return sin(angle), 2.0 * half * half
    small: tuple[float, float] = _taylor(angle)
    return small


@part_kernel
def _taylor(angle: Any) -> tuple[Any, Any]:
    """Return sin x and 1 - cos x [1] of a small angle x [rad], or of one in each of some lanes."""
    x2 = angle * angle
    sine = 1.0 - x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5040.0 - x2 * (1.0 / 362880.0))))
    versine = 0.5 - x2 * (1.0 / 24.0 - x2 * (1.0 / 720.0 - x2 * (1.0 / 40320.0)))
    return angle * sine, x2 * versine


@kernel
def contact_frame(
    u: float, th: float, tip_length: float, radius: float, clearance: float, cosine: float, sine: float
) -> Frame:
    """Gap and the four partial derivatives that map tip rates to contact rates and forces back.

    Args:
        u: displacement of the beam's centre [m].
        th: slope of the beam's centre [rad].
        tip_length, radius, clearance: L_tip, R and clearance [m].
        cosine, sine: of the angle beta.

    Returns:
        gap [m], n.dL/du [1], n.dL/dth [m], t.dL/du [1], t.dL/dth [m]. The gap is formed from
        |d|^2 - R^2 without cancellation, so it is good to round-off of itself, not of R.
    """
    sine_th, versine_th = sine_and_versine(th)
    frame: Frame = _frame(u, sine_th, versine_th, tip_length, radius, clearance, cosine, sine)
    return frame


@part_kernel
def contact_frames(
    u: Lanes, th: Lanes, tip_length: float, radius: float, clearance: float, cosine: float, sine: float
) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:
    """Return what `contact_frame` does, of a motion in each lane."""
    sine_th, versine_th = _taylor(th)
    if largest(th * th) > SMALL_ANGLE * SMALL_ANGLE:
        for i in range(COUNT):
            sine_i, versine_i = sine_and_versine(th[i])
            sine_th, versine_th = put(sine_th, i, sine_i), put(versine_th, i, versine_i)
    return _frame(u, sine_th, versine_th, tip_length, radius, clearance, cosine, sine)


@part_kernel
def _frame(
    u: Any,
    sine_th: Any,
    versine_th: Any,
    tip_length: float,
    radius: float,
    clearance: float,
    cosine: float,
    sine: float,
) -> tuple[Any, Any, Any, Any, Any]:
    """Return what `contact_frame` does, from sin th and 1 - cos th [1]: of numbers, or of lanes."""
    cosine_th = 1.0 - versine_th
    # How far the tip has come against x, and how far its leaning has drawn it back.
    aside, back = tip_length * sine_th, tip_length * versine_th
    # In the axes of the contact at rest, along the line of centres and across it.
    across = aside * cosine + (u - back) * sine
    excess = clearance - u * cosine + back * cosine + aside * sine
    distance = root(across * across + (radius + excess) * (radius + excess))
    gap = (across * across + excess * (2.0 * radius + excess)) / (distance + radius)
    inverse = -1.0 / distance
    aslant, straight = across * inverse, (radius + excess) * inverse
    nx = aslant * cosine + straight * sine
    ny = straight * cosine - aslant * sine
    normal = -tip_length * (cosine_th * nx + sine_th * ny)
    return (gap, ny, normal, nx, tip_length * (cosine_th * ny - sine_th * nx))
