"""Runs the standard cases with engines that have Python packages, as many of them as are installed.

    python3 others.py --which                    prints the packages that can be imported, one a line
    python3 others.py < problems.json > runs.json

Reads the problems that the report writes and prints what each engine made of them: the balls at every sample and the
CPU time of stepping. Errors are judged by the report, with the same arithmetic for every contestant.
"""

import importlib
import json
import math
import os
import sys
import tempfile
import time

PACKAGES = ["mujoco", "pybullet"]


def main():
    found = [name for name in PACKAGES if has(name)]
    if "--which" in sys.argv:
        print("\n".join(found))
        return
    problems = json.load(sys.stdin)
    engines = {"mujoco": (mujoco_settings, MujocoWorld), "pybullet": (bullet_settings, BulletWorld)}
    runs = []
    for problem in problems:
        for name in found:
            settings, world = engines[name]
            runs += [ridden(problem, name, world, setting) for setting in settings(problem)]
    missing = [name for name in PACKAGES if name not in found]
    json.dump({"runs": runs, "missing": missing}, sys.stdout, allow_nan=False)


def has(name):
    try:
        importlib.import_module(name)
    except ImportError:
        return False
    return True


def ridden(problem, engine, make, setting):
    """One run for its states, and as many more for its time as are needed; of a gas the first tenth is warm-up."""
    say(f"{engine}: {problem['id']}, {words(setting)}")
    world = make(problem, setting)
    samples = round(problem["seconds"] * problem["sample_hz"])
    states = [finite(world.look())]
    for sample in range(1, samples + 1):
        go_to(world, problem, setting, sample)
        states.append(finite(world.look()))
    world.close()
    warm = samples // 10 if problem["gas"] else 0
    spent, total = math.inf, 0.0
    for run in range(100):
        world = make(problem, setting)
        go_to(world, problem, setting, warm)
        start = time.process_time()
        go_to(world, problem, setting, samples)
        took = time.process_time() - start
        world.close()
        spent, total = min(spent, took), total + took
        if total >= 0.05 and (run >= 2 or took >= 0.05):
            break
    cost = spent * problem["sample_hz"] / (samples - warm)
    name = f"{engine} {world.version}"
    return {"case": problem["id"], "engine": name, "setting": words(setting), "cpu_s_per_s": cost, "samples": states}


def finite(state):
    """What is no number is written as one that nobody takes for a place."""
    return {
        name: [[x if math.isfinite(x) else 1e300 for x in vector] for vector in vectors]
        for name, vectors in state.items()
    }


def say(line):
    print(line, file=sys.stderr, flush=True)


