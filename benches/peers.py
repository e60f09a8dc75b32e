#!/usr/bin/env python3
"""Run a benchmark scene of ../scenes/bench in LIGGGHTS or LAMMPS and print its cost.

    apt-get install liggghts lammps          # Debian's packages
    ./peers.py liggghts dense-20k            # one core
    ./peers.py lammps dense-20k --ranks 2    # MPI
    ./peers.py liggghts ../drum.toml         # any scene of spheres from a table, with planes or one mesh as walls, or periodic
    ./peers.py lammps target/sizes/ratio-20/rest.toml --multi

Prints one line: code, scene, particles, steps, nanoseconds per particle-step (the code's own loop time: wall, and CPU
time per rank), coordination number, kinetic energy (translational + rotational) after the run. Compare with Mercury in the same minute, on the same machine, several times.
"""
import argparse, csv, math, os, re, subprocess, sys, tempfile, tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
BENCH = os.path.join(HERE, "..", "scenes", "bench")


def read(scene):
    path = scene if scene.endswith(".toml") else os.path.join(BENCH, scene + ".toml")
    cfg = tomllib.load(open(path, "rb"))
    cfg["folder"] = os.path.dirname(os.path.abspath(path))
    group = cfg["particles"][0]
    rows = list(csv.DictReader(open(os.path.join(cfg["folder"], group["file"]))))
    names = list(cfg["materials"])
    for row in rows:
        row["type"] = names.index(row.get("material") or group.get("material")) + 1
        for key in ("x", "y", "z", "radius", "vx", "vy", "vz", "wx", "wy", "wz"):
            row[key] = float(row.get(key) or 0.0)
    return cfg, rows


def write_data(path, cfg, rows):
    lo, hi = cfg["domain"]["min"], cfg["domain"]["max"]
    materials = list(cfg["materials"].values())
    with open(path, "w") as f:
        f.write("spheres\n\n%d atoms\n%d atom types\n\n" % (len(rows), len(materials)))
        for k, a in enumerate("xyz"):
            pad = 0.0 if a in cfg["domain"].get("periodic", []) else 1e-3
            f.write("%.9g %.9g %slo %shi\n" % (lo[k] - pad, hi[k] + pad, a, a))
        f.write("\nAtoms\n\n")
        for i, r in enumerate(rows, 1):   # id type diameter density x y z
            f.write("%d %d %.9g %.9g %.9g %.9g %.9g\n" % (
                i, r["type"], 2 * r["radius"], materials[r["type"] - 1]["density"], r["x"], r["y"], r["z"]))
        f.write("\nVelocities\n\n")
        for i, r in enumerate(rows, 1):
            f.write("%d " % i + " ".join("%.9g" % r[k] for k in ("vx", "vy", "vz", "wx", "wy", "wz")) + "\n")


def of_pairs(cfg, part, key):
    """A coefficient of each pair of materials, row by row: of a pair what the scene says of it, of a material with itself its own."""
    names = list(cfg["materials"])
    said = {frozenset(c["between"]): c.get(part, {}).get(key) for c in cfg.get("contacts", [])}
    value = lambda a, b: said.get(frozenset((a, b))) if a != b else cfg["materials"][a][part][key]
    matrix = [value(a, b) for a in names for b in names]
    if None in matrix:
        sys.exit("the scene does not say %s of each pair of materials" % key)
    return "%d %s" % (len(names), " ".join("%g" % v for v in matrix))


def tsuji_equivalent(e):
    """LAMMPS' tsuji polynomial is not the constant-restitution solution: give the e whose polynomial equals sqrt(5) beta."""
    poly = lambda x: 1.2728 - 4.2783*x + 11.087*x**2 - 22.348*x**3 + 27.467*x**4 - 18.022*x**5 + 4.8218*x**6
    target = math.sqrt(5) * -math.log(e) / math.hypot(math.log(e), math.pi)
    a, b = 0.0, 1.0
    for _ in range(60):
        m = (a + b) / 2
        a, b = (m, b) if poly(m) > target else (a, m)
    return a


