#!/usr/bin/env python3
"""What checkpoints cost a run of 980,000 touching spheres: how long the steps wait for each, and how long each is being written.

usage: benches/checkpoints.py [SOLVER] [--copies 7 7] [--threads 1] [--rounds 3]

Default for SOLVER: target/release/mercury-solve. The steps' wait is what run.log says; writing is counted from when the temporary file
appears until it has its name, looked at every 2 ms, and goes on beside the steps.
"""

import argparse
import os
import pathlib
import re
import subprocess
import tempfile
import time

from memory import ROOT, write_scene


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("solver", nargs="?", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--copies", type=int, nargs=2, default=[7, 7])
    parser.add_argument("--threads", default="1")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    solver = pathlib.Path(options.solver).resolve()
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        write_scene(place, options.copies, 0.0018)
        for _ in range(options.rounds):
            output = place / "run"
            command = [solver, place / "large.toml", "--output", output, "--threads", options.threads, "--quiet", "--force"]
            command += ["--set", "output.restart_interval=0.0003", "--set", "output.pictures=false"]
            process = subprocess.Popen(command)
            writing, since = [], None
            while process.poll() is None:
                names = os.listdir(output) if output.is_dir() else []
                is_there = any("restart" in name and not name.endswith(".restart") for name in names)
                if is_there and since is None:
                    since = time.time()
                elif not is_there and since is not None:
                    writing.append(time.time() - since)
                    since = None
                time.sleep(0.002)
            if process.returncode != 0:
                raise SystemExit(f"the run failed with exit code {process.returncode}")
            log = (output / "run.log").read_text()
            count, held, unit = re.search(r"checkpoints: (\d+), for which the steps were held for ([\d.]+) (\w+)", log).groups()
            held = float(held) * {"s": 1.0, "ms": 1e-3}[unit] / int(count)
            size = max(file.stat().st_size for file in output.glob("*.restart"))
            shown = ", ".join(f"{seconds:.2f}" for seconds in writing)
            print(f"{count} checkpoints of {size / 1e6:.0f} MB: steps held for {held:.3f} s each; written in {shown} s")


if __name__ == "__main__":
    main()
