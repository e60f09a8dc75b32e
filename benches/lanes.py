#!/usr/bin/env python3
"""Nanoseconds per particle-step with each number of lanes that the processor has, on one thread, alternating; medians.

usage: benches/lanes.py [SOLVER] [--against OTHER_SOLVER] [--rounds 3]

Default for SOLVER: target/release/mercury-solve. `mixed-20k` is the packing of dense-20k with every other bead of a second material, so that three laws
lie side by side. `--against`: another program, which chooses its lanes by itself, in the same rounds.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

from memory import ROOT

BENCH = ROOT / "scenes" / "bench"


def write_mixed(folder):
    head, *rows = (BENCH / "dense-20k.csv").read_text().split()
    rows = [f"{row},{('bead', 'other')[k % 2]}" for k, row in enumerate(rows)]
    (folder / "mixed-20k.csv").write_text("\n".join([f"{head},material", *rows]) + "\n")
    scene = (BENCH / "dense-20k.toml").read_text().replace("dense-20k.csv", "mixed-20k.csv")
    begin, end = scene.index("[materials.bead]"), scene.index("[[walls]]")
    other = scene[begin:end].replace("materials.bead", "materials.other").replace("friction = 0.5", "friction = 0.4")
    path = folder / "mixed-20k.toml"
    path.write_text(scene[:end] + other + scene[end:])
    return path


def cost(solver, scene, folder, lanes):
    """ns, or nothing if the processor has not so many lanes."""
    command = [solver, scene, "--output", folder / "run", "--force", "--quiet", "--threads", "1", "--set", "output.pictures=false"]
    if subprocess.run([*command, *lanes], capture_output=True).returncode != 0:
        return None
    return 1e9 / json.loads((folder / "run" / "summary.json").read_text())["particle_steps_per_second"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("solver", nargs="?", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--against")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    ways = [(f"{lanes} lanes", options.solver, ["--lanes", str(lanes)]) for lanes in (1, 2, 4)]
    if options.against:
        ways.append(("other program", options.against, []))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes = [BENCH / f"{scene}.toml" for scene in ("dense-2k", "dense-20k", "dense-20k-frictionless", "poly-20k", "mesh-drum-6k")]
        for scene in [*scenes, write_mixed(folder)]:
            rounds = [[cost(solver, scene, folder, lanes) for _, solver, lanes in ways] for _ in range(options.rounds)]
            shown = [f"{way} {statistics.median(costs):.1f}" for (way, _, _), costs in zip(ways, zip(*rounds)) if None not in costs]
            print(f"{scene.stem}: {', '.join(shown)}", flush=True)


if __name__ == "__main__":
    main()
