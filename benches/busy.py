#!/usr/bin/env python3
"""A small scene on a machine that has other things to do: with one thread, with all, and without `--threads`, which takes what is faster.

usage: benches/busy.py [SOLVER] [--others 4] [--rounds 3]

Default for SOLVER: target/release/mercury-solve. `--others`: processes that count for nothing as long as the runs last.
"""

import argparse
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

from memory import ROOT

SCENE = ["scenes/settle.toml", "--set", "time.end=0.05", "--set", "output.pictures=false", "--quiet", "--force"]


def seconds(solver, folder, threads):
    """Time in the time loop, s, as the run's log says it."""
    command = [solver, *SCENE, "--output", folder, *threads]
    subprocess.run(command, check=True, cwd=ROOT)
    log = (pathlib.Path(folder) / "run.log").read_text()
    number, unit = re.search(r"([\d.]+) (s|ms|min) in the time loop", log).groups()
    return float(number) * {"ms": 1e-3, "s": 1.0, "min": 60.0}[unit]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("solver", nargs="?", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--others", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    solver = pathlib.Path(options.solver).resolve()
    cores = str(os.cpu_count())
    ways = {"one thread": ["--threads", "1"], f"{cores} threads": ["--threads", cores], "as it likes": []}
    count = [sys.executable, "-c", "while True: pass"]
    others = [subprocess.Popen(count) for _ in range(options.others)]
    try:
        with tempfile.TemporaryDirectory() as folder:
            found = {way: [] for way in ways}
            for _ in range(options.rounds):
                for way, threads in ways.items():
                    found[way].append(seconds(solver, folder, threads))
    finally:
        for other in others:
            other.kill()
    for way, all_seconds in found.items():
        told = ", ".join(f"{s:.2f}" for s in all_seconds)
        print(f"{way}: {statistics.median(all_seconds):.2f} s in the time loop ({told})")


if __name__ == "__main__":
    main()
