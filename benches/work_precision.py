#!/usr/bin/env python3
"""Processor time over error for Mercury, LIGGGHTS, LAMMPS and YADE on the same physics.

    apt-get install liggghts lammps yade          # Debian's packages
    pip install matplotlib numpy
    cargo build --release --bin mercury-solve
    benches/work_precision.py                     # all cases: benches/results/work_precision.csv, docs/pictures/work-precision-peers.svg
    benches/work_precision.py bed gas --rounds 1  # some of them, printed only

Time: processor time of one thread for the steps alone, the least of the rounds; the codes run in turn. Start-up is left out: by runs of one step,
of YADE by its own clock. Error: root mean square of what places at the end are off, over that of how far the particles went. The
reference of a code is its own run with a step 128 times shorter than the middle one, as the laws of the codes differ in detail; how far these
limits lie from Mercury's is printed and stands in the table.
"""

import argparse
import csv
import json
import math
import pathlib
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benches" / "results" / "work_precision.csv"
PICTURE = ROOT / "docs" / "pictures" / "work-precision-peers.svg"
FACTORS = [4, 2, 1, 1 / 2, 1 / 4, 1 / 8, 1 / 16]  # of the middle step
REFERENCE = 1 / 128
ERRORS = [1e-2, 1e-3, 1e-4]  # of the table
LEAST = 2e-3  # s; what takes less is not compared: start-up varies by as much
DENSITY, MODULUS, POISSON = 2500.0, 1e7, 0.25
RADIUS = 1e-3


@dataclass
class Case:
    """Spheres with their places (m), velocities (m/s) and spins (rad/s), and what acts on them."""

    title: str
    places: np.ndarray
    velocities: np.ndarray
    spins: np.ndarray
    size: np.ndarray
    end: float
    middle_step: float
    restitution: float = 1.0
    friction: float = 0.0
    gravity: tuple = (0.0, 0.0, 0.0)
    walls: list = field(default_factory=list)  # (axis, coordinate, +1 or -1: the side of the particles)
    periodic: bool = False
    clump: np.ndarray | None = None  # places of pebbles in the principal frame, m
    centres: np.ndarray | None = None  # of clumps
    turns: np.ndarray | None = None  # quaternions of clumps (w, x, y, z)
    lammps_tangential: str = "mindlin"
    modulus: float = MODULUS
    bins: float | None = None  # size of the peers' neighbour bins where particles are sparse, m; else their own choice

    def steps(self, factor):
        """The number of steps and their length, s."""
        number = math.ceil(self.end / (self.middle_step * factor))
        return number, self.end / number


# Cases


