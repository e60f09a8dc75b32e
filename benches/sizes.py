#!/usr/bin/env python3
"""Cost of a step against the ratio of the largest size to the smallest, with levels of sizes and with a single grid.

    cargo build --release --bin mercury-solve && cargo build --release -p solver --example size_levels
    pip install numpy matplotlib && apt-get install valgrind
    benches/sizes.py make                        # packings into target/sizes; `--folder` puts them elsewhere
    benches/sizes.py count                       # instructions, which do not depend on other programs on the machine
    benches/sizes.py time                        # nanoseconds; needs a machine that has nothing else to do
    benches/sizes.py draw                        # docs/pictures/size-ratio.svg from benches/results/sizes.csv
    benches/sizes.py peers --states adrift       # beside LIGGGHTS and LAMMPS (Debian's packages): benches/results/sizes_peers.csv

Packings are periodic along all axes. Numbers follow N(> r) ~ r^-2.5 between the smallest radius and the largest, which is Fuller's grading: the
mass below a size grows with its root. The domain must be as wide as twice the largest diameter, so a ratio of 50 needs 62,000 spheres and one of
100 some 354,000; 30,000 elsewhere. Spheres are placed at random from the largest to the smallest, then the domain shrinks by small steps, after each of which
mercury-solve pushes overlaps apart, without friction, until the packing bears a pressure: with 6 contacts for each sphere that bears some, whatever the sizes.

Two states of each: at rest, and as a whole adrift with the speed that uses up the skin of the list in some 20 steps. Nothing differs but the lists. In a third one
spheres fly about at random (`random`), all with the same mean speed.
"""

import argparse
import csv
import json
import math
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import time

from memory import ROOT

RATIOS = [1, 2, 5, 10, 20, 50, 100]
RESULTS = ROOT / "benches" / "results" / "sizes.csv"
PICTURE = ROOT / "docs" / "pictures" / "size-ratio.svg"
FULLER = 2.5  # exponent of the numbers
SMALLEST = 1e-3  # radius, m
MODULUS = 1e7  # Pa
STEP = 1.2e-5  # s: a tenth of the contact of two of the smallest at 10 m/s, a thirtieth at 0.03 m/s
# Energy of the contacts over volume and modulus at which a packing is done: contacts of spheres of one size are then pressed in by 0.4 % of the radius.
PRESSED = 1e-7
STATES = ["rest", "adrift", "random"]


def radii(ratio, count):
    """In equal parts of the distribution by number, descending, both ends among them; m."""
    import numpy

    parts = (numpy.arange(count) + 0.5) / count
    found = (1 - parts * (1 - ratio**-FULLER)) ** (-1 / FULLER) if ratio > 1 else numpy.ones(count)
    found[0], found[-1] = 1, ratio
    return SMALLEST * found[::-1]


def volume(sizes):
    return 4 / 3 * math.pi * float((sizes**3).sum())


def number(ratio):
    """Of spheres: a packed domain, of which they fill 0.85 at a ratio of 50 and up to 0.9 beyond, is 4.2 of the largest radii wide or a hundredth less, so that
    no particle meets another through two images."""
    if ratio == 1:
        return 30_000
    mean = FULLER / (3 - FULLER) * (ratio ** (3 - FULLER) - 1) / (1 - ratio**-FULLER)
    fill = 0.84 if ratio <= 50 else 0.9
    needed = fill * (4.2 * ratio) ** 3 / (4 / 3 * math.pi * mean)
    return max(30_000, 1000 * math.ceil(needed / 1000))


def place(sizes, edge, seed):
    """Places at random in a periodic cube, from the largest to the smallest, without overlaps; m."""
    import random

    draw = random.Random(seed)
    placed = []  # (cells along an edge, width of a cell, spheres by cell) of each octave of sizes
    centres, octave, largest = [], None, None
    for radius in map(float, sizes):
        if octave is None or radius < 0.5 * largest:
            largest = radius
            # A smaller sphere meets a sphere of this octave in its own cell or the next.
            cells = max(1, int(edge / (2.001 * largest)))
            octave = (cells, edge / cells, {})
            placed.append(octave)
        while True:
            x, y, z = draw.random() * edge, draw.random() * edge, draw.random() * edge
            if not any(meets(level, x, y, z, radius, edge) for level in placed):
                break
        cells, width, spheres = octave
        key = (int(x / width) % cells, int(y / width) % cells, int(z / width) % cells)
        spheres.setdefault(key, []).append((x, y, z, radius))
        centres.append((x, y, z))
    return centres