def neighbours(code, rmin, rmax, skin, multi):
    """How lists are made: one bin size, or with `multi` (LAMMPS; LIGGGHTS' own lists no granular pair) one for each doubling of the radius."""
    if not multi or rmin == rmax:
        return ["neighbor %g bin" % skin, "neigh_modify delay 0"]
    levels = max(1, math.ceil(math.log2(rmax / rmin)))
    bounds = [rmin * 2 ** (k + 1) for k in range(levels - 1)] + [rmax]
    # Collections are distinguished by the cutoff of a particle with its like, twice the radius.
    return ["neighbor %g multi" % skin, "neigh_modify delay 0 collection/interval %d %s" % (len(bounds), " ".join("%.9g" % (2 * b * (1 + 1e-9)) for b in bounds)),
            "comm_modify mode multi vel yes"]


def script(code, cfg, rows, data, warm, steps, ranks, skin, multi):
    materials = list(cfg["materials"].values())
    E, nu, e = (materials[0]["normal"][k] for k in ("youngs_modulus", "poisson_ratio", "restitution"))
    mu = materials[0]["tangential"]["friction"]
    rmin, rmax = min(r["radius"] for r in rows), max(r["radius"] for r in rows)
    skin = skin * rmin if skin else (0.2 * rmin if rmin == rmax else 0.4 * rmin)
    g = cfg.get("gravity", [0.0, 0.0, 0.0])
    walls = cfg.get("walls", [])
    periodic = cfg["domain"].get("periodic", [])
    mesh = [w for w in walls if w["shape"] == "mesh"]
    grid = "1 1 1" if ranks == 1 else ("1 %d 1" % ranks if mesh else "%d 1 1" % ranks)
    L = cfg["domain"]["max"]
    out = ["atom_style %s" % ("sphere" if code == "lammps" else "granular"), "atom_modify map array", "boundary " + " ".join("p" if a in periodic else "f" for a in "xyz"),
           "newton off", "%s vel yes" % ("comm_modify" if code == "lammps" else "communicate single"), "units si",
           "processors " + grid, "read_data " + data, *neighbours(code, rmin, rmax, skin, multi)]
    if code == "lammps":
        xgt = math.sqrt(4 * (1 - nu) / (2 * (2 - nu)))
        stiffness = 8 * E / (4 * (2 - nu) * (1 + nu))   # 8 G* of two of the same material
        law = lambda modulus: "hertz/material %.15g %.15g %g tangential mindlin %.15g %.15g %g damping tsuji" % (modulus, tsuji_equivalent(e), nu, stiffness, xgt, mu)
        out += ["pair_style granular", "pair_coeff * * " + law(E)]
        # Its walls take E/(1 - nu) where E/(1 - nu^2) is meant (version of 29 September 2021).
        out += ["fix w%d all wall/gran granular %s %s" % (k, law(E / (1 + nu)), w) for k, w in
                enumerate(("xplane 0.0 %.9g" % L[0], "yplane 0.0 %.9g" % L[1], "zplane 0.0 NULL")) if walls]
    else:
        of_each = lambda key: " ".join("%g" % m["normal"][key] for m in materials)
        hard = any(m["normal"]["youngs_modulus"] > 1e9 for m in materials)
        soft = any(m["normal"]["youngs_modulus"] < 5e6 for m in materials)
        out += ["soft_particles " + ("yes" if soft else "no"), "hard_particles " + ("yes" if hard else "no"), "fix m1 all property/global youngsModulus peratomtype " + of_each("youngs_modulus"),
                "fix m2 all property/global poissonsRatio peratomtype " + of_each("poisson_ratio"),
                "fix m3 all property/global coefficientRestitution peratomtypepair " + of_pairs(cfg, "normal", "restitution"),
                "fix m4 all property/global coefficientFriction peratomtypepair " + of_pairs(cfg, "tangential", "friction"),
                "pair_style gran model hertz tangential history", "pair_coeff * *"]
        if mesh:
            w = mesh[0]
            turn = w["motion"][0]["angular_velocity"]
            axis = [math.copysign(1, turn) * a for a in w["motion"][0]["axis"]]
            stl = os.path.join(cfg["folder"], w["file"])
            kind = list(cfg["materials"]).index(w["material"]) + 1
            out += ["fix mesh all mesh/surface file %s type %d precision 1e-9" % (stl, kind),
                    "fix w1 all wall/gran model hertz tangential history mesh n_meshes 1 meshes mesh",
                    "fix mv all move/mesh mesh mesh rotate origin 0. 0. 0. axis %g %g %g period %.15g" % (*axis, 2 * math.pi / abs(turn))]
        elif walls:
            for k, w in enumerate(("xplane 0.0", "xplane %.9g" % L[0], "yplane 0.0", "yplane %.9g" % L[1], "zplane 0.0")):
                out.append("fix w%d all wall/gran model hertz tangential history primitive type 1 %s" % (k, w))
    out += ["timestep %g" % cfg["time"]["step"], *(["fix grav all gravity %.15g vector %.15g %.15g %.15g" % (math.hypot(*g), *g)] if any(g) else []), "fix integr all nve/sphere",
            "compute kr all erotate/sphere", "thermo_style custom step atoms ke c_kr", "thermo %d" % max(steps, 1), "thermo_modify lost ignore norm no",
            "run %d" % warm, "run %d" % steps,
            # Contacts are counted behind the timed run: they cost a list of their own.
            "compute ct all contact/atom", "compute cs all reduce sum c_ct", "thermo_style custom step atoms ke c_kr c_cs", "thermo_modify lost ignore norm no", "run 0"]
    return "\n".join(out) + "\n"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("code", choices=("liggghts", "lammps"))
    p.add_argument("scene")
    p.add_argument("--ranks", type=int, default=1)
    p.add_argument("--warm", type=int, default=50)
    p.add_argument("--steps", type=int)
    p.add_argument("--skin", type=float, help="over the smallest radius; 0.2 for equal spheres, 0.4 for others unless given")
    p.add_argument("--multi", action="store_true", help="LAMMPS: bins for each doubling of the radius, which wide sizes need")
    a = p.parse_args()
    cfg, rows = read(a.scene)
    if a.multi and a.code != "lammps":
        sys.exit("--multi is LAMMPS' alone: LIGGGHTS lists no granular pair with it")
    if a.code == "lammps" and any(w["shape"] == "mesh" for w in cfg.get("walls", [])):
        sys.exit("lammps (Debian's version) has no mesh walls")
    steps = a.steps or math.ceil(cfg["time"]["end"] / cfg["time"]["step"] - 1e-6) - a.warm   # so that both end at the same time
    with tempfile.TemporaryDirectory() as d:
        data = os.path.join(d, "in.data")
        write_data(data, cfg, rows)
        inp = os.path.join(d, "in.script")
        open(inp, "w").write(script(a.code, cfg, rows, data, a.warm, steps, a.ranks, a.skin, a.multi))
        cmd = [{"liggghts": "liggghts", "lammps": "lmp"}[a.code], "-in", inp, "-log", os.path.join(d, "log")]
        if a.ranks > 1:
            cmd = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(a.ranks)] + cmd
        run = subprocess.run(cmd, capture_output=True, text=True, cwd=d, env=dict(os.environ, OMP_NUM_THREADS="1"))
        txt = run.stdout + run.stderr
    loops = re.findall(r"Loop time of ([\d.eE+-]+) on", txt)
    if run.returncode or len(loops) < 3:
        sys.exit("%s failed:\n%s" % (a.code, txt[-2000:]))
    cpu = re.findall(r"([\d.]+)% CPU use", txt)
    wall = float(loops[1]) * 1e9 / len(rows) / steps
    share = float(cpu[1]) / 100 if cpu else float("nan")
    last = [l.split() for l in txt.splitlines() if re.match(r"\s*%d\s" % (a.warm + steps), l)][-1]
    print("%s scene=%s ranks=%d N=%d steps=%d wall_ns=%.1f cpu_ns=%.1f coordination=%.3f kinetic_total=%.6e" % (
        a.code, a.scene, a.ranks, len(rows), steps, wall, wall * share, float(last[4]) / len(rows), float(last[2]) + float(last[3])))


if __name__ == "__main__":
    main()
