#!/usr/bin/env python3
"""Shoot the steel sphere of a penetration scene into its bed with LIGGGHTS, and compare its height with Mercury's.

    apt-get install liggghts
    mercury-solve SCENES/penetration-25k.toml --set time.end=0.045 --output /tmp/penetration
    benches/penetration.py SCENES/penetration-25k.toml /tmp/penetration/penetration-25k.track.csv

Same particles, same mesh, same law (LIGGGHTS' Mindlin factor is 1, the scene's 2/3), same step. Prints height by both codes
each millisecond and the largest difference. With --reference FILE, LIGGGHTS' heights are also written as the table that
validation-long compares with (tests/src/long/penetration-25k.liggghts.csv). LIGGGHTS needs some 10 minutes.

    benches/penetration.py --shots SCENES/penetration-25k.toml FILE

shoots it nine times from just above the bed, with small shifts sideways, and writes the heights as the other table that validation-long
compares with (tests/src/long/penetration-shots.liggghts.csv). That takes an hour.
"""
import csv, datetime, os, re, subprocess, sys, tempfile, tomllib


# Sideways, m.
SHIFTS = [(0.0, 0.0), (1e-6, 0.0), (-1e-6, 0.0), (0.0, 1e-6), (0.0, -1e-6), (1e-5, 0.0), (-1e-5, 0.0), (0.0, 1e-5), (0.0, -1e-5)]


def fly(cfg, here, end):
    """Times and heights by LIGGGHTS, each millisecond, as it prints them; number of particles of the table; seconds of its loop."""
    table, intruder = cfg["particles"]
    rows = list(csv.DictReader(open(os.path.join(here, table["file"]))))
    step = cfg["time"]["step"]
    names = ["m1", "steel"]
    normal = [cfg["materials"][n]["normal"] for n in names]
    density = [cfg["materials"][n]["density"] for n in names]
    pair = cfg["contacts"][0]
    e = [normal[0]["restitution"], pair["normal"]["restitution"], normal[1]["restitution"]]
    mu = [cfg["materials"]["m1"]["tangential"]["friction"], pair["tangential"]["friction"],
          cfg["materials"]["steel"].get("tangential", {}).get("friction", pair["tangential"]["friction"])]
    last = len(rows) + 1
    with tempfile.TemporaryDirectory() as d:
        data = os.path.join(d, "in.data")
        lo, hi = cfg["domain"]["min"], cfg["domain"]["max"]
        with open(data, "w") as f:
            f.write("spheres\n\n%d atoms\n2 atom types\n\n" % last)
            for k, a in enumerate("xyz"):
                f.write("%.9g %.9g %slo %shi\n" % (lo[k], hi[k], a, a))
            f.write("\nAtoms\n\n")
            for i, r in enumerate(rows, 1):
                f.write("%d 1 %.12g %g %s %s %s\n" % (i, 2 * float(r["radius"]), density[0], r["x"], r["y"], r["z"]))
            f.write("%d 2 %g %g %g %g %g\n" % (last, 2 * intruder["radius"], density[1], *intruder["position"]))
            f.write("\nVelocities\n\n")
            for i, r in enumerate(rows, 1):
                f.write("%d %s %s %s 0 0 0\n" % (i, *(r.get(k) or 0 for k in ("vx", "vy", "vz"))))
            f.write("%d %g %g %g 0 0 0\n" % (last, *intruder["velocity"]))
        wall = cfg["walls"][0]
        every = round(1e-3 / step)
        text = """atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
hard_particles yes
read_data %s
neighbor 4e-4 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype %g %g
fix m2 all property/global poissonsRatio peratomtype %g %g
fix m3 all property/global coefficientRestitution peratomtypepair 2 %g %g %g %g
fix m4 all property/global coefficientFriction peratomtypepair 2 %g %g %g %g
pair_style gran model hertz tangential history
pair_coeff * *
fix mesh all mesh/surface file %s type 2 precision 1e-9
fix w1 all wall/gran model hertz tangential history mesh n_meshes 1 meshes mesh
timestep %g
fix grav all gravity 9.81 vector 0.0 0.0 -1.0
fix integr all nve/sphere
variable height equal z[%d]
variable now equal step*%g
thermo_style custom step atoms ke
thermo %d
fix say all print %d "HEIGHT ${now} ${height}" screen yes
run %d
""" % (data, normal[0]["youngs_modulus"], normal[1]["youngs_modulus"], normal[0]["poisson_ratio"], normal[1]["poisson_ratio"],
       e[0], e[1], e[1], e[2], mu[0], mu[1], mu[1], mu[2], os.path.join(here, wall["file"]), step, last, step, every, every, round(end / step))
        inp = os.path.join(d, "in.script")
        open(inp, "w").write(text)
        run = subprocess.run(["liggghts", "-in", inp, "-log", os.path.join(d, "log")], capture_output=True, text=True, cwd=d,
                             env=dict(os.environ, OMP_NUM_THREADS="1"))
    if run.returncode:
        sys.exit("liggghts failed:\n%s" % (run.stdout + run.stderr)[-2000:])
    heights = re.findall(r"^HEIGHT (\S+) (\S+)", run.stdout, re.M)
    loop = re.findall(r"Loop time of ([\d.eE+-]+) on", run.stdout)
    return heights, len(rows), loop[-1] if loop else "?"


