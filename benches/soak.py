#!/usr/bin/env python3
"""Hours of simulated insertion and deletion: is the resident size flat, do counts and ids stay right?

    pip install pyarrow
    benches/soak.py [--solver target/release/mercury-solve] [--hours 3] [--docs]

Needs Linux: sizes are VmRSS of /proc/PID/status. Spheres and clumps of two spheres come in at 60 a second, fall on pegs, and are deleted below them; all outputs are
on, every second. --docs puts the result at the end of docs/stability.md. Exit 1 if anything is wrong.

What may grow, and by how much (the rest is an error):
- the energies of each frame are kept for the end of the run: a row of 72 bytes, in an array that doubles, and copied into checkpoints, which double too;
- the sizes that came in are kept up to 65,536 for each ingredient that has more than one size, 8 bytes each, and copied into checkpoints;
- what was reserved for the largest number of grains so far: every array doubles too;
- the allocator's pages: 128 KiB at the top of each of two arenas, in and out.
"""

import argparse
import collections
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import pyarrow.ipc

ROOT = pathlib.Path(__file__).resolve().parent.parent
STEP = 2.5e-4  # s
RATE = 60  # grains a second
ROW_OF_ENERGIES = 72  # bytes
ALLOCATOR = 2 * 2 * 128 * 1024  # bytes
SIZES = 3 * 8 * 65536  # bytes: kept, copied for a checkpoint, and written into one
ROW = 1024  # bytes of a particle in all columns, lists, contacts and queued frames, rounded up

SCENE = """
title   = "Soak"
seed    = 11
gravity = [0.0, 0.0, -9.81]

[time]
end  = {end}
step = {step}

[domain]
min = [0.0, 0.0, 0.0]
max = [1.0, 1.0, 2.0]

[materials.grain]
density    = 1000.0
normal     = {{ law = "linear", stiffness = 2e4, restitution = 0.5 }}
tangential = {{ law = "linear", stiffness = 6e3, friction = 0.4 }}
rolling    = {{ law = "luding", friction = 0.05 }}

[clumps.pair]
file     = "pair.clump.toml"
material = "grain"

[[walls]]
name     = "sides"
shape    = "box"
sides    = ["-x", "+x", "-y", "+y"]
material = "grain"

[[particles]]
material = "grain"
radius   = 0.05
fixed    = true
lattice  = {{ min = [0.2, 0.2, 0.8], max = [0.8, 0.8, 0.8], spacing = 0.3 }}

[[insertions]]
name     = "rain"
region   = {{ shape = "box", min = [0.0, 0.0, 1.5], max = [1.0, 1.0, 2.0] }}
mixture  = [{{ material = "grain", psd = {{ kind = "uniform", min_diameter = 0.04, max_diameter = 0.06, weighting = "number" }}, share = 0.5 }},
            {{ clump = "pair", psd = {{ kind = "monodisperse", diameter = 0.05 }}, share = 0.5 }}]
share_by = "number"
rate     = {{ number = {rate} }}
velocity = {{ mean = [0.0, 0.0, -0.5], spread = [0.5, 0.5, 0.2] }}

[[deletions]]
name   = "outlet"
region = {{ shape = "box", min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 0.3] }}

[output]
interval = 1.0
fstat    = true
pictures = false
"""

# Two touching spheres of diameter 1 in a row, I = m R^2 (0.4, 1.4, 1.4) times two.
PAIR = """
name = "pair"
density = 1.0
mass = 1.0471975511965976
volume = 1.0471975511965976
centre_of_mass = [0.0, 0.0, 0.0]
principal_moments = [0.10471975511965977, 0.3665191429188092, 0.3665191429188092]
rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
inertia_method = "pebbles"
pebbles = [
  { position = [-0.5, 0.0, 0.0], radius = 0.5 },
  { position = [0.5, 0.0, 0.0], radius = 0.5 },
]
"""


def resident(process):
    """Resident size, bytes, or None when the process has gone."""
    try:
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    except FileNotFoundError:
        return None
    size = re.search(r"VmRSS:\s+(\d+) kB", status)
    return int(size[1]) * 1024 if size else None


def frames_written(folder):
    """Lines of the energies, which are written with each frame."""
    try:
        return (folder / "soak.ene").read_bytes().count(b"\n")
    except FileNotFoundError:
        return 0


def run(solver, folder, end):
    """The sizes (bytes) with the number of frames at that time, and the summary."""
    (folder / "soak.toml").write_text(SCENE.format(end=end, step=STEP, rate=RATE))
    (folder / "pair.clump.toml").write_text(PAIR)
    sizes = []
    process = subprocess.Popen([solver, "soak.toml", "--quiet", "--threads", "1", "--output", "out", "--checkpoint-every", "1m"], cwd=folder)
    while process.poll() is None:
        size = resident(process)
        if size:
            sizes.append((frames_written(folder / "out"), size))
        time.sleep(1.0)
    if process.returncode != 0:
        sys.exit(f"mercury-solve ended with {process.returncode}")
    return sizes, json.loads((folder / "out" / "summary.json").read_text())