def random_turns(rng, number):
    """Rotations, evenly distributed, as quaternions and matrices."""
    q = rng.normal(size=(number, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    w, x, y, z = q.T
    matrix = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                       [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                       [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
    return q, np.moveaxis(matrix, 2, 0)


def impacts(restitution):
    """1,000 pairs that collide at random angles, speeds of 0.5 to 1.5 m/s and spins."""
    rng = np.random.default_rng(1)
    pairs, cell = 1000, 0.01
    grid = np.array([(i, j, k) for i in range(10) for j in range(10) for k in range(10)], float)
    middle = (grid + 0.5) * cell
    _, turn = random_turns(rng, pairs)
    speed, impact = rng.uniform(0.5, 1.5, pairs), rng.uniform(0, 0.95, pairs)
    along, across = turn[:, :, 0], turn[:, :, 1]
    apart = 2 * RADIUS * (np.sqrt(1 - impact**2)[:, None] * along + impact[:, None] * across) + (speed * rng.uniform(0.5e-4, 1.5e-4, pairs))[:, None] * along
    drift = rng.uniform(-0.1, 0.1, (pairs, 3))
    places = np.stack([middle - apart / 2, middle + apart / 2], 1).reshape(-1, 3)
    velocities = np.stack([drift + speed[:, None] * along / 2, drift - speed[:, None] * along / 2], 1).reshape(-1, 3)
    case = Case(f"1,000 impacts, e = {restitution:g}", places, velocities, rng.uniform(-300, 300, (2 * pairs, 3)), np.array([0.1] * 3), 1e-3, 4e-6,
                restitution, 0.3, bins=5e-3)
    if restitution < 1:
        case.lammps_tangential = "mindlin/force"
    return case


def bed():
    """The 2,000 beads of dense-2k for 6 ms after gravity turned by 45 degrees."""
    rows = list(csv.DictReader(open(ROOT / "scenes" / "bench" / "dense-2k.csv")))
    of = lambda *keys: np.array([[float(row.get(key) or 0) for key in keys] for row in rows])
    size = np.array([0.048, 0.048, 0.07744])
    walls = [(0, 0.0, 1), (0, size[0], -1), (1, 0.0, 1), (1, size[1], -1), (2, 0.0, 1)]
    tilt = 9.81 / math.sqrt(2)
    global RADIUS_OF_BED
    RADIUS_OF_BED = float(rows[0]["radius"])
    return Case("tilted bed of 2,000", of("x", "y", "z"), of("vx", "vy", "vz"), of("wx", "wy", "wz"), size, 6e-3, 3e-5, 0.5, 0.5, (tilt, 0, -tilt), walls)


def tetrahedron():
    """Four touching pebbles; two are moved apart along one axis so that no two moments are equal."""
    return np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float) * RADIUS / math.sqrt(2) * np.array([1.35, 1.15, 1.0])


def clumps(wall):
    """100 clumps of four pebbles that turn freely; or that are thrown at a wall."""
    rng = np.random.default_rng(2)
    number, cell = 100, 0.02
    grid = np.array([(i, j, 0) for i in range(10) for j in range(10)], float)
    centres = (grid + 0.5) * cell
    pebbles = tetrahedron()
    q, turn = random_turns(rng, number)
    reach = np.linalg.norm(pebbles, axis=1).max() + RADIUS
    spins = rng.uniform(-200, 200, (number, 3))
    speed = rng.uniform(-0.05, 0.05, (number, 3))
    if wall:
        centres[:, 2] = reach * 1.01
        speed[:, 2] = rng.uniform(-1.5, -0.5, number)
    arms = np.einsum("nij,pj->npi", turn, pebbles)
    places = (centres[:, None, :] + arms).reshape(-1, 3)
    velocities = (speed[:, None, :] + np.cross(spins[:, None, :], arms)).reshape(-1, 3)
    title = "100 clumps of four hit a wall" if wall else "100 free clumps of four"
    end = 6e-3 if wall else 0.2
    return Case(title, places, velocities, np.repeat(spins, 4, 0), np.array([0.2, 0.2, 0.05]), end, 6e-6 if wall else 2e-4, 1.0, 0.3 if wall else 0.0,
                walls=[(2, 0.0, 1)] if wall else [], clump=pebbles, centres=centres, turns=q, bins=1e-2,
                modulus=MODULUS if wall else 1e3)  # so soft that no code refuses long steps; nothing touches


def gas():
    """512 elastic smooth spheres in a periodic box, for one mean time between collisions or so."""
    rng = np.random.default_rng(3)
    cell = 3.5e-3
    grid = np.array([(i, j, k) for i in range(8) for j in range(8) for k in range(8)], float)
    places = (grid + 0.5) * cell + rng.uniform(-0.7e-3, 0.7e-3, (512, 3))
    return Case("elastic gas of 512", places, rng.normal(0, 1, (512, 3)), np.zeros((512, 3)), np.array([8 * cell] * 3), 6e-3, 4e-6, periodic=True)


CASES = {"impacts-elastic": lambda: impacts(1.0), "impacts": lambda: impacts(0.5), "bed": bed, "free-clumps": lambda: clumps(False),
         "wall-clumps": lambda: clumps(True), "gas": gas}
RADIUS_OF_BED = None


def radius_of(case):
    return RADIUS_OF_BED if case.title.startswith("tilted") else RADIUS


# Codes: each makes a run of `steps` steps of `step` s and gives the processor time (s) and the places at the end (m).


def user_time():
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


START_UP = {}  # by code and case: least processor time of a run of one step, s


def beyond_start_up(key, command, ends, folder):
    """Processor time (s) of the command for the last of two ends, less that for the first one, a step."""

    def run(end):
        before = user_time()
        done = subprocess.run(command(end), capture_output=True, text=True, cwd=folder)
        if done.returncode:
            raise RuntimeError(f"{key[0]}: {(done.stdout + done.stderr)[-1500:]}")
        return user_time() - before

    if key not in START_UP:
        START_UP[key] = min(run(ends[0]) for _ in range(7))
    return run(ends[1]) - START_UP[key]


def mercury(case, steps, step, folder):
    radius = radius_of(case)
    of_clumps = case.clump is not None
    with open(folder / "particles.csv", "w") as out:
        if of_clumps:
            out.write("x,y,z,vx,vy,vz,wx,wy,wz,clump,qw,qx,qy,qz\n")
            for k, (x, q) in enumerate(zip(case.centres, case.turns)):
                arm = case.places[4 * k] - x
                v = case.velocities[4 * k] - np.cross(case.spins[4 * k], arm)
                out.write(",".join(map(repr, map(float, [*x, *v, *case.spins[4 * k]]))) + ",body," + ",".join(map(repr, map(float, q))) + "\n")
        else:
            out.write("x,y,z,radius,vx,vy,vz,wx,wy,wz\n")
            for x, v, w in zip(case.places, case.velocities, case.spins):
                out.write(",".join(map(repr, map(float, [*x, radius, *v, *w]))) + "\n")
    if of_clumps:
        write_clump(folder / "body.clump.toml", case.clump, radius)
    walls = ""
    for axis, place, side in case.walls:
        point, normal = np.zeros(3), np.zeros(3)
        point[axis], normal[axis] = place, side
        walls += f'[[walls]]\nshape = "plane"\npoint = {point.tolist()}\nnormal = {normal.tolist()}\nmaterial = "bead"\n'
    scene = f"""gravity = {list(map(float, case.gravity))}
time = {{ end = {steps * step!r}, step = {step!r} }}
contact = {{ coulomb_limits = "elastic" }}
[domain]
min = [0.0, 0.0, 0.0]
max = {list(map(float, case.size))}
{'periodic = ["x", "y", "z"]' if case.periodic else ''}
[materials.bead]
density = {DENSITY}
normal = {{ law = "hertz", youngs_modulus = {case.modulus}, poisson_ratio = {POISSON}, restitution = {case.restitution} }}
{f'tangential = {{ law = "mindlin", friction = {case.friction}, stiffness_factor = 1.0 }}' if case.friction else ''}
{'[clumps.body]' if of_clumps else ''}
{'file = "body.clump.toml"' if of_clumps else ''}
{'material = "bead"' if of_clumps else ''}
{walls}
[[particles]]
file = "particles.csv"
{'' if of_clumps else 'material = "bead"'}
[output]
interval = {steps * step!r}
pictures = false
frames = false
ene = false
data = true
{'clumps_as = "pebbles"' if of_clumps else ''}
"""
    (folder / "scene.toml").write_text(scene)
    command = [ROOT / "target" / "release" / "mercury-solve", folder / "scene.toml", "--output", folder / "run", "--force", "--quiet", "--threads", "1"]
    spent = beyond_start_up(("Mercury", case.title), lambda end: [*command, "--set", f"time.end={end!r}"], [step, steps * step], folder)
    lines = next((folder / "run").glob("*.data")).read_text().splitlines()
    last = np.array([line.split()[:3] for line in lines[-len(case.places):]], float)
    return spent, last


def write_clump(path, pebbles, radius):
    mass = DENSITY * 4 / 3 * math.pi * radius**3
    inertia = sum(mass * (0.4 * radius**2 * np.eye(3) + p @ p * np.eye(3) - np.outer(p, p)) for p in pebbles)
    assert np.allclose(pebbles.sum(0), 0, atol=1e-15) and np.allclose(inertia, np.diag(np.diag(inertia)), atol=1e-18)
    order = list(map(float, np.diag(inertia)))
    listed = "".join(f"  {{ position = {list(map(float, p))}, radius = {radius} }},\n" for p in pebbles)
    path.write_text(f"""name = "body"
density = {DENSITY}
mass = {mass * len(pebbles)!r}
volume = {mass * len(pebbles) / DENSITY!r}
centre_of_mass = [0.0, 0.0, 0.0]
principal_moments = {order}
rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
inertia_method = "pebbles"
pebbles = [
{listed}]
""")


def write_data(case, path, style):
    """A data file of LAMMPS or LIGGGHTS; with `style` "hybrid" the last column is the clump."""
    radius, extra = radius_of(case), ""
    with open(path, "w") as out:
        out.write(f"spheres\n\n{len(case.places)} atoms\n1 atom types\n\n")
        pad = 0.0 if case.periodic else 0.05
        for k, a in enumerate("xyz"):
            out.write(f"{-pad!r} {float(case.size[k]) + pad!r} {a}lo {a}hi\n")
        out.write("\nAtoms\n\n")
        for i, x in enumerate(case.places):
            extra = f" {i // 4 + 1}" if style == "hybrid" else ""
            head, tail = (f"{2 * radius!r} {DENSITY!r}", " ".join(map(repr, map(float, x))))
            out.write(f"{i + 1} 1 {tail} {head}{extra}\n" if style == "hybrid" else f"{i + 1} 1 {head} {tail}\n")
        out.write("\nVelocities\n\n")
        for i, (v, w) in enumerate(zip(case.velocities, case.spins)):
            out.write(f"{i + 1} " + " ".join(map(repr, map(float, [*v, *w]))) + "\n")


def tsuji_equivalent(e):
    """LAMMPS' polynomial is not the solution of constant restitution: the e whose polynomial equals sqrt(5) beta."""
    polynomial = lambda x: 1.2728 - 4.2783 * x + 11.087 * x**2 - 22.348 * x**3 + 27.467 * x**4 - 18.022 * x**5 + 4.8218 * x**6
    target = math.sqrt(5) * -math.log(e) / math.hypot(math.log(e), math.pi)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if polynomial(middle) > target else (low, middle)
    return low


def run_script(program, text, case, folder, steps):
    (folder / "in.script").write_text(text)
    command = lambda number: [program, "-in", "in.script", "-log", "log", "-var", "number", str(number)]
    spent = beyond_start_up((program, case.title), command, [1, steps], folder)
    lines = (folder / "last").read_text().splitlines()
    rows = np.array([line.split() for line in lines[-len(case.places):]], float)
    rows = rows[np.argsort(rows[:, 0])]
    return spent, rows[:, 1:4]


def common(case, step, steps):
    skin = 0.4 * radius_of(case)
    boundary = "p p p" if case.periodic else "f f f"
    gravity = np.array(case.gravity, float)
    size = np.linalg.norm(gravity)
    fixes = [] if not size else ["fix grav all gravity %.17g vector %.17g %.17g %.17g" % (size, *gravity)]
    bins = [f"neigh_modify binsize {case.bins!r}"] if case.bins else []
    return f"neighbor {skin!r} bin", boundary, [*bins, *fixes]


def lammps(case, steps, step, folder):
    of_clumps = case.clump is not None
    write_data(case, folder / "in.data", "hybrid" if of_clumps else "sphere")
    skin, boundary, fixes = common(case, step, steps)
    stiffness = 8 * case.modulus / (4 * (2 - POISSON) * (1 + POISSON))  # 8 G* of a pair of the same material
    e = "0" if case.restitution == 1 else repr(tsuji_equivalent(case.restitution))
    if case.friction:
        xt = math.sqrt(4 * (1 - POISSON) / (2 * (2 - POISSON))) if case.restitution < 1 else 0
        tangential = f"tangential {case.lammps_tangential} {stiffness!r} {xt!r} {case.friction}"
    else:
        tangential = "tangential linear_nohistory 0 0"
    damping = "damping velocity" if case.restitution == 1 else "damping tsuji"
    law = lambda modulus: f"hertz/material {modulus!r} {e} {POISSON} {tangential} {damping}"
    lines = [f"atom_style {'hybrid sphere molecular' if of_clumps else 'sphere'}", "atom_modify map array", f"boundary {boundary}", "newton off", "comm_modify vel yes",
             "units si", "read_data in.data", skin, "neigh_modify delay 0", "pair_style granular", "pair_coeff * * " + law(case.modulus), *fixes]
    for k, (axis, place, side) in enumerate(case.walls):
        # Its walls take E/(1 - nu) where E/(1 - nu^2) is meant (version of 29 September 2021).
        ends = f"{float(place)!r} NULL" if side > 0 else f"NULL {float(place)!r}"
        lines.append(f"fix w{k} all wall/gran granular {law(case.modulus / (1 + POISSON))} {'xyz'[axis]}plane {ends}")
    if of_clumps:
        lines += ["comm_modify cutoff 0.01", "neigh_modify exclude molecule/intra all", "fix move all rigid/small molecule"]
    else:
        lines.append("fix move all nve/sphere")
    lines += [f"timestep {step!r}", f"dump d all custom ${{number}} last id {'xu yu zu' if case.periodic else 'x y z'}", "dump_modify d format float %.17g", "thermo ${number}",
              "thermo_style custom step atoms", "thermo_modify lost ignore", "run ${number}"]
    return run_script("lmp", "\n".join(lines) + "\n", case, folder, steps)


def liggghts(case, steps, step, folder):
    of_clumps = case.clump is not None
    write_data(case, folder / "in.data", "hybrid" if of_clumps else "sphere")
    skin, boundary, fixes = common(case, step, steps)
    e = case.restitution
    model = "model hertz" + (" tangential history" if case.friction else "")
    lines = [f"atom_style {'hybrid granular molecular' if of_clumps else 'granular'}", "atom_modify map array", f"boundary {boundary}", "newton off",
             "communicate single vel yes", *(["soft_particles yes"] if case.modulus < 5e6 else []), "units si", "read_data in.data", skin, "neigh_modify delay 0",
             f"fix m1 all property/global youngsModulus peratomtype {case.modulus!r}", f"fix m2 all property/global poissonsRatio peratomtype {POISSON}",
             f"fix m3 all property/global coefficientRestitution peratomtypepair 1 {e if e < 1 else 0.999999999999}",
             f"fix m4 all property/global coefficientFriction peratomtypepair 1 {case.friction}", f"pair_style gran {model}", "pair_coeff * *", *fixes]
    for k, (axis, place, side) in enumerate(case.walls):
        lines.append(f"fix w{k} all wall/gran {model} primitive type 1 {'xyz'[axis]}plane {float(place)!r}")
    if of_clumps:
        lines += ["neigh_modify exclude molecule all", "fix move all rigid molecule"]
    else:
        lines.append("fix move all nve/sphere")
    lines += [f"timestep {step!r}", f"dump d all custom ${{number}} last id {'xu yu zu' if case.periodic else 'x y z'}", 'dump_modify d format "%d %.17g %.17g %.17g"', "thermo ${number}",
              "thermo_style custom step atoms", "thermo_modify lost ignore norm no", "run ${number}"]
    return run_script("liggghts", "\n".join(lines) + "\n", case, folder, steps)


YADE = """
import json, math, time
from yade import *
from yade import utils
case = json.load(open('case.json'))
mat = O.materials.append(FrictMat(young=case['E'], poisson=case['nu'], frictionAngle=math.atan(case['mu']), density=case['rho']))
make = lambda i: utils.sphere(case['x'][i], case['r'], material=mat)
if case['clump']:
    for k in range(len(case['x']) // 4):
        clump, _ = O.bodies.appendClumped([make(4 * k + j) for j in range(4)], discretization=0)
        centre = O.bodies[clump].state.pos
        O.bodies[clump].state.vel = Vector3(case['v'][4 * k]) - Vector3(case['w'][4 * k]).cross(Vector3(case['x'][4 * k]) - centre)
        O.bodies[clump].state.angVel = Vector3(case['w'][4 * k])
        O.bodies[clump].state.angMom = O.bodies[clump].state.ori * (O.bodies[clump].state.ori.conjugate() * Vector3(case['w'][4 * k])).cwiseProduct(O.bodies[clump].state.inertia) if hasattr(Vector3, 'cwiseProduct') else O.bodies[clump].state.ori * Vector3(*[a * b for a, b in zip(O.bodies[clump].state.ori.conjugate() * Vector3(case['w'][4 * k]), O.bodies[clump].state.inertia)])
else:
    for i in range(len(case['x'])):
        n = O.bodies.append(make(i))
        O.bodies[n].state.vel, O.bodies[n].state.angVel = Vector3(case['v'][i]), Vector3(case['w'][i])
spheres = [b.id for b in O.bodies if isinstance(b.shape, Sphere)]
for axis, place, side in case['walls']:
    O.bodies.append(utils.wall(place, axis, sense=side, material=mat))
if case['periodic']:
    O.periodic = True
    O.cell.setBox(*case['size'])
damp = dict(en=case['e'], es=case['e']) if case['e'] < 1 else {}
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.4 * case['r']),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys(**damp)], [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=0, gravity=case['g'], exactAsphericalRot=True)]
O.dt = case['step']
O.run(1, True)
begin = time.process_time()
O.run(case['steps'] - 1, True)
spent = time.process_time() - begin
json.dump(dict(seconds=spent, x=[list(O.bodies[i].state.pos) for i in spheres]), open('last.json', 'w'))
"""


def yade(case, steps, step, folder):
    listed = dict(x=case.places.tolist(), v=case.velocities.tolist(), w=case.spins.tolist(), r=radius_of(case), E=case.modulus, nu=POISSON, mu=case.friction, rho=DENSITY,
                  e=case.restitution, g=list(map(float, case.gravity)), walls=case.walls, periodic=case.periodic, size=list(map(float, case.size)), step=step, steps=steps,
                  clump=case.clump is not None)
    (folder / "case.json").write_text(json.dumps(listed))
    (folder / "run.py").write_text(YADE)
    done = subprocess.run(["yade", "-n", "-x", "-j1", "run.py"], capture_output=True, text=True, cwd=folder)
    if not (folder / "last.json").exists():
        raise RuntimeError("yade: " + (done.stdout + done.stderr)[-1500:])
    last = json.loads((folder / "last.json").read_text())
    (folder / "last.json").unlink()
    return last["seconds"], np.array(last["x"])


CODES = {"Mercury": mercury, "LIGGGHTS": liggghts, "LAMMPS": lammps, "YADE": yade}


# Measuring


def distance(case, a, b):
    """Root mean square of how far places differ, over how far the particles went to the second ones."""
    period = np.array(case.size) if case.periodic else None
    shift = lambda d: d if period is None else d - period * np.round(d / period)
    rms = lambda d: math.sqrt((shift(d) ** 2).sum(1).mean())
    return rms(a - b) / rms(b - case.places)


def measure(name, codes, rounds):
    """Rows: case, code, factor of the step, steps, seconds, error, how far the limit of the code lies from Mercury's."""
    case = CASES[name]()
    rows, limits = [], {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        for code in codes:
            limits[code] = CODES[code](case, *case.steps(REFERENCE), folder)[1]
        apart = {code: distance(case, limits[code], limits["Mercury"]) if "Mercury" in limits else math.nan for code in codes}
        print(name, {code: f"{value:.2g}" for code, value in apart.items()}, flush=True)
        for factor in FACTORS:
            best = {}
            for _ in range(rounds):
                for code in codes:
                    seconds, places = CODES[code](case, *case.steps(factor), folder)
                    best[code] = min(best.get(code, (math.inf, 0.0)), (seconds, distance(case, places, limits[code])))
            for code, (seconds, error) in best.items():
                rows.append([name, code, factor, case.steps(factor)[0], seconds, error, apart[code]])
                print(f"{name} {code} {factor:g}: {seconds:.4g} s, {error:.3g}", flush=True)
    return rows


def time_at(rows, error):
    """Seconds at which a code reaches an error: a straight line between the two neighbours in logarithms; None beyond what was measured."""
    points = sorted((r[5], r[4]) for r in rows if r[4] > LEAST)
    for (low, slow), (high, fast) in zip(points, points[1:]):
        if low <= error <= high and low > 0:
            part = math.log(error / low) / math.log(high / low)
            return math.exp(math.log(slow) * (1 - part) + math.log(fast) * part)
    return None


def order(rows):
    """Slope of the error over the step, by least squares over the errors below 3e-2."""
    points = [(math.log(r[2]), math.log(r[5])) for r in rows if 0 < r[5] < 3e-2]
    return float(np.polyfit(*zip(*points), 1)[0]) if len(points) > 1 else math.nan


def table(rows, codes):
    """The table of the page, as Markdown."""
    peers = [code for code in codes if code != "Mercury"]
    lines = ["| case | " + " | ".join(peers) + " | order of Mercury | limits apart |", "|---" * (len(peers) + 3) + "|"]
    for name in dict.fromkeys(row[0] for row in rows):
        of = lambda code: [row for row in rows if row[0] == name and row[1] == code]
        cells = []
        for peer in peers:
            ratios = [(time_at(of(peer), e), time_at(of("Mercury"), e)) for e in ERRORS]
            cells.append(", ".join("-" if None in pair else f"{pair[0] / pair[1]:.2g}" for pair in ratios))
        apart = ", ".join(f"{of(peer)[0][6]:.1g}" for peer in peers)
        lines.append(f"| {CASES[name]().title} | " + " | ".join(cells) + f" | {order(of('Mercury')):.1f} | {apart} |")
    return "\n".join(lines)


def draw(rows, codes):
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "work-precision"
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullFormatter
    names = list(dict.fromkeys(row[0] for row in rows))
    figure, panels = plt.subplots(2, 3, figsize=(12, 7.5), constrained_layout=True)
    for panel, name in zip(panels.flat, names):
        for code, colour, mark in zip(codes, ("#0b6e99", "#d1495b", "#edae49", "#66a182"), "osD^"):
            points = [(row[4], row[5]) for row in rows if row[0] == name and row[1] == code and row[4] > LEAST]
            panel.loglog(*zip(*points), color=colour, marker=mark, markersize=4, label=code)
        panel.set_title(CASES[name]().title, fontsize=11)
        panel.set_xlabel("processor time (s)")
        panel.set_ylabel("relative error of places")
        panel.grid(alpha=0.3)
        panel.xaxis.set_minor_formatter(NullFormatter())
    panels.flat[0].legend()
    figure.savefig(PICTURE, metadata={"Date": None})


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("cases", nargs="*", help="of " + ", ".join(CASES))
    p.add_argument("--codes", default=",".join(CODES))
    p.add_argument("--rounds", type=int, default=3)
    a = p.parse_args()
    codes = a.codes.split(",")
    wrong = [c for c in codes if c not in CODES] + [c for c in a.cases if c not in CASES]
    if wrong:
        sys.exit(f"unknown: {', '.join(wrong)}; the cases are {', '.join(CASES)}, the codes {', '.join(CODES)}")
    rows = [row for name in a.cases or CASES for row in measure(name, codes, a.rounds)]
    if not a.cases and codes == list(CODES):
        with open(RESULTS, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["case", "code", "step_over_middle", "steps", "seconds", "error", "limit_from_mercury"])
            writer.writerows([[*row[:2], f"{row[2]:g}", row[3], *(f"{v:.4g}" for v in row[4:])] for row in rows])
        draw(rows, codes)
    print(table(rows, codes))


if __name__ == "__main__":
    main()
