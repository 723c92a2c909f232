"""Trajectories at all ticks, a CSV file a case.

    python3 trajectories.py [name ...]

Every case is computed twice: order 22 in steps of 1/28 s (less where floor or spin turn quickly) with 110 bits, and order 26 in
half of them with 140 bits. The second is written, with the largest difference of any number of the two as its error.
"""
import os
import sys

import gmpy2
from floors import BICUBIC, BOWL, BUMPS, INCLINE, MONKEY, PARABOLA, PIT, SADDLE, STEEP, TWELVE
from gmpy2 import mpfr
from impacts import Pair, Wall, bounce, time_of_impact
from newton_euler import Ball, step

# Sevenths of a second fall everywhere within the engine's steps, which are short binary fractions.
RATE_HZ = 7
SECONDS = 10
SUBSTEPS = {"cylinder": 10, "monkey": 10, "steep": 10, "whirl": 40}
SLIDING, SOLID, HOLLOW = 0, 2 / 5, 2 / 3
DATA = os.path.join(os.path.dirname(__file__), "..", "data")


def ball(k, radius, contact, velocity, spin=0, mass=1):
    return {"k": k, "radius": radius, "contact": contact, "velocity": velocity, "spin": spin, "mass": mass}


WALLS = [((0.48, 0.36), (-4, -3)), ((-0.75, 0), (12, 5))]
# name: floor, balls and, if any, what is met and the restitution
CASES = {
    "incline-solid": (INCLINE, [ball(SOLID, 0.5, (3, -7), (2, 1.5, 0), 12)]),
    "pit-sliding": (PIT, [ball(SLIDING, 1, (-3, 0), (0, 0, 0))]),
    "pit-solid": (PIT, [ball(SOLID, 1, (-3, 0), (0, 0, 0))]),
    "pit-hollow": (PIT, [ball(HOLLOW, 1, (-3, 0), (0, 0, 0))]),
    "cylinder-sliding": (PARABOLA, [ball(SLIDING, 0.2, (0.8, 0), (0, 0, 0))]),
    "cylinder-solid": (PARABOLA, [ball(SOLID, 0.2, (0.8, 0), (0, 0, 0))]),
    "cylinder-helix": (PARABOLA, [ball(SOLID, 0.2, (0.8, -1.5), (0, 0.5, 0), 7)]),
    "bowl-sliding": (BOWL, [ball(SLIDING, 0.1, (0.9, 0), (0, 1.1, 0))]),
    "bowl-hollow": (BOWL, [ball(HOLLOW, 0.1, (0.9, 0), (0, 1.1, 0), 11)]),
    "bumps-sliding": (BUMPS, [ball(SLIDING, 0.25, (1.2, -0.7), (-0.4, 1.3, 0))]),
    "bumps-solid": (BUMPS, [ball(SOLID, 0.25, (1.2, -0.7), (-0.4, 1.3, 0), -9)]),
    "bicubic-sliding": (BICUBIC, [ball(SLIDING, 0.05, (-0.6, -0.24), (1, 0.6, 0))]),
    "bicubic-solid": (BICUBIC, [ball(SOLID, 0.05, (-0.6, -0.24), (1, 0.6, 0), 16)]),
    "bicubic-hollow": (BICUBIC, [ball(HOLLOW, 0.05, (-0.6, -0.24), (1, 0.6, 0), -12)]),
    "twelve-sliding": (TWELVE, [ball(SLIDING, 0.1, (0.7, -0.3), (-0.5, 0.9, 0))]),
    "twelve-solid": (TWELVE, [ball(SOLID, 0.1, (0.7, -0.3), (-0.5, 0.9, 0), 8)]),
    "twelve-hollow": (TWELVE, [ball(HOLLOW, 0.1, (0.7, -0.3), (-0.5, 0.9, 0), -5)]),
    "saddle-sliding": (SADDLE, [ball(SLIDING, 0.15, (0.5, 0.1), (0, 0.3, 0))]),
    "saddle-solid": (SADDLE, [ball(SOLID, 0.15, (0.5, 0.1), (0, 0.3, 0), 3)]),
    "saddle-hollow": (SADDLE, [ball(HOLLOW, 0.15, (0.5, 0.1), (0, 0.3, 0), -4)]),
    "monkey-sliding": (MONKEY, [ball(SLIDING, 0.1, (0.6, 0.2), (-0.7, 0.3, 0))]),
    "monkey-solid": (MONKEY, [ball(SOLID, 0.1, (0.6, 0.2), (-0.7, 0.3, 0), 6)]),
    "monkey-hollow": (MONKEY, [ball(HOLLOW, 0.1, (0.6, 0.2), (-0.7, 0.3, 0), -6)]),
    "steep-sliding": (STEEP, [ball(SLIDING, 0.1, (1.13, 0.1), (0, 1.2, 0))]),
    "steep-solid": (STEEP, [ball(SOLID, 0.1, (1.13, 0.1), (0, 1.2, 0), 10)]),
    "steep-hollow": (STEEP, [ball(HOLLOW, 0.1, (1.13, 0.1), (0, 1.2, 0), -15)]),
    "tight-solid": (BOWL, [ball(SOLID, 1.9, (0.9, 0), (0, 1.1, 0), 2)]),
    "whirl-hollow": (BUMPS, [ball(HOLLOW, 0.25, (1.2, -0.7), (-0.4, 1.3, 0), 300)]),
    "walls-sliding": (
        BUMPS,
        [ball(SLIDING, 0.25, (0.8, -0.7), (-0.4, 1.3, 0))],
        "walls",
        1,
    ),
    "walls-solid": (
        BUMPS,
        [ball(SOLID, 0.25, (0.8, -0.7), (-0.4, 1.3, 0), -9)],
        "walls",
        0.875,
    ),
    "pair-sliding": (
        BUMPS,
        [ball(SLIDING, 0.25, (0.8, -0.7), (-0.4, 1.3, 0)), ball(SLIDING, 0.2, (-0.8, 0.3), (0.2, 0, 0), mass=0.5)],
        "pair",
        1,
    ),
    "pair-rolling": (
        BUMPS,
        [ball(SOLID, 0.25, (0.8, -0.7), (-0.4, 1.3, 0), -9), ball(HOLLOW, 0.2, (-0.8, 0.3), (0.2, 0, 0), 5, mass=0.5)],
        "pair",
        0.875,
    ),
}