def look_at_ids(folder):
    """Checks ids frame by frame; returns frames, most rows in a frame, the largest id, and how many bodies have not two pebbles in the same frame."""
    frames = most = largest = wrong = 0
    earlier, gone = set(), set()
    with pyarrow.ipc.open_stream(folder / "soak.particles.arrow") as particles, pyarrow.ipc.open_stream(folder / "soak.bodies.arrow") as bodies:
        for batch, of_bodies in zip(particles, bodies):
            ids = batch.column("id").to_pylist()
            now = set(ids)
            if len(now) != len(ids):
                sys.exit(f"frame {frames}: an id stands twice")
            gone |= earlier - now
            if now & gone:
                sys.exit(f"frame {frames}: an id came back: {sorted(now & gone)[:3]}")
            new = now - earlier
            if earlier and new and min(new) <= largest:
                sys.exit(f"frame {frames}: a new id, {min(new)}, is not above all earlier ones, {largest}")
            pebbles = collections.Counter(body for body in batch.column("body").to_pylist() if body is not None)
            wrong += pebbles != collections.Counter({body: 2 for body in of_bodies.column("id").to_pylist()})
            earlier, largest = now, max(largest, *ids)
            frames, most = frames + 1, max(most, len(ids))
    return frames, most, largest, wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--solver", default=ROOT / "target" / "release" / "mercury-solve", type=pathlib.Path)
    parser.add_argument("--hours", default=3.0, type=float, help="simulated")
    parser.add_argument("--docs", action="store_true", help="write the result to docs/stability.md")
    arguments = parser.parse_args()
    end = 3600.0 * arguments.hours
    begun = time.time()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        sizes, summary = run(arguments.solver.resolve(), folder, end)
        frames, most, largest, wrong = look_at_ids(folder / "out")
    took = time.time() - begun

    # From a tenth of the run on, all arrays have had their size.
    start = [size for count, size in sizes if count >= 0.1 * frames][:5]
    late = [size for count, size in sizes if count >= 0.5 * frames]
    grown = max(late) - min(start)
    allowed = 4 * ROW_OF_ENERGIES * frames + SIZES + 2 * most * ROW + ALLOCATOR
    fixed = 9
    wanted = RATE * end
    warnings = [text for text in summary["warnings"] if not text.startswith("overlaps above 10 %")]
    checks = [
        ("growth of the resident size from a tenth of the run on (kB)", f"at most {allowed / 1e3:.0f}", f"{grown / 1e3:.0f}", grown <= allowed),
        ("grains at the end: start + inserted - deleted", str(fixed + summary["inserted"] - summary["deleted"]), str(summary["particles"]),
         fixed + summary["inserted"] - summary["deleted"] == summary["particles"]),
        ("inserted: rate times time, less one at most", f"{wanted - 1:.0f} to {wanted:.0f}", str(summary["inserted"]), wanted - 1 <= summary["inserted"] <= wanted),
        ("ids: unique in each frame, ascending with time, none comes back; frames looked at", f"{end + 1:.0f}", str(frames), frames == end + 1),
        ("the largest id, over grains ever: one for each sphere, two for each clump", "1 to 2", f"{largest / (fixed + summary['inserted']):.4f}",
         1.0 <= largest / (fixed + summary["inserted"]) <= 2.0),
        ("frames in which a body has not just two pebbles", "0", str(wrong), wrong == 0),
        ("warnings, but of soft contacts", "0", str(len(warnings)), not warnings),
    ]
    text = "## Soak\n\n"
    text += (f"{arguments.hours:g} hours of simulated time ({summary['steps']:.2e} steps, {took / 60:.0f} minutes by the clock) of insertion at {RATE} grains a second, half of them clumps, and deletion: "
             f"{summary['inserted']} grains came, {most} rows at most at a time. Particles, contacts, bodies, energies and walls are written every second, a checkpoint every minute by the clock. "
             f"Resident size at a tenth of the run {min(start) / 1e6:.1f} MB, at most {max(late) / 1e6:.1f} MB in its second half.\n\n```sh\nbenches/soak.py --hours {arguments.hours:g} --docs\n```\n\n")
    text += ("What may grow: a row of energies of 72 bytes for each frame, kept for the end of the run, in an array that doubles, and copied into checkpoints; up to 65,536 sizes, 8 bytes each, which a checkpoint copies; what is reserved for the largest number of grains; "
             "some pages of the allocator.\n\n| check | expected | measured | status |\n|---|---|---|---|\n")
    for name, expected, measured, holds in checks:
        text += f"| {name} | {expected} | {measured} | {'pass' if holds else '**FAIL**'} |\n"
    print(text)
    if arguments.docs:
        page = ROOT / "docs" / "stability.md"
        before = page.read_text() if page.exists() else ""
        page.write_text(before.split("## Soak\n")[0] + text)
    return 0 if all(check[3] for check in checks) else 1


if __name__ == "__main__":
    sys.exit(main())