def meets(level, x, y, z, radius, edge):
    cells, width, spheres = level
    around = lambda at: {(int(at / width) + k) % cells for k in (-1, 0, 1)}
    half = 0.5 * edge
    columns = around(z)
    rows = around(y)
    for i in around(x):
        for j in rows:
            for k in columns:
                for a, b, c, other in spheres.get((i, j, k), ()):
                    a, b, c = (a - x + half) % edge - half, (b - y + half) % edge - half, (c - z + half) % edge - half
                    if a * a + b * b + c * c < (radius + other) ** 2:
                        return True
    return False


SCENE = """# A packing of spheres with a size ratio of {ratio}: written by benches/sizes.py
title = "{title}"

[time]
end  = 1.0
step = {step}

[domain]
min = [0.0, 0.0, 0.0]
max = [{edge!r}, {edge!r}, {edge!r}]
periodic = ["x", "y", "z"]

[contact]
coulomb_limits = "elastic"
sliding_normal = "step"
overlap_error = 1.9
overlap_warning = 1.9

[guard]
policy = "off"

[materials.bead]
density    = 2500.0
normal     = {{ law = "hertz", youngs_modulus = {modulus}, poisson_ratio = 0.25, restitution = {restitution} }}
{tangential}
[[particles]]
file     = "{table}"
material = "bead"

[output]
interval = 1.0
data = {data}
frames = false
walls = false
pictures = false
digits = 17
"""
FRICTION = 'tangential = { law = "mindlin", friction = 0.5, stiffness_factor = 1.0 }\n'


def write_table(path, centres, sizes, velocities=None):
    import numpy

    columns = [centres, sizes[:, None]] + ([velocities] if velocities is not None else [])
    head = "x,y,z,radius" + (",vx,vy,vz" if velocities is not None else "")
    with open(path, "w") as table:
        table.write(head + "\n")
        for row in numpy.hstack(columns).tolist():
            table.write(",".join(map(repr, row)) + "\n")


class Relaxed:
    """A packing in a folder of its own, which mercury-solve pushes apart."""

    def __init__(self, solver, folder, ratio, sizes, centres, edge):
        self.solver, self.folder, self.ratio, self.sizes, self.centres, self.edge = solver, folder, ratio, sizes, centres, edge
        self.velocities = None

    def push_apart(self, steps, at_rest=False):
        """Makes so many steps. Returns the energy of the contacts over volume and modulus, and contacts per sphere."""
        import numpy

        write_table(self.folder / "packing.csv", self.centres, self.sizes, None if at_rest else self.velocities)
        scene = SCENE.format(ratio=self.ratio, title="packing", step=STEP, edge=self.edge, modulus=MODULUS, restitution=0.1, tangential="", table="packing.csv", data="true")
        (self.folder / "packing.toml").write_text(scene)
        out = self.folder / "packing"
        command = [self.solver, self.folder / "packing.toml", "--output", out, "--force", "--quiet", "--threads", "1", "--checkpoint-every", "never", "--set", f"time.end={steps * STEP:.12g}"]
        result = subprocess.run(command, capture_output=True, text=True)
        if result.returncode != 0:
            sys.exit(result.stderr)
        count = len(self.sizes)
        with open(out / "packing.data") as file:
            lines = file.readlines()[-count:]
        columns = numpy.array([line.split(maxsplit=6)[:6] for line in lines], dtype=float)
        self.centres, self.velocities = columns[:, :3] % self.edge, columns[:, 3:]
        summary = json.loads((out / "summary.json").read_text())
        return summary["energy"]["elastic"] / self.edge**3 / MODULUS, summary["coordination_number"]

    def shrink(self, part):
        self.edge *= 1 - part
        self.centres = self.centres * (1 - part)

    def solid_fraction(self):
        return volume(self.sizes) / self.edge**3


def press(packing, since):
    """Shrinks the domain until the packing bears a pressure, and lets it come to rest."""
    # The largest must not pass over the smallest at once.
    part = min(0.01, 0.35 / (packing.ratio + 1))
    contacts = 0.0
    while True:
        is_held = contacts > 1.0
        packing.shrink(0.4 * part if is_held else part)
        energy, contacts = packing.push_apart(120)
        # What is held does not get rid of its energy; large spheres take long to.
        before = math.inf
        while is_held and PRESSED < energy < 0.9 * before:
            before = energy
            energy, contacts = packing.push_apart(500)
        print(f"ratio {packing.ratio}: solid fraction {packing.solid_fraction():.4f}, energy {energy:.2g}, {contacts:.2f} contacts, {time.time() - since:.0f} s", flush=True)
        if is_held and energy > PRESSED:
            break
    for _ in range(5):
        packing.push_apart(500, at_rest=True)


