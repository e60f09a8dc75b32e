#!/usr/bin/env python3
"""What each feature costs that a scene does not have, has but does not use, or uses: instructions per step of dense-2k, steps 20 to 100.

usage: benches/features.py [--solver target/release/mercury-solve] [--only WORD] [--time ROUNDS]

Counted by callgrind (apt-get install valgrind), so that neighbours on the machine change nothing; `--time` measures processor time of
steps 20 to 2,020 instead, rounds alternating, the least of each. Ratios are to the scene of the group's first row.
"""

import argparse
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BENCH = ROOT / "scenes" / "bench"
STEP = 3e-5
WIDTH = 0.048
FACES = '["-x", "+x", "-y", "+y", "-z"]'
BOX = re.compile(r"\[\[walls\]\].*?\n\n", re.DOTALL)


def base():
    text = (BENCH / "dense-2k.toml").read_text().replace("dense-2k.csv", str(BENCH / "dense-2k.csv"))
    # Files only for rows that need them.
    return text.replace("data = false", "data = false\nframes = false\npictures = false\nwalls = false")


def output(text, keys):
    return text + keys + "\n"


def without(law):
    return lambda text: re.sub(law + r" += .*\n", "", text)


def add(tables):
    return lambda text: text.replace("[output]", tables + "\n[output]")


def law(addition):
    return lambda text: text.replace("[[walls]]", addition + "\n\n[[walls]]", 1)


def keys(lines):
    return lambda text: output(text, lines)


def disc(place):
    """As wide as the box; a plane would cut the periodic axis."""
    origin = [WIDTH / 2, place, 0.04]
    return f'[[walls]]\nshape = "disc"\naxis = [0.0, 1.0, 0.0]\norigin = {origin}\nradius = 0.06\nmaterial = "bead"\n\n'


def periodic(text, reach):
    """Along y, beyond walls that hold all (`reach` > 0), or instead of them."""
    text = text.replace("min = [0.0, 0.0, 0.0]", f'min = [0.0, {-reach}, 0.0]\nperiodic = ["y"]')
    text = text.replace(f"max = [{WIDTH}, {WIDTH},", f"max = [{WIDTH}, {WIDTH + reach},")
    text = text.replace(FACES, '["-x", "+x", "-z"]')
    return add(disc(0.0) + disc(WIDTH) if reach else "")(text)


def mesh(name, file, more=""):
    return f'[[walls]]\nname = "{name}"\nshape = "mesh"\nfile = "{file}"\nmaterial = "bead"\n{more}\n\n'


def box_stl(folder):
    """The faces of the box as triangles."""
    low, high = (0.0, 0.0, 0.0), (WIDTH, WIDTH, 0.2)
    corner = lambda k: [high[axis] if k >> axis & 1 else low[axis] for axis in range(3)]
    sides = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2)]
    path = pathlib.Path(folder) / "box.stl"
    with open(path, "w") as stl:
        stl.write("solid box\n")
        for a, b, c, d in sides:
            for triangle in ((a, b, c), (a, c, d)):
                stl.write("facet normal 0 0 0\nouter loop\n")
                for k in triangle:
                    stl.write("vertex {} {} {}\n".format(*corner(k)))
                stl.write("endloop\nendfacet\n")
        stl.write("endsolid box\n")
    return path


def rods(columns):
    clump = f'[clumps.rod]\nfile = "{ROOT}/scenes/rod.clump.toml"\nmaterial = "bead"\n\n'
    far = 0.02 + 0.0115 * (columns - 1)
    place = f"lattice = {{ min = [0.006, 0.006, 0.06], max = [{far}, {far}, 0.06], spacing = 0.009 }}"
    if columns == 1:
        place = "position = [0.024, 0.024, 0.07]"
    return f'{clump}[[particles]]\nclump = "rod"\n{place}\nscale = 0.2\n\n'


