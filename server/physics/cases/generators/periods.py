"""Periods by quadrature, in 20 digits.

    python3 periods.py
"""
from floors import PARABOLA, PIT
from mpmath import findroot, mp, mpf, nstr, quad, sqrt

mp.dps = 30


def period(floor, r, k, g, x0, x_low, x_guess):
    """Released at rest, touching at x0 with y = 0; x_low lies between the turning points. Twice the time from one turning
    point to the other: the integral of |dc/dx| over the speed that energy leaves."""
    r, k, g, x0 = mpf(r), mpf(k), mpf(g), mpf(x0)

    def profile(x):
        z, slope, _, bend, _, _ = floor.derivatives(x, mpf(0))
        return z + r / sqrt(1 + slope ** 2), sqrt(1 + slope ** 2) * (1 - r * bend / (1 + slope ** 2) ** mpf("1.5"))

    top = profile(x0)[0]
    x1 = findroot(lambda x: profile(x)[0] - top, mpf(x_guess))

    def pace(x):
        height, stretch = profile(x)
        return stretch / sqrt(2 * g * (top - height) / (1 + k))

    return 2 * abs(quad(pace, [x0, (x0 + x_low) / 2, x_low, (x_low + x1) / 2, x1]))


for name, k in [("sliding", 0), ("solid", mpf(2) / 5), ("hollow", mpf(2) / 3)]:
    print("pit,", name, nstr(period(PIT, 1, k, "9.8", -3, -4, "-5"), 20))
for name, k in [("sliding", 0), ("rolling", mpf(2) / 5)]:
    for r in ["0.2", "0"]:
        print(f"parabolic cylinder, r {r},", name, nstr(period(PARABOLA, r, k, "9.81", "0.8", 0, "-0.8"), 20))
