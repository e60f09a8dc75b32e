#!/usr/bin/env python3
"""Run time against error: of trajectories and of answers in bulk, over steps, stiffnesses, laws, meshes and pebbles.

    cargo build --release --bin mercury-solve --bin mclump
    pip install matplotlib
    benches/error.py                          # all studies: benches/results/error.csv, docs/pictures/run-time-against-error.svg
    benches/error.py drum --seeds 2           # some of them, printed only

Time is processor time on one thread without pictures, of the mean run. An error is that of the mean over seeds, its uncertainty the standard
error of that mean and of the reference's. The reference of each study is its row marked so; where there is a closed form, that.
"""

import argparse
import csv
import json
import math
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = ROOT / "scenes"
RESULTS = ROOT / "benches" / "results" / "error.csv"
PICTURE = ROOT / "docs" / "pictures" / "run-time-against-error.svg"
QUIET = ["output.pictures=false", "output.data=false", "output.frames=false", "output.fstat=false"]


class Program:
    """Runs scenes in a folder of its own."""

    def __init__(self, programs, folder):
        self.folder = pathlib.Path(folder)
        self.solver, self.mclump = (pathlib.Path(programs) / name for name in ("mercury-solve", "mclump"))

    def run(self, scene, changes, seed):
        """Processor time (s) and the folder of the run."""
        out = self.folder / "run"
        sets = [word for change in [*QUIET, *changes, f"seed={seed}"] for word in ("--set", change)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        result = subprocess.run([self.solver, scene, "--output", out, "--force", "--quiet", "--threads", "1", *sets], capture_output=True, text=True)
        if result.returncode != 0:
            raise RuntimeError(result.stderr.strip().splitlines()[0])
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, out

    def automatic_step(self, scene, changes):
        """The step that `auto` takes, s."""
        sets = [word for change in changes for word in ("--set", change)]
        result = subprocess.run([self.solver, scene, "--check", "--json", *sets], capture_output=True, text=True, check=True)
        return float(json.loads(result.stdout)["time"]["step"])


def rows(folder, suffix):
    """A CSV file of the run as dictionaries of numbers where they are numbers."""
    with open(next(folder.glob(f"*.{suffix}.csv"))) as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            yield {key.split(" [")[0]: number(value) for key, value in row.items()}


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def mean_of(folder, suffix, column, since, where=lambda row: True):
    return statistics.mean(row[column] for row in rows(folder, suffix) if row["time"] >= since and where(row))


def with_step(times):
    """A multiple of the automatic step, which is worked out for the other changes of the row."""
    return ("step", times)


def write(folder, name, text):
    path = pathlib.Path(folder) / name
    path.write_text(text)
    return path


# Studies: each gives its name, the unit of its answer, rows (curve, label, scene, changes), the index of the reference row (or the answer), and
# how the answer is read from a run.

STEPS = [8, 4, 2, 1, 0.5, 0.25]


def settling(program):
    """Height of the centre of mass of 500 beads that fell into a box, m."""
    text = (SCENES / "settle.toml").read_text()
    text = text.replace("max = [0.04, 0.04, 0.12]", "max = [0.02, 0.02, 0.12]").replace("0.038, 0.038, 0.085", "0.018, 0.018, 0.085")
    text = text.replace("number = 2000", "number = 500")
    text += '[[regions]]\nname = "all"\nregion = { shape = "box", min = [0, 0, 0], max = [0.02, 0.02, 0.12] }\n'
    scene = write(program.folder, "settle.toml", text)
    modulus = "materials.glass.normal.youngs_modulus={}".format
    # A linear spring that is pressed as far as Hertz' at the speed of 1 m/s: 1/2 m* v^2 = 8/15 E* sqrt(R*) d^(5/2) = 1/2 k d^2.
    mass, radius, effective = 2500 * math.pi / 6 * 0.002**3 / 2, 0.0005, 1e7 / (2 * (1 - 0.25**2))
    overlap = (mass / 2 * 15 / (8 * effective * math.sqrt(radius))) ** 0.4
    linear = text.replace('"hertz", youngs_modulus = 1e7, poisson_ratio = 0.25,', f'"linear", stiffness = {mass / overlap**2:.4g},')
    linear = linear.replace('"mindlin"', '"linear", stiffness_ratio = 0.2857142857142857')
    linear = write(program.folder, "settle-linear.toml", linear)
    listed = [("step", f"{times:g} x auto", scene, [with_step(times)]) for times in STEPS]
    listed += [("modulus", f"{value:g} Pa", scene, [modulus(value)]) for value in (1e5, 3e5, 1e6, 3e6, 1e7, 3e7)]
    listed += [("law", "linear, as deep at 1 m/s", linear, [])]
    listed += [("reference", "1e8 Pa, 0.5 x auto", scene, [modulus(1e8), with_step(0.5)])]
    return "settled height", listed, height


def last_energies(folder):
    """The last row of `.ene`."""
    lines = next(folder.glob("*.ene")).read_text().splitlines()
    return dict(zip(lines[0].split(), map(number, lines[-1].split())))


def height(folder):
    """Of the centre of mass, m."""
    return last_energies(folder)["centerOfMassZ"]


def chute(program):
    """Velocity of a thin layer that flows down 24 degrees, m/s."""
    text = (SCENES / "chute.toml").read_text()
    for a, b in (("max = [0.020, 0.010, 0.040]", "max = [0.010, 0.005, 0.040]"), ("[0.0199, 0.0099, 0.0]", "[0.0099, 0.0049, 0.0]"),
                 ("max = [0.020, 0.010, 0.038]", "max = [0.010, 0.005, 0.038]"), ("number = 3000", "number = 500"), ("end  = 3.0", "end  = 2.0"),
                 ("interval = 0.05", "interval = 0.01")):
        assert a in text, a
        text = text.replace(a, b)
    text += '[[regions]]\nname = "flow"\nregion = { shape = "box", min = [0, 0, 0.001], max = [0.01, 0.005, 0.04] }\n'
    scene = write(program.folder, "chute.toml", text)
    stiffness = "materials.glass.normal.stiffness={}".format
    listed = [("step", f"{times:g} x auto", scene, [with_step(times)]) for times in STEPS]
    listed += [("stiffness", f"{value:g} N/m", scene, [stiffness(value)]) for value in (1, 3, 10, 30, 100, 300)]
    listed += [("reference", "1000 N/m", scene, [stiffness(1000)])]
    return "chute velocity", listed, lambda folder: mean_of(folder, "regions", "vx", 1.0)


def drum_mesh(folder, sides):
    """A drum of flat sides, as wide as a round one in the mean of its cross-section, longer than the period."""
    radius = 0.03 * math.sqrt(2 * math.pi / sides / math.sin(2 * math.pi / sides))
    corner = lambda k: (radius * math.cos(2 * math.pi * k / sides), radius * math.sin(2 * math.pi * k / sides))
    lines = []
    for k in range(sides):
        (x, z), (u, w) = corner(k), corner(k + 1)
        a, b, c, d = (x, 0.0, z), (u, 0.0, w), (u, 0.008, w), (x, 0.008, z)
        for triangle in ((a, b, c), (a, c, d)):
            vertices = "".join("vertex {} {} {}\n".format(*vertex) for vertex in triangle)
            lines.append(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    return write(folder, f"drum-{sides}.stl", "solid drum\n" + "".join(lines) + "endsolid drum\n")


def drum(program):
    """Torque of a turning drum, N m."""
    text = (SCENES / "drum.toml").read_text()
    scene = write(program.folder, "drum.toml", text)
    stiffness = "materials.glass.normal.stiffness={}".format
    listed = [("step", f"{times:g} x auto", scene, [with_step(times)]) for times in STEPS]
    listed += [("stiffness", f"{value:g} N/m", scene, [stiffness(value)]) for value in (2, 6, 20, 60, 200)]
    for sides in (6, 12, 24, 48, 96, 384):
        shape = f'shape    = "mesh"\nfile     = "{drum_mesh(program.folder, sides)}"\n'
        head, rest = text.split('shape    = "cylinder"\n', 1)
        rest = rest.split('side     = "inside"\n', 1)[1]
        listed.append(("sides of a mesh", f"{sides}", write(program.folder, f"drum-{sides}.toml", head + shape + rest), []))
    listed += [("reference", "1000 N/m", scene, [stiffness(1000)])]
    return "drum torque", listed, lambda folder: mean_of(folder, "walls", "ty", 0.5, lambda row: row["name"] == "drum")


ELLIPSOID = (3e-3, 1.5e-3, 1.5e-3)


def pebbles(program):
    """Height of the centre of mass of 60 ellipsoids of axis ratio 2 that fell into a box, m."""
    obj, count = [], 24
    for i in range(count + 1):
        for j in range(2 * count):
            polar, turn = math.pi * i / count, math.pi * j / count
            x, y, z = math.cos(polar), math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn)
            obj.append("v {} {} {}".format(*(a * b for a, b in zip(ELLIPSOID, (x, y, z)))))
    at = lambda i, j: i * 2 * count + j % (2 * count) + 1
    pole = lambda i: at(i, 0)
    for i in range(count):
        for j in range(2 * count):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            if i > 0:
                obj.append(f"f {a} {b} {d}" if i < count - 1 else f"f {a} {pole(count)} {d}")
            if i < count - 1:
                obj.append(f"f {b} {c} {d}" if i > 0 else f"f {pole(0)} {b} {c}")
    shape = write(program.folder, "ellipsoid.obj", "\n".join(obj) + "\n")
    text = """gravity = [0, 0, -9.81]
time = { end = 0.4, step = "auto" }
domain = { min = [0, 0, 0], max = [0.02, 0.02, 0.12] }
[materials.plastic]
density = 1000.0
normal = { law = "linear", stiffness = 500.0, restitution = 0.4 }
tangential = { law = "linear", stiffness_ratio = 0.2857142857142857, friction = 0.5 }
[clumps.grain]
file = "%s"
material = "plastic"
[[walls]]
name = "box"
shape = "box"
material = "plastic"
[[insertions]]
region = { shape = "box", min = [0, 0, 0.03], max = [0.02, 0.02, 0.11] }
clump = "grain"
psd = { kind = "monodisperse", diameter = 3.779763e-3 }
total = { number = 60 }
velocity = { mean = [0, 0, -0.3], spread = [0.05, 0.05, 0.05] }
[output]
interval = 0.01
"""
    listed = []
    for number_of in (1, 3, 5, 10, 20, 40, 80):
        clump = program.folder / f"ellipsoid-{number_of}.clump.toml"
        subprocess.run([program.mclump, shape, "--generate", "tangent", "--pebbles", str(number_of), "-o", clump], check=True, capture_output=True)
        scene = write(program.folder, f"ellipsoids-{number_of}.toml", text % clump)
        listed.append(("pebbles" if number_of < 80 else "reference", f"{number_of}", scene, []))
    return "height of ellipsoids", listed, height


def impact(program):
    """Restitution of a bead on a wall: worst of eight phases of the step."""
    listed = []
    for law, normal in (("hertz", 'law = "hertz", youngs_modulus = 1e7, poisson_ratio = 0.25'), ("linear", 'law = "linear", stiffness = 200.0')):
        scene = f"""gravity = [0, 0, 0]
time = {{ end = 0.01, step = "auto" }}
domain = {{ min = [-0.01, -0.01, 0.0], max = [0.01, 0.01, 0.02] }}
[materials.bead]
density = 2500.0
normal = {{ {normal}, restitution = 0.5 }}
[[walls]]
shape = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "bead"
[[particles]]
material = "bead"
radius = 1e-3
position = [0, 0, 0.0015]
velocity = [0, 0, -1]
[output]
interval = 0.01
"""
        path = write(program.folder, f"impact-{law}.toml", scene)
        for times in (16, 8, 4, 2, 1, 0.5, 0.25, 0.125, 0.0625):
            listed.append((law, f"{times:g} x auto", path, [with_step(times)]))
    return "restitution", listed


def restitutions(program, scene, times):
    """The worst error over phases of the step, and the time of a run."""
    step = times * program.automatic_step(scene, [])
    worst, spent = 0.0, 0.0
    for phase in range(8):
        gap = 5e-4 + phase / 8 * step
        seconds, folder = program.run(scene, [f"time.step={step:.15g}", f"particles.0.position=[0,0,{1e-3 + gap:.15g}]", "time.end=0.01"], 1)
        speed = math.sqrt(2 * last_energies(folder)["traKineticEnergy"] / (2500 * math.pi * 4 / 3 * 1e-9))
        worst, spent = max(worst, abs(speed - 0.5)), spent + seconds
    return worst, spent / 8


STUDIES = {"settle": settling, "chute": chute, "drum": drum, "pebbles": pebbles}


def study(program, make, seeds):
    """Rows (study, curve, label, time, answer, error, uncertainty)."""
    title, listed, answer = make(program)
    found = []
    for curve, label, scene, changes in listed:
        plain = [change for change in changes if isinstance(change, str)]
        factors = [change[1] for change in changes if not isinstance(change, str)]
        try:
            if factors:
                plain.append(f"time.step={factors[0] * program.automatic_step(scene, plain):.9g}")
            answers, times = [], []
            for seed in range(1, seeds + 1):
                seconds, folder = program.run(scene, plain, seed)
                answers.append(answer(folder))
                times.append(seconds)
        except RuntimeError as refused:
            print(f"{title}, {curve} {label}: {refused}", file=sys.stderr)
            continue
        error = statistics.stdev(answers) / math.sqrt(seeds) if seeds > 1 else math.nan
        found.append([title, curve, label, statistics.mean(times), statistics.mean(answers), error])
        print(f"{title}: {curve} {label}: {found[-1][3]:.2f} s, {found[-1][4]:.6g} +- {error:.2g}", flush=True)
    reference = next(row for row in found if row[1] == "reference")
    return [[*row[:5], abs(row[4] / reference[4] - 1), math.hypot(row[5], reference[5]) / abs(reference[4])] for row in found]


def impacts(program):
    title, listed = impact(program)
    found = []
    for law, label, scene, [(_, times)] in listed:
        try:
            error, seconds = restitutions(program, scene, times)
        except RuntimeError as refused:
            print(f"{title}, {law} {label}: {refused}", file=sys.stderr)
            continue
        print(f"{title}: {law} {label}: error {error:.3g}", flush=True)
        # So few steps cost nothing beside the start: their number stands for the time.
        found.append([title, law, label, 1 / times, 0.5, error / 0.5, 0.0])
    return found


def trajectories(program):
    """Places of 2,000 beads that begin to slide off their heap, after 6 ms: before chaos. Errors relative to how far they went."""
    bench = SCENES / "bench" / "dense-2k.toml"
    text = bench.read_text().replace("dense-2k.csv", str(bench.with_suffix(".csv"))).replace("[0.0, 0.0, -9.81]", "[6.94, 0.0, -6.94]")
    text = text.replace("end  = 0.15", "end  = 6e-3").replace("step = 3e-5", 'step = "auto"')
    scene = write(program.folder, "slide.toml", text)
    auto = program.automatic_step(scene, [])
    places, spent = {}, {}
    for times in (8, 4, 2, 1, 0.5, 0.25, 0.125, 1 / 32):
        try:
            spent[times], folder = program.run(scene, [f"time.step={times * auto:.12g}", "output.data=true"], 1)
        except RuntimeError as refused:
            print(f"trajectories, {times} x auto: {refused}", file=sys.stderr)
            continue
        lines = next(folder.glob("*.data")).read_text().splitlines()
        places[times] = [[float(word) for word in line.split()[:3]] for line in lines[-2000:]]
        first = [[float(word) for word in line.split()[:3]] for line in lines[1:2001]]
    apart = lambda a, b: math.sqrt(sum((x - y) ** 2 for p, q in zip(a, b) for x, y in zip(p, q)))
    finest = places.pop(1 / 32)
    gone = apart(finest, first)
    found = []
    for times, there in places.items():
        found.append(["trajectories", "step", f"{times:g} x auto", spent[times], math.nan, apart(there, finest) / gone, 0.0])
        print(f"trajectories: step {times:g} x auto: {spent[times]:.2f} s, error {found[-1][5]:.3g}", flush=True)
    return found


def write_results(found):
    with open(RESULTS, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["study", "curve", "label", "seconds", "answer", "relative_error", "uncertainty"])
        writer.writerows([*row[:3], *(f"{value:.5g}" for value in row[3:])] for row in found)
    draw(found, PICTURE)


def draw(found, path):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "mercury"
    import matplotlib.pyplot as plt
    import matplotlib.ticker

    titles = list(dict.fromkeys(row[0] for row in found))
    figure, axes = plt.subplots(2, math.ceil(len(titles) / 2), figsize=(4.2 * math.ceil(len(titles) / 2), 7.5))
    for axis, title in zip(axes.flat, titles):
        curves = list(dict.fromkeys(row[1] for row in found if row[0] == title and row[1] != "reference"))
        for curve in curves:
            of = sorted((row for row in found if row[0] == title and row[1] == curve), key=lambda row: row[3])
            times, errors = [row[3] for row in of], [max(row[5], 1e-6) for row in of]
            axis.errorbar(times, errors, yerr=[row[6] for row in of], marker="o", markersize=4, linewidth=1, capsize=2, label=curve)
            here = [(row[3], error) for row, error in zip(of, errors) if row[2] == "1 x auto"]
            axis.plot(*zip(*here), "o", markersize=11, markerfacecolor="none", markeredgecolor="black") if here else None
            for row, error in zip(of, errors):
                axis.annotate(row[2].replace(" x auto", "x"), (row[3], error), fontsize=6, xytext=(3, 3), textcoords="offset points")
        noise = [row[6] for row in found if row[0] == title and row[6] > 0]
        if noise:
            axis.axhspan(0, statistics.median(noise), color="0.9", zorder=0)
        across = "steps over those of auto" if title == "restitution" else "processor time (s)"
        axis.set(xscale="log", yscale="log", title=title, ylabel="relative error", xlabel=across)
        axis.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
        axis.legend(fontsize=7)
    for axis in list(axes.flat)[len(titles):]:
        axis.remove()
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="*", choices=["impact", "trajectories", *STUDIES, []], help="default: all, and the files are written")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--programs", default=ROOT / "target" / "release", help="the folder of mercury-solve and mclump")
    options = parser.parse_args()
    whole = {"impact": impacts, "trajectories": trajectories}
    chosen = options.studies or [*whole, *STUDIES]
    with tempfile.TemporaryDirectory() as folder:
        program = Program(options.programs, folder)
        found = [row for name in chosen for row in (whole[name](program) if name in whole else study(program, STUDIES[name], options.seeds))]
    if not options.studies:
        write_results(found)


if __name__ == "__main__":
    main()