def pack(solver, folder, ratio, seed):
    """The packing of a ratio, pressed; `rest.toml` and what belongs to it."""
    import numpy

    since = time.time()
    sizes = radii(ratio, number(ratio))
    edge = (volume(sizes) / (0.25 if ratio < 50 else 0.5)) ** (1 / 3)
    centres = numpy.array(place(sizes, edge, seed))
    print(f"ratio {ratio}: {len(sizes)} spheres placed in {time.time() - since:.0f} s", flush=True)
    packing = Relaxed(solver, folder, ratio, sizes, centres, edge)
    press(packing, since)
    energy, contacts = packing.push_apart(100, at_rest=True)
    print(f"ratio {ratio}: at rest: solid fraction {packing.solid_fraction():.4f}, energy {energy:.2g}, {contacts:.2f} contacts, {time.time() - since:.0f} s", flush=True)
    return packing


# Metres that a sphere goes in a step, of the smallest radius: half of a skin of a tenth of the mean radius, which is 1.6 of the smallest, lasts some 20 steps.
PER_STEP = 0.004


def write_scenes(packing, folder, ratio, seed):
    """`STATE.toml` of each state, with tables."""
    import numpy

    random = numpy.random.default_rng(seed)
    count = len(packing.sizes)
    speed = PER_STEP * SMALLEST / STEP
    directions = random.normal(size=(count, 3))
    directions /= numpy.linalg.norm(directions, axis=1)[:, None]
    states = {"rest": None, "adrift": numpy.full((count, 3), speed / math.sqrt(3)), "random": speed * directions}
    # So that neither neighbours nor sizes lie side by side in memory before the first sort.
    order = random.permutation(count)
    for state, velocities in states.items():
        velocities = None if velocities is None else velocities[order]
        write_table(folder / f"{state}.csv", packing.centres[order], packing.sizes[order], velocities)
        scene = SCENE.format(ratio=ratio, title=f"sizes-{ratio}-{state}", step=STEP, edge=packing.edge, modulus=MODULUS, restitution=0.5, tangential=FRICTION, table=f"{state}.csv", data="false")
        (folder / f"{state}.toml").write_text(scene)


def make(options):
    for ratio in options.ratios:
        folder = options.folder / f"ratio-{ratio}"
        folder.mkdir(parents=True, exist_ok=True)
        write_scenes(pack(options.solver, folder, ratio, options.seed), folder, ratio, options.seed)


