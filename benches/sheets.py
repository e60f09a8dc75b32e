#!/usr/bin/env python3
"""What a vertex of a sheet costs in a step, beside a particle of dense-2k, on one thread and on two: a sheet of 1e5 triangles at rest, without
grains near it.

    cargo build --release --bin mercury-solve && benches/sheets.py
    benches/sheets.py --count [--solver PROGRAM]      # instructions, which do not depend on other programs: a sheet of 6,000 triangles

Processor time on one thread and wall time, ns for each vertex (particle) and step: the difference of a long and a short run, the least of
three. Wall times need a machine that has nothing else to do.
"""

import argparse
import pathlib
import re
import resource
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOLVER = ROOT / "target/release/mercury-solve"
STEP = 1e-6  # s
SCENE = """title = "sheet"
gravity = [0.0, 0.0, -9.81]

[time]
end  = 1.0
step = {step}

[domain]
min = [-1.0, -1.0, -1.0]
max = [1.0, 1.0, 1.0]

[materials.rubber]
density = 1000.0
normal  = {{ law = "linear", stiffness = 1000.0, restitution = 0.5 }}

[[particles]]
material = "rubber"
radius   = 1e-3
position = [0.9, 0.9, 0.9]
fixed    = true

[[membranes]]
name           = "sheet"
shape          = "rectangle"
corner         = [-0.5, -0.43, 0.0]
along          = [1.0, 0.0, 0.0]
across         = [0.0, 0.86, 0.0]
edge           = {edge}
material       = "rubber"
thickness      = 1e-3
youngs_modulus = 1e6
fixed          = "rim"
{keys}

[output]
interval = 10.0
pictures = false
"""
SHEETS = {
    "springs": "damping_ratio = 0.0",
    "springs with dashpots": "damping_ratio = 0.1",
    "and hinges with dashpots": 'damping_ratio = 0.1\nbending = { law = "bridson", stiffness = 1e-5, damping = 1e-8 }',
    "continuum with dashpots": 'elasticity = "continuum"\ndamping_ratio = 0.1',
}


def counted(solver, scene, folder, end):
    """Instructions of a run on one thread."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", solver, scene, "--output", folder / "run", "--quiet", "--force",
               "--threads", "1", "--set", f"time.end={end:.9g}"]
    log = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    return int(re.search(r"Collected : (\d+)", log)[1])


def sheets(folder, edge):
    """Name, scene and number of vertices of each kind of sheet."""
    for name, keys in SHEETS.items():
        scene = folder / "sheet.toml"
        scene.write_text(SCENE.format(step=STEP, keys=keys, edge=edge))
        plan = subprocess.run([SOLVER, scene, "--check"], check=True, capture_output=True, text=True).stdout
        yield name, scene, int(re.search(r"(\d[\d,]*) vertices", plan)[1].replace(",", ""))


def run(scene, folder, end, threads):
    """Processor and wall time of a run, s."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime, time.time()
    command = [SOLVER, scene, "--output", folder / "run", "--quiet", "--force", "--threads", str(threads), "--fixed-threads", "--set", f"time.end={end:.9g}"]
    subprocess.run(command, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, time.time() - begin


def cost(scene, folder, step, short, long, rows, threads=1):
    """Processor and wall time for each row and step, ns."""
    best = [float("inf")] * 2
    for _ in range(3):
        first, second = run(scene, folder, short * step, threads), run(scene, folder, long * step, threads)
        best = [min(known, (b - a) / (long - short) / rows * 1e9) for known, a, b in zip(best, first, second)]
    return best


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--count", action="store_true")
    arguments.add_argument("--solver", default=SOLVER, type=pathlib.Path, help="for --count")
    arguments = arguments.parse_args()
    if arguments.count:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            for name, scene, vertices in sheets(folder, 1.8e-2):
                first, second = (counted(arguments.solver, scene, folder, steps * STEP) for steps in (20, 120))
                print(f"{name}: {(second - first) / 100 / vertices:.0f} instructions for each vertex and step")
        return
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        dense = cost(ROOT / "scenes/bench/dense-2k.toml", folder, 3e-5, 200, 2200, 2000)
        print("| | processor time, one thread | over dense-2k | wall, one thread | wall, two threads |\n|---|---|---|---|---|")
        print(f"| dense-2k | {dense[0]:.1f} | 1 | {dense[1]:.1f} | |")
        for name, scene, vertices in sheets(folder, 4.45e-3):
            one = cost(scene, folder, STEP, 20, 420, vertices)
            two = cost(scene, folder, STEP, 20, 420, vertices, 2)
            print(f"| {name} | {one[0]:.1f} | {one[0] / dense[0]:.2f} | {one[1]:.1f} | {two[1]:.1f} |")


if __name__ == "__main__":
    main()
