"""What impacts that take the length of a step share: the approach that they are of, and what forces add.

What forces bring within the step is no impact, or contact that lasts would bounce in every step; and what
they take away before its end need not be stopped. A rebound that forces end within the step is none: the
contact lasts, without restitution.
"""

from contactlab.compiler.kernels import inner_kernel
from contactlab.laws.lagrange import stick_or_slip_impulse


@inner_kernel
def approach_of(normal_rate, gap_rate):
    """Return the gap rate that an impact has to meet [m/s], negative; zero where there is no impact."""
    return min(max(gap_rate, normal_rate), 0.0)


@inner_kernel
def with_forces(normal_rate, approach, left, p_n, p_t, mode, d_nn, d_nt, d_tt, mu):
    """Return impulses [N s] and mode of the step from those of its impact, and the slip it leaves [m/s]."""
    rebound = normal_rate + d_nn * p_n + d_nt * p_t
    if normal_rate == approach or rebound >= 0.0:
        return p_n, p_t, mode
    more_n, more_t, mode = stick_or_slip_impulse(rebound, left, left, d_nn, d_nt, d_tt, mu)
    return p_n + more_n, p_t + more_t, mode
