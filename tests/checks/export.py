#!/usr/bin/env python3
"""Reads what mercury-export wrote with other people's readers and compares every value.

    pip install vtk pyvista meshio pyarrow pandas
    cargo build --release --bin mercury-solve --bin mercury-export --bin mclump
    tests/checks/export.py [--bin target/release] [--keep FOLDER]

Solves scenes/drum.toml for 0.3 s (with contacts and vtk = true), exports it in every way, and reads the files with VTK (pyvista), meshio, pyarrow
and pandas; with ParaView's own reader too if pvpython is installed. Then a box of clumps, of which one kind is made from a surface by mclump. The truth is the run's Arrow files, read by pyarrow.
A second run drops balls onto a tessellated floor, whose triangles must bear them.
Prints one line per check; exits 1 if one fails.
"""
import argparse, json, os, shutil, subprocess, sys, tempfile
import meshio, numpy as np, pandas as pd, pyarrow as pa, pyarrow.parquet as pq, pyvista as pv

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
failed = []


def check(what, good, detail=""):
    print(("ok      " if good else "FAILED  ") + what + (" " + str(detail) if detail != "" else ""), flush=True)
    if not good:
        failed.append(what)


def frames(path):
    """The batches of a file of frames, with their times."""
    with pa.ipc.open_stream(path) as stream:
        return [(float(f.custom_metadata[b"time"]), f.batch) for f in stream.iter_batches_with_custom_metadata()]


def columns(batch, *names):
    arrays = [batch[name].to_numpy(zero_copy_only=False) for name in names]
    return arrays[0] if len(arrays) == 1 else np.column_stack(arrays)


def ids(batch, name):
    """A column that may miss values, with -1 for none."""
    return np.array([-1 if v is None else v for v in batch[name].to_pylist()])


VECTORS = {"velocity": "v", "angular_velocity": "w", "force": "f", "torque": "t", "principal_moments": "i"}


def compare_particles(what, grid, batch, exact):
    same = np.array_equal if exact else (lambda a, b: np.allclose(a, b, rtol=1e-7, atol=0))
    position = columns(batch, "x", "y", "z")
    good = same(grid.points, position if exact else position.astype(np.float32)) and grid.n_cells == len(position)
    seen = {"TimeValue"}
    for name in grid.point_data:
        a, seen = np.asarray(grid.point_data[name]), seen | {name}
        if name in VECTORS:
            expected = columns(batch, *(VECTORS[name] + k for k in "xyz"))
        elif name == "orientation":
            expected = columns(batch, "qw", "qx", "qy", "qz")
        elif name == "diameter":
            expected = 2 * columns(batch, "radius")
        elif name == "speed":
            v = columns(batch, "vx", "vy", "vz")
            expected = np.sqrt((v[:, 0] * v[:, 0] + v[:, 1] * v[:, 1]) + v[:, 2] * v[:, 2])
        else:
            expected = columns(batch, name)
        if not same(a, expected):
            good = False
            print("        differs:", what, name)
    good = good and {"diameter", "speed", "id", "material", "radius", "mass", "velocity", "force"} <= seen
    return good


def check_series(folder, run, exact, what):
    truth = frames(os.path.join(run, "drum.particles.arrow"))
    reader = pv.get_reader(os.path.join(folder, "drum.particles.pvd"))
    check(what + ": times of the .pvd", reader.time_values == [time for time, _ in truth], len(truth))
    good = good_mesh = True
    for k, (time, batch) in enumerate(truth):
        path = os.path.join(folder, "drum.particles.%04d.vtu" % k)
        grid = pv.read(path)
        good = good and compare_particles(path, grid, batch, exact) and grid.field_data["TimeValue"][0] == time
        other = meshio.read(path)
        good_mesh = good_mesh and np.array_equal(other.points, grid.points) and all(
            np.array_equal(other.point_data[name], grid.point_data[name]) for name in grid.point_data)
    check(what + ": VTK reads every value of every frame", good)
    check(what + ": meshio reads the same", good_mesh)