def go_to(world, problem, setting, sample):
    target = -(-sample * setting["rate_hz"] // problem["sample_hz"])
    world.step(target - world.steps)
    world.steps = target


def words(setting):
    said = [f"{setting['rate_hz']} Hz"]
    if "cells" in setting:
        said.append(f"{setting['cells']} cells")
    return ", ".join(said + setting["words"])


def bowl_of(problem):
    """c of z = c (x^2 + y^2), or None on the plane."""
    ground = problem["ground"]
    return ground["bowl"] if isinstance(ground, dict) else None


def planes_of(problem):
    """Points and normals of the walls."""
    if not problem["walls"]:
        return []
    (west, east), (south, north) = problem["walls"]
    return [
        ((west, 0, 0), (1, 0, 0)),
        ((east, 0, 0), (-1, 0, 0)),
        ((0, south, 0), (0, 1, 0)),
        ((0, north, 0), (0, -1, 0)),
    ]


def grid(problem, cells, most):
    """Rates and cells to try: those of the problem that stay below so many steps."""
    rates = [rate for rate in problem["rates_hz"] if rate * problem["seconds"] * len(problem["balls"]) <= most]
    return [(rate, count) for rate in rates for count in (cells if bowl_of(problem) is not None else [0])]


# MuJoCo: contacts are springs. A stiff one without damping is an elastic hit that lasts some steps.


def mujoco_settings(problem):
    if len(problem["balls"]) > 1000:
        return []
    cells = [256] if len(problem["balls"]) == 1 else problem["cells"]
    settings = []
    for rate, count in grid(problem, cells, 240_000):
        for part in (0.02, 0.05, 0.1):
            setting = {"rate_hz": rate, "stiffness": (2 * math.pi * part * rate) ** 2}
            setting["words"] = ["RK4", f"springs of {part * rate:g} Hz"]
            settings.append({**setting, "cells": count} if count else setting)
    return settings


class MujocoWorld:
    def __init__(self, problem, setting):
        import mujoco

        self.mujoco, self.steps, self.version, self.rolls = mujoco, 0, mujoco.__version__, problem["rolls"]
        assets = {}
        self.model = mujoco.MjModel.from_xml_string(mujoco_scene(problem, setting), assets)
        if "cells" in setting:
            fill_height_field(self.model, problem, setting["cells"])
        self.data = mujoco.MjData(self.model)
        slides = 3 if bowl_of(problem) is not None else 2
        for n, ball in enumerate(problem["balls"]):
            if self.rolls:
                self.data.qvel[6 * n : 6 * n + 3] = ball["velocity"]
                self.data.qvel[6 * n + 3 : 6 * n + 6] = ball["omega"]
            else:
                self.data.qvel[slides * n : slides * (n + 1)] = ball["velocity"][:slides]
        mujoco.mj_forward(self.model, self.data)

    def step(self, count):
        if count > 0:
            self.mujoco.mj_step(self.model, self.data, count)

    def look(self):
        # Copies of the state, carried forward so that places and velocities belong to one time.
        self.mujoco.mj_kinematics(self.model, self.data)
        self.mujoco.mj_comPos(self.model, self.data)
        self.mujoco.mj_comVel(self.model, self.data)
        centers = self.data.xpos[1:].tolist()
        velocities, omegas = [], []
        import numpy

        for body in range(1, self.model.nbody):
            six = numpy.zeros(6)
            self.mujoco.mj_objectVelocity(self.model, self.data, self.mujoco.mjtObj.mjOBJ_BODY, body, six, 0)
            velocities.append(six[3:].tolist())
            omegas.append(six[:3].tolist())
        return {"centers": centers, "velocities": velocities, "omegas": omegas if self.rolls else []}

    def close(self):
        pass


def mujoco_scene(problem, setting):
    """The model as MuJoCo's XML. Sliding balls have slides only, so that nothing turns them."""
    bowl, half = bowl_of(problem), problem["half"]
    springs = f'solref="{-setting["stiffness"]} 0" solimp="0.99 0.99 0.001 0.5 2"'
    gravity = problem["gravity"] if bowl is not None else 0
    friction = "10 0 0" if problem["rolls"] else "0 0 0"
    condim = 3 if problem["rolls"] else 1
    parts, assets = [], ""
    if bowl is not None:
        top, count = bowl * 2 * half * half, setting["cells"] + 1
        assets = f'<hfield name="floor" nrow="{count}" ncol="{count}" size="{half} {half} {top} 1"/>'
        parts.append('<geom name="floor" type="hfield" hfield="floor"/>')
    for point, normal in planes_of(problem):
        parts.append(f'<geom type="plane" size="100 100 1" pos="{spaced(point)}" zaxis="{spaced(normal)}"/>')
    axes = ["1 0 0", "0 1 0"] + (["0 0 1"] if bowl is not None else [])
    for n, ball in enumerate(problem["balls"]):
        inertia = ball["inertia_factor"] * ball["mass"] * ball["radius"] ** 2
        slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in axes)
        parts.append(
            f'<body pos="{spaced(ball["center"])}">{"<freejoint/>" if problem["rolls"] else slides}'
            f'<inertial pos="0 0 0" mass="{ball["mass"]}" diaginertia="{spaced([inertia] * 3)}"/>'
            f'<geom name="ball{n}" type="sphere" size="{ball["radius"]}"/></body>'
        )
    # Springs without damping would let friction slip for ever, so that it has a damper of its own.
    pairs = ""
    if problem["rolls"]:
        grip = f'solreffriction="-1 {-setting["rate_hz"]}" friction="10 10 0 0 0" condim="3" {springs}'
        named = range(len(problem["balls"]))
        pairs = "".join(f'<pair geom1="floor" geom2="ball{n}" {grip}/>' for n in named)
    return f"""<mujoco><option timestep="{1 / setting["rate_hz"]}" integrator="RK4" gravity="0 0 {-gravity}"
        cone="elliptic" tolerance="1e-12" iterations="100"/>
        <default><geom friction="{friction}" condim="{condim}" {springs}/></default>
        <size memory="256M"/><asset>{assets}</asset><worldbody>{"".join(parts)}</worldbody>
        <contact>{pairs}</contact></mujoco>"""


