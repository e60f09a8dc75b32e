#!/usr/bin/env python3
"""How the time of a particle-step grows with the number of particles: the packing of dense-20k, made periodic and left to rest, beside itself.

usage: benches/growth.py [--solver target/release/mercury-solve] [--copies 1 2 3 5 7] [--rounds 3] [--threads 1]

A periodic packing fits onto itself without a seam, so that all sizes do the very same: as many contacts, and lists that are built as often.
n x n copies are n^2 times 20,000 spheres.
"""

import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
WIDTH = 0.104  # of the benchmark's box, m


def scene(name, copies, **settings):
    """The text of dense-20k with a periodic box of so many copies."""
    text = (ROOT / "scenes" / "bench" / "dense-20k.toml").read_text()
    changes = {
        'sides    = ["-x", "+x", "-y", "+y", "-z"]': 'sides    = ["-z"]',
        "max = [0.104, 0.104, 0.1552]": f'max = [{copies * WIDTH}, {copies * WIDTH}, 0.1552]\nperiodic = ["x", "y"]',
        "dense-20k.csv": f"{name}.csv",
        "end  = 0.018": f"end  = {settings.pop('end')}",
    }
    for old, new in changes.items():
        assert old in text, old
        text = text.replace(old, new)
    return text


def write_tiles(folder, rows, copies):
    with open(folder / f"tiles-{copies}.csv", "w") as table:
        table.write("x,y,z,radius,vx,vy,vz,wx,wy,wz\n")
        for i in range(copies):
            for j in range(copies):
                for row in rows:
                    place = [float(row["x"]) + i * WIDTH, float(row["y"]) + j * WIDTH]
                    rest = [row[key] for key in ("z", "radius", "vx", "vy", "vz", "wx", "wy", "wz")]
                    table.write(",".join(map(str, place + rest)) + "\n")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--solver", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--export", default=ROOT / "target" / "release" / "mercury-export")
    parser.add_argument("--copies", type=int, nargs="+", default=[1, 2, 3, 5, 7])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", default="1")
    parser.add_argument("--folder", help="keeps the scenes there")
    parser.add_argument("--steps", type=int, default=120, help="of the largest; smaller ones make as many particle-steps, at most 20 times as many steps")
    arguments = parser.parse_args()
    solver, export = (str(pathlib.Path(name).resolve()) for name in (arguments.solver, arguments.export))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(arguments.folder or folder)
        folder.mkdir(parents=True, exist_ok=True)
        bench = ROOT / "scenes" / "bench"
        (folder / "rest.csv").write_text((bench / "dense-20k.csv").read_text())
        (folder / "rest.toml").write_text(scene("rest", 1, end=0.3) + "frames = true\n")
        subprocess.run([solver, "rest.toml", "--quiet", "--force"], cwd=folder, check=True)
        subprocess.run([export, "particles", "rest", "--frames", "last", "-o", "state", "--quiet", "--force"], cwd=folder, check=True)
        (state,) = (folder / "state").glob("**/*.csv")
        with open(state) as table:
            rows = list(csv.DictReader(line for line in table if not line.startswith("#")))
        times, lists, touching = {}, {}, {}
        for copies in arguments.copies:
            steps = min(20 * arguments.steps, arguments.steps * max(arguments.copies) ** 2 // copies**2)
            write_tiles(folder, rows, copies)
            text = scene(f"tiles-{copies}", copies, end=steps * 3e-5)
            (folder / f"tiles-{copies}.toml").write_text(text)
        for _ in range(arguments.rounds):
            for copies in arguments.copies:
                run = [solver, f"tiles-{copies}.toml", "--quiet", "--force", "--threads", arguments.threads]
                subprocess.run(run, cwd=folder, check=True)
                summary = json.loads((folder / f"tiles-{copies}" / "summary.json").read_text())
                times.setdefault(copies, []).append(1e9 / summary["particle_steps_per_second"])
                log = (folder / f"tiles-{copies}" / "run.log").read_text().splitlines()
                lists[copies] = next(line for line in log if line.startswith("neighbour list"))
                touching[copies] = summary["coordination_number"]
        first = statistics.median(times[arguments.copies[0]])
        print("| spheres | ns per particle-step | ratio | coordination | |\n|---|---|---|---|---|")
        for copies, found in times.items():
            time = statistics.median(found)
            print(f"| {len(rows) * copies**2:,} | {time:.1f} | {time / first:.2f} | {touching[copies]:.3f} | {lists[copies]} |")


if __name__ == "__main__":
    main()
