"""The floors of the reference calculations, in 30 digits."""
from math import comb

from mpmath import mp, mpf

mp.dps = 30


class Floor:
    """z = sum c[i][j] x^i y^j."""

    def __init__(self, terms):
        self.terms = [(i, j, mpf(c)) for (i, j), c in terms.items()]

    def derivatives(self, x, y):
        """P, P_x, P_y, P_xx, P_xy, P_yy."""
        top = max(max(i, j) for i, j, _ in self.terms) + 1
        px, py = [mpf(1)], [mpf(1)]
        for _ in range(top):
            px.append(px[-1] * x)
            py.append(py[-1] * y)
        power = lambda table, n: table[n] if n >= 0 else mpf(0)
        sums = [mpf(0)] * 6
        for i, j, c in self.terms:
            for slot, (a, b) in enumerate([(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]):
                factor = c
                for s in range(a):
                    factor *= i - s
                for s in range(b):
                    factor *= j - s
                if factor:
                    sums[slot] += factor * power(px, i - a) * power(py, j - b)
        return sums


def pit():
    """One control point of an 11 x 11 net over 20 m at -70 m: B_3(u) B_5(v) around the origin, u = x/20 + 1/2."""
    def centred(i, half=10, n=10):
        # B_i^n in s = x/half: choose (1+s)^i (1-s)^(n-i) / 2^n.
        row = {0: mpf(comb(n, i)) / 2 ** n}
        for sign in [1] * i + [-1] * (n - i):
            longer = {}
            for power, c in row.items():
                longer[power] = longer.get(power, 0) + c
                longer[power + 1] = longer.get(power + 1, 0) + sign * c / half
            row = longer
        return row

    along_x, along_y = centred(3), centred(5)
    return Floor({(i, j): -70 * a * b for i, a in along_x.items() for j, b in along_y.items()})


PIT = pit()
BOWL = Floor({(2, 0): mpf("0.25"), (0, 2): mpf("0.25")})
PARABOLA = Floor({(2, 0): mpf("0.75")})
BUMPS = Floor({(2, 0): "0.2", (0, 2): "0.15", (1, 1): "0.05", (3, 0): "-0.03", (1, 2): "0.02", (2, 2): "0.01", (0, 4): "0.004"})
SADDLE = Floor({(2, 0): "0.25", (0, 2): "-0.125", (0, 4): "0.125"})
