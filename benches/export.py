#!/usr/bin/env python3
"""Time mercury-export against pyvista on the same frames, in one run.

    pip install vtk pyvista pyarrow
    cargo build --release --bin mercury-export
    benches/export.py [--particles 1000000] [--frames 3] [--rounds 3]

Makes a run of random particles (positions, velocities, spins, forces: digits that do not shrink; ids, materials, four radii, zero torques: digits
that do) as Arrow frames, and turns it into .vtu files: by mercury-export with each compression, and by pyvista from the same Arrow file with VTK's
writer (appended binary, zlib, its default; and without compression). Both read the Arrow file and write all arrays, diameter and speed too. The two take turns;
printed are medians, s per frame, and MB. A plain copy of as many bytes as the uncompressed frame has, and sync, shows the speed of the disk.
"""
import argparse, os, shutil, statistics, subprocess, sys, tempfile, time
import numpy as np, pyarrow as pa, pyvista as pv, vtk
from vtk.util import numpy_support

HERE = os.path.dirname(os.path.abspath(__file__))
EXPORT = os.path.join(HERE, "..", "target", "release", "mercury-export")
NAMES = ["mass", "volume", "radius"] + [a + b for a in ("", "v", "w", "f", "t") for b in "xyz"]


def make(path, count, frames):
    units = {"mass": "kg", "volume": "m^3"}
    fields = [pa.field("time", pa.float64(), False)] + [pa.field(n, pa.uint32(), False) for n in ("id", "material")]
    fields += [pa.field("state", pa.uint8(), False)] + [pa.field(n, pa.float64(), False, {"unit": units.get(n, "1")}) for n in NAMES]
    schema = pa.schema(fields)
    random = np.random.default_rng(1)
    with pa.OSFile(path, "wb") as sink, pa.ipc.new_stream(sink, schema) as stream:
        for k in range(frames):
            ids = np.arange(count, dtype=np.uint32)
            radius = 1e-3 * (1 + ids % 4)
            columns = [np.full(count, 0.1 * k), ids, ids % 3, np.zeros(count, np.uint8)]
            for n in NAMES:
                known = {"radius": radius, "mass": 2500 * radius**3, "volume": radius**3, "tx": 0 * radius, "ty": 0 * radius, "tz": 0 * radius}
                columns.append(known.get(n, None) if n in known else random.standard_normal(count))
            stream.write_batch(pa.record_batch([pa.array(c, f.type) for c, f in zip(columns, schema)], schema=schema))


def with_pyvista(path, folder, compressed):
    """What a careful user would write: one pass, VTK's own writer."""
    with pa.ipc.open_stream(path) as stream:
        for k, batch in enumerate(stream):
            get = lambda n: batch[n].to_numpy()
            stack = lambda s: np.column_stack([get(s + a) for a in "xyz"])
            grid = vtk.vtkUnstructuredGrid()
            points = vtk.vtkPoints()
            points.SetData(numpy_support.numpy_to_vtk(stack("")))
            grid.SetPoints(points)
            n = batch.num_rows
            cells = vtk.vtkCellArray()
            cells.SetData(numpy_support.numpy_to_vtkIdTypeArray(np.arange(n + 1, dtype=np.int64)), numpy_support.numpy_to_vtkIdTypeArray(np.arange(n, dtype=np.int64)))
            grid.SetCells(vtk.VTK_VERTEX, cells)
            grid = pv.wrap(grid)
            velocity = stack("v")
            grid["diameter"], grid["speed"] = 2 * get("radius"), np.linalg.norm(velocity, axis=1)
            for name in ("id", "material", "state", "mass", "volume", "radius"):
                grid[name] = get(name)
            grid["velocity"] = velocity
            for name, stem in (("angular_velocity", "w"), ("force", "f"), ("torque", "t")):
                grid[name] = stack(stem)
            writer = vtk.vtkXMLUnstructuredGridWriter()
            writer.SetFileName(os.path.join(folder, "p.%04d.vtu" % k))
            writer.SetInputData(grid)
            writer.SetDataModeToAppended()
            writer.EncodeAppendedDataOff()
            if not compressed:
                writer.SetCompressorTypeToNone()
            writer.Write()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--particles", type=int, default=1_000_000)
    parser.add_argument("--frames", type=int, default=3)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    work = tempfile.mkdtemp()
    arrow = os.path.join(work, "run.particles.arrow")
    make(arrow, given.particles, given.frames)
    ways = {}
    for compression in ("fast", "none", "1"):
        for precision in ("double", "single"):
            ways["mercury-export %s %s" % (compression, precision)] = lambda f, c=compression, p=precision: subprocess.run(
                [EXPORT, "vtu", arrow, "-o", f, "--quiet", "--compression", c, "--precision", p], check=True)
    ways["pyvista zlib double"] = lambda f: with_pyvista(arrow, f, True)
    ways["pyvista none double"] = lambda f: with_pyvista(arrow, f, False)

    def copy(folder):
        for k in range(given.frames):
            with open(os.path.join(folder, "p.%04d.vtu" % k), "wb") as out:
                out.write(bytes(copy.size))

    copy.size = os.path.getsize(arrow) // given.frames
    ways["the bytes alone"] = copy
    seconds, size = {w: [] for w in ways}, {}
    for _ in range(given.rounds):
        for way, work_on in ways.items():
            folder = os.path.join(work, "out")
            os.makedirs(folder)
            begin = time.perf_counter()
            work_on(folder)
            seconds[way].append((time.perf_counter() - begin) / given.frames)
            size[way] = sum(os.path.getsize(os.path.join(folder, f)) for f in os.listdir(folder)) / given.frames / 1e6
            shutil.rmtree(folder)
    shutil.rmtree(work)
    print("%d particles, %d threads; medians of %d rounds of %d frames" % (given.particles, os.cpu_count(), given.rounds, given.frames))
    print("%-32s %12s %12s" % ("", "s per frame", "MB per frame"))
    for way in ways:
        print("%-32s %12.3f %12.1f" % (way, statistics.median(seconds[way]), size[way]))


main()
