#!/usr/bin/env python3
"""What the normal of the half step changes in bulk scenes: each scene with `sliding_normal = "half-step"` and `"step"`, from several seeds.

    cargo build --release --bin mercury-solve
    benches/sliding_normal.py [--seeds 3] [--only SCENE]

Prints a table in Markdown: the mean over the seeds, and their standard deviation, of one number for each scene.
"""

import argparse
import math
import pathlib
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOLVER = ROOT / "target" / "release" / "mercury-solve"

# 100 grains of 4 mm at rest in a box 16 mm wide, and 3,000 fines of 0.5 mm that fall into them.
FINES = """
title = "Fines among coarse grains"
gravity = [0.0, 0.0, -9.81]
[time]
end = 0.6
[domain]
min = [0.0, 0.0, 0.0]
max = [0.016, 0.016, 0.08]
[materials.grain]
density = 2500.0
normal = { law = "linear", stiffness = 200.0, restitution = 0.5 }
tangential = { law = "linear", stiffness_ratio = 0.8, friction = 0.6 }
[[walls]]
name = "box"
shape = "box"
sides = ["-x", "+x", "-y", "+y", "-z"]
material = "grain"
[[insertions]]
name = "coarse"
region = { shape = "box", min = [0.0, 0.0, 0.0], max = [0.016, 0.016, 0.06] }
material = "grain"
psd = { kind = "monodisperse", diameter = 4e-3 }
total = { number = 100 }
[[insertions]]
name = "fines"
region = { shape = "box", min = [0.0, 0.0, 0.045], max = [0.016, 0.016, 0.05] }
material = "grain"
psd = { kind = "monodisperse", diameter = 5e-4 }
total = { number = 3000 }
from = 0.3
[output]
interval = 0.3
"""


def last_frame(path):
    """Rows of the last frame of a .data file: x, y, z, vx, vy, vz, radius, ..."""
    frames = []
    with open(path) as lines:
        for head in lines:
            count = int(head.split()[0])
            frames = [[float(word) for word in next(lines).split()] for _ in range(count)]
    return frames


def mean(numbers):
    return statistics.fmean(numbers)


def heap(rows):
    """Angle of a cone of the same mean height and mean distance from the axis, degrees."""
    return math.degrees(math.atan(4 * mean(r[2] for r in rows) / (1.5 * mean(math.hypot(r[0], r[1]) for r in rows))))


# Scene, settings, what is measured, and how.
SCENES = {
    "settle": ("scenes/settle.toml", {"time.end": "0.4"}, "mean height, mm", lambda rows: 1e3 * mean(r[2] for r in rows)),
    "chute": ("chute", {}, "mean speed along the slope, m/s", lambda rows: mean(r[3] for r in rows)),
    "drum": ("drum", {}, "slope of the centre of mass, degrees",
             lambda rows: math.degrees(math.atan2(abs(mean(r[0] for r in rows)), -mean(r[2] for r in rows)))),
    "repose": ("repose", {}, "angle of repose, degrees", heap),
    "fines": (FINES, {}, "fines below the middle of the bed, %",
              lambda rows: 100 * mean(r[2] < 0.008 for r in rows if r[6] < 1e-3)),
}


def run(name, rule, seed, folder):
    scene, sets, _, measure = SCENES[name]
    path = folder / f"{name}.toml"
    if scene.endswith(".toml"):
        path = ROOT / scene
    elif "\n" in scene:
        path.write_text(scene)
    else:
        subprocess.run([SOLVER, "new", scene, folder / f"new-{name}-{rule}-{seed}"], check=True, capture_output=True)
        path = folder / f"new-{name}-{rule}-{seed}" / f"{scene}.toml"
    sets = {**sets, "contact.sliding_normal": rule, "seed": str(seed), "output.data": "true", "output.pictures": "false"}
    words = [word for key, value in sets.items() for word in ("--set", f"{key}={value}")]
    out = folder / f"{name}-{rule}-{seed}"
    subprocess.run([SOLVER, path, "--output", out, "--quiet", "--threads", "1", *words], check=True, capture_output=True, text=True)
    return measure(last_frame(out / f"{path.stem}.data"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", choices=SCENES)
    arguments = parser.parse_args()
    print('| scene | measured | `"half-step"` | `"step"` |\n|---|---|---|---|')
    for name in [arguments.only] if arguments.only else SCENES:
        cells = []
        for rule in ("half-step", "step"):
            with tempfile.TemporaryDirectory() as scratch:
                values = [run(name, rule, seed, pathlib.Path(scratch)) for seed in range(1, arguments.seeds + 1)]
            spread = statistics.stdev(values) if len(values) > 1 else 0.0
            cells.append(f"{mean(values):.4g} ± {spread:.2g}")
        print(f"| {name} | {SCENES[name][2]} | {cells[0]} | {cells[1]} |", flush=True)


if __name__ == "__main__":
    main()
