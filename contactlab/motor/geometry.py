"""Where tip and rotor touch, and every sign of the contact.

The tip end is L = (-L_tip sin th, L_tip cos th + u); the rotor's centre lies at
(0, L_tip + clearance + R) (eqs. 35-37). With d = L - centre:

    gap     g = |d| - R                        positive when open
    normal  n = d / |d|                        from the rotor's centre to the tip, (0, -1) at rest
    tangent t = n turned by +90 degrees        (1, 0) at rest; the paper's e_mu is -t (eqs. 43, 46)
    force on the tip   N n + F t,  N >= 0,  |F| <= mu N
    slip    v = t . Ldot - R Omega             friction opposes it: F = -mu N sign(v)
    rotor   J Omegadot = -R F - C_r Omega - tau   (eq. 48 prints the torque without R)
"""

from dataclasses import dataclass
from math import cos, sin, sqrt
from typing import Annotated, final

from contactlab.checks import Checked
from contactlab.compiler.kernels import kernel
from contactlab.parameter import Parameter, positive


@final
@dataclass(frozen=True)
class ContactGeometry(Checked):
    """Lengths of the contact; a negative clearance, for compliant laws only, presses the tip on the rotor.

    >>> import contactlab as cl
    >>> cl.ContactGeometry(tip_length=19e-3, rotor_radius=25e-3, clearance=0.5e-6)
    ContactGeometry(tip_length=0.019, rotor_radius=0.025, clearance=5e-07)
    """

    tip_length: Annotated[float, positive("L_tip", "m", "from the beam to the tip end")] = 19e-3
    rotor_radius: Annotated[float, positive("R", "m", "radius of the rotor")] = 25e-3
    clearance: Annotated[float, Parameter("g_0", "m", "gap at rest")] = 1e-6


@kernel
def contact_frame(
    u: float, th: float, tip_length: float, radius: float, clearance: float
) -> tuple[float, float, float, float, float]:
    """Gap and the four partial derivatives that map tip rates to contact rates and forces back.

    Args:
        u: displacement of the beam's centre [m].
        th: slope of the beam's centre [rad].
        tip_length, radius, clearance: L_tip, R and clearance [m].

    Returns:
        gap [m], n.dL/du [1], n.dL/dth [m], t.dL/du [1], t.dL/dth [m]. The gap is formed from
        |d|^2 - R^2 without cancellation, so it is good to round-off of itself, not of R.
    """
    sine = sin(th)
    cosine = cos(th)
    half = sin(0.5 * th)
    across = tip_length * sine
    excess = clearance - u + 2.0 * tip_length * half * half
    distance = sqrt(across * across + (radius + excess) * (radius + excess))
    gap = (across * across + excess * (2.0 * radius + excess)) / (distance + radius)
    nx = -across / distance
    ny = -(radius + excess) / distance
    return (gap, ny, -tip_length * (cosine * nx + sine * ny), nx, tip_length * (cosine * ny - sine * nx))
