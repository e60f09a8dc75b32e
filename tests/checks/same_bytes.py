#!/usr/bin/env python3
"""Runs every example scene with two builds of mercury-solve and compares every output that holds numbers, byte by byte.

    tests/checks/same_bytes.py OLD/mercury-solve NEW/mercury-solve [--short] [--keep DIR] [--set key=value] [--new-set key=value] [NAME ...]

--short   cuts each run to a few seconds; without it the scenes run as they stand (some take minutes).
--keep    keeps the runs of OLD in DIR and takes them from there when called again.
--set     for both builds, as in mercury-solve.
--new-set for the new build alone (a key whose default it changed).
NAME      only scenes whose path ends in NAME.

Compared: frames, .data, .ene, .fstat, tracks, walls, regions, VTU and PVD, particles tables, and summary.json but for times,
rates and threads. Not compared: pictures, run.log, plan.toml. Exit 1 if anything differs.
"""

import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Simulated seconds that take a few seconds of work; scenes that are not named run as they stand.
SHORT = {
    "settle": 0.02, "chute": 0.02, "drum": 0.02, "hopper-simple": 0.05, "press": 0.05, "discs-2d": 0.1, "rolling": 0.5,
    "clumps/drum": 0.05, "clumps/rod-gas": 0.05, "clumps/t-bar-gas": 0.05, "clumps/t-bar": 0.1, "clumps/egg": 0.2,
    "clumps/dominoes": 0.1, "clumps/rattleback": 0.2, "clumps/wheels": 0.2,
}
UNLIKE = {"wall_seconds", "particle_steps_per_second", "threads", "total_seconds"}
PICTURES = {".png", ".svg", ".gif", ".log"}


def scenes():
    for folder in ["", "clumps", "bench"]:
        for path in sorted((ROOT / "scenes" / folder).glob("*.toml")):
            if path.name not in ("keys.toml",) and not path.name.endswith(".clump.toml"):
                yield path


def run(binary, scene, name, folder, options, settings):
    # More outputs than the scene itself has.
    settings = ["output.data=true", "output.ene=true", "output.fstat=true", *settings]
    if options.short and name in SHORT:
        settings.append(f"time.end={SHORT[name]}")
    command = [binary, scene, "--output", folder, "--quiet", "--threads", "2"]
    # So that both make every step; earlier builds have no such option and do so anyway.
    if "--fixed-threads" in subprocess.run([binary, "--help"], capture_output=True, text=True).stdout:
        command.append("--fixed-threads")
    command += [word for key in settings for word in ("--set", key)]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    return done.returncode, done.stderr.strip()[:300]


def content(path):
    if path.name == "summary.json":
        values = json.loads(path.read_text())
        return json.dumps({key: value for key, value in values.items() if key not in UNLIKE}, sort_keys=True).encode()
    return path.read_bytes()


def compare(old, new):
    def files(folder):
        every = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
        return {path for path in every if path.suffix not in PICTURES and path.name not in ("plan.toml", ".lock", ".mercury-run")}

    left, right = files(old), files(new)
    unlike = [f"only in one: {path}" for path in sorted(left ^ right)]
    unlike += [f"differs: {path}" for path in sorted(left & right) if content(old / path) != content(new / path)]
    return len(left & right), unlike


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--new-set", action="append", default=[])
    options = parser.parse_args()
    bad = 0
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        for scene in scenes():
            name = str(scene.relative_to(ROOT / "scenes"))[: -len(".toml")]
            if options.names and not any(name.endswith(wanted) for wanted in options.names):
                continue
            old = (options.keep or scratch / "old") / name.replace("/", "-")
            if not (old / "summary.json").exists():
                old.parent.mkdir(parents=True, exist_ok=True)
                shutil.rmtree(old, ignore_errors=True)
                code, message = run(options.old, scene, name, old, options, options.set)
                if code:
                    print(f"{name}: the old build fails with {code}: {message}")
                    bad += 1
                    continue
            new = scratch / "new" / name.replace("/", "-")
            new.parent.mkdir(parents=True, exist_ok=True)
            code, message = run(options.new, scene, name, new, options, options.set + options.new_set)
            if code:
                print(f"{name}: the new build fails with {code}: {message}")
                bad += 1
                continue
            count, unlike = compare(old, new)
            print(f"{name}: {count} files, {'the same' if not unlike else '; '.join(unlike)}", flush=True)
            bad += bool(unlike)
            shutil.rmtree(new)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