INSERTION = """[[insertions]]
region = {{ shape = "box", min = [0.012, 0.012, {low}], max = [0.036, 0.036, {high}] }}
material = "bead"
psd = {{ kind = "monodisperse", diameter = 0.004 }}
total = {{ number = 5 }}
velocity = {{ mean = [0, 0, 0] }}
{more}

"""
PROBE = '[[particles]]\nname = "probe"\nmaterial = "bead"\nradius = 0.002\nposition = [0.024, 0.024, 0.074]\nfixed = true\n\n'
SPRAY = """[[sprays]]
name = "nozzle"
position = [0.024, 0.024, {place}]
axis = [0, 0, -1]
orifice = 0.02
pattern = {{ kind = "full-cone", half_angle_degrees = 3.0 }}
flow_rate = 2.094e-6   # 2,400 droplets until step 20
speed = {speed}
droplets = {{ kind = "monodisperse", diameter = 1e-4 }}
liquid_density = 1000.0
until = 6e-4
{more}

"""
DRAG = 'drag = { law = "schiller-naumann", gas_density = 1.2, gas_viscosity = 1.8e-5 }'
FIELDS = '[[fields]]\nname = "profile"\ncoordinates = "Z"\ngrid = [20]\nwidth = "1d"\n{when}\naverage = true\n\n'
TEN = f"interval = {10 * STEP}"
REGION = '[[regions]]\nname = "upper"\nregion = { shape = "box", min = [0.0, 0.0, 0.03], max = [0.048, 0.048, 0.07] }\n\n'
FLUX = '[[fluxes]]\nname = "gate"\nplane = { point = [0.0, 0.0, %s], normal = [0.0, 0.0, -1.0] }\n\n'
DELETION = '[[deletions]]\nname = "outlet"\nregion = { shape = "half-space", point = [0.0, 0.0, %s], normal = [0.0, 0.0, -1.0] }\n\n'
DISCS = "".join(
    f'[[walls]]\nshape = "disc"\naxis = [0, 0, 1]\norigin = [{0.002 + 0.004 * (k % 10)}, {0.002 + 0.004 * (k // 10)}, 0.075]\nradius = 0.002\nmaterial = "bead"\n\n'
    for k in range(100)
)


def every(text):
    return text.replace("interval = 1.0", TEN)


def groups(folder):
    """(feature, state, change of the scene), those of a group after one that they are compared with."""
    frictionless = without("tangential")
    same = lambda text: text
    box = box_stl(folder)
    both = lambda *changes: lambda text: [text := change(text) for change in changes][-1]
    yield [
        ("friction", "absent", frictionless),
        ("friction", "there, 0", lambda text: text.replace("friction = 0.5", "friction = 0.0")),
        ("friction", "used", same),
    ]
    films = pathlib.Path(folder) / "films.csv"
    lines = (BENCH / "dense-2k.csv").read_text().splitlines()
    films.write_text("\n".join([lines[0] + ",film_volume", *(line + ",1e-10" for line in lines[1:])]) + "\n")
    # Every contact has a bridge: films are worth a bridge of 1e-11 m3 (V* = 1.25e-3) at each of some five contacts, and more.
    liquid = 'liquid = {{ law = "{}", surface_tension = 0.05, contact_angle_degrees = 10.0, viscosity = {}, max_bridge_volume = 1e-11 }}'.format
    wet = lambda name, viscosity: both(law(liquid(name, viscosity)), lambda text: text.replace(str(BENCH / "dense-2k.csv"), str(films)))
    yield [
        ("liquid bridges", "absent", same),
        ("liquid bridges", "there, no liquid", law(liquid("bagheri", 1e-3))),
        ("liquid bridges", "`bagheri`, without viscosity", wet("bagheri", 0.0)),
        ("liquid bridges", "`bagheri`", wet("bagheri", 1e-3)),
        ("liquid bridges", "`willett-classical`", wet("willett-classical", 1e-3)),
        ("liquid bridges", "`lian-seville`", wet("lian-seville", 1e-3)),
        ("liquid bridges", "`willett`", wet("willett", 1e-3)),
        ("liquid bridges", "`young-laplace`", wet("young-laplace", 1e-3)),
    ]
    # Droplets above the bed (0.054 m) for all steps, and droplets that reach it within them.
    falling = lambda more: SPRAY.format(place=0.076, speed=0.5, more=more)
    arriving = lambda more: SPRAY.format(place=0.058, speed=2.0, more=more)
    bed = wet("bagheri", 1e-3)
    yield [
        ("sprays", "absent, wet bed", bed),
        ("sprays", "2,400 droplets fall", both(bed, add(falling("")))),
        ("sprays", "2,400 droplets fall with drag", both(bed, add(falling(DRAG)))),
        ("sprays", "2,400 droplets reach the bed", both(bed, add(arriving("")))),
        ("sprays", "2,400 droplets reach the bed with drag", both(bed, add(arriving(DRAG)))),
    ]
    rolling = 'rolling = {{ law = "luding", friction = {0} }}\ntorsion = {{ law = "luding", friction = {0} }}'.format
    yield [
        ("rolling and torsion", "absent", same),
        ("rolling and torsion", "there, 0", law(rolling(0.0))),
        ("rolling and torsion", "used", law(rolling(0.05))),
    ]
    yield [
        ("all else", "absent", same),
        ("walls", "100 discs that nothing is near", add(DISCS)),
        ("walls", "floor that moves", lambda text: add('[[walls]]\nname = "floor"\nshape = "plane"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = "bead"\nmotion = [{ kind = "translation", velocity = [0, 0, -1e-4] }]\n\n')(text.replace(FACES, '["-x", "+x", "-y", "+y"]'))),
        ("meshes", "2,432 triangles that nothing is near", add(mesh("drum", BENCH / "mesh-drum.stl", "offset = [0.0, 0.0, 0.3]"))),
        ("meshes", "10 triangles instead of the box", lambda text: BOX.sub(mesh("box", box, 'side = "both"'), text, count=1)),
        ("periodic axis", "no particle near its ends (two discs as walls)", lambda text: periodic(text, 0.1)),
        ("periodic axis", "instead of two walls", lambda text: periodic(text, 0.0)),
        ("clumps", "one of 3 pebbles, alone", add(rods(1))),
        ("clumps", "16 of 3 pebbles, falling", add(rods(3))),
        ("insertion", "waits for its time", add(INSERTION.format(low=0.06, high=0.074, more="from = 1.0"))),
        ("insertion", "finds no space", add(INSERTION.format(low=0.01, high=0.03, more=""))),
        ("deletion", "no particle near", add(DELETION % -0.1)),
        ("fluxes", "no particle near", add(FLUX % 0.07)),
        ("fluxes", "through the bed", add(FLUX % 0.02)),
        ("regions", "not yet due", add(REGION)),
        ("regions", "every 10 steps", both(every, add(REGION))),
        ("tracking", "not yet due", both(add(PROBE), keys('track = ["probe"]'))),
        ("tracking", "every 10 steps", both(every, add(PROBE), keys('track = ["probe"]'))),
        ("fields", "not yet due", add(FIELDS.format(when="from = 1.0"))),
        ("fields", "every 10 steps", add(FIELDS.format(when=TEN))),
        ("frames", "every 10 steps", lambda text: every(text).replace("frames = false", "frames = true")),
        ("contact output", "not yet due", keys("fstat = true")),
        ("contact output", "every 10 steps", lambda text: output(every(text).replace("frames = false", "frames = true"), "fstat = true")),
        ("loads of walls", "every 10 steps", lambda text: every(text).replace("walls = false", "walls = true")),
        ("energies (`.ene`)", "every 10 steps", every),
        ("energy audit", "every step", keys("energy_budget = true")),
        ("guard", "off", add('[guard]\npolicy = "off"\n')),
    ]


