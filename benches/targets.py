#!/usr/bin/env python3
"""The numbers that the solver is measured by, with one command: time beside LIGGGHTS on one core, without friction, on two threads.

    cargo build --release --bin mercury-solve && apt-get install liggghts
    benches/targets.py                       # on a machine that has nothing else to do; some twenty minutes
    benches/targets.py --scenes dense-2k threads --rounds 3

All are run in turn, round by round; a row of the table has medians (and minima) of nanoseconds per particle-step: of the whole time loop, without start-up and output;
of LIGGGHTS of its loop after 50 steps to warm up. Each run's number goes into benches/results/targets.csv, with when all began, the commit, the processor and the way; where
that names no lanes they are what the program chooses. Coordination numbers and kinetic energies of both codes stand beside them, as the times of
different physics say nothing. drum-soft is the scene of the open-source DEM benchmark, ../shared/scenes/drum-soft.toml beside this checkout, or where `--drum-soft` says; without it the row is left out.
"""

import argparse
import csv
import datetime
import json
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import tempfile

from memory import ROOT

BENCH = ROOT / "scenes" / "bench"
RESULTS = ROOT / "benches" / "results" / "targets.csv"
BESIDE = ["dense-2k", "dense-20k", "poly-20k", "mesh-drum-6k", "flow-20k", "drum-soft"]
OURS = ["frictionless", "threads"]
SOFT = [f"materials.{material}.tangential.stiffness_factor=1.0" for material in ("m1", "m2", "steel")]
SOFT += ["contact.coulomb_limits=elastic", "contact.sliding_normal=step", "time.end=0.2"]
SOFT_STEPS = 1950  # after 50 to warm up, 2,000 as SOFT has them


def processor():
    found = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text()) if sys.platform == "linux" else None
    return found[1] if found else platform.processor()


def commit():
    """That of the checkout, with a + if that is changed."""
    result = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty=+", "--exclude=*"], capture_output=True, text=True)
    return result.stdout.strip()


def mercury(options, scene, settings=(), lanes=None, threads=1):
    """ns per particle-step, coordination number, kinetic energy (J) at the end; none if the processor has not so many lanes."""
    command = [options.solver, scene, "--force", "--quiet", "--threads", str(threads), "--fixed-threads"]
    for setting in [*settings, "output.pictures=false"]:
        command += ["--set", setting]
    if lanes:
        command += ["--lanes", str(lanes)]
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run([*command, "--output", folder + "/run"], capture_output=True, text=True)
        if run.returncode != 0:
            if lanes and "lanes" in run.stderr:
                return None
            sys.exit(run.stderr)
        summary = json.loads((pathlib.Path(folder) / "run" / "summary.json").read_text())
    energy = summary["energy"]
    return 1e9 / summary["particle_steps_per_second"], summary["coordination_number"], energy["kinetic"] + energy["rotational"]


def liggghts(scene, *more):
    run = subprocess.run([sys.executable, ROOT / "benches" / "peers.py", "liggghts", scene, *more], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(run.stderr)
    wall, coordination, energy = (float(re.search(rf"{name}=(\S+)", run.stdout)[1]) for name in ("wall_ns", "coordination", "kinetic_total"))
    return wall, coordination, energy


def ways(options, scene):
    """What is run in turn for a row: name and function."""
    if scene == "frictionless":
        return {
            "hertz-mindlin": lambda: mercury(options, BENCH / "dense-20k.toml"),
            "frictionless": lambda: mercury(options, BENCH / "dense-20k-frictionless.toml"),
        }
    if scene == "threads":
        dense = (options, BENCH / "dense-20k.toml", ["time.end=0.054"])
        return {f"{threads} thread{'s' * (threads > 1)}": lambda threads=threads: mercury(*dense, threads=threads) for threads in (1, 2)}
    path, settings, peer = BENCH / f"{scene}.toml", [], [scene]
    if scene == "drum-soft":
        path, settings, peer = options.drum_soft, SOFT, [str(options.drum_soft), "--steps", str(SOFT_STEPS)]
    found = {f"{lanes} lanes": lambda lanes=lanes: mercury(options, path, settings, lanes) for lanes in (4,)}
    return {**found, "liggghts": lambda: liggghts(*peer)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", choices=[*BESIDE, *OURS], default=[*BESIDE, *OURS])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--solver", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--drum-soft", type=pathlib.Path, default=ROOT.parent / "shared" / "scenes" / "drum-soft.toml")
    options = parser.parse_args()
    begun = datetime.datetime.now().isoformat(timespec="minutes")
    rows = []
    print("| scene | ns, medians (minima) | to the last | coordination | kinetic energy (J) |\n|---|---|---|---|---|")
    for scene in options.scenes:
        if scene == "drum-soft" and not options.drum_soft.exists():
            continue
        runs = {}
        for turn in range(options.rounds):
            for way, run in ways(options, scene).items():
                found = run()
                if found is None:
                    continue
                runs.setdefault(way, []).append(found)
                rows.append([begun, commit(), processor(), scene, way, turn, *(f"{number:.6g}" for number in found)])
        medians = {way: statistics.median(run[0] for run in found) for way, found in runs.items()}
        shown = ", ".join(f"{way} {median:.1f} ({min(run[0] for run in runs[way]):.1f})" for way, median in medians.items())
        last = [*medians.values()][-1]
        parts = ", ".join(f"{median / last:.2f}" for median in [*medians.values()][:-1])
        same = [", ".join(f"{found[0][k]:.5g}" for found in runs.values()) for k in (1, 2)]
        print(f"| {scene} | {shown} | {parts} | {same[0]} | {same[1]} |", flush=True)
        with open(RESULTS, "a", newline="") as table:
            write = csv.writer(table)
            if table.tell() == 0:
                write.writerow(["begun", "commit", "processor", "scene", "way", "round", "ns", "coordination", "kinetic_energy"])
            write.writerows(rows)
        rows.clear()


if __name__ == "__main__":
    main()
