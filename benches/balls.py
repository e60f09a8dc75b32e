#!/usr/bin/env python3
"""What a skin of its own for each level of sizes gains: 180 balls of 16 mm fall towards the bed of dense-20k (4 mm), and are still in the air when the run ends.

usage: benches/balls.py [--solver target/release/mercury-solve] [--against PROGRAM] [--rounds 3]
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def write_scene(folder):
    bench = ROOT / "scenes" / "bench"
    bed = (bench / "dense-20k.csv").read_text()
    (folder / "bed.csv").write_text(bed)
    top = max(float(row.split(",")[2]) for row in bed.split()[1:])
    with open(folder / "balls.csv", "w") as table:
        table.write("x,y,z,radius,vx,vy,vz\n")
        for i, j, k in ((i, j, k) for i in range(6) for j in range(6) for k in range(5)):
            place = [0.0087 + 0.0173 * i, 0.0087 + 0.0173 * j, top + 0.112 + 0.018 * k]
            table.write(",".join(map(str, [*place, 0.008, 0, 0, -3])) + "\n")
    scene = (bench / "dense-20k.toml").read_text()
    changes = {
        "dense-20k.csv": "bed.csv",
        "end  = 0.018": "end  = 0.03",
        "step = 3e-5": "step = 2e-5",
        "0.1552]": "0.5]",
        "[output]": '[[particles]]\nfile = "balls.csv"\nmaterial = "bead"\n\n[output]',
    }
    for old, new in changes.items():
        assert old in scene, old
        scene = scene.replace(old, new)
    (folder / "balls.toml").write_text(scene)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--solver", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--against")
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    programs = [str(pathlib.Path(name).resolve()) for name in (arguments.solver, arguments.against) if name]
    times = {}
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write_scene(folder)
        for _ in range(arguments.rounds):
            for program in programs:
                subprocess.run([program, "balls.toml", "--quiet", "--force", "--threads", "1"], cwd=folder, check=True)
                summary = json.loads((folder / "balls" / "summary.json").read_text())
                log = (folder / "balls" / "run.log").read_text().splitlines()
                lists = next(line for line in log if line.startswith("neighbour list"))
                times.setdefault((program, lists), []).append(1e9 / summary["particle_steps_per_second"])
    for (program, lists), found in times.items():
        print(f"{statistics.median(found):.1f} ns  {lists}  {program}")


if __name__ == "__main__":
    main()
