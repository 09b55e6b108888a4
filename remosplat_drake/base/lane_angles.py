"""Computes sine and cosine of a number, or of each lane of a SIMD vector."""

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import round_down, where

_QUARTERS = 0.6366197723675814
"""Number of quarter turns in a radian."""

_QUARTER = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
"""A quarter turn as a sum of three numbers [rad]. The first two have so few
digits that their products with small integers are exact."""


@helper
def sine_and_cosine(x):
    """Returns sine and cosine of an angle, or of each lane of a vector [rad].

    The errors are about 1e-16 if the angle's magnitude is less than 1e6 rad.
    """
    n = round_down(x * _QUARTERS + 0.5)
    r = ((x - n * _QUARTER[0]) - n * _QUARTER[1]) - n * _QUARTER[2]
    sine, cosine = _series(r)
    quarter = n - 4.0 * round_down(0.25 * n)
    is_odd = ((quarter > 0.5) & (quarter < 1.5)) | (quarter > 2.5)
    s, c = where(is_odd, cosine, sine), where(is_odd, sine, cosine)
    s = where(quarter > 1.5, -s, s)
    c = where((quarter > 0.5) & (quarter < 2.5), -c, c)
    return s, c


@helper
def _series(r):
    """Computes sine and cosine by Taylor's series, for |x| <= pi / 4 [rad]."""
    r2 = r * r
    sine = 1 / 6227020800 - r2 * (1 / 1307674368000)
    for factor in (39916800, 362880, 5040, 120, 6):
        sine = 1 / factor - r2 * sine
    cosine = 1 / 87178291200 - r2 * (1 / 20922789888000)
    for factor in (479001600, 3628800, 40320, 720, 24, 2):
        cosine = 1 / factor - r2 * cosine
    return r - r * r2 * sine, 1.0 - r2 * cosine