def spaced(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def fill_height_field(model, problem, cells):
    import numpy

    x = numpy.linspace(-1, 1, cells + 1)
    model.hfield_data[:] = (0.5 * (x[None, :] ** 2 + x[:, None] ** 2)).ravel()


# PyBullet: restitution 1, a mesh as the floor.


def bullet_settings(problem):
    if len(problem["balls"]) > 1000:
        return []
    cells = [256] if len(problem["balls"]) == 1 else problem["cells"]
    settings = []
    for rate, count in grid(problem, cells, 240_000):
        setting = {"rate_hz": rate, "words": []}
        settings.append({**setting, "cells": count} if count else setting)
    return settings


def hits(problem):
    """A ball alone in a bowl rides best without restitution, which makes it hop over the edges of the mesh."""
    return len(problem["balls"]) > 1


class BulletWorld:
    def __init__(self, problem, setting):
        import pybullet

        self.engine, self.steps = pybullet, 0
        self.version = importlib.import_module("importlib.metadata").version("pybullet")
        self.client, self.rolls = pybullet.connect(pybullet.DIRECT), problem["rolls"]
        self.bounce = 1 if hits(problem) else 0
        bowl = bowl_of(problem)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=1 / setting["rate_hz"],
            **({"restitutionVelocityThreshold": 0, "contactSlop": 0} if hits(problem) else {}),
            allowedCcdPenetration=0,
            physicsClientId=self.client,
        )
        pybullet.setGravity(0, 0, -problem["gravity"] if bowl is not None else 0, physicsClientId=self.client)
        if bowl is not None:
            self.fixed(self.floor(bowl, problem["half"], setting["cells"]), (0, 0, 0))
        for point, normal in planes_of(problem):
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_PLANE, planeNormal=normal, physicsClientId=self.client
            )
            self.fixed(shape, point)
        self.balls = [self.ball(problem, ball) for ball in problem["balls"]]

    def floor(self, bowl, half, cells):
        """A mesh with mended edges, which is better than a height field; such meshes come from files only."""
        side = cells + 1
        at = [half * (2 * k / cells - 1) for k in range(side)]
        lines = [f"v {x!r} {y!r} {bowl * (x * x + y * y)!r}" for y in at for x in at]
        for a in (j * side + i + 1 for j in range(cells) for i in range(cells)):
            lines += [f"f {a} {a + 1} {a + side + 1}", f"f {a} {a + side + 1} {a + side}"]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bowl.obj")
            with open(path, "w") as file:
                file.write("\n".join(lines))
            return self.engine.createCollisionShape(
                self.engine.GEOM_MESH,
                fileName=path,
                flags=self.engine.GEOM_FORCE_CONCAVE_TRIMESH | self.engine.GEOM_CONCAVE_INTERNAL_EDGE,
                physicsClientId=self.client,
            )

    def fixed(self, shape, point):
        body = self.engine.createMultiBody(0, shape, basePosition=point, physicsClientId=self.client)
        friction = 10 if self.rolls else 0
        self.engine.changeDynamics(
            body, -1, restitution=self.bounce, lateralFriction=friction, physicsClientId=self.client
        )

    def ball(self, problem, ball):
        shape = self.engine.createCollisionShape(
            self.engine.GEOM_SPHERE, radius=ball["radius"], physicsClientId=self.client
        )
        body = self.engine.createMultiBody(
            ball["mass"], shape, basePosition=ball["center"], physicsClientId=self.client
        )
        inertia = ball["inertia_factor"] * ball["mass"] * ball["radius"] ** 2
        self.engine.changeDynamics(
            body,
            -1,
            restitution=self.bounce,
            lateralFriction=1 if problem["rolls"] else 0,
            linearDamping=0,
            angularDamping=0,
            rollingFriction=0,
            spinningFriction=0,
            localInertiaDiagonal=[inertia] * 3,
            maxJointVelocity=1e9,
            physicsClientId=self.client,
        )
        omega = ball["omega"] if problem["rolls"] else [0, 0, 0]
        self.engine.resetBaseVelocity(body, ball["velocity"], omega, physicsClientId=self.client)
        return body

    def step(self, count):
        for _ in range(count):
            self.engine.stepSimulation(physicsClientId=self.client)

    def look(self):
        centers, velocities, omegas = [], [], []
        for body in self.balls:
            centers.append(self.engine.getBasePositionAndOrientation(body, physicsClientId=self.client)[0])
            velocity, omega = self.engine.getBaseVelocity(body, physicsClientId=self.client)
            velocities.append(velocity)
            omegas.append(omega)
        return {"centers": centers, "velocities": velocities, "omegas": omegas if self.rolls else []}

    def close(self):
        self.engine.disconnect(physicsClientId=self.client)


if __name__ == "__main__":
    main()
