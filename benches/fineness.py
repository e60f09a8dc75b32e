#!/usr/bin/env python3
"""What do more triangles of the same wall cost? Cuts every triangle of a drum into n * n and runs the scene.

    cargo build --release --bin mercury-solve
    benches/fineness.py scenes/bench/mesh-drum-6k.toml target/release/mercury-solve

The first row is the same drum with no corners but those of its two ends: its strips and its ends are plane. Prints triangles, ns per
particle-step, and the ratio to the first row; the least of five rounds, in which the meshes take turns.
"""
import json, math, os, re, subprocess, sys, tempfile


def read(path):
    """Triangles of an ASCII STL."""
    corners = [tuple(map(float, x)) for x in re.findall(r"vertex\s+(\S+)\s+(\S+)\s+(\S+)", open(path).read())]
    return [corners[k : k + 3] for k in range(0, len(corners), 3)]


def cut(triangle, n):
    """n * n triangles. Corners on common edges are the same numbers, whatever the order of the ends."""
    named = sorted(range(3), key=lambda k: triangle[k])
    ends = [triangle[k] for k in named]

    def at(weights):
        sorted_weights = [weights[k] for k in named]
        return tuple(sum(w * x[axis] for w, x in zip(sorted_weights, ends) if w) / n for axis in range(3))

    for i in range(n):
        for j in range(n - i):
            k = n - i - j
            yield at((k, i, j)), at((k - 1, i + 1, j)), at((k - 1, i, j + 1))
            if i + j < n - 1:
                yield at((k - 1, i + 1, j)), at((k - 2, i + 1, j + 1)), at((k - 1, i, j + 1))


def coarse(triangles):
    """The drum about the y axis with the corners of its ends alone."""
    corners = {tuple(round(a, 9) for a in x) for triangle in triangles for x in triangle}
    radius = max(math.hypot(x, z) for x, _, z in corners)
    ends = [f(y for _, y, _ in corners) for f in (min, max)]
    low, high = (sorted((x for x in corners if x[1] == y and math.hypot(x[0], x[2]) > (1 - 1e-6) * radius),
                        key=lambda x: math.atan2(x[2], x[0])) for y in ends)
    for k in range(len(low)):
        yield low[k - 1], low[k], high[k]
        yield low[k - 1], high[k], high[k - 1]
        yield (0.0, ends[0], 0.0), low[k - 1], low[k]
        yield (0.0, ends[1], 0.0), high[k], high[k - 1]


def main(scene, solver):
    text = open(scene).read()
    here = os.path.dirname(os.path.abspath(scene))
    mesh = re.search(r'file\s*=\s*"([^"]+\.stl)"', text).group(1)
    triangles = read(os.path.join(here, mesh))
    with tempfile.TemporaryDirectory() as folder:
        cases = []
        for n in (0, 1, 3, 10, 20):
            path = os.path.join(folder, "%d.obj" % n)
            fine = [small for triangle in triangles for small in cut(triangle, n)] if n else list(coarse(triangles))
            numbers = {}
            with open(path, "w") as f:
                for small in fine:
                    for corner in small:
                        if corner not in numbers:
                            numbers[corner] = len(numbers) + 1
                            f.write("v %r %r %r\n" % corner)
                for small in fine:
                    f.write("f %d %d %d\n" % tuple(numbers[corner] for corner in small))
            new = re.sub(r'file(\s*)=(\s*)"([^"/][^"]*)"', lambda m: 'file%s=%s"%s"' % (m[1], m[2], path if m[3] == mesh else os.path.join(here, m[3])), text)
            new_scene = os.path.join(folder, "%d.toml" % n)
            open(new_scene, "w").write(new)
            cases.append((len(fine), new_scene, []))
        for _ in range(5):
            for _, new_scene, times in cases:
                out = os.path.join(folder, "out")
                subprocess.run([solver, new_scene, "--threads", "1", "--output", out, "--force", "--quiet"], check=True, capture_output=True)
                summary = json.load(open(os.path.join(out, "summary.json")))
                times.append(1e9 / summary["particle_steps_per_second"])
    print("triangles,ns_per_particle_step,ratio")
    for count, _, times in cases:
        print("%d,%.1f,%.2f" % (count, min(times), min(times) / min(cases[0][2])))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
