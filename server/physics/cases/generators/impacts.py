"""When balls meet walls and each other, and what then, in numbers of any length.

An impulse J along the line of centres finds the floor's impulse L as a multiplier of the constraint, per ball:

    m dw = J d + L,  k m r^2 domega = -r n x L,  dw = r domega x n     rolling: L is any vector at the contact
    m dw = J d + L,  L = l n,  dw . n = 0                              sliding
"""
from gmpy2 import mpfr, sqrt
from newton_euler import cross, dot, normal


def solve(matrix, right):
    """Gauss with row pivots."""
    rows = [row[:] + [b] for row, b in zip(matrix, right)]
    size = len(rows)
    for i in range(size):
        pivot = max(range(i, size), key=lambda r: abs(rows[r][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for r in range(i + 1, size):
            factor = rows[r][i] / rows[i][i]
            rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i])]
    out = [mpfr(0)] * size
    for i in reversed(range(size)):
        out[i] = (rows[i][size] - sum(rows[i][j] * out[j] for j in range(i + 1, size))) / rows[i][i]
    return out


def response(ball, state, d):
    """dw and domega for a unit impulse along d at the centre."""
    _, n, _, _ = normal(ball.floor, state[0], state[1])
    zero, one, m = mpfr(0), mpfr(1), ball.mass
    axes = [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
    if not ball.rolling:
        # dw (3), l.
        matrix = [[m * axes[i][j] for j in range(3)] + [-n[i]] for i in range(3)] + [n + [zero]]
        return solve(matrix, list(d) + [zero])[:3], [zero] * 3
    # dw (3), domega (3), L (3); the columns of v -> v x n and v -> n x v are images of the axes.
    over = [cross(e, n) for e in axes]
    inertia = ball.k * m * ball.r**2
    matrix, right = [], []
    for i in range(3):
        matrix.append([m * axes[i][j] for j in range(3)] + [zero] * 3 + [-axes[i][j] for j in range(3)])
        right.append(d[i])
        matrix.append([zero] * 3 + [inertia * axes[i][j] for j in range(3)] + [-ball.r * over[j][i] for j in range(3)])
        right.append(zero)
        matrix.append([axes[i][j] for j in range(3)] + [-ball.r * over[j][i] for j in range(3)] + [zero] * 3)
        right.append(zero)
    answer = solve(matrix, right)
    return answer[:3], answer[3:6]


class Wall:
    """A vertical plane through `point` with the unit normal `inward`, met by ball number `ball`."""

    def __init__(self, ball, point, inward):
        self.ball, self.point = ball, [mpfr(c) for c in point]
        length = sqrt(mpfr(inward[0]) ** 2 + mpfr(inward[1]) ** 2)
        self.lines = [(ball, [mpfr(inward[0]) / length, mpfr(inward[1]) / length, mpfr(0)])]

    def gap(self, balls, states):
        center = balls[self.ball].seen(states[self.ball])
        inward = self.lines[0][1]
        return sum((c - p) * q for c, p, q in zip(center, self.point, inward)) - balls[self.ball].r

    def directions(self, balls, states):
        return self.lines


class Pair:
    """Two balls by number."""

    def __init__(self, first, second):
        self.members = (first, second)

    def between(self, balls, states):
        first, second = [balls[i].seen(states[i])[:3] for i in self.members]
        return [b - a for a, b in zip(first, second)]

    def gap(self, balls, states):
        apart = self.between(balls, states)
        return sqrt(dot(apart, apart)) - sum(balls[i].r for i in self.members)

    def directions(self, balls, states):
        apart = self.between(balls, states)
        length = sqrt(dot(apart, apart))
        line = [c / length for c in apart]
        return [(self.members[0], [-c for c in line]), (self.members[1], line)]


def bounce(contact, restitution, balls, states):
    """The states after an impact."""
    closing, yielding, answers = mpfr(0), mpfr(0), []
    for i, d in contact.directions(balls, states):
        dw, domega = response(balls[i], states[i], d)
        closing += dot(balls[i].seen(states[i])[3:6], d)
        yielding += dot(dw, d)
        answers.append((i, domega if balls[i].rolling else dw))
    impulse = -(1 + restitution) * closing / yielding
    states = list(states)
    for i, change in answers:
        turned = [a + impulse * b for a, b in zip(states[i][2:5], change)]
        states[i] = states[i][:2] + turned + states[i][5:]
    return states


def time_of_impact(contact, balls, states, move, h):
    """The root of the gap in (0, h] by the secant rule of Illinois; the gap is positive at 0 and negative at h."""
    gap = lambda s: contact.gap(balls, move(states, s))
    low, high = mpfr(0), h
    f_low, f_high = contact.gap(balls, states), gap(h)
    for _ in range(100):
        s = high - f_high * (high - low) / (f_high - f_low)
        f = gap(s)
        if (f > 0) == (f_high > 0):
            f_low /= 2
        else:
            low, f_low = high, f_high
        high, f_high = s, f
        if abs(high - low) < mpfr("1e-33") or abs(f) < mpfr("1e-33"):
            return s
    raise ArithmeticError("no root")