def run(options, scene, steps, wrapper=()):
    """Summary, number of lists built, pairs listed at the end, and what was said on standard error."""
    out = scene.parent / "run"
    command = [*wrapper, options.solver, scene, "--output", out, "--force", "--quiet", "--threads", "1", "--checkpoint-every", "never", "--set", f"time.end={steps * STEP:.12g}"]
    result = subprocess.run([*command, *options.lanes], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(result.stderr)
    log = (out / "run.log").read_text()
    builds, listed = re.search(r"built (\d+) times.*, (\d+) pairs listed", log).groups()
    return json.loads((out / "summary.json").read_text()), int(builds), int(listed), result.stderr


def about(options, ratio):
    """What size_levels says of the packing; beyond a ratio of 50 nothing of a single grid, which compares all with all there for minutes."""
    folder = options.folder / f"ratio-{ratio}"
    result = subprocess.run([options.size_levels, folder / "rest.toml", *["--levels"] * (ratio > 50)], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(result.stderr)
    return dict(line.split(" ", 1) for line in result.stdout.splitlines())


# First and last step of what is counted: lists are built at the start, then, adrift, every 20 steps or so.
WINDOWS = {"rest": (2, 12), "adrift": (30, 90), "random": (30, 90)}
COUNTED = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]


def collected(result):
    return int(re.search(r"Collected : (\d+)", result)[1])


def count(options):
    """Instructions per particle-step, and of a list per particle."""
    for ratio in options.ratios:
        folder = options.folder / f"ratio-{ratio}"
        packing = about(options, ratio)
        spheres = int(packing["particles"])
        row = {"ratio": ratio, "kind": "instructions", **what_is_in(packing)}
        for state in options.states:
            first, last = WINDOWS[state]
            _, built_first, _, early = run(options, folder / f"{state}.toml", first, COUNTED)
            _, built_last, listed, late = run(options, folder / f"{state}.toml", last, COUNTED)
            row[state] = (collected(late) - collected(early)) / spheres / (last - first)
            row[f"{state}_builds_per_100"] = 100 * (built_last - built_first) / (last - first)
            row[f"{state}_listed"] = listed / spheres
            print(f"ratio {ratio}, {state}: {row[state]:.0f} instructions, {row[f'{state}_builds_per_100']:.1f} lists in 100 steps", flush=True)
        for way in ("levels", "single"):
            # From a ratio of 50 on callgrind would take hours to compare all with all, which is what a single grid does there.
            if way == "levels" or ratio < 50:
                command = [*COUNTED, options.size_levels, folder / "rest.toml", way]
                once, twice = (collected(subprocess.run([*command, str(times)], capture_output=True, text=True, check=True).stderr) for times in (1, 2))
                row[f"list_{way}"] = (twice - once) / spheres
                print(f"ratio {ratio}, list with {way}: {row[f'list_{way}']:.0f} instructions", flush=True)
        keep(row)


def clock(options):
    """Nanoseconds per particle-step, and of a list per particle; packings in turn, medians."""
    found = {ratio: {state: [] for state in options.states} for ratio in options.ratios}
    rows = {}
    for ratio in options.ratios:
        packing = about(options, ratio)
        ways = [way for way in ("levels", "single") if f"ns_per_particle_{way}" in packing]
        lists = {f"list_{way}": float(packing[f"ns_per_particle_{way}"]) for way in ways}
        rows[ratio] = {"ratio": ratio, "kind": "ns", **what_is_in(packing), **lists}
    for _ in range(options.rounds):
        for ratio in options.ratios:
            spheres = rows[ratio]["particles"]
            for state in options.states:
                steps = options.steps
                scene = options.folder / f"ratio-{ratio}" / f"{state}.toml"
                summary, builds, listed, _ = run(options, scene, steps)
                found[ratio][state].append(1e9 / summary["particle_steps_per_second"])
                rows[ratio][f"{state}_builds_per_100"] = 100 * (builds - 1) / steps
                rows[ratio][f"{state}_listed"] = listed / spheres
    for ratio, row in rows.items():
        row.update({state: statistics.median(times) for state, times in found[ratio].items()})
        print(f"ratio {ratio}: " + ", ".join(f"{key} {value:.4g}" for key, value in row.items() if not isinstance(value, str)), flush=True)
        keep(row)


def processor_time(command):
    """User time of a command, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    result = subprocess.run([*map(str, command)], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(result.stderr)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


# How the peers make their lists.
PEERS = {"liggghts": ["liggghts"], "lammps": ["lammps"], "lammps multi": ["lammps", "--multi"]}


def peers(options):
    """Processor time per particle-step of Mercury and of the peers with the skin that suits each best: a run of some more steps less one of fewer, so
    that start-up is left out. The codes run in turn; the least of the rounds."""
    fewer, more = 50, 50 + options.steps
    rows = []
    for ratio in options.ratios:
        for state in options.states:
            scene = options.folder / f"ratio-{ratio}" / f"{state}.toml"
            spheres = sum(1 for _ in open(scene.parent / f"{state}.csv")) - 1
            mercury = [options.solver, scene, "--output", scene.parent / "run", "--force", "--quiet", "--threads", "1", "--checkpoint-every", "never", *options.lanes]
            ways = {"mercury": lambda steps: [*mercury, "--set", f"time.end={steps * STEP:.12g}"]}
            for name, arguments in PEERS.items():
                # With equal spheres both kinds of lists of LAMMPS are the same.
                if name == "lammps multi" and ratio == 1:
                    continue
                for skin in options.skins:
                    ways[f"{name}, skin {skin}"] = lambda steps, arguments=arguments, skin=skin: [ROOT / "benches" / "peers.py", *arguments, scene, "--warm", "1", "--steps", steps, "--skin", skin]
            found = {}
            for _ in range(options.rounds):
                for way, command in ways.items():
                    spent = processor_time(command(more)) - processor_time(command(fewer))
                    found.setdefault(way, []).append(1e9 * spent / spheres / options.steps)
            row = {"ratio": ratio, "state": state, "spheres": spheres, "mercury": min(found["mercury"])}
            for name in PEERS:
                of_skins = {way: min(times) for way, times in found.items() if way.startswith(f"{name}, ")}
                best = min(of_skins, key=of_skins.get, default=None)
                row[name] = of_skins[best] if best else ""
                row[f"{name}, skin"] = best.rsplit(" ", 1)[1] if best else ""
            print(", ".join(f"{key} {value:.0f}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()), flush=True)
            rows.append(row)
    with open(RESULTS.parent / "sizes_peers.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: f"{value:.1f}" if isinstance(value, float) else value for key, value in row.items()} for row in rows)


def what_is_in(packing):
    return {
        "particles": int(packing["particles"]),
        "solid_fraction": float(packing["solid_fraction"]),
        "contacts": float(packing["contacts_per_particle"]),
        "held": float(packing["held"]),
        "coordination_of_held": float(packing["coordination_of_held"]),
        "levels": int(packing["levels"]),
    }


COLUMNS = ["ratio", "kind", "particles", "solid_fraction", "contacts", "held", "coordination_of_held", "levels", *STATES, *(f"{state}_{what}" for state in STATES for what in ("builds_per_100", "listed")), "list_levels", "list_single"]


def kept():
    if not RESULTS.exists():
        return []
    with open(RESULTS, newline="") as file:
        return list(csv.DictReader(file))


def keep(row):
    """Puts a row into the results, in place of the one of its ratio and kind."""
    others = [old for old in kept() if (int(old["ratio"]), old["kind"]) != (row["ratio"], row["kind"])]
    row = {key: f"{value:.5g}" if isinstance(value, float) else value for key, value in row.items()}
    rows = sorted([*others, row], key=lambda row: (row["kind"], int(row["ratio"])))
    with open(RESULTS, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="")
        writer.writeheader()
        writer.writerows(rows)


def costs(rows, state):
    """Ratios, costs with levels, and with a single grid where it is known."""
    for row in rows:
        if row[state]:
            builds = float(row[f"{state}_builds_per_100"]) / 100
            step = float(row[state])
            single = step + builds * (float(row["list_single"]) - float(row["list_levels"])) if row["list_single"] else None
            yield int(row["ratio"]), step, single


def draw(options):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "mercury"
    import matplotlib.pyplot as plt

    kinds = [kind for kind in ("ns", "instructions") if any(row["kind"] == kind for row in kept())]
    figure, axes = plt.subplots(1, len(kinds), figsize=(5 * len(kinds), 4.2), squeeze=False)
    for axis, kind in zip(axes.flat, kinds):
        rows = [row for row in kept() if row["kind"] == kind]
        for state, colour in zip(STATES, ("tab:blue", "tab:green", "tab:orange")):
            found = list(costs(rows, state))
            if not found:
                continue
            first = found[0][1]
            axis.plot([row[0] for row in found], [row[1] / first for row in found], "o-", color=colour, markersize=4, label=f"{state}, levels")
            single = [(ratio, cost / found[0][2]) for ratio, _, cost in found if cost is not None]
            if state != "rest":
                axis.plot(*zip(*single), "s--", color=colour, markersize=4, label=f"{state}, single grid (from the time of a list)")
        axis.axhline(1.5, color="0.5", linewidth=1, linestyle=":", label="limit wanted")
        axis.set(xscale="log", yscale="log", xlabel="largest over smallest radius", ylabel="cost per particle-step over that of equal spheres", title={"ns": "by the clock", "instructions": "by instructions"}[kind])
        axis.set_yticks([0.5, 1, 1.5, 2, 5, 10, 20], ["0.5", "1", "1.5", "2", "5", "10", "20"])
        axis.minorticks_off()
        axis.set_xticks(RATIOS, [str(ratio) for ratio in RATIOS])
        axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(PICTURE, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["make", "count", "time", "draw", "peers"])
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "target" / "sizes")
    parser.add_argument("--ratios", type=int, nargs="+", default=RATIOS)
    parser.add_argument("--states", nargs="+", choices=STATES, default=STATES[:2])
    parser.add_argument("--solver", type=pathlib.Path, default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--size-levels", type=pathlib.Path, default=ROOT / "target" / "release" / "examples" / "size_levels")
    parser.add_argument("--lanes", default=[], type=lambda lanes: ["--lanes", lanes], help="`count` takes 4 unless it is given")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=400, help="that are timed")
    parser.add_argument("--skins", type=float, nargs="+", default=[0.2, 0.4, 0.8], help="over the smallest radius, that `peers` tries")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.what == "count" and not options.lanes:
        options.lanes = ["--lanes", "4"]
    {"make": make, "count": count, "time": clock, "draw": draw, "peers": peers}[options.what](options)


if __name__ == "__main__":
    main()