def check_contacts(folder, run):
    good = True
    spheres = {time: dict(zip(columns(b, "id").tolist(), columns(b, "x", "y", "z"))) for time, b in frames(os.path.join(run, "drum.particles.arrow"))}
    for k, (time, batch) in enumerate(frames(os.path.join(run, "drum.contacts.arrow"))):
        grid = pv.read(os.path.join(folder, "drum.contacts.%04d.vtu" % k))
        if grid.n_cells != batch.num_rows:
            good = False
        if batch.num_rows == 0:
            continue
        begin, end = grid.points[0::2], grid.points[1::2]
        branch, normal = columns(batch, "bx", "by", "bz"), columns(batch, "nx", "ny", "nz")
        force, wall = columns(batch, "fx", "fy", "fz"), ids(batch, "wall")
        i = columns(batch, "i")
        centres = np.array([spheres[time][a] for a in i.tolist()])
        data = grid.cell_data
        good = (good and np.allclose(begin, centres, rtol=0, atol=1e-12) and np.allclose(begin - end, branch, rtol=0, atol=1e-15)
                and np.array_equal(data["i"], i) and np.array_equal(data["j"], ids(batch, "j")) and np.array_equal(data["wall"], wall)
                and np.array_equal(data["force"], force) and np.array_equal(data["overlap"], columns(batch, "overlap"))
                and np.allclose(data["force_magnitude"], np.linalg.norm(force, axis=1), rtol=1e-14)
                and np.allclose(data["normal_force"], (force * normal).sum(axis=1), rtol=0, atol=1e-15))
    check("contacts: lines from centre to centre, values equal", good, "%d frames" % (k + 1))


def check_walls(folder, run):
    truth = frames(os.path.join(run, "drum.walls.arrow"))
    good = True
    for k, (time, batch) in enumerate(truth):
        grid = pv.read(os.path.join(folder, "drum.walls.%04d.vtu" % k))
        # The drum: radius 0.03 m about y, however far it has turned.
        distance = np.hypot(grid.points[:, 0], grid.points[:, 2])
        good = good and np.allclose(distance, 0.03, rtol=1e-12) and grid.points[:, 1].min() == 0.0 and abs(grid.points[:, 1].max() - 0.008) < 1e-15
    first = pv.read(os.path.join(folder, "drum.walls.0000.vtu")).points
    q = [batch[name][0].as_py() for name in ("qw", "qx", "qy", "qz")]
    angle = 2 * np.arctan2(q[2], q[0])
    turned = np.column_stack([np.cos(angle) * first[:, 0] + np.sin(angle) * first[:, 2], first[:, 1], -np.sin(angle) * first[:, 0] + np.cos(angle) * first[:, 2]])
    check("walls: on the drum's radius in every frame", good, "%d frames" % len(truth))
    check("walls: turned by the angle of the motion (3 rad/s from 0.15 s)", np.allclose(grid.points, turned, atol=1e-12) and abs(angle - 3.0 * (time - 0.15)) < 1e-9, "%.6f rad" % angle)


BALLS = """
title = "Balls on a tessellated floor"
gravity = [0.0, 0.0, -9.81]
[time]
end = 0.3
step = 1e-5
[domain]
min = [0.0, 0.0, -0.01]
max = [0.04, 0.04, 0.04]
[output]
interval = 0.02
triangle_loads = true
vtk = true
[materials.glass]
density = 2500.0
normal = { law = "hertz", youngs_modulus = 1e7, poisson_ratio = 0.25, restitution = 0.5 }
tangential = { law = "mindlin", friction = 0.5 }
[[walls]]
name = "side"
shape = "plane"
material = "glass"
point = [0.0, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
[[walls]]
name = "floor"
shape = "mesh"
material = "glass"
file = "floor.obj"
[[particles]]
material = "glass"
radius = 0.002
lattice = { min = [0.005, 0.005, 0.0025], max = [0.029, 0.029, 0.0085], spacing = 0.006 }
velocity = [0.01, 0.005, 0.0]
"""


