"""A ball on z = P(x, y), straight from Newton and Euler, in numbers of any length.

State: contact point (x, y), then angular velocity and orientation (rolling) or velocity of the centre (sliding).
Independent of the engine on purpose: no fundamental forms, no Weingarten map, spin and rolling in one vector.

    c = (x, y, P) + r n,  n = (-P_x, -P_y, 1)/|.|
    c' = w,  w = r omega x n                       rolling without slip
    w' = g + N n + f,  k r^2 omega' = -r n x f     per unit mass; f is friction, tangent
    q' = (omega, 0) q / 2                          quaternion x, y, z, w, ball to world
"""
from gmpy2 import mpfr, sqrt


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def normal(floor, x, y):
    """P, n and its derivatives with respect to x and y."""
    p, px, py, pxx, pxy, pyy = floor.derivatives(x, y)
    up = [-px, -py, mpfr(1)]
    length = sqrt(dot(up, up))
    n = [c / length for c in up]

    def derivative(column):
        along = dot(column, n)
        return [(c - along * m) / length for c, m in zip(column, n)]

    return p, n, derivative([-pxx, -pxy, mpfr(0)]), derivative([-pxy, -pyy, mpfr(0)])


class Ball:
    """Numbers are taken as the nearest f64, as the engine takes them."""

    def __init__(self, floor, radius, k, g, rolling, mass=1):
        self.floor, self.rolling = floor, rolling
        self.r, self.k, self.g, self.mass = mpfr(radius), mpfr(k), mpfr(g), mpfr(mass)

    def start(self, x, y, velocity, spin):
        """From a contact point, a velocity that is projected, and a spin about the normal (rad/s)."""
        _, n, _, _ = normal(self.floor, mpfr(x), mpfr(y))
        w = [mpfr(c) for c in velocity]
        along = dot(w, n)
        w = [c - along * m for c, m in zip(w, n)]
        if not self.rolling:
            return [mpfr(x), mpfr(y)] + w
        upright = [mpfr(0), mpfr(0), mpfr(0), mpfr(1)]
        return [mpfr(x), mpfr(y)] + [a / self.r + mpfr(spin) * m for a, m in zip(cross(n, w), n)] + upright

    def velocity(self, state, n):
        return [self.r * c for c in cross(state[2:5], n)] if self.rolling else state[2:5]

    def rate(self, state):
        r, k = self.r, self.k
        _, n, nx, ny = normal(self.floor, state[0], state[1])
        w = self.velocity(state, n)
        a, b, c, d = 1 + r * nx[0], r * ny[0], r * nx[1], 1 + r * ny[1]
        det = a * d - b * c
        x_rate, y_rate = (d * w[0] - b * w[1]) / det, (a * w[1] - c * w[0]) / det
        n_rate = [x_rate * s + y_rate * t for s, t in zip(nx, ny)]
        gravity = [mpfr(0), mpfr(0), -self.g]
        if not self.rolling:
            push = -dot(gravity, n) - dot(w, n_rate)
            return [x_rate, y_rate] + [s + push * m for s, m in zip(gravity, n)]
        omega, q, q_w = state[2:5], state[5:8], state[8]
        wanted = [r * s - t for s, t in zip(cross(omega, n_rate), gravity)]
        along = dot(wanted, n)
        friction = [k / (1 + k) * (s - along * m) for s, m in zip(wanted, n)]
        turning = [(s * q_w + t) / 2 for s, t in zip(omega, cross(omega, q))] + [-dot(omega, q) / 2]
        return [x_rate, y_rate] + [-s / (k * r) for s in cross(n, friction)] + turning

    def seen(self, state):
        """Centre, velocity of the centre and, when rolling, angular velocity and orientation."""
        p, n, _, _ = normal(self.floor, state[0], state[1])
        center = [state[0] + self.r * n[0], state[1] + self.r * n[1], p + self.r * n[2]]
        return center + self.velocity(state, n) + (state[2:9] if self.rolling else [])


def step(rate, state, h, columns):
    """Gragg's midpoint rule extrapolated: order 2 * columns."""
    add = lambda u, v, s: [a + s * b for a, b in zip(u, v)]
    start = rate(state)
    table = []
    for row in range(columns):
        n = 2 * (row + 1)
        tiny = h / n
        before, now = state, add(state, start, tiny)
        for _ in range(n - 1):
            before, now = now, add(before, rate(now), 2 * tiny)
        end = [(a + b + tiny * c) / 2 for a, b, c in zip(now, before, rate(now))]
        line = [end]
        for back in range(row):
            ratio = mpfr(n) / (2 * (row - back))
            line.append([a + (a - b) / (ratio**2 - 1) for a, b in zip(line[back], table[-1][back])])
        table.append(line)
    return table[-1][-1]
