"""The answer of a nearly resonant mode to its tone, from rest and not from the steady state.

Near resonance the steady state is what the tone builds up over a long time, up to a billion times what
moves now: split off, it would leave its own round-off in every gap. Over one step the answer from rest
to exp(i omega s) is formed instead, which is as small as what the step adds:

    R(s) = int_0^s w(u) exp(i omega (s - u)) du = exp(i omega s) (E(z_-) - E(z_+)) / (2 i nu),
    E(z) = (1 - exp(-z s)) / z,  z_-+ = sigma + i (omega -+ nu),

with the impulse response w(u) = exp(-sigma u) sin(nu u) / nu. The first term is the beat that grows, and
it does so without cancellation however slow the beat is.
"""

from math import cos, exp, expm1, sin, sqrt

from contactlab.compiled import inner_kernel, kernel


@kernel
def answer_from_rest(
    k: float, c: float, omega: float, s: float
) -> tuple[float, float, float, float]:
    """Displacement and rate of an underdamped oscillator under exp(i omega s), from rest.

    Args:
        k, c: stiffness and damping over mass [1/s^2], [1/s], c^2 < 4 k.
        omega: of the tone [rad/s].
        s: time [s].

    Returns:
        Re R, Im R [s^2], Re and Im of its rate [s].
    """
    sigma = 0.5 * c
    nu = sqrt(k - sigma * sigma)
    beat_re, beat_im = _faded(sigma, omega - nu, s)
    fast_re, fast_im = _faded(sigma, omega + nu, s)
    q_re, q_im = (beat_im - fast_im) / (2.0 * nu), (fast_re - beat_re) / (2.0 * nu)
    v_re = 0.5 * (beat_re + fast_re) - sigma * q_re
    v_im = 0.5 * (beat_im + fast_im) - sigma * q_im
    cosine, sine = cos(omega * s), sin(omega * s)
    return (
        q_re * cosine - q_im * sine,
        q_re * sine + q_im * cosine,
        v_re * cosine - v_im * sine,
        v_re * sine + v_im * cosine,
    )


@inner_kernel
def _faded(a: float, b: float, s: float) -> tuple[float, float]:
    """Re and Im of (1 - exp(-z s)) / z for z = a + i b, not zero."""
    left = exp(-a * s)
    half = sin(0.5 * b * s)
    real = 2.0 * left * half * half - expm1(-a * s)
    imaginary = left * sin(b * s)
    size = a * a + b * b
    return (real * a + imaginary * b) / size, (imaginary * a - real * b) / size