def check_triangle_loads(work, solve, export):
    n, edge = 8, 0.04
    with open(os.path.join(work, "floor.obj"), "w") as obj:
        for j in range(n + 1):
            for i in range(n + 1):
                obj.write("v %r %r 0\n" % (edge * i / n, edge * j / n))
        for j in range(n):
            for i in range(n):
                a = j * (n + 1) + i + 1
                obj.write("f %d %d %d\nf %d %d %d\n" % (a, a + 1, a + n + 2, a, a + n + 2, a + n + 1))
    scene, run = os.path.join(work, "balls.toml"), os.path.join(work, "balls")
    with open(scene, "w") as text:
        text.write(BALLS)
    subprocess.run([solve, scene, "--output", run, "--force", "--quiet"], check=True)
    subprocess.run([export, "vtu", run, "-o", os.path.join(work, "loads"), "--force", "--quiet"], check=True)
    truth = frames(os.path.join(run, "balls.triangle_loads.arrow"))
    good = same = True
    for k, (time, batch) in enumerate(truth):
        name = "balls.walls.%04d.vtu" % k
        grid = pv.read(os.path.join(work, "loads", name))
        # Corners of meshes are numbered anew when they are read back; the triangles are the same.
        own = pv.read(os.path.join(run, "vtk", name))
        same = same and all(np.array_equal(grid.cell_data[array], own.cell_data[array]) for array in own.cell_data) and set(own.cell_data) == set(grid.cell_data)
        same = same and np.array_equal(grid.points[grid.cells.reshape(-1, 4)[:, 1:]], own.points[own.cells.reshape(-1, 4)[:, 1:]])
        floor = np.flatnonzero(grid.cell_data["wall"] == 1)
        rows = floor[columns(batch, "triangle")]
        for array, names in (("pressure", ["pressure"]), ("slip_power", ["slip_power"]), ("shear", ["shear_x", "shear_y", "shear_z"]), ("force", ["fx", "fy", "fz"])):
            expected = np.zeros_like(np.asarray(grid.cell_data[array]))
            expected[rows] = columns(batch, *names)
            good = good and np.array_equal(grid.cell_data[array], expected)
    check("triangles: VTK reads the loads of every frame, on their triangles", good and len(floor) == 2 * n * n, "%d frames" % len(truth))
    check("triangles: vtk = true writes the same triangles and values", same)
    # At rest the floor bears the weight of those that have not rolled off it, and pressure times area is force.
    areas = grid.compute_cell_sizes(length=False, volume=False).cell_data["Area"]
    weight = columns(frames(os.path.join(run, "balls.particles.arrow"))[-1][1], "mass").sum() * 9.81
    borne = (np.asarray(grid.cell_data["pressure"]) * areas).sum()
    down = np.asarray(grid.cell_data["force"])[:, 2].sum()
    check("triangles: they bear the weight", abs(borne / weight - 1) < 0.02 and abs(down + borne) < 1e-9 * weight, "%.4f of it" % (borne / weight))


PVPYTHON = """
import sys, json
from paraview.simple import *
from paraview import servermanager
r = PVDReader(FileName=sys.argv[1])
r.UpdatePipeline()
out = []
for t in r.TimestepValues:
    r.UpdatePipeline(t)
    block = servermanager.Fetch(r)
    block = block.GetBlock(0) if hasattr(block, "GetBlock") else block
    a = block.GetPointData().GetArray("speed")
    out.append([t, block.GetNumberOfPoints(), sum(a.GetValue(k) for k in range(a.GetNumberOfTuples()))])
print("RESULT" + json.dumps(out))
"""


