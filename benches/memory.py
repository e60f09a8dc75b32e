#!/usr/bin/env python3
"""The memory that a run takes beside what its plan says: copies of scenes/bench/dense-20k side by side, read from a table.

usage: benches/memory.py [--solver target/release/mercury-solve] [--copies 7 7] [--threads 1] [--end 0.003] [--speed 0.5]

Needs Linux: sizes are VmRSS and VmHWM of /proc/PID/status, read every tenth of a second. The spheres slide along x with --speed (m/s), so
that lists are built anew. 7 x 7 copies are 980,000 spheres.
"""

import argparse
import json
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
WIDTH = 0.104  # of the benchmark's box, m


def write_scene(folder, copies, end, speed=0.5):
    bench = ROOT / "scenes" / "bench"
    head, *rows = (bench / "dense-20k.csv").read_text().split()
    rows = [row.split(",") for row in rows]
    with open(folder / "large.csv", "w") as table:
        table.write(head + "\n")
        for i in range(copies[0]):
            for j in range(copies[1]):
                for x, y, z, radius, _, *rest in rows:
                    place = f"{float(x) + i * WIDTH:.8g},{float(y) + j * WIDTH:.8g}"
                    table.write(",".join([place, z, radius, str(speed), *rest]) + "\n")
    scene = (bench / "dense-20k.toml").read_text()
    scene = scene.replace("dense-20k.csv", "large.csv")
    scene = scene.replace("max = [0.104, 0.104,", f"max = [{copies[0] * WIDTH}, {copies[1] * WIDTH},")
    scene = re.sub(r"end  = .*", f"end  = {end}", scene)
    (folder / "large.toml").write_text(scene)


def sizes(process):
    """Resident size and its maximum in bytes at each time (s)."""
    found, begun = [], time.time()
    while process.poll() is None:
        try:
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        except FileNotFoundError:
            break
        sizes = [re.search(key + r":\s+(\d+) kB", status) for key in ("VmRSS", "VmHWM")]
        if all(sizes):
            found.append((time.time() - begun, *(1024 * int(size[1]) for size in sizes)))
        time.sleep(0.1)
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--solver", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--copies", type=int, nargs=2, default=[7, 7])
    parser.add_argument("--threads", default="1")
    parser.add_argument("--end", type=float, default=0.003)
    parser.add_argument("--speed", type=float, default=0.5)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write_scene(folder, arguments.copies, arguments.end, arguments.speed)
        solve = [pathlib.Path(arguments.solver).resolve(), "large.toml", "--quiet", "--threads", arguments.threads]
        plan = json.loads(subprocess.check_output([*solve, "--check", "--json"], cwd=folder))
        check = subprocess.Popen([*solve, "--check"], cwd=folder, stdout=subprocess.DEVNULL)
        start = max(most for _, _, most in sizes(check))
        run = subprocess.Popen([*solve, "--checkpoint-every", "never"], cwd=folder)
        found = sizes(run)
        print((folder / "large" / "run.log").read_text())
        interval = f"output.restart_interval={arguments.end / 2.5}"
        again = subprocess.Popen([*solve, "--force", "--set", interval], cwd=folder)
        with_checkpoints = max(most for _, _, most in sizes(again))
    # The second half of the run lies in the time loop, but for its end.
    half = [size for when, size, _ in found if 0.5 < when / found[-1][0] < 0.9]
    measured = {"at_start": start, "time_loop": statistics.median(half), "at_most": max(most for _, _, most in found)}
    measured["with_checkpoints"] = with_checkpoints
    memory = plan["memory"]
    memory["with_checkpoints"] = memory["at_most"] + memory["checkpoint"]
    for name, size in measured.items():
        said = memory[name]
        print(f"{name:16} plan {said / 1e6:8.0f} MB, resident {size / 1e6:8.0f} MB, ratio {said / size:.3f}")


if __name__ == "__main__":
    main()