def run(solver, folder, scene, steps, wrapper=()):
    command = [*wrapper, solver, scene, "--threads", "1", "--quiet", "--force", "--output", folder / "run", "--set", f"time.end={steps * STEP:.9g}"]
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{scene}:\n{result.stderr}")
    return result.stderr


def count(solver, folder, scene, steps):
    wrapper = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder / 'callgrind.out'}"]
    result = run(solver, folder, scene, steps, wrapper)
    return int(re.search(r"Collected : (\d+)", result)[1])


def seconds(solver, folder, scene, steps):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    run(solver, folder, scene, steps)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--solver", default=ROOT / "target" / "release" / "mercury-solve")
    parser.add_argument("--only", default="", help="rows whose feature has this word")
    parser.add_argument("--time", type=int, default=0, metavar="ROUNDS")
    options = parser.parse_args()
    solver = pathlib.Path(options.solver).resolve()
    print("| feature | | {} a step | ratio |\n|---|---|---|---|".format("ms" if options.time else "1,000 instructions"))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for group in groups(folder):
            rows = group[:1] + [row for row in group[1:] if options.only in row[0]]
            if len(rows) == 1:
                continue
            files = []
            for k, (_, _, change) in enumerate(rows):
                scene = folder / f"row-{k}.toml"
                scene.write_text(change(base()))
                files.append(scene)
            if options.time:
                # Without the start, in which some laws make tables.
                least = lambda steps: [min(times) for times in zip(*([seconds(solver, folder, scene, steps) for scene in files] for _ in range(options.time)))]
                costs = [1e3 * (end - start) / 2000 for start, end in zip(least(20), least(2020))]
            else:
                costs = [(count(solver, folder, scene, 100) - count(solver, folder, scene, 20)) / 80e3 for scene in files]
            for (feature, state, _), cost in zip(rows, costs):
                print(f"| {feature} | {state} | {cost:.4g} | {cost / costs[0]:.3f} |", flush=True)


if __name__ == "__main__":
    main()
