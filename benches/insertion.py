#!/usr/bin/env python3
"""What insertion costs while its region is full: the time of scenes/bench/full-region*.toml from 0.3 s on, with the insertion that goes
on trying over that without it. Both start from the same run to 0.3 s, and what goes on trying is 2.5 times as large, so that it never
finds a place: both runs make the same steps of the same grains, and only the trying differs. Runs alternate; each pair gives a ratio.

    cargo build --release --bin mercury-solve && benches/insertion.py [--pairs 7] [--scene full-region-clumps]

Processor time of one thread is counted, start-up included. `--count`: instructions by callgrind, without the start-up, once. `--box 0.02`: a cube of
2 cm with a hundred grains.
"""

import argparse
import json
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile

# Diameters that wait, m.
LARGE = {
    "full-region": ["insertions.fill.psd.min_diameter=9e-3", "insertions.fill.psd.max_diameter=11e-3"],
    "full-region-clumps": ["insertions.fill.psd.diameter=22.5e-3"],
}
ROOT = pathlib.Path(__file__).resolve().parent.parent
SOLVER = ROOT / "target/release/mercury-solve"


def run(scene, output, *settings):
    """Runs a scene; returns its processor time, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [SOLVER, scene, "--output", output, "--quiet", "--force", "--threads", "1", "--set", "output.pictures=false"]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def counted(scene, output, *settings):
    """Instructions of a run but for its start."""
    def instructions(end):
        command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", SOLVER, scene, "--output", output, "--quiet", "--force",
                   "--threads", "1", "--set", "output.pictures=false"]
        for setting in (*settings, f"time.end={end}"):
            command += ["--set", setting]
        log = subprocess.run(command, check=True, capture_output=True, text=True).stderr
        return int(re.search(r"Collected : (\d+)", log)[1])

    of_start = instructions(0.0002)
    return instructions(0.2) - of_start


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--pairs", type=int, default=7)
    arguments.add_argument("--scene", action="append", choices=LARGE)
    arguments.add_argument("--count", action="store_true")
    arguments.add_argument("--box", type=float, help="edge of a cube, m, in place of the box of the scene")
    arguments = arguments.parse_args()
    measured, pairs = (counted, 1) if arguments.count else (run, arguments.pairs)
    cube = [arguments.box] * 3
    box = [f"domain.max={cube}", f"insertions.fill.region.max={cube}"] if arguments.box else []
    for name in arguments.scene or ["full-region", "full-region-clumps"]:
        scene = ROOT / f"scenes/bench/{name}.toml"
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            run(scene, folder / "filled", "time.end=0.3", *box)
            later = folder / "later.toml"
            text = scene.read_text().replace('"../', f'"{scene.parent.parent}/')
            later.write_text(text + f'\n[[particles]]\nrun = "{folder / "filled"}"\n')
            ratios = []
            for _ in range(pairs):
                trying = measured(later, folder / "waiting", "time.end=0.2", *LARGE[name], *box)
                # The same sizes: the skin of the candidate list follows from them.
                over = measured(later, folder / "over", "time.end=0.2", *LARGE[name], *box, "insertions.fill.until=1e-9")
                ratios.append(trying / over)
                waiting = json.loads((folder / "waiting" / "summary.json").read_text())
                if waiting["inserted"]:
                    sys.exit(f"{name}: {waiting['inserted']} came: they are not large enough")
                unit = "instructions" if arguments.count else "s"
                print(f"{name}: {trying:.6g} {unit} with insertion, {over:.6g} without: {ratios[-1]:.4f}")
        spread = statistics.stdev(ratios) / len(ratios) ** 0.5 if len(ratios) > 1 else float("nan")
        print(f"{name}: median {statistics.median(ratios):.4f}, mean {statistics.mean(ratios):.4f} +- {spread:.4f}")


if __name__ == "__main__":
    main()
