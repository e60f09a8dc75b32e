#!/usr/bin/env python3
"""Runs that end when a result is known: is the interval right, and does an interrupted run end with the same bytes?

    cargo build --release --bin mercury-solve
    benches/known.py           # benches/results/known.csv, some 20 minutes on one core
    benches/known.py --seeds 3 --length 20 --kills 5    # a short look, printed only

The drum of scenes/drum.toml, 900 beads at 3 rad/s, a quarter as stiff; its torque is to be known to 2 % (one standard error), from rows every 0.01 s.

interval   each seed's run ends by itself (`time.until`). Its 95 % interval should hold the mean of the same drum over --length s behind the start-up,
           whose own error is printed beside it: 17 of 20 or more. None may end before 3 turns.
kills      the run of the first seed is killed --kills times (SIGKILL) at random times and resumed with 1 to 3 threads: all files but the log have the bytes
           of the run that was not, and it ends at the same step with the same results.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOLVER = pathlib.Path(os.environ.get("MERCURY_SOLVE", ROOT / "target/release/mercury-solve"))
RESULTS = ROOT / "benches/results/known.csv"
SCENE = ROOT / "scenes/drum.toml"
TURNS = 3 * 2 * math.pi / 3.0  # s, at 3 rad/s
START = 0.15  # s, when the drum begins to turn
SETTINGS = [
    # Softer and with longer steps than the scene: a twentieth of a contact, six times as fast.
    "materials.glass.normal.stiffness=50", "time.step=5e-5", "output.interval=0.5", "output.rows_interval=0.01", "output.pictures=false", "output.data=false",
    'results={ torque = "mean(walls.drum.ty, steady..)" }',
]
UNTIL = ["time.end=120", 'time.until={ result = "torque", error = "2 %" }']
CLOCK = {"run.log", "summary.json"}  # files with times by the clock


def command(folder, settings, *more):
    words = [str(SOLVER), str(SCENE), "--output", str(folder), "--quiet", *more]
    return words + [word for setting in SETTINGS + settings for word in ("--set", setting)]


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def made(folder, settings, *more):
    """The summary of a run, and the seconds that it took."""
    since = time.perf_counter()
    subprocess.run(command(folder, settings, *more), check=True)
    return summary(folder), time.perf_counter() - since


def torque(found):
    return found["results"]["torque"]


def intervals(place, seeds, length):
    """A row for each seed; the long mean first."""
    long, seconds = made(place / "long", [f"time.end={length + 1}", "seed=1000"], "--threads", "1")
    mean, error = torque(long)["value"], torque(long)["error"]
    print(f"mean of {length} s: {mean:.5e} +- {error:.1e} N m ({100 * error / abs(mean):.2f} %); {seconds / (length + 1):.2f} s for a second", flush=True)
    rows = []
    for seed in range(1, seeds + 1):
        found, _ = made(place / str(seed), UNTIL + [f"seed={seed}"], "--threads", "1")
        known = torque(found)
        low, high = known["interval"]
        rows.append({
            "seed": seed, "end": found["time"], "reached": found["until"][0]["reached"], "value": known["value"], "error": known["error"],
            "low": low, "high": high, "batches": known["batches"], "holds": low <= mean <= high,
            "in_errors": (known["value"] - mean) / math.hypot(known["error"], error),
        })
        row = rows[-1]
        print(f"seed {seed}: {row['end']:.2f} s, {row['value']:.4e} +- {row['error']:.1e}, {row['in_errors']:+.2f} errors, "
              f"{'holds' if row['holds'] else 'MISSES'} the mean", flush=True)
    return rows


def bytes_of(folder):
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    # Two checkpoints are kept, at times by the clock.
    return {str(path.relative_to(folder)): path.read_bytes() for path in files if path.name not in CLOCK and path.suffix != ".restart"}


def killed(place, kills):
    """Whether the run of the first seed, killed so often, leaves the same bytes; prints what differs."""
    whole, seconds = made(place / "whole", UNTIL + ["seed=1"], "--threads", "1")
    folder, left, tries = place / "killed", kills, 0
    numbers = random.Random(47)
    while left and tries < 20 * kills:
        tries += 1
        threads = str(numbers.randint(1, 3))
        run = subprocess.Popen(command(folder, UNTIL + ["seed=1"], "--resume", "--checkpoint-every", "0.05s", "--fixed-threads", "--threads", threads))
        try:
            # Such that all of them lie within the run.
            run.wait(timeout=numbers.uniform(0.1, 1.2) * seconds / (kills + 1))
            break
        except subprocess.TimeoutExpired:
            run.kill()
            run.wait()
            left -= 1
    again, _ = made(folder, UNTIL + ["seed=1"], "--resume", "--threads", "2", "--fixed-threads")
    one, other = bytes_of(place / "whole"), bytes_of(folder)
    wrong = [name for name in sorted(one.keys() | other.keys()) if one.get(name) != other.get(name)]
    wrong += [member for member in ("steps", "time", "results", "until") if whole[member] != again[member]]
    print(f"{kills - left} kills: {'the same bytes' if not wrong else 'differs: ' + ', '.join(wrong)}, step {again['steps']} and {whole['steps']}", flush=True)
    return not wrong and left == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--length", type=float, default=200.0, help="s of the long run")
    parser.add_argument("--kills", type=int, default=20)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder)
        is_same = killed(place, arguments.kills)
        rows = intervals(place, arguments.seeds, arguments.length)
    holding = sum(row["holds"] for row in rows)
    earliest = min(row["end"] for row in rows)
    least = math.floor(0.85 * len(rows))
    print(f"{holding} of {len(rows)} intervals hold the long mean ({least} are needed); the earliest end is {earliest:.2f} s, "
          f"3 turns are over at {START + TURNS:.2f} s; mean length {sum(row['end'] for row in rows) / len(rows):.1f} s")
    if (arguments.seeds, arguments.length) == (20, 200.0):
        with open(RESULTS, "w", newline="") as file:
            table = csv.DictWriter(file, rows[0])
            table.writeheader()
            table.writerows(rows)
    return 0 if is_same and holding >= least and earliest >= START + TURNS and all(row["reached"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