def check_paraview(folder, run):
    if not shutil.which("pvpython"):
        print("skipped ParaView: no pvpython")
        return
    with tempfile.NamedTemporaryFile("w", suffix=".py") as script:
        script.write(PVPYTHON)
        script.flush()
        said = subprocess.run(["pvpython", script.name, os.path.abspath(os.path.join(folder, "drum.particles.pvd"))], capture_output=True, text=True).stdout
    found = [json.loads(line[6:]) for line in said.splitlines() if line.startswith("RESULT")]
    expected = []
    for time, batch in frames(os.path.join(run, "drum.particles.arrow")):
        v = columns(batch, "vx", "vy", "vz")
        expected.append([time, batch.num_rows, float(np.linalg.norm(v, axis=1).sum())])
    check("ParaView's own reader: all times, points and speeds", bool(found) and np.allclose(found[0], expected, rtol=1e-12), "%d frames" % len(expected))


STONE = "v 3 0 0\nv -3 0 0\nv 0 2 0\nv 0 -2 0\nv 0 0 1\nv 0 0 -2\n" + "".join(
    "f %d %d %d\n" % face for face in [(1, 3, 5), (3, 2, 5), (2, 4, 5), (4, 1, 5), (3, 1, 6), (2, 3, 6), (4, 2, 6), (1, 4, 6)])

CLUMPS = """
title   = "Stones and rods"
seed    = 1
gravity = [0.0, 0.0, -9.81]
[time]
end  = 0.06
step = 2e-5
[domain]
min = [0.0, 0.0, 0.0]
max = [0.04, 0.04, 0.04]
[materials.rock]
density    = 2000.0
normal     = { law = "linear", stiffness = 1000.0, restitution = 0.5 }
tangential = { law = "linear", stiffness_ratio = 0.2857142857142857, friction = 0.4 }
[clumps.rod]
file     = "ROD"
material = "rock"
[clumps.stone]
file     = "stone.clump.toml"
material = "rock"
[[walls]]
name     = "box"
shape    = "box"
material = "rock"
[[insertions]]
name     = "fill"
region   = { shape = "box", min = [0.0, 0.0, 0.0], max = [0.04, 0.04, 0.04] }
mixture  = [
    { clump = "rod", psd = { kind = "uniform", min_diameter = 4e-3, max_diameter = 5e-3, weighting = "number" }, share = 0.5 },
    { clump = "stone", psd = { kind = "uniform", min_diameter = 4e-3, max_diameter = 6e-3, weighting = "number" }, share = 0.5 },
]
share_by = "number"
total    = { number = 40 }
[output]
interval = 0.02
"""


def rotated(q, points):
    """Points turned by a unit quaternion w, x, y, z."""
    w, v = q[0], q[1:]
    return points + 2 * np.cross(v, np.cross(v, points) + w * points)


