#!/usr/bin/env python3
"""Small scenes on a machine that has other things to do: with one thread, with all of them in every step, and with as many as are faster.

usage: benches/busy.py [SOLVER] [--others 4] [--rounds 3] [--spheres 500 1000 2000]

Default for SOLVER: target/release/mercury-solve. `--others`: processes that count for nothing as long as the runs last. The scene is `settle` with so
many spheres; seconds in the time loop, medians of rounds in which the ways take turns.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from memory import ROOT

SCENE = ["scenes/settle.toml", "--set", "time.end=0.05", "--set", "output.pictures=false", "--quiet", "--force"]


def seconds(solver, folder, spheres, threads):
    """Time in the time loop, s."""
    command = [solver, *SCENE, "--set", f"insertions.rain.total.number={spheres}", "--output", folder, *threads]
    subprocess.run(command, check=True, cwd=ROOT)
    return json.loads((pathlib.Path(folder) / "summary.json").read_text())["wall_seconds"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("solver", nargs="?", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--others", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--spheres", type=int, nargs="+", default=[500, 1000, 2000])
    options = parser.parse_args()
    solver = pathlib.Path(options.solver).resolve()
    cores = str(os.cpu_count())
    ways = {"1 thread": ["--threads", "1"], f"{cores} in every step": ["--threads", cores, "--fixed-threads"], f"at most {cores}": ["--threads", cores], "as it likes": []}
    count = [sys.executable, "-c", "while True: pass"]
    others = [subprocess.Popen(count) for _ in range(options.others)]
    try:
        with tempfile.TemporaryDirectory() as folder:
            for spheres in options.spheres:
                found = {way: [] for way in ways}
                for _ in range(options.rounds):
                    for way, threads in ways.items():
                        found[way].append(seconds(solver, folder, spheres, threads))
                for way, all_seconds in found.items():
                    shown = ", ".join(f"{s:.3f}" for s in all_seconds)
                    print(f"{spheres} spheres, {way}: {statistics.median(all_seconds):.3f} s in the time loop ({shown})", flush=True)
    finally:
        for other in others:
            other.kill()


if __name__ == "__main__":
    main()
