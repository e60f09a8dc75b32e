#!/usr/bin/env python3
"""What a pebble costs beside a sphere: 2,000 clumps of 20 pebbles in a turning drum, and 40,000 spheres of the pebbles' size there.

usage: benches/clumps.py [SOLVER] [--rounds 3] [--time 0.3]

Default for SOLVER: target/release/mercury-solve. Both start as lattices, fall and turn with the drum; a run's processor time up to 0.2 s is taken
off that up to --time (s). Prints nanoseconds per pebble or sphere and step, the least of all rounds.
"""

import argparse
import json
import math
import pathlib
import resource
import subprocess
import tempfile

from memory import ROOT

RADIUS = 1e-3
SETTLED = 0.2

SCENE = """
gravity = [0.0, 0.0, -9.81]
time = {{ end = 1.0, step = 2e-5 }}
domain = {{ min = [-0.1, 0.0, -0.1], max = [0.1, {length}, 0.1], periodic = ["y"] }}

[materials.bead]
density = 2500.0
normal = {{ law = "linear", stiffness = 2000.0, restitution = 0.5 }}
tangential = {{ law = "linear", stiffness_ratio = 0.2857142857142857, friction = 0.5 }}

[[walls]]
name = "drum"
shape = "cylinder"
axis = [0.0, 1.0, 0.0]
origin = [0.0, 0.0, 0.0]
radius = 0.1
material = "bead"
motion = [{{ kind = "rotation", axis = [0.0, 1.0, 0.0], origin = [0.0, 0.0, 0.0], angular_velocity = 3.0 }}]

{grains}

[output]
interval = 1.0
data = false
frames = false
pictures = false
"""


def sites(spacing, half, count):
    """So many places of a lattice in the lower part of the drum, and the length of drum that holds them."""
    across = [
        (x, z)
        for x in (spacing * k for k in range(-60, 61))
        for z in (spacing * k for k in range(-60, 30))
        if math.hypot(x, z) < 0.1 - half and z < 0.04
    ]
    layers = math.ceil(count / len(across))
    places = [(x, (k + 0.5) * spacing, z) for k in range(layers) for x, z in sorted(across, key=lambda place: place[1])]
    return places[:count], layers * spacing


def pebbles():
    """Twenty on the corners of a dodecahedron that touch and overlap their neighbours: a round grain with bumps."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    for a in (-1, 1):
        for b in (-1, 1):
            corners += [(0, a / golden, b * golden), (a / golden, b * golden, 0), (a * golden, 0, b / golden)]
    # Neighbours stand 2/golden of the unit apart.
    unit = 0.9 * 2 * RADIUS / (2 / golden)
    return [tuple(unit * x for x in corner) for corner in corners]


def write_clumps(folder, solver):
    centres = pebbles()
    reach = max(math.dist((0, 0, 0), centre) for centre in centres) + RADIUS
    (folder / "pebbles.csv").write_text("x,y,z,radius\n" + "".join(f"{x},{y},{z},{RADIUS}\n" for x, y, z in centres))
    mclump = solver.parent / "mclump"
    subprocess.run([mclump, folder / "pebbles.csv", "-o", folder / "grain.clump.toml"], check=True, capture_output=True)
    places, length = sites(2.05 * reach, reach, 2000)
    grains = f'[clumps.grain]\nfile = "grain.clump.toml"\nmaterial = "bead"\n\n'
    for x, y, z in places:
        grains += f'[[particles]]\nclump = "grain"\nposition = [{x:.6g}, {y:.6g}, {z:.6g}]\norientation = "random"\n\n'
    (folder / "clumps.toml").write_text(SCENE.format(length=f"{length:.6g}", grains=grains))


def write_spheres(folder):
    places, length = sites(2.05 * RADIUS, RADIUS, 40000)
    table = "x,y,z,radius,vx\n" + "".join(f"{x:.6g},{y:.6g},{z:.6g},{RADIUS},{0.05 * math.sin(k)}\n" for k, (x, y, z) in enumerate(places))
    (folder / "spheres.csv").write_text(table)
    (folder / "spheres.toml").write_text(SCENE.format(length=f"{length:.6g}", grains='[[particles]]\nfile = "spheres.csv"\nmaterial = "bead"\n'))


def seconds(solver, folder, name, end):
    """Processor time of a run, s."""
    command = [solver, folder / f"{name}.toml", "--output", folder / "run", "--force", "--quiet", "--threads", "1", "--set", f"time.end={end}"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(command, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("solver", nargs="?", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--time", type=float, default=0.3)
    options = parser.parse_args()
    solver = pathlib.Path(options.solver).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_clumps(folder, solver)
        write_spheres(folder)
        found = {"clumps": [], "spheres": []}
        for _ in range(options.rounds):
            for scene, costs in found.items():
                first, last = (seconds(solver, folder, scene, end) for end in (SETTLED, options.time))
                costs.append(1e9 * (last - first) / (40000 * (options.time - SETTLED) / 2e-5))
                result = json.loads((folder / "run" / "summary.json").read_text())
                print(f"{scene}: {costs[-1]:.1f} ns, coordination {result['coordination_number']:.2f}", flush=True)
        clumps, spheres = (min(costs) for costs in found.values())
        print(f"clumps {clumps:.1f} ns per pebble and step, spheres {spheres:.1f}: ratio {clumps / spheres:.2f}")


if __name__ == "__main__":
    main()