def check_clumps(work, binary, go):
    run, out = os.path.join(work, "stones"), os.path.join(work, "stones-out")
    solve, export, mclump = (os.path.join(binary, name) for name in ("mercury-solve", "mercury-export", "mclump"))
    for name, text in (("stone.obj", STONE), ("stones.toml", CLUMPS.replace("ROD", os.path.abspath(os.path.join(ROOT, "scenes", "clumps", "rod.clump.toml"))))):
        with open(os.path.join(work, name), "w") as file:
            file.write(text)
    stone = os.path.join(work, "stone")
    go(mclump, stone + ".obj", "--scale", "1e-3", "--generate", "tangent", "--pebbles", "40", "-o", stone + ".clump.toml", "--quiet", "--force")
    go(solve, stone + "s.toml", "--output", run, "--force", "--quiet", "--set", "output.vtk=true")
    go(export, "vtu", run, "-o", out, "--force", "--quiet", "--clumps", "surface")
    bodies, particles = (frames(os.path.join(run, "stones.%s.arrow" % kind)) for kind in ("bodies", "particles"))
    good = all(compare_particles("bodies", pv.read(os.path.join(folder, "stones.bodies.%04d.vtu" % k)), batch, True)
               for folder in (out, os.path.join(run, "vtk")) for k, (_, batch) in enumerate(bodies))
    check("bodies: VTK reads every value, of mercury-export and of vtk = true", good, "%d frames of %d bodies" % (len(bodies), bodies[-1][1].num_rows))

    surface = frames(os.path.join(run, "stones.clumps.arrow"))[0][1]
    own = columns(surface, *(c + k for c in "abc" for k in "xyz")).reshape(-1, 3, 3)
    good = good_volume = good_rest = True
    reader = pv.get_reader(os.path.join(out, "stones.clumps.pvd"))
    check("clumps: times of the .pvd", reader.time_values == [time for time, _ in bodies])
    for k, (_, batch) in enumerate(bodies):
        path = os.path.join(out, "stones.clumps.%04d.vtu" % k)
        grid, table = pv.read(path), batch.to_pandas()
        stones = table[table.clump == 1]
        corners = grid.points[grid.cells.reshape(-1, 4)[:, 1:]].reshape(len(stones), len(own), 3, 3)
        data = {name: np.asarray(grid.cell_data[name]).reshape((len(stones), len(own)) + grid.cell_data[name].shape[1:]) for name in grid.cell_data}
        for (_, row), found, place in zip(stones.iterrows(), corners, range(len(stones))):
            centre = row[["x", "y", "z"]].to_numpy(float)
            expected = centre + rotated(row[["qw", "qx", "qy", "qz"]].to_numpy(float), row.scale * own.reshape(-1, 3)).reshape(own.shape)
            v = row[["vx", "vy", "vz"]].to_numpy(float)
            good = (good and np.allclose(found, expected, rtol=0, atol=1e-15) and (data["body"][place] == row.id).all() and (data["mass"][place] == row.mass).all()
                    and (data["velocity"][place] == v).all() and np.allclose(data["speed"][place], np.linalg.norm(v), rtol=1e-15)
                    and (data["angular_velocity"][place] == row[["wx", "wy", "wz"]].to_numpy(float)).all() and (data["material"][place] == row.material).all())
            # What the surface encloses is the body: its mass at 2000 kg/m3, its centre of mass. The STL has single precision.
            six = np.einsum("ij,ij->i", found[:, 0] - centre, np.cross(found[:, 1] - centre, found[:, 2] - centre))
            middle = (six[:, None] * (found - centre).sum(axis=1)).sum(axis=0) / (4 * six.sum())
            good_volume = good_volume and abs(2000 * six.sum() / 6 / row.mass - 1) < 1e-6 and np.linalg.norm(middle) < 1e-6 * row.radius
        rods = set(table[table.clump == 0].id)
        left = pv.read(os.path.join(out, "stones.particles.%04d.vtu" % k))
        all_particles = particles[k][1].to_pandas()
        rest = all_particles[[body in rods for body in all_particles.body]]
        good_rest = good_rest and np.array_equal(left.point_data["id"], rest.id) and len(rest) < len(all_particles)
        other = meshio.read(path)
        good = good and np.array_equal(other.points, grid.points)
        sums = all_particles.groupby("body").agg({"mass": "sum", "volume": "sum"})
        good_rest = good_rest and np.allclose(sums.loc[table.id].mass, table.mass, rtol=1e-14) and np.allclose(sums.loc[table.id].volume, table.volume, rtol=1e-14)
    check("clumps: surfaces placed, turned and scaled, every value", good, "%d triangles" % grid.n_cells)
    check("clumps: the surface encloses the body's mass about its centre", good_volume)
    check("clumps: pebbles are left of those without a surface, and sum to their bodies", good_rest)

    for command in ("csv", "parquet"):
        go(export, command, run, "-o", out, "--force", "--quiet", "--table", "bodies")
    found = pd.read_csv(os.path.join(out, "stones.bodies.%04d.csv" % k))
    check("CSV of bodies: pandas reads the same numbers", list(found) == list(table) and all(np.array_equal(found[c], table[c]) for c in table))
    found = pq.read_table(os.path.join(out, "stones.bodies.parquet"))
    whole = pa.Table.from_batches([b for _, b in bodies])
    same = found.drop(["step"]).cast(whole.schema.remove_metadata()).equals(whole.replace_schema_metadata(None))
    check("Parquet of bodies: pyarrow reads the same table", same, "%d rows" % found.num_rows)
    for choice, rows, radii in (("bodies", len(table), table.radius), ("pebbles", len(all_particles), all_particles.radius)):
        again = os.path.join(work, "stones-" + choice)
        go(solve, stone + "s.toml", "--output", again, "--force", "--quiet", "--set", "output.clumps_as=" + choice)
        lines = open(os.path.join(again, "stones.data")).read().splitlines()
        last = np.array([line.split() for line in lines[-rows:]], float)
        check(".data with clumps_as = %s: a row for each" % choice, lines[-rows - 1].split()[0] == str(rows) and np.array_equal(last[:, 6], radii), "%d rows" % rows)


