"""The floors of the reference calculations: graphs of polynomials with exact coefficients."""
from fractions import Fraction
from math import comb


class Floor:
    """z = sum c[i][j] x^i y^j; evaluates in the numbers it is asked with."""

    def __init__(self, terms):
        size = [1 + max(power[axis] for power in terms) for axis in (0, 1)]
        self.rows = [[Fraction(terms.get((i, j), 0)) for j in range(size[1])] for i in range(size[0])]
        self.rounded = {}

    def derivatives(self, x, y):
        """P, P_x, P_y, P_xx, P_xy, P_yy."""
        number = type(x)
        if number not in self.rounded:
            self.rounded[number] = [[number(c.numerator) / number(c.denominator) for c in row] for row in self.rows]
        along_y = [horner(row, y) for row in self.rounded[number]]
        p, px, pxx = horner([row[0] for row in along_y], x)
        py, pxy, _ = horner([row[1] for row in along_y], x)
        pyy, _, _ = horner([row[2] for row in along_y], x)
        return p, px, py, pxx, pxy, pyy


def horner(coefficients, x):
    """A polynomial and its first two derivatives."""
    p = first = half_second = coefficients[0] * 0
    for c in reversed(coefficients):
        half_second = half_second * x + first
        first = first * x + p
        p = p * x + c
    return p, first, 2 * half_second


def centred(half, n, i):
    """B_i^n in powers of x over [-half, half]: choose (1+s)^i (1-s)^(n-i) / 2^n with s = x/half."""
    row = {0: Fraction(comb(n, i), 2**n)}
    for sign in [1] * i + [-1] * (n - i):
        longer = {}
        for power, c in row.items():
            longer[power] = longer.get(power, 0) + c
            longer[power + 1] = longer.get(power + 1, 0) + Fraction(sign) / half * c
        row = longer
    return row


def net(half, heights):
    """A net of control heights[i][j] over [-half, half]^2, i along x."""
    p, q = len(heights) - 1, len(heights[0]) - 1
    along_x, along_y = [centred(half, p, i) for i in range(p + 1)], [centred(half, q, j) for j in range(q + 1)]
    terms = {}
    for i in range(p + 1):
        for j in range(q + 1):
            if heights[i][j]:
                for a, c in along_x[i].items():
                    for b, d in along_y[j].items():
                        terms[a, b] = terms.get((a, b), 0) + Fraction(heights[i][j]) * c * d
    return Floor(terms)


PIT = net(10, [[-70 if (i, j) == (3, 5) else 0 for j in range(11)] for i in range(11)])
# The bumpy bicubic of the work-precision measurements, heights in 1/1024 m.
BICUBIC = net(
    Fraction(3, 2),
    [
        [Fraction(h, 1024) for h in row]
        for row in [[1751, 28, 790, 1083], [567, 81, -381, 623], [461, 987, 194, 592], [1157, 512, 413, 1129]]
    ],
)
# A bowl with bumps at every control point; the numbers are anything that repeats late.
TWELVE = net(
    2,
    [
        [
            Fraction((i - 6) ** 2 + (j - 6) ** 2, 32) + Fraction((7 * i * i + 5 * i * j + 11 * j * j + 3 * i) % 17 - 8, 64)
            for j in range(13)
        ]
        for i in range(13)
    ],
)
INCLINE = Floor({(1, 0): 0.25, (0, 1): 0})
BOWL = Floor({(2, 0): 0.25, (0, 2): 0.25})
PARABOLA = Floor({(2, 0): 0.75})
BUMPS = Floor({(2, 0): 0.2, (0, 2): 0.15, (1, 1): 0.05, (3, 0): -0.03, (1, 2): 0.02, (2, 2): 0.01, (0, 4): 0.004})
SADDLE = Floor({(2, 0): 0.25, (0, 2): -0.125, (0, 4): 0.125})
# x^3 - 3 x y^2 in a quartic bowl.
MONKEY = Floor({(3, 0): 0.25, (1, 2): -0.75, (4, 0): 0.125, (2, 2): 0.25, (0, 4): 0.125})
# (x^2 + y^2)^2 / 2 with a dent that takes its symmetry: 70 degrees near 1.11 m.
STEEP = Floor({(4, 0): 0.5, (2, 2): 1.0, (0, 4): 0.5, (2, 1): 0.125})