def run(case, substeps, columns):
    """Rows (kind, index or seconds, ball, numbers); bounces found by bracketing within a step."""
    floor, specs, meet, restitution = (CASES[case] + (None, 1))[:4]
    contacts = {None: [], "walls": [Wall(0, *wall) for wall in WALLS], "pair": [Pair(0, 1)]}[meet]
    g = 9.8 if case.startswith("pit") else 9.81
    balls = [Ball(floor, b["radius"], b["k"], g, b["k"] > 0, b["mass"]) for b in specs]
    states = [own.start(*b["contact"], b["velocity"], b["spin"]) for own, b in zip(balls, specs)]
    move = lambda states, h: [step(own.rate, s, h, columns) for own, s in zip(balls, states)]
    rows = [("tick", 0, i, own.seen(s)) for i, (own, s) in enumerate(zip(balls, states))]
    h = mpfr(1) / (RATE_HZ * substeps)
    for part in range(SECONDS * RATE_HZ * substeps):
        done = mpfr(0)
        while True:
            ends = move(states, h - done)
            met = [c for c in contacts if c.gap(balls, ends) < 0]
            if not met:
                break
            times = [(time_of_impact(c, balls, states, move, h - done), c) for c in met]
            until, contact = min(times, key=lambda pair: pair[0])
            states = bounce(contact, restitution, balls, move(states, until))
            done += until
            rows.append(("hit", contacts.index(contact), 0, [part * h + done]))
        states = ends
        if (part + 1) % substeps == 0:
            tick = (part + 1) // substeps
            rows += [("tick", tick, i, own.seen(s)) for i, (own, s) in enumerate(zip(balls, states))]
    return rows


def write(case):
    gmpy2.get_context().precision = 110
    substeps = SUBSTEPS.get(case.split("-")[0], 4)
    coarse = run(case, substeps, 11)
    gmpy2.get_context().precision = 140
    fine = run(case, 2 * substeps, 13)
    assert [row[:3] for row in coarse] == [row[:3] for row in fine], "the two runs tell different stories"
    error = max(abs(a - b) for old, new in zip(coarse, fine) for a, b in zip(old[3], new[3]))
    with open(os.path.join(DATA, case + ".csv"), "w") as out:
        print(f"# Generated by trajectories.py. Ticks of {RATE_HZ} Hz: centre (m), velocity (m/s) and, rolling, angular", file=out)
        print("# velocity (rad/s) and orientation (quaternion, ball to world). Hits: contact, seconds.", file=out)
        print(f"error,{float(error):.1e}", file=out)
        for kind, index, number, values in fine:
            text = ",".join(repr(float(v) if abs(v) > 1e-25 else 0.0) for v in values)
            print(f"{kind},{index},{text}" if kind == "hit" else f"tick,{index},{number},{text}", file=out)
    return error


if __name__ == "__main__":
    for name in sys.argv[1:] or CASES:
        print(f"{name}: own error {float(write(name)):.1e}", flush=True)