def check_tables(folder, run):
    for table in ("particles", "contacts"):
        truth = frames(os.path.join(run, "drum.%s.arrow" % table))
        whole = pa.Table.from_batches([b for _, b in truth])
        found = pq.read_table(os.path.join(folder, "drum.%s.parquet" % table))
        same = found.drop(["step"]).cast(whole.schema.remove_metadata()).equals(whole.replace_schema_metadata(None))
        check("Parquet of %s: pyarrow reads the same table" % table, same, "%d rows" % found.num_rows)
    k = len(frames(os.path.join(run, "drum.particles.arrow"))) - 1
    truth = frames(os.path.join(run, "drum.particles.arrow"))[k][1].to_pandas()
    found = pd.read_csv(os.path.join(folder, "drum.particles.%04d.csv" % k))
    check("CSV: pandas reads the same numbers", list(found) == list(truth) and all(np.array_equal(found[c], truth[c]) for c in truth))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", default=os.path.join(ROOT, "target", "release"))
    parser.add_argument("--keep", help="work in this folder and leave the files there")
    given = parser.parse_args()
    work = given.keep or tempfile.mkdtemp()
    os.makedirs(work, exist_ok=True)
    run, out = os.path.join(work, "drum"), os.path.join(work, "out")
    solve, export = (os.path.join(given.bin, name) for name in ("mercury-solve", "mercury-export"))

    def go(*arguments):
        subprocess.run(arguments, check=True)

    go(solve, os.path.join(ROOT, "scenes", "drum.toml"), "--output", run, "--force", "--quiet", "--set", "time.end=0.3", "--set", "output.fstat=true", "--set", "output.vtk=true")
    check_series(os.path.join(run, "vtk"), run, True, "vtk = true")
    for compression in ("none", "fast", "1", "9"):
        folder = os.path.join(out, compression)
        go(export, "vtu", run, "-o", folder, "--force", "--quiet", "--compression", compression)
        check_series(folder, run, True, "vtu --compression " + compression)
    single = os.path.join(out, "single")
    go(export, "vtu", run, "-o", single, "--force", "--quiet", "--precision", "single")
    check_series(single, run, False, "vtu --precision single")
    folder = os.path.join(out, "fast")
    check_contacts(folder, run)
    check_walls(folder, run)
    check_paraview(folder, run)
    check_triangle_loads(work, solve, export)
    go(export, "csv", run, "-o", out, "--force", "--quiet")
    for table in ("particles", "contacts"):
        go(export, "parquet", run, "-o", out, "--force", "--quiet", "--table", table)
    check_tables(out, run)
    go(export, "xballs", run, "-o", out, "--force", "--quiet")
    written, own = (open(os.path.join(f, "drum.data"), "rb").read() for f in (out, run))
    check(".data from the Arrow frames is the solver's own, byte for byte", written == own, "%d bytes" % len(own))
    go(export, "xballs", os.path.join(run, "drum.data"), "-o", os.path.join(out, "again"), "--force", "--quiet")
    again = open(os.path.join(out, "again", "drum.data"), "rb").read()
    check(".data goes round byte for byte", again == own)
    check_clumps(work, given.bin, go)
    if not given.keep:
        shutil.rmtree(work)
    print("%d checks failed" % len(failed) if failed else "all checks passed")
    sys.exit(1 if failed else 0)


main()
