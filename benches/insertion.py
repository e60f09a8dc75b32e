#!/usr/bin/env python3
"""What insertion costs while its region is full: the time of the steps after 0.3 s of scenes/bench/full-region*.toml, with the insertion
that goes on trying over that of the same run whose insertion ended at 0.3 s. Runs alternate; each pair gives a ratio.

    cargo build --release --bin mercury-solve && benches/insertion.py [--pairs 7] [--scene full-region-clumps]

Processor time of one thread is counted. The run to 0.3 s, the same in both, is taken off.
"""

import argparse
import os
import pathlib
import resource
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOLVER = ROOT / "target/release/mercury-solve"


def seconds(scene, *settings):
    """Processor time of a run, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        command = [SOLVER, ROOT / f"scenes/bench/{scene}.toml", "--output", os.path.join(folder, "run"), "--quiet", "--threads", "1"]
        for setting in settings:
            command += ["--set", setting]
        subprocess.run(command, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--pairs", type=int, default=7)
    arguments.add_argument("--scene", action="append")
    arguments = arguments.parse_args()
    for scene in arguments.scene or ["full-region", "full-region-clumps"]:
        ratios = []
        for _ in range(arguments.pairs):
            filling = seconds(scene, "time.end=0.3")
            trying = seconds(scene)
            over = seconds(scene, "insertions.fill.until=0.3")
            ratios.append((trying - filling) / (over - filling))
            print(f"{scene}: {filling:.2f} s to 0.3 s, then {trying - filling:.2f} s with insertion, {over - filling:.2f} s without: {ratios[-1]:.4f}")
        spread = statistics.stdev(ratios) / len(ratios) ** 0.5 if len(ratios) > 1 else float("nan")
        print(f"{scene}: median {statistics.median(ratios):.4f}, mean {statistics.mean(ratios):.4f} +- {spread:.4f}")


if __name__ == "__main__":
    main()
