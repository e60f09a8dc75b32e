#!/usr/bin/env python3
"""What sleeping saves and what it costs in accuracy: three scenes without sleepers, with them at several thresholds, and, as a measure of
chance, without them from places that differ by a thousandth of a micrometre.

    cargo build --release --bin mercury-solve
    benches/sleeping.py                       # all scenes, as a table in Markdown
    benches/sleeping.py --only rest --count   # one of them, instructions by callgrind (slow) instead of processor time

`left out`: share of all steps of particles that were not made. `time`: over that without sleepers, processor time on one thread without output but at the
end. Particles and kinetic energy are those at the end, height, load of the floor, places and contacts the difference to the run without sleepers there; `roused`: how often one was; `energy
lost`: the energy of the particles that fell asleep, over m g d.
"""

import argparse
import csv
import json
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BENCH = ROOT / "scenes" / "bench"
G = 9.81


def bed(end, more=""):
    """The packing of dense-2k, which has rested a while before."""
    text = (BENCH / "dense-2k.toml").read_text().replace("dense-2k.csv", str(BENCH / "dense-2k.csv"))
    text = text.replace("end  = 0.15", f"end  = {end}").replace("data = false", "data = true\npictures = false\nframes = false")
    return text.replace("interval = 1.0", f"interval = {end}").replace("[output]", more + "\n[output]")


def rest():
    return bed(0.3)


def filling():
    """A bead every tenth of a second falls on the bed."""
    return bed(0.6, """[[insertions]]
name     = "rain"
region   = { shape = "box", min = [0.003, 0.003, 0.066], max = [0.045, 0.045, 0.073] }
material = "bead"
psd      = { kind = "monodisperse", diameter = 0.004 }
total    = { number = 10 }
rate     = { number = 10.0 }
""")


def silo():
    """A flat floor with a hole that opens: what lies beside it stays where it is."""
    return """title = "silo"
seed = 1
gravity = [0.0, 0.0, -9.81]
[time]
end = 1.1
step = 2e-5
[domain]
min = [-0.018, -0.018, -0.03]
max = [0.018, 0.018, 0.1]
[materials.bead]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, restitution = 0.5 }
tangential = { law = "linear", stiffness_ratio = 0.2857142857142857, friction = 0.5 }
rolling = { law = "luding", friction = 0.1 }
[[walls]]
name = "silo"
shape = "revolution"
axis = [0.0, 0.0, 1.0]
origin = [0.0, 0.0, 0.0]
profile = [[0.0085, 0.0], [0.017, 0.0], [0.017, 0.1]]
side = "inside"
material = "bead"
[[walls]]
name = "gate"
shape = "disc"
axis = [0.0, 0.0, 1.0]
origin = [0.0, 0.0, 0.0]
radius = 0.0095
material = "bead"
until = 0.6
[[insertions]]
name = "fill"
region = { shape = "cylinder", axis = [0.0, 0.0, 1.0], origin = [0.0, 0.0, 0.0], radius = 0.0165, along = [0.002, 0.098] }
material = "bead"
psd = { kind = "uniform", min_diameter = 2.6e-3, max_diameter = 3.0e-3, weighting = "number" }
total = { number = 1500 }
[[deletions]]
name = "out"
region = { shape = "half-space", point = [0.0, 0.0, -0.02], normal = [0.0, 0.0, -1.0] }
[output]
interval = 1.1
data = true
ene = true
frames = false
pictures = false
"""


SCENES = {
    "rest": ("dense-2k at rest, 0.3 s", rest, 0.004, "box.-z"),
    "filling": ("A bead falls on it every 0.1 s, 0.6 s", filling, 0.004, "box.-z"),
    "silo": ("1,500 beads fill a silo with a flat floor and leave it from 0.6 s on; at 1.1 s", silo, 0.0026, "silo"),
}
ROWS = [
    ("none", None),
    ("none, 1e-9 m beside", "shift"),
    ("default", {}),
    ("imbalance 0.3", {"imbalance": 0.3}),
    ("imbalance 0.03", {"imbalance": 0.03}),
    ("speed x 10", {"speed": 10}),
    ("speed / 10", {"speed": 0.1}),
    ("after x 4", {"after": 4}),
]


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


