#!/usr/bin/env python3
"""Compare mclump's volume integrals with trimesh, on the same file, in one run.

    pip install numpy trimesh
    cargo build --release --bin mclump
    benches/mclump.py                       # a torus of 1,000,000 triangles, binary STL
    benches/mclump.py --triangles 400000 --ascii

Prints wall time of each (reading, merging vertices, integrating; mclump also hashes the file, checks the surface and describes its
shape) and the relative differences of volume and principal moments.
"""
import argparse, json, math, os, struct, subprocess, sys, tempfile, time

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))


def torus(triangles, big=2.0, small=0.5):
    n = max(3, round(math.sqrt(triangles / 2)))
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    u, v = np.meshgrid(angle, angle, indexing="ij")
    rho = big + small * np.cos(v)
    points = np.stack([rho * np.cos(u), rho * np.sin(u), small * np.sin(v)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    at = lambda i, j: ((i % n) * n + j % n).ravel()
    a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
    return points[np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])]


def write(path, corners, ascii_form):
    if ascii_form:
        with open(path, "w") as f:
            f.write("solid torus\n")
            for t in corners:
                f.write("facet normal 0 0 1\nouter loop\n" + "".join("vertex %.9g %.9g %.9g\n" % tuple(p) for p in t) + "endloop\nendfacet\n")
            f.write("endsolid torus\n")
        return
    record = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    record["corners"] = corners
    with open(path, "wb") as f:
        f.write(b" " * 80 + struct.pack("<I", len(corners)) + record.tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--ascii", action="store_true")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--mclump", default=os.path.join(HERE, "..", "target", "release", "mclump"))
    options = parser.parse_args()
    try:
        import trimesh
    except ImportError:
        sys.exit("trimesh is needed: pip install trimesh")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "torus.stl")
        corners = torus(options.triangles)
        write(path, corners, options.ascii)
        print("%d triangles, %.1f MB" % (len(corners), os.path.getsize(path) / 1e6))
        times = {"mclump": [], "trimesh": []}
        for _ in range(options.repeat):
            begin = time.perf_counter()
            ours = json.loads(subprocess.run([options.mclump, path, "--json"], check=True, capture_output=True).stdout)["surface"]
            times["mclump"].append(time.perf_counter() - begin)
            begin = time.perf_counter()
            mesh = trimesh.load(path)
            theirs = mesh.mass_properties
            moments = np.sort(np.linalg.eigvalsh(theirs["inertia"]))
            times["trimesh"].append(time.perf_counter() - begin)
        for name, values in times.items():
            print("%-8s %.2f s (median of %d)" % (name, sorted(values)[len(values) // 2], len(values)))
        print("volume: relative difference %.1e" % abs(ours["mass"] / theirs["volume"] - 1))
        print("moments: largest relative difference %.1e" % np.max(np.abs(np.array(ours["principal_moments"]) / moments - 1)))


if __name__ == "__main__":
    main()