def head(scene, what, arguments, factor, step, count):
    """The comment above a table."""
    return ("# Height of the centre of the steel sphere of %s%s by LIGGGHTS 3.8 (Debian's package), one process.\n"
            "# Made on %s by: benches/penetration.py %s\n"
            "# Model hertz with tangential history (Mindlin factor 1%s), step %g s, gravity 9.81 m/s^2, %d spheres of the scene's table, "
            "mesh of the scene.\n" % (os.path.basename(scene), what, datetime.date.today(), arguments, factor, step, count))


def compare(scene, track, reference=None):
    cfg = tomllib.load(open(scene, "rb"))
    # Names stand before their units: "z [m]".
    table = ({key.split(" [")[0]: value for key, value in row.items()} for row in csv.DictReader(open(track)))
    ours = {round(float(r["time"]), 6): float(r["z"]) for r in table}
    heights, count, loop = fly(cfg, os.path.dirname(os.path.abspath(scene)), max(ours))
    if reference:
        with open(reference, "w") as f:
            f.write(head(scene, "", "SCENES/%s TRACK.csv --reference FILE" % os.path.basename(scene), ", the scene's is 2/3", cfg["time"]["step"], count))
            f.write("time_s,height_m\n" + "".join("%s,%.6f\n" % (t, float(h)) for t, h in heights))
    largest = 0.0
    print("time_s,mercury_m,liggghts_m")
    for time, height in heights:
        mine = ours.get(round(float(time), 6))
        if mine is not None:
            largest = max(largest, abs(mine - float(height)))
            print("%s,%.6f,%.6f" % (time, mine, float(height)))
    print("largest difference %.3g mm; LIGGGHTS' loop %s s" % (1e3 * largest, loop))


def shoot(scene, file):
    cfg = tomllib.load(open(scene, "rb"))
    text = ""
    for x, y in SHIFTS:
        # After 0.0202 s of the scene's free fall.
        cfg["particles"][1].update(position=[x, y, -0.0430015], velocity=[0.0, 0.0, -5.198162])
        heights, count, _ = fly(cfg, os.path.dirname(os.path.abspath(scene)), 0.014)
        text += "".join("%g,%g,%s,%.6f\n" % (x, y, t, float(h)) for t, h in heights)
    with open(file, "w") as f:
        f.write(head(scene, ", shot from just above the bed with small shifts along x and y,", "--shots SCENES/%s FILE" % os.path.basename(scene), "",
                     cfg["time"]["step"], count))
        f.write("x_m,y_m,time_s,height_m\n" + text)


if __name__ == "__main__":
    if len(sys.argv) == 5 and sys.argv[3] == "--reference":
        compare(sys.argv[1], sys.argv[2], sys.argv[4])
    elif len(sys.argv) == 4 and sys.argv[1] == "--shots":
        shoot(*sys.argv[2:])
    elif len(sys.argv) == 3:
        compare(*sys.argv[1:])
    else:
        sys.exit(__doc__)