class Runs:
    def __init__(self, solver, folder, count):
        self.solver, self.folder, self.count = solver, pathlib.Path(folder), count

    def run(self, name, text, diameter, wall, row):
        if row == "shift":
            text = text.replace("min = [0.0, 0.0, 0.0]", "min = [0.0, 0.0, -1e-9]").replace("along = [0.002,", "along = [0.002000001,")
        elif row is not None:
            defaults = {"speed": 1e-3 * (diameter * G) ** 0.5, "after": 0.5 * (diameter / G) ** 0.5, "imbalance": 1.0}
            keys = ", ".join(f"{key} = {factor * defaults[key]:.6g}" for key, factor in row.items())
            text = f"sleeping = {{ {keys} }}\n" + text
        scene = self.folder / f"{name}.toml"
        scene.write_text(text)
        out = self.folder / "out"
        command = [self.solver, scene, "--output", out, "--force", "--quiet", "--threads", "1"]
        if self.count:
            command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command]
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        result = subprocess.run(command, capture_output=True, text=True)
        if result.returncode != 0:
            sys.exit(result.stderr)
        cost = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        if self.count:
            cost = float(re.search(r"Collected : (\d+)", result.stderr)[1])
        return cost, self.read(out, wall)

    def read(self, out, wall):
        summary = json.loads((out / "summary.json").read_text())
        with open(next(out.glob("*.walls.csv"))) as file:
            rows = csv.DictReader(line for line in file if not line.startswith("#"))
            loads = [float(row["fz"]) for row in rows if row["name"].startswith(wall)]
        lines = next(out.glob("*.data")).read_text().splitlines()
        count = int(lines[len(lines) - 1 - summary["particles"]].split()[0])
        last = [list(map(float, line.split())) for line in lines[len(lines) - count:]]
        energies = next(out.glob("*.ene")).read_text().splitlines()
        energies = dict(zip(energies[0].split(), map(number, energies[-1].split())))
        return {"places": [row[:3] for row in last], "height": energies["centerOfMassZ"], "load": loads[-1],
                "kinetic": summary["energy"]["kinetic"] + summary["energy"]["rotational"], "contacts": summary["contacts"],
                "particles": summary["particles"], "sleeping": summary.get("sleeping")}


def apart(a, b):
    """Root of the mean square distance, where the same particles are there."""
    if len(a) != len(b):
        return None
    return statistics.fmean(sum((x - y) ** 2 for x, y in zip(p, q)) for p, q in zip(a, b)) ** 0.5


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--solver", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--only", help="names of scenes with this word in it")
    parser.add_argument("--count", action="store_true", help="instructions instead of processor time")
    arguments = parser.parse_args()
    cost_is = "instructions" if arguments.count else "time"
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(arguments.solver, folder, arguments.count)
        for name, (title, text, diameter, wall) in SCENES.items():
            if arguments.only and arguments.only not in name:
                continue
            print(f"\n**{title}**\n")
            print(f"| sleeping | left out | {cost_is} | particles | height, d | floor, % | kinetic energy, m g d | places, d | contacts, % | roused | energy lost, m g d |")
            print("|---|---|---|---|---|---|---|---|---|---|---|")
            reference = None
            # The silo takes longest.
            for label, row in ROWS[:4] if name == "silo" else ROWS:
                cost, seen = runs.run(name, text(), diameter, wall, row)
                reference = reference or (cost, seen)
                base = reference[1]
                # kg m/s^2 m of a particle
                unit = 2500 * 3.14159265 / 6 * diameter**3 * G * diameter
                far = apart(seen["places"], base["places"])
                sleeping = seen["sleeping"]
                cells = [
                    label,
                    f"{100 * sleeping['share']:.1f} %" if sleeping else "",
                    f"{cost / reference[0]:.2f}",
                    f"{seen['particles']}",
                    f"{(seen['height'] - base['height']) / diameter:+.1e}",
                    f"{100 * (seen['load'] / base['load'] - 1):+.3f}",
                    f"{seen['kinetic'] / unit:.1e}",
                    "" if far is None else f"{far / diameter:.1e}",
                    f"{100 * (seen['contacts'] / base['contacts'] - 1):+.2f}",
                    f"{sleeping['roused']}" if sleeping else "",
                    f"{sleeping['energy'] / unit:.1e}" if sleeping else "",
                ]
                print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
